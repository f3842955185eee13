//! The path-traced picture, which converges.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lumigon_renderer::{Camera, CpuRenderer, Pixels, ReferenceSettings, RenderError};

use super::accumulation::{Accumulation, Mean};
use super::background::Reporter;
use super::job::Update;

/// The first picture has so many times fewer pixels along each side: it is there at once.
const PREVIEW: u32 = 4;

/// A pass has twice the paths of the one before while that took no longer than this.
const LONGEST: Duration = Duration::from_secs(1);

/// Below so many paths a pixel the error is too uncertain itself to stop for it.
const LEAST_PATHS: u64 = 32;

/// A path-traced picture of one view of a scene.
pub(crate) struct ReferenceJob {
    /// Of the scene.
    pub(crate) renderer: Arc<CpuRenderer<'static>>,
    /// From where it is seen.
    pub(crate) camera: Camera,
    /// Size, samples a pixel, and which light counts. The number of paths is of no effect, and the seed is
    /// that of the first pass.
    pub(crate) settings: ReferenceSettings,
    /// It ends when [`ReferenceState::relative_noise`] is as low as this ...
    pub(crate) target_noise: f64,
    /// ... or there are as many paths a pixel as this.
    pub(crate) most_paths: u64,
}

/// A path-traced picture as it is so far.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ReferenceState {
    /// Pixels across: of the first result a quarter of what is wanted.
    pub(crate) width: u32,
    /// Pixels down.
    pub(crate) height: u32,
    /// Radiance.
    pub(crate) mean: Pixels,
    /// Standard error of the radiance, as it is estimated from the paths.
    pub(crate) error: Pixels,
    /// Passes that it is the mean of; 0 for the first result, the smaller picture.
    pub(crate) passes: u32,
    /// Paths a pixel of all passes; 0 for the first result too.
    pub(crate) paths: u64,
    /// The mean error over the mean radiance; 0 where all is black.
    pub(crate) relative_noise: f64,
}

impl ReferenceState {
    fn new(size: [u32; 2], sums: &Accumulation) -> Self {
        let Mean {
            mean,
            error,
            relative_noise,
        } = sums.mean();
        Self {
            width: size[0],
            height: size[1],
            mean,
            error,
            passes: sums.passes,
            paths: sums.paths,
            relative_noise,
        }
    }
}

impl ReferenceJob {
    pub(super) fn run(&self, reporter: &Reporter) -> Result<(), RenderError> {
        let settings = &self.settings;
        if settings.width.min(settings.height) >= PREVIEW {
            let preview = ReferenceSettings {
                width: settings.width / PREVIEW,
                height: settings.height / PREVIEW,
                samples: 1,
                paths: 2,
                ..*settings
            };
            let mut sums = Accumulation::default();
            self.pass(&preview, &mut sums, reporter)?;
            let state = ReferenceState::new([preview.width, preview.height], &sums);
            let preview = ReferenceState {
                passes: 0,
                paths: 0,
                ..state
            };
            reporter.show(Update::Reference(preview));
        }
        let mut sums = Accumulation::default();
        // At least two for each of the pixel's samples.
        let mut paths = settings.samples.saturating_mul(2);
        loop {
            let start = Instant::now();
            let pass = ReferenceSettings {
                paths,
                seed: settings.seed.wrapping_add(sums.passes.into()),
                ..*settings
            };
            self.pass(&pass, &mut sums, reporter)?;
            let size = [settings.width, settings.height];
            let state = ReferenceState::new(size, &sums);
            let is_done = sums.paths >= self.most_paths
                || sums.paths >= LEAST_PATHS && state.relative_noise <= self.target_noise;
            reporter.show(Update::Reference(state));
            if is_done {
                return Ok(());
            }
            if start.elapsed() <= LONGEST {
                paths = paths.saturating_mul(2);
            }
            // No more than are wanted, in whole rounds of the samples.
            let left = u32::try_from(self.most_paths - sums.paths).unwrap_or(u32::MAX);
            let least = settings.samples.saturating_mul(2);
            paths = paths.min(left.max(least) / settings.samples * settings.samples);
        }
    }

    fn pass(
        &self,
        settings: &ReferenceSettings,
        sums: &mut Accumulation,
        reporter: &Reporter,
    ) -> Result<(), RenderError> {
        let picture = reporter.watched([0, 1], |watch| {
            self.renderer.reference(&self.camera, settings, watch)
        })?;
        sums.add(&picture, settings.paths.into());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workers::{Background, BackgroundState, Job};
    use lumigon_renderer::{Scene, Watch};
    use std::sync::mpsc::channel;

    const SETTINGS: ReferenceSettings = ReferenceSettings {
        width: 32,
        height: 20,
        samples: 2,
        paths: 0,
        bounces: 2,
        shadows: true,
        direct: true,
        bounce_shadows: true,
        seed: 11,
    };

    fn job(settings: ReferenceSettings, target_noise: f64, most_paths: u64) -> ReferenceJob {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/cornell.glb");
        let scene = Scene::load(path).unwrap();
        let camera = scene.cameras[0].clone();
        ReferenceJob {
            renderer: Arc::new(CpuRenderer::shared(Arc::new(scene))),
            camera,
            settings,
            target_noise,
            most_paths,
        }
    }

    /// All states of a job, the newest last.
    fn states(job: ReferenceJob) -> Vec<ReferenceState> {
        let (sender, receiver) = channel();
        let wake = move || sender.send(()).unwrap_or_default();
        let background = Background::start(Job::Reference(job), Box::new(wake));
        let mut states: Vec<ReferenceState> = Vec::new();
        loop {
            receiver.recv_timeout(Duration::from_secs(60)).unwrap();
            let state = background.state();
            if let Some(Update::Reference(latest)) = background.latest().as_deref()
                && states.last() != Some(latest)
            {
                states.push(latest.clone());
            }
            if state != BackgroundState::Running {
                assert_eq!(state, BackgroundState::Finished);
                return states;
            }
        }
    }

    #[test]
    fn passes_add_up_to_one_long_picture() {
        let job = job(SETTINGS, 0.0, 500);
        let (renderer, camera) = (Arc::clone(&job.renderer), job.camera.clone());
        let states = states(job);
        let last = states.last().unwrap();
        assert_eq!(last.paths, 500);
        assert!(last.passes >= 4, "{}", last.passes);
        let long = ReferenceSettings {
            paths: 500,
            seed: 1 << 32,
            ..SETTINGS
        };
        let long = renderer.reference(&camera, &long, Watch::none()).unwrap();
        let (mut squares, mut sum, mut variance, mut count) = (0.0, 0.0, 0.0, 0);
        for (i, radiance) in long.mean.radiance().iter().enumerate() {
            // One channel of each pixel: the three share their paths.
            let of = |pixels: &Pixels| f64::from(pixels[i][1]);
            let both = of(&long.radiance_error).hypot(of(&last.error));
            if both > 1e-4 * f64::from(radiance[1]) {
                let deviation = of(&last.mean) - f64::from(radiance[1]);
                squares += (deviation / both).powi(2);
                sum += deviation;
                variance += both * both;
                count += 1;
            }
        }
        let (rms, bias) = ((squares / f64::from(count)).sqrt(), sum / variance.sqrt());
        println!("rms {rms:.3}, bias {bias:.3} over {count}");
        assert!(count > 300, "{count}");
        assert!((0.85..1.15).contains(&rms), "{rms}");
        assert!(bias.abs() < 4.0, "{bias}");
    }

    #[test]
    fn the_error_falls_with_the_root_of_the_passes() {
        let job = job(SETTINGS, 0.0, 0);
        let mut sums = Accumulation::default();
        let mut noise = Vec::new();
        for seed in 0..64 {
            let settings = ReferenceSettings {
                paths: 16,
                seed,
                ..SETTINGS
            };
            let picture = job
                .renderer
                .reference(&job.camera, &settings, Watch::none());
            sums.add(&picture.unwrap(), 16);
            noise.push(sums.mean().relative_noise);
        }
        // Of few paths it seems smaller than it is: rare bright ones are yet to come.
        for passes in [8, 16] {
            let ratio = noise[passes - 1] / noise[4 * passes - 1];
            println!("{passes} passes: {ratio}");
            assert!((1.85..2.1).contains(&ratio), "{passes}: {ratio}");
        }
    }

    #[test]
    fn it_ends_where_it_is_good_enough() {
        let states = states(job(SETTINGS, 0.1, u64::MAX));
        let last = states.last().unwrap();
        assert!(last.relative_noise <= 0.1 && last.relative_noise > 0.01);
        assert_eq!((last.width, last.height), (32, 20));
        assert!(
            states
                .iter()
                .all(|s| s.mean.len() == (s.width * s.height) as usize)
        );
        assert!(states.iter().all(|s| s.mean.len() == s.error.len()));
    }
}
