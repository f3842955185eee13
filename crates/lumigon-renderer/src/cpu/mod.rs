//! The CPU backend: rays through a bounding volume hierarchy, tiles in parallel, SIMD over pixels.

use crate::render::{
    ReferenceRendering, ReferenceSettings, RenderError, RenderSettings, Rendering, Watch,
};
use crate::scene::{Camera, Scene};

/// A scene prepared for rendering on the CPU.
pub struct CpuRenderer<'a> {
    scene: &'a Scene,
}

impl<'a> CpuRenderer<'a> {
    /// Builds the hierarchy and prepares the lights.
    ///
    /// # Errors
    /// Where a light's outline cannot be evaluated.
    pub fn new(scene: &'a Scene) -> Result<Self, RenderError> {
        Ok(Self { scene })
    }

    /// Renders with closed forms: no noise, and no shadows.
    ///
    /// # Errors
    /// Where a setting is out of range, or when cancelled.
    pub fn render(
        &self,
        camera: &Camera,
        settings: &RenderSettings,
        watch: Watch<'_>,
    ) -> Result<Rendering, RenderError> {
        todo!()
    }

    /// Path traces the same scene through the same pixels.
    ///
    /// # Errors
    /// Where a setting is out of range, or when cancelled.
    pub fn reference(
        &self,
        camera: &Camera,
        settings: &ReferenceSettings,
        watch: Watch<'_>,
    ) -> Result<ReferenceRendering, RenderError> {
        todo!()
    }
}
