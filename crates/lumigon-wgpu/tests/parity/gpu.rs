//! A device, and functions run on it.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::poison::poisoned;
use bytemuck::{Pod, Zeroable};
use lumigon::{DistanceFieldSettings, DistanceFields, PolygonLight};
use lumigon_wgpu::{
    DistanceFieldBuffers, ImageColors, Light, LightBuffers, ReplaceImageError, TableFormat, Tables,
};

/// One call's arguments: the shaders' struct `Place`, field by field. A function takes those it needs.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Place {
    pub(crate) point: [f32; 3],
    /// Which light.
    pub(crate) light: u32,
    pub(crate) normal: [f32; 3],
    pub(crate) alpha: f32,
    pub(crate) view: [f32; 3],
    pub(crate) cosine: f32,
    pub(crate) towards: [f32; 3],
    pub(crate) bias: f32,
    /// A lobe's matrix, or any four numbers.
    pub(crate) lobe: [f32; 4],
}

/// What a call gives: as many of these as the function has numbers, then zeros.
pub(crate) type Values = [f32; 12];

const HEADER: &str = "
import package::lights::{lights, light_vertices};
struct Place {
    point: vec3f,
    light: u32,
    normal: vec3f,
    alpha: f32,
    view: vec3f,
    cosine: f32,
    towards: vec3f,
    bias: f32,
    lobe: vec4f,
}
@group(1) @binding(0) var<storage, read> places: array<Place>;
@group(1) @binding(1) var<storage, read_write> results: array<array<vec4f, 3>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < arrayLength(&places) {
        results[id.x] = evaluate(places[id.x]);
    }
}
fn one(x: f32) -> array<vec4f, 3> {
    return four(vec4f(x, 0.0, 0.0, 0.0));
}
fn three(v: vec3f) -> array<vec4f, 3> {
    return four(vec4f(v, 0.0));
}
fn four(v: vec4f) -> array<vec4f, 3> {
    return array<vec4f, 3>(v, vec4f(0.0), vec4f(0.0));
}
";

/// A body that gives a light's vertices to `name`'s sum, and returns `result`.
pub(crate) fn streamed(module: &str, name: &str, begin: &str, result: &str) -> String {
    format!(
        "fn evaluate(place: Place) -> array<vec4f, 3> {{
            let light = lights.list[place.light];
            var sum = package::{module}::{begin};
            for (var i = light.first_record; i < light.end_record; i++) {{
                let record = light_vertices[i];
                if record.w != 0.0 {{
                    sum = package::{module}::{name}_move_to(sum, record.xyz);
                }} else {{
                    sum = package::{module}::{name}_line_to(sum, record.xyz);
                }}
            }}
            return {result};
        }}"
    )
}

pub(crate) struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    lights_layout: wgpu::BindGroupLayout,
    places_layout: wgpu::BindGroupLayout,
    tables: Tables,
}

static LOST: AtomicBool = AtomicBool::new(false);

/// Longest that a function may take over all places: beyond, it hangs.
const PATIENCE: Duration = Duration::from_secs(60);

pub(crate) fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))
            .unwrap_or_else(|fault| {
                panic!(
                    "no GPU to test the shaders on ({fault}): install a driver; Debian's package \
                     mesa-vulkan-drivers has one that needs no GPU"
                )
            });
        println!("on {}", adapter.get_info().name);
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))
            .unwrap_or_else(|fault| panic!("no device on {}: {fault}", adapter.get_info().name));
        device.set_device_lost_callback(|_, message| {
            // Also called when the device is dropped, which this one never is.
            eprintln!("the device is lost: {message}");
            LOST.store(true, Ordering::SeqCst);
        });
        let entry = |binding, read_only| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let places_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[entry(0, true), entry(1, false)],
        });
        let lights_layout = lumigon_wgpu::bind_group_layout(&device, wgpu::ShaderStages::COMPUTE);
        let tables = Tables::new(&device, &queue, TableFormat::F32);
        Gpu {
            device,
            queue,
            lights_layout,
            places_layout,
            tables,
        }
    })
}

/// Fields of the lights that functions see.
pub(crate) fn fields<'a>(
    lights: impl IntoIterator<Item = &'a PolygonLight<f32>>,
) -> DistanceFields<f32> {
    let settings = DistanceFieldSettings::new(32, 2.0, false).unwrap();
    DistanceFields::new(lights, settings, u64::MAX).unwrap()
}

/// Poisoned places that every function has to get over.
const POISONED: usize = 512;

/// The values of a function at all places: `body` is its WESL, with an `evaluate(place: Place)`.
///
/// Poisoned places go in after the others: whatever they give, the function must end, and the device
/// must live.
pub(crate) fn evaluate(
    name: &str,
    body: &str,
    lights: &[PolygonLight<f32>],
    places: &[Place],
) -> Vec<Values> {
    let plain = |polygon: &PolygonLight<f32>| Light {
        polygon: polygon.clone(),
        radiance: [1.0; 3],
        image: None,
    };
    let lights: Vec<_> = lights.iter().map(plain).collect();
    evaluate_on(name, body, &lights, places)
}

/// [`evaluate`], with any lights.
pub(crate) fn evaluate_on(
    name: &str,
    body: &str,
    lights: &[Light],
    places: &[Place],
) -> Vec<Values> {
    let gpu = gpu();
    let count = places.len();
    let places: Vec<Place> = [places, &poisoned(places, POISONED)].concat();
    let text = lumigon_shaders::link(&format!("{HEADER}{body}"), lumigon_wgpu::MODULES)
        .unwrap_or_else(|fault| panic!("{name}: {fault}"));
    if let Err(fault) = naga::front::wgsl::parse_str(&text) {
        panic!("{name}: {}", fault.emit_to_string(&text));
    }
    let module = gpu
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
    let layout = gpu
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &[Some(&gpu.lights_layout), Some(&gpu.places_layout)],
            immediate_size: 0,
        });
    let pipeline = gpu
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
    let buffers = LightBuffers::new(&gpu.device, &gpu.queue, lights).unwrap();
    let fields = fields(lights.iter().map(|light| &light.polygon));
    let fields = DistanceFieldBuffers::upload(&gpu.device, &gpu.queue, &fields).unwrap();
    let lights_group = lumigon_wgpu::bind_group_with_fields(
        &gpu.device,
        &gpu.lights_layout,
        &buffers,
        &gpu.tables,
        &fields,
    );

    let buffer = |size: usize, usage| {
        gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(name),
            size: size as u64,
            usage,
            mapped_at_creation: false,
        })
    };
    let result_size = places.len() * size_of::<Values>();
    let arguments = buffer(
        size_of_val(&*places),
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
    );
    let results = buffer(
        result_size,
        wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    );
    let back = buffer(
        result_size,
        wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
    );
    gpu.queue
        .write_buffer(&arguments, 0, bytemuck::cast_slice(&places));
    let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
    let places_group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(name),
        layout: &gpu.places_layout,
        entries: &[
            entry(0, arguments.as_entire_binding()),
            entry(1, results.as_entire_binding()),
        ],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &lights_group, &[]);
    pass.set_bind_group(1, &places_group, &[]);
    pass.dispatch_workgroups(places.len().div_ceil(64) as u32, 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&results, 0, &back, 0, result_size as u64);
    let submission = gpu.queue.submit([encoder.finish()]);
    back.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    let wait = wgpu::PollType::Wait {
        submission_index: Some(submission),
        timeout: Some(PATIENCE),
    };
    if let Err(fault) = gpu.device.poll(wait) {
        panic!("{name} does not end: {fault}");
    }
    assert!(!LOST.load(Ordering::SeqCst), "{name}: the device is lost");
    let bytes = back.slice(..).get_mapped_range().unwrap();
    let mut values: Vec<Values> = bytemuck::pod_collect_to_vec(&bytes);
    values.truncate(count);
    values
}

/// The texels of all images, after a light's was replaced.
pub(crate) fn texels_after_replacing(
    lights: &[Light],
    light: usize,
    colors: ImageColors<'_>,
) -> Result<Vec<[f32; 4]>, ReplaceImageError> {
    let gpu = gpu();
    let mut buffers = LightBuffers::new(&gpu.device, &gpu.queue, lights).unwrap();
    buffers.replace_image(&gpu.device, &gpu.queue, light, colors)?;
    let texels = buffers.images().texels();
    let back = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: texels.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(texels, 0, &back, 0, texels.size());
    let submission = gpu.queue.submit([encoder.finish()]);
    back.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    let wait = wgpu::PollType::Wait {
        submission_index: Some(submission),
        timeout: Some(PATIENCE),
    };
    gpu.device.poll(wait).unwrap();
    let bytes = back.slice(..).get_mapped_range().unwrap();
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}
