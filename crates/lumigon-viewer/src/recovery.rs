//! Edits outlive a crash: a copy of the edited scene is kept until the user has saved or given it up.

use std::collections::HashMap;
use std::env;
use std::fs::{self, DirBuilder};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

use glam::DAffine3;
use lumigon_renderer::{GltfSource, SaveError, Scene};
use sha2::{Digest, Sha256};

/// A copy is written when nothing was edited for so long,
const STILL: Duration = Duration::from_secs(1);
/// or when the oldest edit that is not kept is so old,
const LONGEST: Duration = Duration::from_secs(5);
/// but so many times as long as writing took is left between copies.
const SHARE: u32 = 10;

/// An edited scene and the file it came from: what [`GltfSource::save`] asks for.
#[derive(Clone)]
pub(crate) struct Edits {
    pub(crate) source: Arc<GltfSource>,
    pub(crate) original: Arc<Scene>,
    pub(crate) edited: Arc<Scene>,
    /// World from local, for the nodes of new meshes by their index.
    pub(crate) frames: HashMap<usize, DAffine3>,
}

impl Edits {
    /// Writes them as glTF.
    ///
    /// # Errors
    /// As [`GltfSource::save`].
    pub(crate) fn save(&self, path: &Path) -> Result<(), SaveError> {
        let (original, edited) = (&self.original, &self.edited);
        self.source.save(original, edited, &self.frames, path)
    }
}

/// Keeps copies of one scene's edits, on a thread of its own, in the folder where this system keeps
/// programs' state. Dropped, it first writes what is not yet kept.
pub(crate) struct Recovery {
    shared: Arc<Shared>,
    writer: Option<JoinHandle<()>>,
}

/// What was found of an earlier session: a `.glb` file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Found {
    pub(crate) file: PathBuf,
    written: SystemTime,
}

struct Shared {
    /// Where the copy goes, or why it goes nowhere.
    file: Result<PathBuf, String>,
    wake: Box<dyn Fn() + Send + Sync>,
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// Edits not yet kept, and since when there are such, and the last of them.
    pending: Option<(Edits, Instant, Instant)>,
    is_writing: bool,
    /// What is being written is not wanted any more.
    is_forgotten: bool,
    /// The file holds edits of this session.
    is_kept: bool,
    /// When the next copy may be written.
    not_before: Option<Instant>,
    fault: Option<String>,
    /// So that it is not told again and again.
    last_fault: Option<String>,
    is_ending: bool,
}

impl Recovery {
    /// For a scene's file, or the gallery. `wake` is called from the thread when there is a fault to show.
    pub(crate) fn new(path: Option<&Path>, wake: Box<dyn Fn() + Send + Sync>) -> Self {
        Self::in_folder(folder(), path, wake)
    }

    fn in_folder(
        folder: Option<PathBuf>,
        path: Option<&Path>,
        wake: Box<dyn Fn() + Send + Sync>,
    ) -> Self {
        let file = folder.map(|folder| folder.join(file_name(path)));
        Self {
            shared: Arc::new(Shared {
                file: file.ok_or_else(|| "this system names no folder for it".to_owned()),
                wake,
                state: Mutex::default(),
                changed: Condvar::new(),
            }),
            writer: None,
        }
    }

    /// What an earlier session left of that scene, or of the gallery.
    pub(crate) fn found<'a>(path: impl Into<Option<&'a Path>>) -> Option<Found> {
        found_in(&folder()?, path.into())
    }

    /// Takes edits to be kept. Returns at once; they are written when there is a pause.
    pub(crate) fn keep(&mut self, edits: Edits) {
        let now = Instant::now();
        let mut state = self.shared.lock();
        let since = state.pending.as_ref().map_or(now, |pending| pending.1);
        state.pending = Some((edits, since, now));
        drop(state);
        self.shared.changed.notify_all();
        if self.writer.is_none() {
            let shared = Arc::clone(&self.shared);
            let writer = thread::Builder::new().name("recovery".to_owned());
            match writer.spawn(move || shared.write_all()) {
                Ok(writer) => self.writer = Some(writer),
                Err(fault) => _ = self.shared.lock().set_fault(&fault.to_string()),
            }
        }
    }

    /// The user has saved or given up: the copy goes away. Returns at once.
    pub(crate) fn forget(&mut self) {
        let mut state = self.shared.lock();
        state.pending = None;
        state.is_forgotten = state.is_writing;
        if !state.is_writing && std::mem::take(&mut state.is_kept) {
            self.shared.remove();
        }
    }

    /// Writes what is not yet kept, waiting for it. Returns the file where edits are kept.
    pub(crate) fn finish(&mut self) -> Option<PathBuf> {
        self.end();
        let state = self.shared.lock();
        let file = self.shared.file.as_ref().ok();
        file.filter(|_| state.is_kept).cloned()
    }

    /// Why edits are not kept; each reason once.
    pub(crate) fn fault(&mut self) -> Option<String> {
        self.shared.lock().fault.take()
    }

    fn end(&mut self) {
        self.shared.lock().is_ending = true;
        self.shared.changed.notify_all();
        if let Some(writer) = self.writer.take() {
            // It only ends so where a scene could not be saved for a fault of ours.
            _ = writer.join();
        }
        self.shared.lock().is_ending = false;
    }
}

impl Drop for Recovery {
    fn drop(&mut self) {
        self.end();
    }
}

impl Found {
    /// How long ago it was, for a person.
    pub(crate) fn when(&self) -> String {
        // A clock that was set back makes it no older than now.
        let ago = self.written.elapsed().unwrap_or_default();
        let minutes = ago.as_secs() / 60;
        let count = |n: u64, what: &str| {
            let plural = if n == 1 { "" } else { "s" };
            format!("{n} {what}{plural} ago")
        };
        match minutes {
            0 => "just now".to_owned(),
            1..60 => count(minutes, "minute"),
            60..1440 => count(minutes / 60, "hour"),
            _ => count(minutes / 1440, "day"),
        }
    }

    /// Throws it away.
    pub(crate) fn forget(&self) {
        // It is offered again where this fails.
        _ = fs::remove_file(&self.file);
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // Every change of the state is one assignment: it is whole whoever panicked.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes copies until the end.
    fn write_all(&self) {
        let mut state = self.lock();
        loop {
            let Some((_, since, last)) = &state.pending else {
                if state.is_ending {
                    return;
                }
                let woken = self.changed.wait(state);
                state = woken.unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            let now = Instant::now();
            let due = (*last + STILL).min(*since + LONGEST);
            let due = state
                .not_before
                .map_or(due, |not_before| due.max(not_before));
            if now < due && !state.is_ending {
                let woken = self.changed.wait_timeout(state, due - now);
                state = woken.unwrap_or_else(PoisonError::into_inner).0;
                continue;
            }
            let Some((edits, ..)) = state.pending.take() else {
                continue;
            };
            state.is_writing = true;
            drop(state);
            let written = self.write(&edits);
            drop(edits);
            let end = Instant::now();
            state = self.lock();
            state.is_writing = false;
            state.not_before = Some(end + (end - now) * SHARE);
            match written {
                Ok(()) => {
                    state.is_kept = true;
                    state.last_fault = None;
                    if std::mem::take(&mut state.is_forgotten) {
                        state.is_kept = false;
                        self.remove();
                    }
                }
                Err(fault) => {
                    if std::mem::take(&mut state.is_forgotten) {
                        state.is_kept = false;
                        self.remove();
                    } else if state.set_fault(&fault) {
                        drop(state);
                        (self.wake)();
                        state = self.lock();
                    }
                }
            }
        }
    }

    fn write(&self, edits: &Edits) -> Result<(), String> {
        let file = self.file.as_ref().map_err(Clone::clone)?;
        if let Some(folder) = file.parent() {
            make_folder(folder).map_err(|fault| format!("{}: {fault}", folder.display()))?;
        }
        edits.save(file).map_err(|fault| fault.to_string())
    }

    fn remove(&self) {
        if let Ok(file) = &self.file {
            // It is offered at the next start where this fails.
            _ = fs::remove_file(file);
        }
    }
}

impl State {
    /// Whether it is to be told.
    fn set_fault(&mut self, fault: &str) -> bool {
        let fault = format!("Edits are not kept for the case of a crash: {fault}");
        let is_new = self.last_fault.as_ref() != Some(&fault);
        if is_new {
            self.fault = Some(fault.clone());
            self.last_fault = Some(fault);
        }
        is_new
    }
}

/// Where this system keeps programs' state, and in it ours.
fn folder() -> Option<PathBuf> {
    let absolute = |name: &str| {
        let path = PathBuf::from(env::var_os(name)?);
        path.is_absolute().then_some(path)
    };
    let state = if cfg!(windows) {
        absolute("LOCALAPPDATA")?
    } else if cfg!(target_os = "macos") {
        absolute("HOME")?.join("Library/Application Support")
    } else {
        absolute("XDG_STATE_HOME").or_else(|| Some(absolute("HOME")?.join(".local/state")))?
    };
    Some(state.join("lumigon").join("recovery"))
}

/// For the user's eyes only, as scenes may be.
fn make_folder(folder: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

/// One name for each scene, however its path is written.
fn file_name(path: Option<&Path>) -> String {
    let Some(path) = path else {
        return "gallery.glb".to_owned();
    };
    let path = fs::canonicalize(path)
        .or_else(|_| std::path::absolute(path))
        .unwrap_or_else(|_| path.to_owned());
    let hash = Sha256::digest(path.as_os_str().as_encoded_bytes());
    let hash: String = hash
        .iter()
        .take(10)
        .map(|byte| format!("{byte:02x}"))
        .collect();
    // The start of its own name, for who looks into the folder.
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: &char| c.is_ascii_alphanumeric() || *c == '-' || *c == '_';
    let stem: String = stem.chars().filter(plain).take(32).collect();
    format!("{stem}-{hash}.glb")
}

fn found_in(folder: &Path, path: Option<&Path>) -> Option<Found> {
    let file = folder.join(file_name(path));
    let metadata = fs::metadata(&file).ok()?;
    let written = metadata.modified().ok()?;
    (metadata.is_file() && metadata.len() > 0).then_some(Found { file, written })
}

#[cfg(test)]
mod tests {
    use lumigon_renderer::{Limits, LoadWatch};

    use super::*;

    fn edits(count: usize) -> Edits {
        static GALLERY: &[u8] = include_bytes!("../../../scenes/cornell.glb");
        let (limits, watch) = (Limits::default(), LoadWatch::none());
        let read = Scene::from_slice_watched(GALLERY, None, "cornell", &limits, watch);
        let (original, source) = read.unwrap();
        let mut edited = original.clone();
        for mesh in edited.meshes.iter_mut().take(count) {
            Arc::make_mut(mesh).triangles.clear();
        }
        Edits {
            source: Arc::new(source),
            original: Arc::new(original),
            edited: Arc::new(edited),
            frames: HashMap::new(),
        }
    }

    fn recovery(folder: &Path, path: &Path) -> Recovery {
        Recovery::in_folder(Some(folder.to_owned()), Some(path), Box::new(|| ()))
    }

    #[test]
    fn edits_are_found_by_the_next_session_until_they_are_saved() {
        let place = tempfile::tempdir().unwrap();
        let (folder, scene) = (place.path().join("a/b"), place.path().join("my scene.glb"));
        fs::write(&scene, "").unwrap();
        let mut first = recovery(&folder, &scene);
        assert_eq!(first.finish(), None);
        let edits = edits(1);
        first.keep(edits.clone());
        let file = first.finish().unwrap();
        assert!(
            file.file_name()
                .unwrap()
                .to_string_lossy()
                .starts_with("myscene-")
        );
        drop(first);

        // Another way to say the same path.
        let same = place.path().join("./a/../my scene.glb");
        let found = found_in(&folder, Some(&same)).unwrap();
        assert_eq!(
            (found.file.clone(), found.when().as_str()),
            (file.clone(), "just now")
        );
        let read = Scene::load(&found.file).unwrap();
        assert_eq!(read.meshes.len(), edits.original.meshes.len() - 1);
        assert_eq!(
            found_in(&folder, Some(&place.path().join("other.glb"))),
            None
        );
        assert_eq!(found_in(&folder, None), None);

        // A session without edits leaves it, one that saves takes its own away.
        let mut second = recovery(&folder, &scene);
        second.forget();
        assert!(file.exists());
        second.keep(edits);
        assert!(second.finish().is_some());
        second.forget();
        assert!(!file.exists());
        assert_eq!(second.finish(), None);
    }

    #[test]
    fn the_last_of_many_edits_is_kept_after_a_pause_or_at_the_end() {
        let place = tempfile::tempdir().unwrap();
        let scene = place.path().join("a.glb");
        let mut kept = recovery(place.path(), &scene);
        let all: Vec<Edits> = (0..4).map(edits).collect();
        let start = Instant::now();
        all.iter().for_each(|edits| kept.keep(edits.clone()));
        assert!(start.elapsed() < Duration::from_millis(200));
        while found_in(place.path(), Some(&scene)).is_none() {
            assert!(start.elapsed() < 20 * STILL, "it never is");
            thread::sleep(Duration::from_millis(20));
        }
        assert!(start.elapsed() >= STILL);
        let found = found_in(place.path(), Some(&scene)).unwrap();
        let meshes = |found: &Found| Scene::load(&found.file).unwrap().meshes.len();
        assert_eq!(meshes(&found), all[3].original.meshes.len() - 3);
        // As if the window were gone.
        kept.keep(all[1].clone());
        drop(kept);
        assert_eq!(meshes(&found), all[3].original.meshes.len() - 1);
        found.forget();
        assert_eq!(found_in(place.path(), Some(&scene)), None);
    }

    #[test]
    fn what_is_forgotten_before_it_is_written_is_never_there() {
        let place = tempfile::tempdir().unwrap();
        let scene = place.path().join("a.glb");
        let mut kept = recovery(place.path(), &scene);
        kept.keep(edits(1));
        kept.forget();
        assert_eq!(kept.finish(), None);
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_fault_is_told_once() {
        let place = tempfile::tempdir().unwrap();
        let blocked = place.path().join("file");
        fs::write(&blocked, "in the way").unwrap();
        let mut kept = recovery(&blocked.join("folder"), &place.path().join("a.glb"));
        for is_told in [true, false] {
            kept.keep(edits(1));
            assert_eq!(kept.finish(), None);
            let fault = kept.fault();
            assert_eq!(fault.is_some(), is_told);
            assert!(fault.is_none_or(|fault| fault.contains("file/folder")));
        }
        let mut nowhere = Recovery::in_folder(None, None, Box::new(|| ()));
        nowhere.keep(edits(1));
        assert_eq!(nowhere.finish(), None);
        assert!(nowhere.fault().unwrap().contains("names no folder"));
    }

    #[test]
    fn ages_are_for_people() {
        let found = |seconds| Found {
            file: PathBuf::new(),
            written: SystemTime::now() - Duration::from_secs(seconds),
        };
        for (seconds, expected) in [
            (0, "just now"),
            (61, "1 minute ago"),
            (3 * 3600 + 5, "3 hours ago"),
            (24 * 3600 + 5, "1 day ago"),
        ] {
            assert_eq!(found(seconds).when(), expected);
        }
        let future = Found {
            file: PathBuf::new(),
            written: SystemTime::now() + Duration::from_secs(900),
        };
        assert_eq!(future.when(), "just now");
    }
}
