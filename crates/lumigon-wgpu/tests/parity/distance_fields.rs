//! Distance fields: their texels, what is read from them, and the kernels that bake them.

use std::collections::HashMap;
use std::sync::Mutex;

use lumigon::{
    DistanceField, DistanceFieldSettings, DistanceFieldSmoothness, DistanceFields,
    PlacedDistanceField, PolygonLight, Sides, distance_field_smoothness, field_shapes,
    reflected_distance,
};
use lumigon_wgpu::{DistanceFieldBaker, Light, LightBuffers};

use crate::cases::{Sight, Subject, double};
use crate::check::{all, check, check_light};
use crate::gpu::{Place, fields, gpu, streamed};
use crate::tolerances::is_comparable;

/// Texels along a side of the fields whose texels are compared.
const SIDE: u32 = 32;

/// Column and row that a place stands for, in both languages.
const TEXEL: &str = "vec2u(min(vec2f(place.cosine, place.alpha) * 32.0, vec2f(31.0)))";

fn texel(place: &Place) -> usize {
    let cell = |x: f32| ((x * 32.0).min(31.0)) as usize;
    cell(place.cosine) + cell(place.alpha) * SIDE as usize
}

/// Whether both precisions have the same axes: next to some normals rounding chooses.
fn has_same_axes(subject: &Subject) -> bool {
    let ((exact, _), (single, _)) = (subject.light.plane_axes(), subject.single.plane_axes());
    (exact - double(single.into())).length() < 1e-6 && subject.has_same_circle()
}

#[test]
fn distance_field_is_the_cpu_s() {
    for (name, signed) in [("distance_field", false), ("distance_field, signed", true)] {
        let settings = DistanceFieldSettings::new(SIDE, 2.0, signed).unwrap();
        let baked: Mutex<HashMap<u32, DistanceField>> = Mutex::default();
        check(
            name,
            &streamed(
                "distance_field",
                "distance_field",
                &format!(
                    "begin_distance_field(
                        light.polygon,
                        2.0,
                        (2.0 * vec2f({TEXEL}) + 1.0) / 32.0 - 1.0,
                    )"
                ),
                &format!("one(package::distance_field::distance_field(sum, {signed}))"),
            ),
            (-2.0, 2.0),
            |subject, _, _, place| {
                let mut baked = baked.lock().unwrap();
                let field = baked
                    .entry(place.light)
                    .or_insert_with(|| DistanceField::new(&subject.light, settings));
                [field.level(0)[texel(place)].into()]
            },
            // Places and vertices are rounded by 1e-7 radii or two.
            |subject, _, sight, _| (has_same_axes(subject) && !sight.is_sliver).then_some(1e-6),
        );
    }
}

/// What f32 can tell of a distance that is read where a mirrored view meets the plane.
fn read(subject: &Subject, place: &Place, sight: &Sight) -> Option<f64> {
    let (normal, view) = (double(place.normal), double(place.view));
    let reflected = normal * (2.0 * normal.dot(view)) - view;
    let approach = subject.light.normal().dot(reflected).abs();
    let steady = normal.dot(view).abs() > 1e-6 && approach > 1e-3;
    if !is_comparable(sight) || !steady || !has_same_axes(subject) || sight.distance > 1e5 {
        return None;
    }
    let length = sight.plane_height.abs() / approach;
    let moved = 2e-7 * (1.0 + sight.distance + length) / approach;
    let spread = f64::from(place.alpha) * length;
    let slope = distance_field_smoothness(spread, 2.0).min(1e3);
    // Where k_s is in the thousands any rounding is an edge's width.
    (f64::from(place.alpha) > 1e-3).then_some(slope * moved + 1e-6)
}

#[test]
fn reflected_distance_is_the_cpu_s() {
    let cases = all();
    let fields = fields(&cases.lights());
    let placed = |subject: &Subject, place: &Place| -> [f64; 2] {
        let placed = fields.iter().nth(place.light as usize).unwrap();
        let placed = PlacedDistanceField {
            field: placed.field,
            light_to_field: placed.light_to_field.map(f64::from),
        };
        let (point, normal) = (double(place.point), double(place.normal));
        let view = double(place.view);
        let alpha = f64::from(place.alpha);
        let fixed = DistanceFieldSmoothness::fixed(3.0).unwrap();
        [DistanceFieldSmoothness::default(), fixed].map(|smoothness| {
            reflected_distance(
                &subject.light,
                placed,
                point,
                normal,
                view,
                alpha,
                smoothness,
            )
        })
    };
    check_light(
        "reflected_distance",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            let by_material = package::lights::reflected_distance_from(
                place.light, place.point, place.normal, place.view, place.alpha, vec2f(1.0, 0.0)
            );
            let by_user = package::lights::reflected_distance_from(
                place.light, place.point, place.normal, place.view, place.alpha, vec2f(0.0, 3.0)
            );
            return four(vec4f(by_material, by_user, 0.0, 0.0));
        }",
        (0.0, 1.0),
        |subject, _, _, place| placed(subject, place),
        |subject, place, sight, _| read(subject, place, sight),
    );
}

#[test]
fn distance_field_smoothness_is_the_cpu_s() {
    check(
        "distance_field_smoothness",
        "fn evaluate(place: Place) -> array<vec4f, 3> {
            return one(package::distance_field::distance_field_smoothness(place.cosine, 2.0));
        }",
        (0.0, 2e6),
        |_, _, _, place| [distance_field_smoothness(f64::from(place.cosine), 2.0)],
        |_, _, _, exact| Some(1e-6 * exact[0]),
    );
}

fn ring(count: usize, angle: f64, size: f64) -> PolygonLight<f32> {
    let outline = |radius: f64, turn: f64| -> Vec<_> {
        (0..count)
            .map(|i| {
                let at = turn * std::f64::consts::TAU * i as f64 / count as f64 + angle;
                let radius = size * radius * (1.0 + 0.2 * (3.0 * (at - angle)).sin());
                [radius * at.cos(), 5.0 + radius * at.sin(), -3.0]
            })
            .collect()
    };
    PolygonLight::new(&[outline(1.0, 1.0), outline(0.4, -1.0)], Sides::Front)
        .unwrap()
        .cast()
        .unwrap()
}

fn quad() -> PolygonLight<f32> {
    let outline = [
        [0.0, 0.0, 1.0],
        [2.0, 0.0, 1.0],
        [2.0, 1.0, 1.5],
        [0.0, 1.0, 1.5],
    ];
    PolygonLight::new(&[outline], Sides::Both)
        .unwrap()
        .cast()
        .unwrap()
}

/// The bytes of a buffer on the device.
fn read_back(buffer: &wgpu::Buffer) -> Vec<f32> {
    let gpu = gpu();
    let back = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &back, 0, buffer.size());
    gpu.queue.submit([encoder.finish()]);
    back.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    gpu.device
        .poll(wgpu::PollType::wait_indefinitely())
        .unwrap();
    let bytes = back.slice(..).get_mapped_range().unwrap();
    bytemuck::pod_collect_to_vec(&bytes)
}

/// All levels of all fields, those of shapes that several lights share once.
#[test]
fn the_gpu_bakes_what_the_cpu_does() {
    let polygons = [
        quad(),
        ring(100, 0.0, 1.0),
        ring(100, 1.0, 0.01),
        ring(1500, 0.0, 30.0),
        quad(),
    ];
    let lights: Vec<_> = polygons
        .iter()
        .map(|polygon| Light {
            polygon: polygon.clone(),
            radiance: [1.0; 3],
            image: None,
        })
        .collect();
    let gpu = gpu();
    let buffers = LightBuffers::new(&gpu.device, &gpu.queue, &lights).unwrap();
    let baker = DistanceFieldBaker::new(&gpu.device).unwrap();
    let polygons: Vec<_> = polygons.iter().collect();
    for (resolution, phi, signed) in [(64, 2.0, false), (4, 1.0, true), (128, 3.0, true)] {
        let settings = DistanceFieldSettings::new(resolution, phi, signed).unwrap();
        let fields = DistanceFields::new(polygons.iter().copied(), settings, u64::MAX).unwrap();
        assert_eq!(fields.fields().len(), 3);
        let (shapes, placements) = field_shapes(&polygons, phi.into());
        let baked = baker
            .bake(
                &gpu.device,
                &gpu.queue,
                &buffers,
                &polygons,
                (&shapes, &placements),
                settings,
            )
            .unwrap();
        let exact: Vec<f32> = fields
            .fields()
            .iter()
            .flat_map(|field| field.texels().iter().copied())
            .collect();
        let got = read_back(baked.texels());
        assert_eq!(got.len(), exact.len());
        let worst = got
            .iter()
            .zip(&exact)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
        println!("baked {resolution}: {worst:e}");
        assert!(worst < 1e-5, "{worst:e}");
    }
}
