//! The viewer as a process on a display: what it is given, what it leaves behind.

use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::time::{Duration, Instant};

use crate::display::Display;

/// Nothing here takes as long; whoever does hangs.
const PATIENCE: Duration = Duration::from_secs(240);

/// A folder, and a display for windows on its scenes.
pub(crate) struct Session {
    pub(crate) display: Display,
    folder: tempfile::TempDir,
}

impl Session {
    pub(crate) fn new() -> Self {
        Self {
            display: Display::open(),
            folder: tempfile::tempdir().unwrap(),
        }
    }

    /// A session with a copy of a scene of the repository, which may be written over.
    pub(crate) fn with(scene: &str) -> Self {
        let this = Self::new();
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let from = from.join(scene);
        std::fs::copy(&from, this.folder.path().join(from.file_name().unwrap())).unwrap();
        this
    }

    /// A file of the folder.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Starts the command in the folder, `words` its arguments.
    pub(crate) fn start(&self, words: &str) -> Viewer {
        let mut command = self.display.lumigon(self.folder.path());
        let child = command
            .args(words.split_whitespace())
            .current_dir(self.folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        Viewer(Some(child))
    }

    /// Replays a script in a window on a scene, which must end well.
    pub(crate) fn replay(&self, scene: &str, script: &str) -> Output {
        std::fs::write(self.path("input.txt"), script).unwrap();
        let words = format!("view {scene} --size 900x600 --backend cpu --replay input.txt");
        let output = self.start(&words).end();
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {complaint}", output.status);
        output
    }

    /// A picture that a window or the command wrote.
    pub(crate) fn image(&self, name: &str) -> Image {
        Image::open(&self.path(name))
    }
}

/// A running viewer; it ends with the value, also where a test fails.
pub(crate) struct Viewer(Option<Child>);

impl Viewer {
    pub(crate) fn id(&self) -> u32 {
        self.0.as_ref().unwrap().id()
    }

    /// Waits until it ends by itself.
    pub(crate) fn end(mut self) -> Output {
        let start = Instant::now();
        let child = self.0.as_mut().unwrap();
        while child.try_wait().unwrap().is_none() {
            assert!(start.elapsed() < PATIENCE, "the viewer does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
        self.0.take().unwrap().wait_with_output().unwrap()
    }

    /// Processor time it has used, in clock ticks, a hundredth of a second each.
    pub(crate) fn ticks(&self) -> u64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.id())).unwrap();
        // The name in brackets may hold anything; the 14th and 15th fields count from before it.
        let (_, fields) = stat.rsplit_once(')').unwrap();
        let fields: Vec<u64> = fields
            .split_whitespace()
            .skip(11)
            .take(2)
            .map(|field| field.parse().unwrap())
            .collect();
        fields[0] + fields[1]
    }

    /// Waits until it has used next to no processor time for half a second.
    pub(crate) fn rest(&self) {
        let start = Instant::now();
        loop {
            let before = self.ticks();
            std::thread::sleep(Duration::from_millis(700));
            if self.ticks() <= before + 1 {
                return;
            }
            assert!(
                start.elapsed() < PATIENCE,
                "the viewer does not come to rest"
            );
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            // It may be gone already.
            _ = child.kill();
            _ = child.wait();
        }
    }
}

/// Eight bits a channel.
#[derive(PartialEq)]
pub(crate) struct Image(image::RgbImage);

impl Image {
    pub(crate) fn open(path: &Path) -> Self {
        let image = image::open(path);
        Self(
            image
                .unwrap_or_else(|fault| panic!("{}: {fault}", path.display()))
                .into_rgb8(),
        )
    }

    pub(crate) fn size(&self) -> [u32; 2] {
        self.0.dimensions().into()
    }

    /// A rectangle of it, from `x`, `y` as wide and high as `size`.
    pub(crate) fn part(&self, x: u32, y: u32, size: [u32; 2]) -> Self {
        Self(image::imageops::crop_imm(&self.0, x, y, size[0], size[1]).to_image())
    }

    /// The largest difference of a channel from another image of its size.
    pub(crate) fn difference(&self, other: &Self) -> u8 {
        assert_eq!(self.size(), other.size());
        let pairs = self.0.iter().zip(other.0.iter());
        pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap()
    }

    /// The mean of all channels, 0 to 255.
    pub(crate) fn mean(&self) -> f64 {
        let sum: u64 = self.0.iter().map(|&channel| u64::from(channel)).sum();
        sum as f64 / self.0.len() as f64
    }

    /// Pixels of about that colour.
    pub(crate) fn count(&self, color: [u8; 3]) -> usize {
        let is_near = |pixel: &image::Rgb<u8>| {
            let pairs = pixel.0.into_iter().zip(color);
            pairs.into_iter().all(|(a, b)| a.abs_diff(b) < 12)
        };
        self.0.pixels().filter(|pixel| is_near(pixel)).count()
    }
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [width, height] = self.size();
        write!(f, "{width} x {height}, {:.3} on average", self.mean())
    }
}
