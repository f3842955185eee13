//! `lumigon gpu check`: whether the GPU gives the CPU's pictures.

use std::path::{Path, PathBuf};

use clap::Args;
use lumigon_renderer::{
    BounceCenters, BounceSettings, CpuRenderer, Gpu, GpuPreference, GpuRenderer, RenderError,
    RenderSettings, Rendering, Scene, ToneMap, Watch, srgb8,
};
use serde::Serialize;

use crate::Failure;
use crate::bench::write_json;
use crate::camera::choose_camera;
use crate::interrupt::Interrupt;
use crate::progress::Progress;
use crate::size::Size;

/// What a channel of 8 bits may differ by, but on silhouettes.
const GREATEST_BYTE: u8 = 1;

/// What radiance may differ by there: root of the mean square, over the CPU's.
const GREATEST_ERROR: f64 = 1e-4;

/// Share of pixels whose rays and rasters may see different sides of an edge.
const GREATEST_SHARE: f64 = 0.005;

/// Renders scenes on the GPU and on the CPU, and tells how the pictures differ
///
/// Bounce light, by the same virtual lights on both, is a picture of its own. The exit code is 1 where they differ by more than they should. What they differ by on silhouettes
/// is left out: where a pixel's neighbours differ, and the GPU's value is between them, its rays may
/// have passed an edge on the other side.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  lumigon gpu check scenes/*.glb
  lumigon gpu check scene.glb --size 1920x1080 --samples 4 --json check.json")]
pub(super) struct Check {
    /// glTF files, .gltf or .glb
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Width and height of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "360x225")]
    size: Size,
    /// Camera rays a pixel
    #[arg(long, value_name = "N", default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Write the figures to this file too, as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// How two pictures differ.
#[derive(Debug, PartialEq, Serialize)]
struct Difference {
    pixels: usize,
    on_silhouettes: usize,
    /// Off silhouettes, of 255.
    greatest_byte: u8,
    /// Off silhouettes.
    relative_rmse: f64,
}

#[derive(Debug, Serialize)]
struct SceneFigures {
    scene: String,
    same: bool,
    #[serde(flatten)]
    difference: Difference,
    /// Of bounce light alone.
    bounce_light: Difference,
}

#[derive(Debug, Serialize)]
struct Figures {
    gpu: String,
    width: u32,
    height: u32,
    samples: u32,
    scenes: Vec<SceneFigures>,
}

impl Check {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let interrupt = Interrupt::catch()?;
        interrupt.watch();
        let gpu = Gpu::new(GpuPreference::Any)?;
        println!("{}", gpu.adapter().name);
        println!(
            "{:32} {:>10} {:>12} {:>14} {:>14}",
            "scene", "pixels", "silhouettes", "of 255, most", "relative RMSE"
        );
        let mut scenes = Vec::new();
        for path in &self.scenes {
            let [difference, bounce_light] = self.differences(&gpu, path, &interrupt)?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            difference.print(&name);
            bounce_light.print("  its bounce light");
            scenes.push(SceneFigures {
                scene: path.display().to_string(),
                same: difference.is_none_that_matters() && bounce_light.is_none_that_matters(),
                difference,
                bounce_light,
            });
        }
        let differing = scenes.iter().filter(|scene| !scene.same).count();
        let figures = Figures {
            gpu: gpu.adapter().name.clone(),
            width: self.size.width,
            height: self.size.height,
            samples: self.samples,
            scenes,
        };
        if let Some(path) = &self.json {
            write_json(path, &figures)?;
        }
        match differing {
            0 => Ok(()),
            _ => Err(format!(
                "{differing} of {} scenes differ by more than {GREATEST_BYTE}/255 or a relative \
                 RMSE of {GREATEST_ERROR:e} off silhouettes: use --backend cpu, and report this",
                figures.scenes.len(),
            )
            .into()),
        }
    }

    /// Of the scene's lights, and of bounce light alone.
    fn differences(
        &self,
        gpu: &Gpu,
        path: &Path,
        interrupt: &Interrupt,
    ) -> Result<[Difference; 2], Failure> {
        let scene = Scene::load(path)?;
        let camera = choose_camera(&scene, path, None)?;
        let settings = RenderSettings {
            width: self.size.width,
            height: self.size.height,
            samples: self.samples,
            ..RenderSettings::default()
        };
        let progress = Progress::new("rendering");
        let watch = Watch {
            progress: &|done, total| progress.set(done, total),
            cancelled: interrupt.flag(),
        };
        let pictures = || -> Result<[[Rendering; 2]; 2], RenderError> {
            let gpu = GpuRenderer::new(gpu, &scene)?;
            let cpu = CpuRenderer::new(&scene);
            let direct = [
                cpu.render(&camera, &settings, watch)?,
                gpu.render(&camera, &settings, watch)?,
            ];
            // A few hundred lights of what the camera sees around it.
            let bounce = BounceSettings {
                centers: BounceCenters::Camera,
                face_size: 32,
                virtual_lights: 256,
                ..BounceSettings::default()
            };
            let lights = gpu.virtual_lights(&camera, &bounce, watch)?;
            let settings = RenderSettings {
                direct: false,
                ..settings
            };
            let bounced = [
                cpu.render_with_bounce(&camera, &settings, &lights, watch)?,
                gpu.render_with_bounce(&camera, &settings, &lights, watch)?,
            ];
            Ok([direct, bounced])
        };
        match pictures() {
            Ok(pictures) => Ok(pictures.map(|[cpu, gpu]| {
                let width = self.size.width as usize;
                Difference::new(&cpu.radiance(), &gpu.radiance(), width)
            })),
            Err(RenderError::Cancelled) => Err(Failure::Interrupted),
            Err(error) => Err(error.into()),
        }
    }
}

impl Difference {
    /// Of two pictures of this width.
    fn new(cpu: &[[f32; 3]], gpu: &[[f32; 3]], width: usize) -> Self {
        let height = cpu.len() / width.max(1);
        let bytes = [cpu, gpu].map(|picture| srgb8(picture, 0.0, ToneMap::None));
        let mut difference = Self {
            pixels: cpu.len(),
            on_silhouettes: 0,
            greatest_byte: 0,
            relative_rmse: 0.0,
        };
        let (mut error, mut scale) = (0.0, 0.0);
        for (i, (cpu_pixel, gpu_pixel)) in cpu.iter().zip(gpu).enumerate() {
            let (column, row) = (i % width, i / width);
            let own = |picture: &[u8]| [0, 1, 2].map(|channel| picture[3 * i + channel]);
            let (expected, found) = (own(&bytes[0]), own(&bytes[1]));
            let byte = (0..3).map(|c| expected[c].abs_diff(found[c])).max();
            let byte = byte.unwrap_or(0);
            if byte > GREATEST_BYTE {
                let (mut low, mut high) = (expected, expected);
                for y in row.saturating_sub(1)..(row + 2).min(height) {
                    for x in column.saturating_sub(1)..(column + 2).min(width) {
                        for c in 0..3 {
                            let near = bytes[0][3 * (y * width + x) + c];
                            low[c] = low[c].min(near);
                            high[c] = high[c].max(near);
                        }
                    }
                }
                if (0..3).all(|c| {
                    (low[c].saturating_sub(1)..=high[c].saturating_add(1)).contains(&found[c])
                }) {
                    difference.on_silhouettes += 1;
                    continue;
                }
            }
            difference.greatest_byte = difference.greatest_byte.max(byte);
            for (a, b) in cpu_pixel.iter().zip(gpu_pixel) {
                error += f64::from(a - b).powi(2);
                scale += f64::from(*a).powi(2);
            }
        }
        if error > 0.0 || error.is_nan() {
            difference.relative_rmse = (error / scale).sqrt();
        }
        difference
    }

    fn print(&self, what: &str) {
        println!(
            "{what:32} {:>10} {:>12} {:>14} {:>14.1e}{}",
            self.pixels,
            self.on_silhouettes,
            self.greatest_byte,
            self.relative_rmse,
            if self.is_none_that_matters() {
                ""
            } else {
                "  differs"
            },
        );
    }

    fn is_none_that_matters(&self) -> bool {
        self.greatest_byte <= GREATEST_BYTE
            && self.relative_rmse <= GREATEST_ERROR
            && self.on_silhouettes as f64 <= GREATEST_SHARE * self.pixels as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 by 30 pixels, the left half darker.
    fn picture() -> Vec<[f32; 3]> {
        let shade = |i: usize| if i % 40 < 20 { 0.1 } else { 0.5 };
        (0..1200).map(|i| [shade(i); 3]).collect()
    }

    #[test]
    fn edges_may_move_and_nothing_else_may() {
        let cpu = picture();
        let difference = Difference::new(&cpu, &cpu, 40);
        assert!(difference.is_none_that_matters());
        assert_eq!(
            (difference.greatest_byte, difference.relative_rmse),
            (0, 0.0)
        );

        let mut on_edge = picture();
        on_edge[5 * 40 + 19] = [0.3; 3];
        let difference = Difference::new(&cpu, &on_edge, 40);
        assert_eq!(difference.on_silhouettes, 1);
        assert!(difference.is_none_that_matters(), "{difference:?}");

        let mut too_bright = picture();
        too_bright[5 * 40 + 19] = [0.7; 3];
        assert!(!Difference::new(&cpu, &too_bright, 40).is_none_that_matters());

        let mut elsewhere = picture();
        elsewhere[5 * 40 + 10] = [0.12; 3];
        let difference = Difference::new(&cpu, &elsewhere, 40);
        assert_eq!(difference.on_silhouettes, 0);
        assert!(!difference.is_none_that_matters());

        let everywhere: Vec<_> = cpu.iter().map(|p| p.map(|x| x * 1.0005)).collect();
        let difference = Difference::new(&cpu, &everywhere, 40);
        assert!(difference.greatest_byte <= 1 && !difference.is_none_that_matters());

        let mut many: Vec<_> = picture();
        for row in 0..30 {
            many[row * 40 + 19] = [0.5; 3];
        }
        assert!(!Difference::new(&cpu, &many, 40).is_none_that_matters());

        let mut hostile = picture();
        hostile[3] = [f32::NAN; 3];
        assert!(!Difference::new(&cpu, &hostile, 40).is_none_that_matters());
    }
}
