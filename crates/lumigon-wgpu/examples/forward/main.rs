//! Adds polygon lights to a forward renderer on wgpu, renders one picture and compares it with the
//! CPU: `cargo run -p lumigon-wgpu --example forward`.
//!
//! `renderer.rs` stands for the renderer that you have; this file and the loop over the lights in
//! `floor.wgsl` are what lumigon adds to it.

mod renderer;

use lumigon::{LtcTable, PolygonLight, PreparedLtc, Sides, Vec3, form_factor, ltc_form_factor};
use lumigon_wgpu::{Light, LightBuffers, TableFormat, Tables};
use pollster::FutureExt;
use renderer::{EYE, Renderer, SIDE, floor_point};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = instance
        .request_adapter(&wgpu::RequestAdapterOptions::default())
        .block_on()
        .map_err(|fault| format!("{fault}: install a Vulkan driver or mesa-vulkan-drivers"))?;
    let (device, queue) = adapter
        .request_device(&wgpu::DeviceDescriptor::default())
        .block_on()?;

    // A light: a star that shines down.
    let star: Vec<[f64; 3]> = (0..10)
        .map(|i| {
            let (radius, angle) = ([1.0, 0.4][i % 2], 0.2 * std::f64::consts::PI * i as f64);
            [radius * angle.cos(), 1.0, radius * angle.sin()]
        })
        .collect();
    let lights = [Light {
        polygon: PolygonLight::new(&[star], Sides::Front)?.cast()?,
        radiance: [4.0, 3.0, 2.0],
        image: None,
    }];

    // What shaders read, and where they find it: bind group 1, behind the renderer's own.
    let buffers = LightBuffers::new(&device, &queue, &lights)?;
    let tables = Tables::new(&device, &queue, TableFormat::F32);
    let layout = lumigon_wgpu::bind_group_layout(&device, wgpu::ShaderStages::FRAGMENT);
    let group = lumigon_wgpu::bind_group(&device, &layout, &buffers, &tables);
    let shader = lumigon_wgpu::wgsl(1)? + include_str!("floor.wgsl");

    // Lights that move: `buffers.write(&device, &queue, &lights)`, every frame.
    let renderer = Renderer::new(&device, &shader, &layout);
    let pixels = renderer.render(&device, &queue, &group)?;
    println!(
        "{SIDE}x{SIDE} pixels, the middle one: {:?}",
        pixels[pixels.len() / 2 + SIDE as usize / 2]
    );

    // The same on the CPU.
    let (table, mut worst) = (LtcTable::ggx(), 0.0_f32);
    for (i, pixel) in pixels.iter().enumerate() {
        let expected = floor_point(i as u32).map_or(0.0, |point| {
            let normal = Vec3::new(0.0, 1.0, 0.0);
            let view = (Vec3::new(EYE[0], EYE[1], EYE[2]) - point).normalize_or_zero();
            let sum = table.lookup(0.3, normal.dot(view));
            let lobe = PreparedLtc::new(&sum.lobes[0], normal, view);
            let light = &lights[0].polygon;
            (0.5 + sum.cosine.reflectance(0.04, 1.0)) * form_factor(light, point, normal)
                + sum.lobes[0].reflectance(0.04, 1.0) * ltc_form_factor(light, point, &lobe)
        });
        for (got, radiance) in pixel.iter().zip(lights[0].radiance) {
            worst = worst.max((got / radiance - expected).abs());
        }
    }
    println!("greatest difference from the CPU, for radiance 1: {worst:e}");
    if worst > 1e-5 {
        return Err("GPU and CPU differ".into());
    }
    Ok(())
}
