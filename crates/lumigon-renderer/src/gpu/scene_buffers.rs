//! A scene in storage buffers.

use std::ops::Range;

use glam::Vec3;

use super::device::Gpu;
use super::error::GpuError;
use super::record::{MaterialRecord, MeshRecord, NONE, TriangleRecord, textures};
use super::storage::check;
use super::texels;
use crate::scene::{AlphaMode, Material, Mesh, Scene};

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
    pub(super) ranges: [Range<u32>; 3],
    pub(super) order: TriangleOrder,
    pub(super) bounds: Option<(Vec3, Vec3)>,
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

impl SceneBuffers {
    pub(super) fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        scene: &Scene,
    ) -> Result<Self, GpuError> {
        let limit = gpu.adapter().largest_storage();
        let lists = Lists::new(scene, limit)?;
        let (textures, texels) =
            texels::packed(&scene.textures, limit / 4).map_err(|words| GpuError::TooMuch {
                what: "texels",
                count: words,
                needed: words * 4,
                limit,
            })?;
        let materials: Vec<_> = scene.materials.iter().map(MaterialRecord::from).collect();
        let frames = gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("frames"),
            size: (FRAMES * FRAME_STRIDE) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let buffers = [
            gpu.storage("triangles", &lists.triangles)?,
            gpu.storage("vertices", &lists.positions)?,
            gpu.storage("meshes", &lists.meshes)?,
            gpu.storage("vertex attributes", &lists.attributes)?,
            gpu.storage("materials", &materials)?,
            gpu.storage("textures", &textures)?,
            gpu.storage("texels", &texels)?,
        ];
        let mut entries = vec![wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &frames,
                offset: 0,
                size: wgpu::BufferSize::new(FRAME_STRIDE as u64),
            }),
        }];
        entries.extend(
            (1..)
                .zip(&buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                }),
        );
        let bind_group = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene"),
            layout,
            entries: &entries,
        });
        Ok(Self {
            bind_group,
            frames,
            ranges: lists.ranges,
            order: lists.order,
            bounds: scene.bounds(),
            features: Features::new(&scene.materials),
        })
    }
}

/// Which triangle of the scene, counted over its meshes, each triangle on the device is.
#[derive(Default)]
pub(super) struct TriangleOrder {
    /// The first triangle of each mesh: on the device, ascending, and of the scene.
    starts: Vec<[u32; 2]>,
}

impl TriangleOrder {
    fn push(&mut self, on_device: u32, of_scene: u32) {
        // Meshes without triangles start where the next one does.
        if self.starts.last().is_some_and(|last| last[0] == on_device) {
            self.starts.pop();
        }
        self.starts.push([on_device, of_scene]);
    }

    /// The triangle of the scene.
    pub(super) fn of_scene(&self, on_device: u32) -> u32 {
        let after = self.starts.partition_point(|start| start[0] <= on_device);
        let [first, of_scene] = after.checked_sub(1).map_or([0; 2], |i| self.starts[i]);
        of_scene + (on_device - first)
    }
}

/// The lists of a scene's meshes.
#[derive(Default)]
struct Lists {
    triangles: Vec<TriangleRecord>,
    ranges: [Range<u32>; 3],
    order: TriangleOrder,
    positions: Vec<[f32; 4]>,
    meshes: Vec<MeshRecord>,
    attributes: Vec<f32>,
}

impl Lists {
    fn new(scene: &Scene, limit: u64) -> Result<Self, GpuError> {
        // Before anything is copied. Three vertices a triangle have to be counted in 32 bits.
        let count = |of: fn(&Mesh) -> usize| scene.meshes.iter().map(|m| of(m) as u64).sum();
        let triangle = size_of::<TriangleRecord>();
        let triangle_limit = limit.min(u64::from(u32::MAX / 3) * triangle as u64);
        check(
            "triangles",
            count(|m| m.triangles.len()),
            triangle,
            triangle_limit,
        )?;
        check("vertices", count(|m| m.positions.len()), 16, limit)?;
        let numbers = count(|m| m.positions.len() * Attributes::new(m).stride as usize);
        check("vertex attributes", numbers, 4, limit)?;

        let mut lists = Self::default();
        let mut before = Vec::new();
        let mut triangles = 0;
        for mesh in &scene.meshes {
            lists.push_vertices(mesh);
            before.push(triangles);
            triangles += mesh.triangles.len() as u32;
        }
        for (range, drawn) in DRAWN.iter().enumerate() {
            let start = lists.triangles.len() as u32;
            for (index, mesh) in scene.meshes.iter().enumerate() {
                if Drawn::of(&scene.materials[mesh.material]) != *drawn {
                    continue;
                }
                let first = lists.meshes[index].first_vertex;
                let records = mesh.triangles.iter().map(|corners| TriangleRecord {
                    corners: corners.map(|i| first + i),
                    mesh: index as u32,
                });
                lists
                    .order
                    .push(lists.triangles.len() as u32, before[index]);
                lists.triangles.extend(records);
            }
            lists.ranges[range] = start..lists.triangles.len() as u32;
        }
        Ok(lists)
    }

    fn push_vertices(&mut self, mesh: &Mesh) {
        let attributes = Attributes::new(mesh);
        self.meshes.push(MeshRecord {
            material: mesh.material as u32,
            first_vertex: self.positions.len() as u32,
            first_number: self.attributes.len() as u32,
            stride: attributes.stride,
            normal: attributes.normal,
            tangent: attributes.tangent,
            color: attributes.color,
            texcoord: attributes.texcoord,
        });
        for (i, position) in mesh.positions.iter().enumerate() {
            self.positions.push(position.extend(0.0).into());
            let to = &mut self.attributes;
            if attributes.normal != NONE {
                to.extend(mesh.normals[i].to_array());
            }
            if attributes.tangent != NONE {
                to.extend(mesh.tangents[i].to_array());
            }
            if attributes.color != NONE {
                to.extend(mesh.colors[i].to_array());
            }
            for (texcoords, offset) in mesh.texcoords.iter().zip(attributes.texcoord) {
                if offset != NONE {
                    to.extend(texcoords[i].to_array());
                }
            }
        }
    }
}

/// Where a mesh's vertices have which attribute, in numbers.
struct Attributes {
    normal: u32,
    tangent: u32,
    color: u32,
    texcoord: [u32; 2],
    stride: u32,
}

impl Attributes {
    fn new(mesh: &Mesh) -> Self {
        let mut stride = 0;
        let mut place = |length: usize, numbers: u32| {
            // One for each vertex, or none.
            if length == 0 || length < mesh.positions.len() {
                return NONE;
            }
            stride += numbers;
            stride - numbers
        };
        Self {
            normal: place(mesh.normals.len(), 3),
            tangent: place(mesh.tangents.len(), 4),
            color: place(mesh.colors.len(), 4),
            texcoord: [
                place(mesh.texcoords[0].len(), 2),
                place(mesh.texcoords[1].len(), 2),
            ],
            stride,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn triangles_are_sorted_by_how_they_are_drawn() {
        let triangle = |material| Mesh {
            material,
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let masked = Material {
            alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
            ..Material::default()
        };
        let double_sided = Material {
            double_sided: true,
            ..Material::default()
        };
        let scene = Scene {
            meshes: [0, 1, 2, 1].map(|m| Arc::new(triangle(m))).to_vec(),
            materials: vec![masked, Material::default(), double_sided],
            ..Scene::default()
        };
        let lists = Lists::new(&scene, u64::MAX).unwrap();
        assert_eq!(lists.ranges, [0..2, 2..3, 3..4]);
        let meshes: Vec<_> = lists.triangles.iter().map(|t| t.mesh).collect();
        assert_eq!(meshes, [1, 3, 2, 0]);
        assert_eq!([0, 1, 2, 3].map(|i| lists.order.of_scene(i)), [1, 3, 2, 0]);
        assert_eq!(lists.triangles[1].corners, [9, 10, 11]);
        assert_eq!(
            (lists.meshes[3].first_number, lists.attributes.len()),
            (27, 36)
        );
        let fault = Lists::new(&scene, 63).err();
        assert!(
            matches!(
                fault,
                Some(GpuError::TooMuch {
                    what: "triangles",
                    count: 4,
                    ..
                })
            ),
            "{fault:?}"
        );
    }
}
