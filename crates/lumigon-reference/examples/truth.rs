//! Writes the truth values of the anisotropic GGX, Charlie and EON lobes to `tests/truth/`:
//!
//! `cargo run --release -p lumigon-reference --example truth -- tests/truth`
//!
//! Each line is one random polygon (3 to 8 vertices, star-shaped, often concave, often across the horizon) over one
//! random surface, with the light it reflects at radiance 1. The same command writes the same lines. Numbers are
//! rounded before anything is computed from them, so a line holds exactly what its truth was computed from. Every value
//! is asked for to 1e-9, absolute; the estimated errors are below 1e-8.

use std::error::Error;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use glam::DVec3;
use lumigon_reference::{
    EonIntegral, GgxIntegral, Integral, Polygon, Tolerance, charlie, eon, ggx_anisotropic,
};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use serde_json::{Value, json};

const LINES: usize = 200;

const TOLERANCE: Tolerance = Tolerance {
    absolute: 1e-9,
    relative: 0.0,
    max_evaluations: 20_000_000,
};

struct Random(Pcg64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.0.next_u64() >> 11) as f64 * (0.5 * f64::EPSILON);
        rounded(low + (high - low) * unit)
    }

    fn direction(&mut self) -> DVec3 {
        let z = self.between(-1.0, 1.0);
        let phi = self.between(0.0, 2.0 * PI);
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * phi.cos(), radius * phi.sin(), z)
    }
}

/// A surface element with a polygon over it.
struct Case {
    polygon: Polygon,
    loops: Vec<Vec<[f64; 3]>>,
    point: [f64; 3],
    normal: [f64; 3],
    tangent: [f64; 3],
    view: [f64; 3],
}

impl Case {
    /// A case whose polygon is valid, lit side to the point, and partly or wholly above the horizon.
    fn random(random: &mut Random) -> Self {
        loop {
            let point = random.direction() * 2.0;
            let normal = random.direction();
            let x = normal.any_orthonormal_vector();
            let y = normal.cross(x);
            // Views from the normal to 88 degrees.
            let (theta, phi) = (
                random.between(0.0, 88.0).to_radians(),
                random.between(0.0, 2.0 * PI),
            );
            let view = theta.sin() * (phi.cos() * x + phi.sin() * y) + theta.cos() * normal;
            let turn = random.between(0.0, 2.0 * PI);
            let tangent = turn.cos() * x + turn.sin() * y;

            // The centre's direction may be a little below the horizon.
            let towards = (random.direction() + 0.8 * normal).normalize();
            let distance = 10_f64.powf(random.between(-0.7, 0.7));
            let centre = point + distance * towards;
            let mut facing = random.direction();
            if facing.dot(towards) > 0.0 {
                facing = -facing;
            }
            let u = facing.any_orthonormal_vector();
            let v = facing.cross(u);
            let size = 10_f64.powf(random.between(-0.6, 0.7)) * distance;
            let count = random.between(3.0, 9.0).floor() as usize;
            let corners = (0..count).map(|i| {
                let angle = 2.0 * PI * (i as f64 + random.between(0.0, 0.8)) / count as f64;
                let radius = size * random.between(0.25, 1.0);
                rounded3(centre + radius * (angle.cos() * u + angle.sin() * v))
            });
            let loops = vec![corners.collect::<Vec<_>>()];
            let [point, normal, tangent, view] = [point, normal, tangent, view].map(rounded3);
            let Ok(polygon) = Polygon::new(&loops, false) else {
                continue;
            };
            let faces = DVec3::from(point) - DVec3::from(loops[0][0]);
            let above = |vertex: &[f64; 3]| {
                (DVec3::from(*vertex) - DVec3::from(point)).dot(normal.into()) > 0.0
            };
            if DVec3::from(polygon.normal()).dot(faces) > 0.0 && loops[0].iter().any(above) {
                return Self {
                    polygon,
                    loops,
                    point,
                    normal,
                    tangent,
                    view,
                };
            }
        }
    }

    /// The line's fields that every quantity has, with some more.
    fn line(&self, more: &Value) -> String {
        let mut line = json!({
            "loops": self.loops,
            "point": self.point,
            "normal": self.normal,
            "view": self.view,
        });
        if let (Some(line), Some(more)) = (line.as_object_mut(), more.as_object()) {
            line.extend(more.iter().map(|(key, value)| (key.clone(), value.clone())));
        }
        line.to_string()
    }
}

fn rounded(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
}

fn rounded3(v: DVec3) -> [f64; 3] {
    v.to_array().map(rounded)
}

fn anisotropic_line(case: &Case, random: &mut Random) -> Result<String, Box<dyn Error>> {
    let perceptual_roughness = random.between(0.1, 1.0);
    let strength = random.between(0.0, 1.0);
    let alpha_b = rounded(perceptual_roughness * perceptual_roughness);
    // As KHR_materials_anisotropy maps its strength.
    let alpha = [
        rounded(alpha_b + (1.0 - alpha_b) * strength * strength),
        alpha_b,
    ];
    let GgxIntegral { value, schlick, .. } = ggx_anisotropic(
        &case.polygon,
        case.point,
        case.normal,
        case.tangent,
        case.view,
        alpha,
        TOLERANCE,
    )?;
    Ok(case.line(&json!({
        "tangent": case.tangent,
        "alpha": alpha,
        "perceptual_roughness": perceptual_roughness,
        "anisotropy_strength": strength,
        "quantity": "ggx_anisotropic",
        "truth": value,
        "truth_schlick": schlick,
    })))
}

fn charlie_line(case: &Case, random: &mut Random) -> Result<String, Box<dyn Error>> {
    let perceptual_roughness = random.between(0.1, 1.0);
    let alpha = rounded(perceptual_roughness * perceptual_roughness);
    let Integral { value, .. } = charlie(
        &case.polygon,
        case.point,
        case.normal,
        case.view,
        alpha,
        TOLERANCE,
    )?;
    Ok(case.line(&json!({
        "sheen_perceptual_roughness": perceptual_roughness,
        "alpha": alpha,
        "quantity": "charlie",
        "truth": value,
    })))
}

fn eon_line(case: &Case, random: &mut Random) -> Result<String, Box<dyn Error>> {
    let diffuse_roughness = random.between(0.0, 1.0);
    let EonIntegral {
        single, multiple, ..
    } = eon(
        &case.polygon,
        case.point,
        case.normal,
        case.view,
        diffuse_roughness,
        TOLERANCE,
    )?;
    Ok(case.line(&json!({
        "diffuse_roughness": diffuse_roughness,
        "quantity": "eon",
        "truth_single": single,
        "truth_multiple": multiple,
    })))
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args()
        .nth(1)
        .ok_or("name the folder to write to: truth -- tests/truth")?;
    type Line = fn(&Case, &mut Random) -> Result<String, Box<dyn Error>>;
    let quantities: [(&str, Line); 3] = [
        ("ggx_anisotropic", anisotropic_line),
        ("charlie", charlie_line),
        ("eon", eon_line),
    ];
    for (seed, (name, line)) in quantities.into_iter().enumerate() {
        let mut random = Random(Pcg64::seed_from_u64(seed as u64));
        let mut text = String::new();
        for _ in 0..LINES {
            let case = Case::random(&mut random);
            text += &line(&case, &mut random)?;
            text.push('\n');
        }
        let path = Path::new(&folder).join(format!("{name}.jsonl"));
        fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}
