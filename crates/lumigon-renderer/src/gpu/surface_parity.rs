//! What a ray meets is the same on both devices: `surface_at` = [`Scene::surface`], and `ray_is_blocked`
//! = [`Geometry::occluded`].

use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::frame::View;
use super::rays::Rays;
use super::scene_buffers::{DRAWN, Drawn, SceneBuffers, layout};
use super::shader::{Shader, scene_constants};
use super::tile::Tile;
use super::{Gpu, GpuPreference};
use crate::cpu::Geometry;
use crate::scene::{
    AlphaMode, Camera, Filter, Material, Mesh, Sampler, Scene, SurfaceSample, Texels, Texture,
    TextureRef, TextureTransform, Wrap,
};

const ROOT: &str = "
import package::frame::frame;
import package::surface::{opacity_at, surface_at};

struct Query { direction: vec3f, triangle: u32, barycentrics: vec2f }

@group(2) @binding(0) var<storage, read> queries: array<Query>;
@group(2) @binding(1) var<storage, read_write> answers: array<vec4f>;

@compute @workgroup_size(64)
fn answer(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let query = queries[id.x];
    let s = surface_at(query.triangle, query.barycentrics, query.direction);
    let opacity = opacity_at(query.triangle, query.barycentrics, query.direction);
    let first = id.x * 11u;
    answers[first] = vec4f(s.position, s.metallic);
    answers[first + 1u] = vec4f(s.geometric_normal, s.perceptual_roughness);
    answers[first + 2u] = vec4f(s.shading_normal, s.specular);
    answers[first + 3u] = vec4f(s.base_color, s.ior);
    answers[first + 4u] = vec4f(s.specular_color, s.anisotropy_strength);
    answers[first + 5u] = vec4f(s.tangent, s.diffuse_roughness);
    answers[first + 6u] = vec4f(s.sheen_color, s.sheen_perceptual_roughness);
    answers[first + 7u] = vec4f(s.clearcoat_normal, s.clearcoat);
    answers[first + 8u] = vec4f(s.emissive, s.clearcoat_perceptual_roughness);
    answers[first + 9u] = vec4f(s.opacity, opacity, f32(s.front), f32(s.unlit));
    answers[first + 10u] = vec4f(frame.share);
}
";

/// Groups of four numbers an answer, the last of them to see that it was written.
const ANSWER: usize = 11;

const RAYS_ROOT: &str = "
import package::frame::frame;
import package::rays::ray_is_blocked;

struct Query { origin: vec3f, nearest: f32, direction: vec3f, farthest: f32 }

@group(2) @binding(0) var<storage, read> queries: array<Query>;
@group(2) @binding(1) var<storage, read_write> answers: array<vec4f>;

@compute @workgroup_size(64)
fn answer(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let query = queries[id.x];
    let blocked = ray_is_blocked(query.origin, query.direction, query.nearest, query.farthest);
    answers[id.x] = vec4f(f32(blocked), frame.share, 0.0, 0.0);
}
";

fn answer(surface: &SurfaceSample) -> [(&'static str, Vec4); 10] {
    let flag = |is| if is { 1.0 } else { 0.0 };
    let s = surface;
    let flags = [s.opacity, s.opacity, flag(s.front), flag(s.unlit)];
    [
        ("position, metallic", s.position.extend(s.metallic)),
        (
            "geometric normal, roughness",
            s.geometric_normal.extend(s.perceptual_roughness),
        ),
        (
            "shading normal, specular",
            s.shading_normal.extend(s.specular),
        ),
        ("base color, ior", s.base_color.extend(s.ior)),
        (
            "specular color, anisotropy",
            s.specular_color.extend(s.anisotropy_strength),
        ),
        (
            "tangent, diffuse roughness",
            s.tangent.extend(s.diffuse_roughness),
        ),
        ("sheen", s.sheen_color.extend(s.sheen_perceptual_roughness)),
        ("coat normal, coat", s.clearcoat_normal.extend(s.clearcoat)),
        (
            "emissive, coat roughness",
            s.emissive.extend(s.clearcoat_perceptual_roughness),
        ),
        ("opacity, front, unlit", Vec4::from(flags)),
    ]
}

struct Random(Pcg64Mcg);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0.random()
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| 2.0 * self.unit() - 1.0))
    }

    fn chance(&mut self, share: f32) -> bool {
        self.unit() < share
    }

    fn index(&mut self, length: usize) -> usize {
        self.0.random_range(0..length)
    }

    fn texture(&mut self) -> Texture {
        let size = [self.0.random_range(1..6), self.0.random_range(1..6)];
        let count = (size[0] * size[1]) as usize;
        let texels = match self.index(3) {
            0 => Texels::U8((0..count).map(|_| self.0.random()).collect()),
            1 => Texels::U16((0..count).map(|_| self.0.random()).collect()),
            _ => Texels::F32((0..count).map(|_| self.0.random()).collect()),
        };
        let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
        let sampler = Sampler {
            wrap_s: wraps[self.index(3)],
            wrap_t: wraps[self.index(3)],
            filter: [Filter::Nearest, Filter::Linear][self.index(2)],
        };
        let srgb = self.chance(0.5);
        Texture::new(String::new(), size, Arc::new(texels), srgb, sampler)
    }

    fn texture_ref(&mut self, textures: usize) -> Option<TextureRef> {
        self.chance(0.6).then(|| TextureRef {
            texture: self.index(textures),
            texcoord: self.index(2),
            transform: if self.chance(0.5) {
                TextureTransform::default()
            } else {
                let [offset, scale] = [self.vec3(), self.vec3() * 3.0];
                TextureTransform::new(offset.truncate(), 6.0 * self.unit(), scale.truncate())
            },
        })
    }

    fn material(&mut self, textures: usize) -> Material {
        Material {
            base_color: self.vec3().abs().extend(self.unit()),
            metallic: self.unit(),
            perceptual_roughness: self.unit(),
            specular: self.unit(),
            specular_color: self.vec3().abs() * 2.0,
            ior: [0.0, 1.0, 1.5][self.index(3)],
            anisotropy_strength: self.unit() * f32::from(u8::from(self.chance(0.7))),
            anisotropy_rotation: 6.0 * self.unit(),
            diffuse_roughness: self.unit(),
            sheen_color: self.vec3().abs(),
            sheen_perceptual_roughness: self.unit(),
            clearcoat: self.unit() * f32::from(u8::from(self.chance(0.7))),
            clearcoat_perceptual_roughness: self.unit(),
            clearcoat_normal_scale: self.unit(),
            normal_scale: 2.0 * self.unit(),
            emissive: self.vec3().abs() * 10.0,
            alpha_mode: match self.index(3) {
                0 => AlphaMode::Opaque,
                1 => AlphaMode::Blend,
                _ => AlphaMode::Mask { cutoff: 0.3 },
            },
            double_sided: self.chance(0.5),
            unlit: self.chance(0.2),
            base_color_texture: self.texture_ref(textures),
            metallic_roughness_texture: self.texture_ref(textures),
            normal_texture: self.texture_ref(textures),
            emissive_texture: self.texture_ref(textures),
            specular_texture: self.texture_ref(textures),
            specular_color_texture: self.texture_ref(textures),
            anisotropy_texture: self.texture_ref(textures),
            diffuse_roughness_texture: self.texture_ref(textures),
            sheen_color_texture: self.texture_ref(textures),
            sheen_roughness_texture: self.texture_ref(textures),
            clearcoat_texture: self.texture_ref(textures),
            clearcoat_roughness_texture: self.texture_ref(textures),
            clearcoat_normal_texture: self.texture_ref(textures),
            ..Material::default()
        }
    }

    fn mesh(&mut self, materials: usize) -> Mesh {
        const VERTICES: usize = 9;
        let mut list = |has: f32| {
            let length = if self.chance(has) { VERTICES } else { 0 };
            (0..length)
                .map(|_| self.vec3().extend(2.0 * self.unit() - 1.0))
                .collect::<Vec<_>>()
        };
        let [positions, normals, colors] = [1.0, 0.9, 0.5].map(&mut list);
        let tangents = list(0.5);
        let texcoords = [list(0.8), list(0.5)];
        let three = |list: Vec<Vec4>| list.into_iter().map(Vec4::truncate).collect::<Vec<_>>();
        Mesh {
            positions: three(positions),
            normals: three(normals).iter().map(|n| n.normalize()).collect(),
            tangents: tangents
                .into_iter()
                .map(|t| t.truncate().normalize().extend(t.w.signum()))
                .collect(),
            colors: colors.into_iter().map(Vec4::abs).collect(),
            texcoords: texcoords
                .map(|uvs| uvs.iter().map(|uv| Vec2::new(uv.x, uv.y) * 3.0).collect()),
            triangles: (0..6).map(|i| [i, i + 2, i + 3]).collect(),
            material: self.index(materials),
            ..Mesh::default()
        }
    }
}

/// Where the scene's triangles are on the device, in the device's order: mesh and index.
fn order(scene: &Scene) -> Vec<(usize, usize)> {
    let drawn = |mesh: &Mesh| Drawn::of(&scene.materials[mesh.material]);
    DRAWN
        .iter()
        .flat_map(|by| {
            let meshes = scene.meshes.iter().enumerate();
            meshes.filter(move |(_, mesh)| drawn(mesh) == *by)
        })
        .flat_map(|(i, mesh)| (0..mesh.triangles.len()).map(move |triangle| (i, triangle)))
        .collect()
}

/// The device's answers, `groups` of four numbers a query; `root` may ask for rays.
fn answers(gpu: &Gpu, scene: &Scene, root: &str, queries: &[[f32; 8]], groups: usize) -> Vec<Vec4> {
    let device = gpu.device();
    let scene_layout = layout(gpu);
    let buffers = SceneBuffers::new(gpu, &scene_layout, scene).unwrap();
    let camera = Camera::framing(scene);
    let view = View::new(&camera, [1, 1], scene.bounds()).unwrap();
    let tile = Tile {
        origin: [0, 0],
        size: [1, 1],
    };
    let frame = view.frame(tile, [0.5; 2], 0.25);
    gpu.queue()
        .write_buffer(&buffers.frames, 0, bytemuck::bytes_of(&frame));
    let rays = Rays::new(gpu, scene, &buffers.order).unwrap();
    let shader = Shader::new(gpu, "parity", root).unwrap();
    let constants = shader.constants(&scene_constants(buffers.features));
    let pipeline = {
        let storage = |binding, read_only| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let test_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[storage(0, true), storage(1, false), storage(6, true)],
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[None, Some(&scene_layout), Some(&test_layout)],
            immediate_size: 0,
        });
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: Some(&layout),
            module: &shader.module,
            entry_point: Some("answer"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                ..Default::default()
            },
            cache: None,
        })
    };
    let buffer = |usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: (queries.len() * groups * size_of::<Vec4>()) as u64,
            usage,
            mapped_at_creation: false,
        })
    };
    let written = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(2),
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: gpu.storage("queries", queries).unwrap().as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: written.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 6,
                resource: rays.nodes.as_entire_binding(),
            },
        ],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(1, &buffers.bind_group, &[0]);
    pass.set_bind_group(2, &group, &[]);
    pass.dispatch_workgroups(queries.len().div_ceil(64) as u32, 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&written, 0, &read, 0, read.size());
    let submission = gpu.queue().submit([encoder.finish()]);
    let mut numbers = Vec::new();
    gpu.read(
        &submission,
        &[read.slice(..)],
        || false,
        |_, bytes| {
            numbers = bytemuck::pod_collect_to_vec(bytes);
        },
    )
    .unwrap();
    numbers
}

/// Triangles of all kinds of materials, all over a cube.
fn random_scene(random: &mut Random, meshes: usize) -> Scene {
    let textures: Vec<_> = (0..12).map(|_| random.texture()).collect();
    let materials: Vec<_> = (0..40).map(|_| random.material(textures.len())).collect();
    let meshes: Vec<_> = (0..meshes)
        .map(|_| random.mesh(materials.len()).into())
        .collect();
    Scene {
        meshes,
        materials,
        textures,
        ..Scene::default()
    }
}

#[test]
fn surfaces_are_the_same_on_both_devices() {
    let gpu = Gpu::new(GpuPreference::Any).unwrap();
    let mut random = Random(Pcg64Mcg::seed_from_u64(11));
    let scene = random_scene(&mut random, 120);
    let order = order(&scene);
    let asked: Vec<_> = (0..8000)
        .map(|_| {
            let mut at = Vec2::new(random.unit(), random.unit());
            if at.x + at.y > 1.0 {
                at = Vec2::ONE - at;
            }
            (random.index(order.len()), at, random.vec3().normalize())
        })
        .collect();
    let queries: Vec<_> = asked
        .iter()
        .map(|&(triangle, at, direction)| {
            let [x, y, z] = direction.to_array();
            let triangle = f32::from_bits(triangle as u32);
            [x, y, z, triangle, at.x, at.y, 0.0, 0.0]
        })
        .collect();
    let got = gpu
        .guarded("a test", || {
            Ok(answers(&gpu, &scene, ROOT, &queries, ANSWER))
        })
        .unwrap();
    let mut differing = 0;
    for (i, &(triangle, at, direction)) in asked.iter().enumerate() {
        let (mesh, index) = order[triangle];
        let expected = answer(&scene.surface(mesh, index, at, direction));
        let got = &got[i * ANSWER..];
        assert_eq!(got[10], Vec4::splat(0.25));
        for ((what, expected), got) in expected.into_iter().zip(got) {
            let off = (expected - got).abs() / (1.0 + expected.abs());
            if off.is_nan() || off.max_element() > 2e-4 {
                differing += 1;
                println!("{what} of mesh {mesh} triangle {index} at {at}: {expected}, not {got}");
            }
        }
    }
    // Where rounding decides which texel is nearest, or on which side of a cutoff it is.
    assert!(differing <= 8, "{differing} numbers differ");
}

/// How many rays each device finds blocked, and of how many they disagree.
fn blocked(gpu: &Gpu, scene: &Scene, rays: &[[f32; 8]]) -> [usize; 3] {
    let got = gpu
        .guarded("a test", || Ok(answers(gpu, scene, RAYS_ROOT, rays, 1)))
        .unwrap();
    let geometry = Geometry::new(scene);
    let mut counts = [0; 3];
    for (ray, got) in rays.iter().zip(&got) {
        let [ox, oy, oz, nearest, x, y, z, farthest] = *ray;
        let (origin, direction) = (Vec3::new(ox, oy, oz), Vec3::new(x, y, z));
        let on_cpu = geometry.occluded(scene, origin, direction, nearest, farthest);
        let on_gpu = got.x == 1.0;
        assert!(got.y == 0.25 && (on_gpu || got.x == 0.0), "{got}");
        counts[0] += usize::from(on_cpu);
        counts[1] += usize::from(on_gpu);
        counts[2] += usize::from(on_cpu != on_gpu);
        if on_cpu != on_gpu {
            println!("{ray:?}: {on_cpu} on the CPU, {on_gpu} on the GPU");
        }
    }
    counts
}

#[test]
fn rays_are_blocked_alike_on_both_devices() {
    let gpu = Gpu::new(GpuPreference::Any).unwrap();
    let mut random = Random(Pcg64Mcg::seed_from_u64(23));
    for (meshes, most_differing) in [(1, 3), (3, 3), (120, 10)] {
        let scene = random_scene(&mut random, meshes);
        let rays: Vec<_> = (0..20_000)
            .map(|i| {
                let origin = random.vec3() * 1.5;
                let direction = match i % 8 {
                    // Along an axis, both ways.
                    0 => Vec3::AXES[random.index(3)],
                    1 => -Vec3::AXES[random.index(3)],
                    _ => random.vec3().normalize(),
                };
                let nearest = 0.1 * random.unit();
                let farthest = match i % 5 {
                    0 => f32::INFINITY,
                    1 => 3e38,
                    _ => nearest + random.unit() - 0.05,
                };
                let ([ox, oy, oz], [x, y, z]) = (origin.to_array(), direction.to_array());
                [ox, oy, oz, nearest, x, y, z, farthest]
            })
            .collect();
        let [on_cpu, on_gpu, differing] = blocked(&gpu, &scene, &rays);
        println!("{meshes} meshes: {on_cpu} and {on_gpu} blocked, {differing} differ");
        assert!((100..19_000).contains(&on_cpu), "{on_cpu}");
        // Those that graze edges, texels' borders and distances.
        assert!(differing <= most_differing, "{differing} rays differ");
    }
}

#[test]
fn nothing_blocks_rays_where_nothing_is() {
    let gpu = Gpu::new(GpuPreference::Any).unwrap();
    let scene = Scene::default();
    let rays = [[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1e9]; 64];
    assert_eq!(blocked(&gpu, &scene, &rays), [0; 3]);
}
