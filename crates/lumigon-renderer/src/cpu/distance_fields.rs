//! The lights' baked distance fields, kept from picture to picture.

use std::sync::{Arc, Mutex, PoisonError};

use lumigon::{DistanceFieldError, DistanceFieldSettings, DistanceFields};
use lumigon_wgpu::Light;

/// Fields of a scene's lights, as they were last wanted.
#[derive(Default)]
pub(super) struct FieldCache(Mutex<Option<(DistanceFieldSettings, Arc<DistanceFields<f32>>)>>);

impl FieldCache {
    /// The lights' fields; baked unless they were the last ones that were asked for.
    pub(super) fn get(
        &self,
        lights: &[Light],
        settings: DistanceFieldSettings,
        budget: u64,
    ) -> Result<Arc<DistanceFields<f32>>, DistanceFieldError> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of, fields)) = &*kept
            && *of == settings
        {
            lumigon::check_budget(fields.fields().len(), settings, budget)?;
            return Ok(Arc::clone(fields));
        }
        // Not both at once in memory.
        *kept = None;
        let polygons = lights.iter().map(|light| &light.polygon);
        let fields = Arc::new(DistanceFields::new(polygons, settings, budget)?);
        *kept = Some((settings, Arc::clone(&fields)));
        Ok(fields)
    }
}
