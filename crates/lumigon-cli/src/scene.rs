//! `lumigon scene`: what a file holds.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use lumigon::{PolygonLight, Sides};
use lumigon_renderer::{EmissivePolygon, Projection, PunctualKind, PunctualLight, Scene};
use serde::Serialize;

use crate::Failure;

/// Tells what a glTF file holds
#[derive(Debug, Args)]
pub struct SceneCommand {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    Info(Info),
}

/// Lists meshes, materials, cameras and, above all, lights
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lumigon scene info scene.glb
  lumigon scene info scene.glb --json | jq '.polygon_lights[].area'")]
struct Info {
    /// glTF file, .gltf or .glb
    scene: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

impl SceneCommand {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        match &self.action {
            Action::Info(info) => info.run(),
        }
    }
}

impl Info {
    fn run(&self) -> Result<(), Failure> {
        let report = Report::new(&Scene::load(&self.scene)?);
        let text = match self.json {
            true => serde_json::to_string_pretty(&report)? + "\n",
            false => report.text(),
        };
        match std::io::Write::write_all(&mut std::io::stdout().lock(), text.as_bytes()) {
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
            _ => Ok(()),
        }
    }
}

#[derive(Debug, Serialize)]
struct Report {
    meshes: usize,
    triangles: usize,
    materials: usize,
    textures: usize,
    cameras: Vec<CameraReport>,
    polygon_lights: Vec<LightReport>,
    punctual_lights: Vec<PunctualReport>,
    warnings: Vec<String>,
}

#[derive(Debug, Serialize)]
struct CameraReport {
    name: String,
    projection: &'static str,
    position: [f32; 3],
}

#[derive(Debug, Serialize)]
struct LightReport {
    name: String,
    /// In square metres; absent where the outline cannot be evaluated.
    area: Option<f64>,
    vertices: usize,
    loops: usize,
    holes: usize,
    /// The mean, where it shows a picture.
    radiance: [f32; 3],
    two_sided: bool,
    /// What it shows, where that is more than one colour.
    picture: Option<PictureReport>,
    error: Option<String>,
}

#[derive(Debug, Serialize)]
struct PictureReport {
    width: u32,
    height: u32,
    /// Of its prefiltered pyramid.
    bytes: u64,
}

#[derive(Debug, Serialize)]
struct PunctualReport {
    name: String,
    kind: &'static str,
    /// Candela, or lux for directional lights.
    color: [f32; 3],
}

impl Report {
    fn new(scene: &Scene) -> Self {
        let cameras = scene.cameras.iter().map(|camera| CameraReport {
            name: camera.name.clone(),
            projection: match camera.projection {
                Projection::Perspective { .. } => "perspective",
                Projection::Orthographic { .. } => "orthographic",
            },
            position: camera.world_from_camera.translation.into(),
        });
        Self {
            meshes: scene.meshes.len(),
            triangles: scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum(),
            materials: scene.materials.len(),
            textures: scene.textures.len(),
            cameras: cameras.collect(),
            polygon_lights: scene.polygon_lights.iter().map(LightReport::new).collect(),
            punctual_lights: scene
                .punctual_lights
                .iter()
                .map(PunctualReport::new)
                .collect(),
            warnings: scene.warnings.clone(),
        }
    }

    fn text(&self) -> String {
        use std::fmt::Write;
        let mut text = String::new();
        let out = &mut text;
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{} meshes of {} triangles, {} materials, {} textures",
            self.meshes, self.triangles, self.materials, self.textures
        );
        let _ = writeln!(out, "{} cameras", self.cameras.len());
        for (index, camera) in self.cameras.iter().enumerate() {
            let [x, y, z] = camera.position;
            let (name, projection) = (&camera.name, camera.projection);
            let _ = writeln!(out, "  {index}: {name:?}, {projection} at ({x}, {y}, {z})");
        }
        let _ = writeln!(out, "{} polygon lights", self.polygon_lights.len());
        for (index, light) in self.polygon_lights.iter().enumerate() {
            let _ = write!(out, "  {index}: {:?}, ", light.name);
            let _ = match (&light.error, light.area) {
                (Some(error), _) => write!(out, "{error}"),
                (None, area) => write!(out, "{:.6} m2", area.unwrap_or_default()),
            };
            let [r, g, b] = light.radiance;
            let _ = writeln!(
                out,
                ", {} vertices in {} loops ({} holes), radiance ({r}, {g}, {b}), {}",
                light.vertices,
                light.loops,
                light.holes,
                if light.two_sided {
                    "two-sided"
                } else {
                    "one-sided"
                },
            );
            if let Some(picture) = &light.picture {
                let PictureReport {
                    width,
                    height,
                    bytes,
                } = picture;
                let mib = *bytes as f64 / f64::from(1 << 20);
                let _ = writeln!(out, "     shows {width} x {height} texels, {mib:.2} MiB");
            }
        }
        let _ = writeln!(out, "{} punctual lights", self.punctual_lights.len());
        for (index, light) in self.punctual_lights.iter().enumerate() {
            let [r, g, b] = light.color;
            let (name, kind) = (&light.name, light.kind);
            let unit = if kind == "directional" { "lx" } else { "cd" };
            let _ = writeln!(out, "  {index}: {name:?}, {kind}, ({r}, {g}, {b}) {unit}");
        }
        let _ = writeln!(out, "{} warnings", self.warnings.len());
        for warning in &self.warnings {
            let _ = writeln!(out, "  {warning}");
        }
        text
    }
}

impl LightReport {
    fn new(light: &EmissivePolygon) -> Self {
        let sides = match light.two_sided {
            true => Sides::Both,
            false => Sides::Front,
        };
        let polygon = PolygonLight::new(&light.loops, sides);
        Self {
            name: light.name.clone(),
            area: polygon.as_ref().ok().map(PolygonLight::area),
            vertices: light.loops.iter().map(Vec::len).sum(),
            loops: light.loops.len(),
            holes: light.loops.len().saturating_sub(1),
            radiance: light.radiance.into(),
            two_sided: light.two_sided,
            picture: light.image.as_ref().map(|image| PictureReport {
                width: image.size[0],
                height: image.size[1],
                bytes: image.pyramid_bytes(),
            }),
            error: polygon.err().map(|error| error.to_string()),
        }
    }
}

impl PunctualReport {
    fn new(light: &PunctualLight) -> Self {
        Self {
            name: light.name.clone(),
            kind: match light.kind {
                PunctualKind::Directional => "directional",
                PunctualKind::Point => "point",
                PunctualKind::Spot { .. } => "spot",
            },
            color: light.color.into(),
        }
    }
}
