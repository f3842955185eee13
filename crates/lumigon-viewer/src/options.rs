//! What to open, and how.

use std::path::PathBuf;

use lumigon_renderer::ToneMap;

/// What computes the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BackendChoice {
    /// A hardware GPU where there is one, else the CPU at a resolution that keeps up.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, software Vulkan included.
    Gpu,
}

/// What to open, and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// The scene; the gallery where there is none.
    pub scene: Option<PathBuf>,
    /// The window's width and height in points, at least 1.
    pub size: [u32; 2],
    /// What computes the picture.
    pub backend: BackendChoice,
    /// The camera to start with, counted from 0 in the file's order.
    pub camera: usize,
    /// Stops: the radiance is multiplied with 2 to their power.
    pub exposure: f32,
    /// From radiance to what a display shows.
    pub tone_map: ToneMap,
    /// Closes the window after as many frames.
    pub frames: Option<u64>,
    /// Where the last frame goes, as PNG: the whole window, panels included.
    pub screenshot: Option<PathBuf>,
    /// Recorded input, to be replayed; the window closes where it ends unless `frames` says otherwise.
    pub replay: Option<PathBuf>,
    /// Where all input is recorded.
    pub record: Option<PathBuf>,
    /// Prints what each frame took.
    pub timings: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            scene: None,
            size: [1440, 900],
            backend: BackendChoice::default(),
            camera: 0,
            exposure: 0.0,
            tone_map: ToneMap::default(),
            frames: None,
            screenshot: None,
            replay: None,
            record: None,
            timings: false,
        }
    }
}
