//! A scene in storage buffers.

use std::ops::Range;

use glam::Vec3;

use super::device::Gpu;
use super::error::GpuError;
use super::mesh_store::{Arrangement, MeshStore, StagedMeshes, TriangleOrder};
use super::record::{MaterialRecord, textures};
use super::storage::{Records, StagedRecords};
use super::texels::{StagedTextures, TextureStore};
use crate::scene::{AlphaMode, Material, Scene};

/// What the scene's materials have, for shaders that leave out the rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Features {
    pub(super) textures: bool,
    pub(super) anisotropy: bool,
    pub(super) clearcoat: bool,
    pub(super) sheen: bool,
    pub(super) diffuse_roughness: bool,
}

impl Features {
    /// What either has.
    pub(super) fn or(self, other: Self) -> Self {
        Self {
            textures: self.textures || other.textures,
            anisotropy: self.anisotropy || other.anisotropy,
            clearcoat: self.clearcoat || other.clearcoat,
            sheen: self.sheen || other.sheen,
            diffuse_roughness: self.diffuse_roughness || other.diffuse_roughness,
        }
    }

    fn new(materials: &[Material]) -> Self {
        let any = |has: fn(&Material) -> bool| materials.iter().any(has);
        Self {
            textures: any(|m| textures(m).iter().any(|t| t.is_some())),
            anisotropy: any(|m| m.anisotropy_strength != 0.0),
            clearcoat: any(|m| m.clearcoat > 0.0),
            sheen: any(|m| m.sheen_color != Vec3::ZERO),
            diffuse_roughness: any(|m| m.diffuse_roughness != 0.0),
        }
    }
}

/// How a triangle is rastered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drawn {
    FromItsFront,
    FromBothSides,
    WhereOpaque,
}

pub(super) const DRAWN: [Drawn; 3] = [
    Drawn::FromItsFront,
    Drawn::FromBothSides,
    Drawn::WhereOpaque,
];

impl Drawn {
    pub(super) fn of(material: &Material) -> Self {
        match material.alpha_mode {
            AlphaMode::Mask { .. } => Self::WhereOpaque,
            _ if material.double_sided => Self::FromBothSides,
            _ => Self::FromItsFront,
        }
    }
}

/// The scene, bound.
pub(super) struct SceneBuffers {
    pub(super) bind_group: wgpu::BindGroup,
    /// Written before each submission, one after the other at [`FRAME_STRIDE`].
    pub(super) frames: wgpu::Buffer,
    /// Triangles by how they are drawn, as [`DRAWN`].
    pub(super) draws: [Vec<Range<u32>>; 3],
    pub(super) order: TriangleOrder,
    pub(super) bounds: Option<(Vec3, Vec3)>,
    /// At least what its materials have.
    pub(super) features: Features,
    meshes: MeshStore,
    textures: TextureStore,
    materials: Records<MaterialRecord>,
}

/// A scene that is to replace the one in the buffers: beside it on the device, but for small records.
pub(super) struct StagedScene {
    meshes: StagedMeshes,
    textures: Option<StagedTextures>,
    materials: StagedRecords<MaterialRecord>,
    pub(super) features: Features,
}

/// Frames of one submission.
pub(super) const FRAMES: usize = 16;

/// Bytes from one frame to the next: what any device aligns uniforms to.
pub(super) const FRAME_STRIDE: usize = 256;

/// The scene's layout: a frame by its offset, then storage buffers.
pub(super) fn layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |binding, ty, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::all(),
        ty: wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset,
            min_binding_size: None,
        },
        count: None,
    };
    let read = wgpu::BufferBindingType::Storage { read_only: true };
    let mut entries = vec![entry(0, wgpu::BufferBindingType::Uniform, true)];
    entries.extend((1..8).map(|binding| entry(binding, read, false)));
    let descriptor = wgpu::BindGroupLayoutDescriptor {
        label: Some("scene"),
        entries: &entries,
    };
    gpu.device().create_bind_group_layout(&descriptor)
}

fn material_records(scene: &Scene) -> Vec<MaterialRecord> {
    scene.materials.iter().map(MaterialRecord::from).collect()
}

impl SceneBuffers {
    pub(super) fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        scene: &Scene,
    ) -> Result<Self, GpuError> {
        let limit = gpu.adapter().largest_storage();
        let meshes = MeshStore::new(gpu, scene, limit)?;
        let textures = TextureStore::new(gpu, &scene.textures, limit)?;
        let materials = Records::new(gpu, "materials", material_records(scene))?;
        let frames = gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("frames"),
            size: (FRAMES * FRAME_STRIDE) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let Arrangement {
            draws,
            order,
            bounds,
        } = meshes.arrangement();
        Ok(Self {
            bind_group: bind_group(gpu, layout, &frames, (&meshes, &textures, &materials)),
            frames,
            draws,
            order,
            bounds,
            features: Features::new(&scene.materials),
            meshes,
            textures,
            materials,
        })
    }

    /// Brings to the device what another scene has and this one has not. `None` where there is no room for
    /// both.
    pub(super) fn stage(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
    ) -> Result<Option<StagedScene>, GpuError> {
        let materials = self.materials.stage(gpu, material_records(scene))?;
        let Some(meshes) = self.meshes.stage(gpu, scene)? else {
            return Ok(None);
        };
        match self.textures.stage(gpu, &scene.textures) {
            Ok(Some(textures)) => Ok(Some(StagedScene {
                meshes,
                textures,
                materials,
                features: self.features.or(Features::new(&scene.materials)),
            })),
            other => {
                self.meshes.withdraw(&meshes);
                other.map(|_| None)
            }
        }
    }

    /// Forgets what was staged.
    pub(super) fn withdraw(&mut self, staged: &StagedScene) {
        self.meshes.withdraw(&staged.meshes);
        if let Some(textures) = &staged.textures {
            self.textures.withdraw(textures);
        }
    }

    /// Becomes the scene that was staged.
    pub(super) fn commit(
        &mut self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        staged: StagedScene,
    ) {
        self.meshes.commit(gpu, staged.meshes);
        if let Some(textures) = staged.textures {
            self.textures.commit(gpu, textures);
        }
        self.materials.commit(gpu, staged.materials);
        self.features = staged.features;
        let arrangement = self.meshes.arrangement();
        self.draws = arrangement.draws;
        self.order = arrangement.order;
        self.bounds = arrangement.bounds;
        let lists = (&self.meshes, &self.textures, &self.materials);
        self.bind_group = bind_group(gpu, layout, &self.frames, lists);
    }
}

fn bind_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    frames: &wgpu::Buffer,
    (meshes, textures, materials): (&MeshStore, &TextureStore, &Records<MaterialRecord>),
) -> wgpu::BindGroup {
    let [texture_records, texels] = textures.buffers();
    let lists = meshes
        .buffers()
        .into_iter()
        .chain([materials.buffer(), texture_records, texels]);
    let mut entries = vec![wgpu::BindGroupEntry {
        binding: 0,
        resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: frames,
            offset: 0,
            size: wgpu::BufferSize::new(FRAME_STRIDE as u64),
        }),
    }];
    entries.extend(
        (1..)
            .zip(lists)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            }),
    );
    gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("scene"),
        layout,
        entries: &entries,
    })
}
