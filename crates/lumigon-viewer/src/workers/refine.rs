//! The picture at its full size, with more and more samples.

use std::sync::Arc;

use lumigon_renderer::{
    BounceSettings, Camera, CpuRenderer, RenderError, RenderSettings, Rendering, VirtualLights,
};

use super::background::Reporter;
use super::job::Update;

/// Samples a pixel, one pass after the other.
const SAMPLES: [u32; 3] = [1, 4, 16];

/// One way to light a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Size and methods; the number of samples is of no effect.
    pub settings: RenderSettings,
    /// What bounce light is computed by, if there is any.
    pub bounce: Option<BounceSettings>,
}

/// Pictures of some looks at the same scene, as a rule one or two.
pub struct RefineJob {
    /// Of the scene.
    pub renderer: Arc<CpuRenderer<'static>>,
    /// From where it is seen.
    pub camera: Camera,
    /// What is wanted.
    pub looks: Vec<Look>,
}

/// A picture of each look.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedPictures {
    /// Samples a pixel: 1, then 4, then 16.
    pub samples: u32,
    /// In the order of the looks.
    pub pictures: Vec<Rendering>,
}

impl RefineJob {
    pub(super) fn run(&self, reporter: &Reporter) -> Result<(), RenderError> {
        let Self {
            renderer,
            camera,
            looks,
        } = self;
        let mut lights: Vec<VirtualLights> = Vec::new();
        for (pass, samples) in (1..).zip(SAMPLES) {
            let mut pictures = Vec::new();
            for (i, look) in looks.iter().enumerate() {
                if lights.len() == i {
                    let earlier = looks[..i]
                        .iter()
                        .position(|other| other.bounce == look.bounce);
                    lights.push(match (&look.bounce, earlier) {
                        (None, _) => VirtualLights::default(),
                        (_, Some(same)) => lights[same].clone(),
                        (Some(bounce), None) => reporter.watched([i, looks.len()], |watch| {
                            renderer.virtual_lights(camera, bounce, watch)
                        })?,
                    });
                }
                let settings = RenderSettings {
                    samples,
                    ..look.settings
                };
                pictures.push(reporter.watched([i, looks.len()], |watch| {
                    renderer.render_with_bounce(camera, &settings, &lights[i], watch)
                })?);
            }
            let refined = RefinedPictures { samples, pictures };
            reporter.show(Update::Refined(refined), pass, samples.into());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workers::{Background, BackgroundState, Job};
    use lumigon_renderer::{Scene, Watch};
    use std::sync::mpsc::channel;
    use std::time::{Duration, Instant};

    fn job(name: &str, looks: Vec<Look>) -> RefineJob {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/");
        let scene = Scene::load(format!("{folder}{name}")).unwrap();
        let camera = scene.cameras[0].clone();
        RefineJob {
            renderer: Arc::new(CpuRenderer::shared(Arc::new(scene))),
            camera,
            looks,
        }
    }

    fn look(width: u32, height: u32) -> Look {
        let settings = RenderSettings {
            width,
            height,
            ..RenderSettings::default()
        };
        Look {
            settings,
            bounce: None,
        }
    }

    fn bounced(width: u32, height: u32) -> Look {
        Look {
            bounce: Some(BounceSettings {
                face_size: 8,
                virtual_lights: 64,
                ..BounceSettings::default()
            }),
            ..look(width, height)
        }
    }

    #[test]
    fn pictures_become_those_of_sixteen_samples() {
        let job = job("cornell.glb", vec![look(24, 15), bounced(24, 15)]);
        let (renderer, camera) = (Arc::clone(&job.renderer), job.camera.clone());
        let (sender, receiver) = channel();
        let wake = move || sender.send(()).unwrap_or_default();
        let background = Background::start(Job::Refine(job), Box::new(wake));
        let mut seen = Vec::new();
        while background.state() == BackgroundState::Running {
            receiver.recv_timeout(Duration::from_secs(60)).unwrap();
            if let Some(Update::Refined(refined)) = background.latest().as_deref() {
                seen.push(refined.samples);
            }
        }
        assert_eq!(background.state(), BackgroundState::Finished);
        assert!(seen.is_sorted());
        let latest = background.latest().unwrap();
        let Update::Refined(refined) = &*latest else {
            panic!("no pictures");
        };
        assert_eq!((refined.samples, background.progress().paths), (16, 16));
        let settings = RenderSettings {
            samples: 16,
            ..look(24, 15).settings
        };
        let direct = renderer.render(&camera, &settings, Watch::none()).unwrap();
        assert_eq!(refined.pictures[0], direct);
        assert!(refined.pictures[1].radiance() > direct.radiance());
    }

    #[test]
    fn what_makes_no_sense_is_said() {
        let (sender, receiver) = channel();
        let wake = move || sender.send(()).unwrap_or_default();
        let job = job("cornell.glb", vec![look(0, 15)]);
        let background = Background::start(Job::Refine(job), Box::new(wake));
        receiver.recv_timeout(Duration::from_secs(60)).unwrap();
        assert!(
            matches!(background.state(), BackgroundState::Failed(why) if why.contains("width"))
        );
    }

    #[test]
    fn it_stops_soon() {
        let job = job("screens.glb", vec![bounced(96, 60), look(1440, 900)]);
        let background = Background::start(Job::Refine(job), Box::new(|| ()));
        while background.progress().fraction <= 0.5 {
            std::thread::yield_now();
        }
        let start = Instant::now();
        background.stop();
        let told = start.elapsed();
        while background.state() == BackgroundState::Running {
            std::thread::yield_now();
        }
        println!("told in {told:?}, stopped in {:?}", start.elapsed());
        assert_eq!(background.state(), BackgroundState::Stopped);
        assert!(start.elapsed() < Duration::from_secs(10));
    }
}
