//! The GPU backend: triangles rastered to ids, surfaces and lights in compute.

mod adapter;
mod device;
mod error;

use crate::render::{RenderError, RenderSettings, Rendering, Watch};
use crate::scene::{Camera, EmissivePolygon, Scene};

pub use adapter::{AdapterDescription, AdapterKind, GpuPreference};
pub use device::Gpu;
pub use error::GpuError;

/// How long the device worked on the last picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GpuTimings {
    /// Milliseconds of finding what each pixel sees, over all tiles and samples.
    pub visibility: f64,
    /// Milliseconds of lighting it.
    pub shading: f64,
}

/// A scene on a device, ready to be rendered.
pub struct GpuRenderer {
    gpu: Gpu,
    warnings: Vec<String>,
}

impl GpuRenderer {
    /// Brings the scene to the device.
    ///
    /// # Errors
    /// Where the scene is larger than the device's memory or buffers.
    pub fn new(gpu: &Gpu, _scene: &Scene) -> Result<Self, GpuError> {
        gpu.check()?;
        Ok(Self {
            gpu: gpu.clone(),
            warnings: Vec::new(),
        })
    }

    /// Lights whose outlines cannot be evaluated, and why: they light nothing.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Replaces the lights, which the scene's faces do not follow.
    ///
    /// # Errors
    /// Where they are more than the device's buffers hold; they stay as they were.
    pub fn set_lights(&mut self, _lights: &[EmissivePolygon]) -> Result<(), GpuError> {
        self.gpu.check()
    }

    /// Renders with closed forms, as [`CpuRenderer::render`](crate::CpuRenderer::render) does.
    ///
    /// # Errors
    /// Where a setting is out of range, when cancelled, and where the device fails.
    pub fn render(
        &self,
        _camera: &Camera,
        _settings: &RenderSettings,
        _watch: Watch<'_>,
    ) -> Result<Rendering, RenderError> {
        Err(GpuError::Refused {
            what: "to render",
            reason: "this part is not written yet".to_owned(),
        }
        .into())
    }

    /// How long the device worked on the last picture; `None` before one, and where it has no clock.
    #[must_use]
    pub fn timings(&self) -> Option<GpuTimings> {
        None
    }
}
