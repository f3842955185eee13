//! What virtual lights cost as lights grow in number.

use std::time::{Duration, Instant};

use lumigon_renderer::{BounceCenters, BounceMethod, BounceSettings, Camera};
use serde::Serialize;

use super::many_lights::room;
use super::{Study, rendered};
use crate::Failure;
use crate::gpu::Backend;
use crate::progress::Progress;

/// Repeated so often at most,
const REPEATS: usize = 7;
/// and no more once this long; the fastest counts, for what else the machine does slows repetitions and
/// never speeds one up.
const ENOUGH: Duration = Duration::from_millis(1500);

/// Where the one cube map looks from: the middle of the room.
const CENTER: [f32; 3] = [0.0, 1.5, 1.0];

/// Making virtual lights in a room.
#[derive(Clone, Debug, Serialize)]
pub(super) struct CostRow {
    /// The scene's own lights.
    pub(super) lights: usize,
    /// Wall milliseconds with one cube map that sees all of them.
    pub(super) cube_map_milliseconds: f64,
    /// Wall milliseconds with a reflective shadow map for each.
    pub(super) shadow_maps_milliseconds: f64,
    /// How many virtual lights that made, from how many texels.
    pub(super) cube_map: [usize; 2],
    /// The same.
    pub(super) shadow_maps: [usize; 2],
}

impl Study<'_> {
    /// Both ways, at equally many virtual lights; the rows, and what computed them.
    pub(super) fn cost(&self) -> Result<(Vec<CostRow>, String), Failure> {
        let counts = self.command.light_counts();
        let progress = Progress::new("measuring cost");
        let mut rows = Vec::new();
        let mut described = String::new();
        for (done, &lights) in counts.iter().enumerate() {
            progress.set(2 * done as u64, 2 * counts.len() as u64);
            let scene = room(lights);
            let backend = rendered(Backend::new(self.command.backend, &scene))?;
            let camera = Camera::framing(&scene);
            let of = |method| {
                let settings = BounceSettings {
                    method,
                    centers: BounceCenters::Points(vec![CENTER]),
                    face_size: self.command.cost_size(),
                    virtual_lights: self.command.sweep().count,
                    ..BounceSettings::default()
                };
                self.time(&backend, &camera, &settings)
            };
            let (cube_map_milliseconds, cube_map) = of(BounceMethod::CubeMap)?;
            progress.set(2 * done as u64 + 1, 2 * counts.len() as u64);
            let (shadow_maps_milliseconds, shadow_maps) = of(BounceMethod::ReflectiveShadowMaps)?;
            described = backend.describe();
            rows.push(CostRow {
                lights,
                cube_map_milliseconds,
                shadow_maps_milliseconds,
                cube_map,
                shadow_maps,
            });
        }
        Ok((rows, described))
    }

    fn time(
        &self,
        backend: &Backend<'_>,
        camera: &Camera,
        settings: &BounceSettings,
    ) -> Result<(f64, [usize; 2]), Failure> {
        let begin = Instant::now();
        let mut fastest = Duration::MAX;
        let mut made = [0; 2];
        for _ in 0..REPEATS {
            let start = Instant::now();
            let lights = rendered(backend.virtual_lights(camera, settings, self.watch()))?;
            fastest = fastest.min(start.elapsed());
            made = [lights.len(), lights.texels()];
            if begin.elapsed() > ENOUGH {
                break;
            }
        }
        Ok((1e3 * fastest.as_secs_f64(), made))
    }
}
