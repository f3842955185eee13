//! A renderer that lives while its scene is edited.

use std::sync::{Arc, Mutex, OnceLock};

use super::CpuRenderer;
use super::distance_fields::FieldCache;
use super::fitted_lobes::FittedLobes;
use super::geometry::Geometry;
use super::held_scene::HeldScene;
use crate::prepared_lights::{EarlierLights, PreparedLights};
use crate::scene::Scene;

impl<'a> CpuRenderer<'a> {
    pub(super) fn held(scene: HeldScene<'a>) -> Self {
        let lights = PreparedLights::new(&scene.polygon_lights, &scene.textures);
        let geometry = Geometry::new(&scene);
        Self::of_parts(scene, geometry, lights, Arc::new(FittedLobes::new()))
    }

    fn of_parts(
        scene: HeldScene<'a>,
        geometry: Geometry,
        PreparedLights {
            lights,
            sources,
            warnings,
            ..
        }: PreparedLights,
        fitted: Arc<FittedLobes>,
    ) -> Self {
        Self {
            scene,
            geometry,
            lights,
            sources,
            lookup_lights: OnceLock::new(),
            warnings,
            fitted,
            fields: FieldCache::default(),
            facets: OnceLock::new(),
            earlier_facets: None,
            targets: OnceLock::new(),
            timings: Mutex::new(None),
        }
    }
}

impl CpuRenderer<'static> {
    /// As [`CpuRenderer::new`], keeping the scene: renderers of edited scenes outlive each other.
    #[must_use]
    pub fn shared(scene: Arc<Scene>) -> Self {
        Self::held(HeldScene::Shared(scene))
    }
}

impl CpuRenderer<'_> {
    /// A renderer of the same scene after edits, which renders what [`CpuRenderer::shared`] would of it,
    /// within rounding. What has not changed is kept:
    ///
    /// - The hierarchy, as far as meshes are the same by [`Arc::ptr_eq`]. New meshes go to a small one of
    ///   their own, and rays to both: many new meshes make them slower, see [`CpuRenderer::is_layered`].
    /// - Lights that are equal and show the same texels, with their filtered pictures; and the pictures
    ///   of lights that have moved with all that is on them. What
    ///   [`CpuRenderer::replace_light_image`] has shown stays on such lights too.
    /// - Fitted tables, distance fields of unchanged shapes, and the flat parts of unchanged meshes.
    ///
    /// Both renderers share what is kept; this one goes on to show the scene as it was.
    #[must_use]
    pub fn edited(&self, scene: Arc<Scene>) -> CpuRenderer<'static> {
        // With the levels of the one lookup, where they are there already.
        let lights = self.lookup_lights.get().unwrap_or(&self.lights);
        let earlier = EarlierLights {
            scene: &self.scene,
            lights,
            sources: &self.sources,
        };
        let lights = PreparedLights::edited(&scene, &earlier);
        let geometry = self.geometry.edited(&scene);
        let scene = HeldScene::Shared(scene);
        CpuRenderer {
            fields: self.fields.edited(),
            earlier_facets: self.facets.get().or(self.earlier_facets.as_ref()).cloned(),
            ..CpuRenderer::of_parts(scene, geometry, lights, Arc::clone(&self.fitted))
        }
    }

    /// Whether rays go through more than one hierarchy, or through triangles that are gone, since the
    /// scene has been edited: one that is made by [`CpuRenderer::shared`] is as fast as can be.
    #[must_use]
    pub fn is_layered(&self) -> bool {
        self.geometry.is_layered()
    }
}
