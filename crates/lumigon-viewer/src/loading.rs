//! Scenes are loaded beside the window, which shows what is being done.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use lumigon_renderer::{CpuRenderer, GltfSource, Limits, LoadPhase, LoadWatch, Scene, SceneError};

/// Opened without a scene of the user's.
static GALLERY: &[u8] = include_bytes!("../../../scenes/gallery.glb");

/// Phases follow each other faster than anyone reads: the window is woken no more often.
const BETWEEN_WAKES: Duration = Duration::from_millis(50);

/// A scene ready to be shown, and what saving it needs.
pub(crate) struct Loaded {
    pub(crate) scene: Arc<Scene>,
    /// The file as it was read.
    pub(crate) source: Arc<GltfSource>,
    /// Of `scene`.
    pub(crate) renderer: CpuRenderer<'static>,
}

/// A scene being loaded by a thread of its own. Dropped, it is given up.
pub(crate) struct Loading {
    progress: Arc<Progress>,
    result: Receiver<Result<Loaded, SceneError>>,
    /// What stands for the scene in errors.
    name: String,
}

struct Progress {
    phase: Mutex<Phase>,
    cancelled: AtomicBool,
    wake: Box<dyn Fn() + Send + Sync>,
}

#[derive(Clone, Copy)]
struct Phase {
    work: Work,
    woken: Option<Instant>,
}

#[derive(Clone, Copy)]
enum Work {
    Starting,
    Reading(LoadPhase),
    Hierarchy { triangles: usize },
}

impl fmt::Display for Work {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Starting => f.write_str("opening the file"),
            Self::Reading(phase) => phase.fmt(f),
            Self::Hierarchy { triangles } => {
                write!(f, "building the hierarchy of {triangles} triangles")
            }
        }
    }
}

impl Loading {
    /// Begins to load a file. `wake` is called from the thread when there is something new to show.
    pub(crate) fn start(path: &Path, wake: Box<dyn Fn() + Send + Sync>) -> Self {
        let name = path.display().to_string();
        let path = PathBuf::from(path);
        Self::with(name, wake, move |watch| {
            Scene::load_watched(path, &Limits::default(), watch)
        })
    }

    /// Begins to load the gallery, which is built in.
    pub(crate) fn gallery(wake: Box<dyn Fn() + Send + Sync>) -> Self {
        let name = "the gallery";
        Self::with(name.to_owned(), wake, move |watch| {
            Scene::from_slice_watched(GALLERY, None, name, &Limits::default(), watch)
        })
    }

    fn with(
        name: String,
        wake: Box<dyn Fn() + Send + Sync>,
        read: impl FnOnce(LoadWatch<'_>) -> Result<(Scene, GltfSource), SceneError> + Send + 'static,
    ) -> Self {
        let progress = Arc::new(Progress {
            phase: Mutex::new(Phase {
                work: Work::Starting,
                woken: None,
            }),
            cancelled: AtomicBool::new(false),
            wake,
        });
        let (send, result) = channel();
        let watched = Arc::clone(&progress);
        let work = move || {
            // Whatever goes wrong there, the sender is dropped, and the window woken to see it.
            let loaded = catch_unwind(AssertUnwindSafe(|| watched.load(read)));
            if let Ok(loaded) = loaded {
                // No one waits for it any more where this fails.
                _ = send.send(loaded);
            } else {
                drop(send);
            }
            (watched.wake)();
        };
        // Without a thread the sender is dropped too.
        _ = thread::Builder::new()
            .name("loading".to_owned())
            .spawn(work);
        Self {
            progress,
            result,
            name,
        }
    }

    /// What is being done, for a person.
    pub(crate) fn phase(&self) -> String {
        self.progress.work().to_string()
    }

    /// How far that is, 0 to 1, where it is known.
    pub(crate) fn fraction(&self) -> Option<f32> {
        match self.progress.work() {
            Work::Reading(phase) => phase.fraction(),
            _ => None,
        }
    }

    /// The scene or why there is none, once it is decided.
    pub(crate) fn take(&mut self) -> Option<Result<Loaded, SceneError>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(SceneError {
                path: self.name.clone(),
                place: "loading".to_owned(),
                what: "it ended without a result while ".to_owned() + &self.phase(),
                mend: "try again; if it happens again, this is a fault of lumigon".to_owned(),
            })),
        }
    }
}

impl Drop for Loading {
    fn drop(&mut self) {
        self.progress.cancelled.store(true, Ordering::Relaxed);
    }
}

impl Progress {
    fn load(
        &self,
        read: impl FnOnce(LoadWatch<'_>) -> Result<(Scene, GltfSource), SceneError>,
    ) -> Result<Loaded, SceneError> {
        let progress = |phase| self.begin(Work::Reading(phase));
        let (scene, source) = read(LoadWatch {
            progress: &progress,
            cancelled: &self.cancelled,
        })?;
        let triangles = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        self.begin(Work::Hierarchy { triangles });
        let scene = Arc::new(scene);
        Ok(Loaded {
            renderer: CpuRenderer::shared(Arc::clone(&scene)),
            scene,
            source: Arc::new(source),
        })
    }

    fn work(&self) -> Work {
        // A phase is whole whoever panicked.
        let phase = self.phase.lock().unwrap_or_else(PoisonError::into_inner);
        phase.work
    }

    fn begin(&self, work: Work) {
        let now = Instant::now();
        let mut phase = self.phase.lock().unwrap_or_else(PoisonError::into_inner);
        phase.work = work;
        let is_due = phase.woken.is_none_or(|woken| now - woken >= BETWEEN_WAKES);
        // What takes long is told of at once.
        if is_due || matches!(work, Work::Hierarchy { .. }) {
            phase.woken = Some(now);
            drop(phase);
            (self.wake)();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};

    use super::*;

    fn waking(send: Sender<()>) -> Box<dyn Fn() + Send + Sync> {
        let send = Mutex::new(send);
        Box::new(move || _ = send.lock().unwrap().send(()))
    }

    fn wait(loading: &mut Loading, woken: &Receiver<()>) -> Result<Loaded, SceneError> {
        loop {
            woken
                .recv_timeout(Duration::from_secs(60))
                .expect("the window sleeps for ever");
            if let Some(result) = loading.take() {
                return result;
            }
        }
    }

    #[test]
    fn the_gallery_is_built_in() {
        let (send, woken) = channel();
        let mut loading = Loading::gallery(waking(send));
        let loaded = wait(&mut loading, &woken).unwrap();
        assert!(loaded.scene.polygon_lights.len() > 3);
        assert!(
            loading.phase().starts_with("building the hierarchy of "),
            "{}",
            loading.phase()
        );
        assert_eq!(loading.fraction(), None);
        let settings = lumigon_renderer::RenderSettings {
            width: 16,
            height: 10,
            samples: 1,
            ..Default::default()
        };
        let camera = &loaded.scene.cameras[0];
        let watch = lumigon_renderer::Watch::none();
        let picture = loaded.renderer.render(camera, &settings, watch).unwrap();
        assert!(picture.radiance().iter().flatten().any(|&c| c > 0.0));
    }

    #[test]
    fn faults_are_delivered() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("broken.glb");
        std::fs::write(&path, b"glTF\x02\0\0\0").unwrap();
        for path in [path, folder.path().join("missing.gltf")] {
            let (send, woken) = channel();
            let mut loading = Loading::start(&path, waking(send));
            let fault = wait(&mut loading, &woken).err().unwrap();
            assert_eq!(fault.path, path.display().to_string());
        }
        let (send, woken) = channel();
        let mut loading =
            Loading::with("odd.glb".to_owned(), waking(send), |_| panic!("for a test"));
        let fault = wait(&mut loading, &woken).err().unwrap();
        assert!(fault.what.contains("without a result"), "{fault}");
    }

    #[test]
    fn what_is_dropped_is_given_up() {
        let (tell, told) = channel();
        let (go, gone) = channel::<()>();
        let loading = Loading::with("slow.glb".to_owned(), Box::new(|| ()), move |watch| {
            gone.recv().unwrap();
            tell.send(watch.cancelled.load(Ordering::Relaxed)).unwrap();
            Scene::from_slice_watched(GALLERY, None, "slow", &Limits::default(), watch)
        });
        drop(loading);
        go.send(()).unwrap();
        assert!(told.recv().unwrap());
        // The channel goes with the thread's work: it came to an end.
        assert!(told.recv_timeout(Duration::from_secs(60)).is_err());
    }
}
