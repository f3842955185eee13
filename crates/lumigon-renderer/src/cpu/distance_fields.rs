//! The lights' baked distance fields, kept from picture to picture.

use std::sync::{Arc, Mutex, PoisonError, TryLockError};

use lumigon::{DistanceFieldError, DistanceFieldSettings, DistanceFields, PolygonLight};
use lumigon_wgpu::Light;

/// Fields of a scene's lights, as they were last wanted.
#[derive(Default)]
pub(super) struct FieldCache(Mutex<Option<Kept>>);

#[derive(Clone)]
struct Kept {
    settings: DistanceFieldSettings,
    fields: Arc<DistanceFields<f32>>,
    /// Of the outline that each field was baked from.
    shapes: Arc<Vec<PolygonLight<f32>>>,
    /// The lights are still those that the fields are for.
    is_current: bool,
}

impl FieldCache {
    /// For a scene whose lights may have changed: fields of shapes that have not are not baked again.
    pub(super) fn edited(&self) -> Self {
        // Whoever bakes now, in another thread, is not waited for.
        let kept = match self.0.try_lock() {
            Ok(kept) => kept.clone(),
            Err(TryLockError::Poisoned(kept)) => kept.into_inner().clone(),
            Err(TryLockError::WouldBlock) => None,
        };
        Self(Mutex::new(kept.map(|kept| Kept {
            is_current: false,
            ..kept
        })))
    }

    /// The lights' fields; baked unless they were the last ones that were asked for.
    pub(super) fn get(
        &self,
        lights: &[Light],
        settings: DistanceFieldSettings,
        budget: u64,
    ) -> Result<Arc<DistanceFields<f32>>, DistanceFieldError> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let same = kept.take().filter(|kept| kept.settings == settings);
        if let Some(same) = &same
            && same.is_current
        {
            lumigon::check_budget(same.fields.fields().len(), settings, budget)?;
            let fields = Arc::clone(&same.fields);
            *kept = Some(same.clone());
            return Ok(fields);
        }
        let polygons = lights.iter().map(|light| &light.polygon);
        // One that was baked from the very same outline.
        let baked = |shape: &PolygonLight<f32>| {
            let earlier = same.as_ref()?;
            let index = earlier
                .shapes
                .iter()
                .position(|other| other.has_outline_of(shape))?;
            Some(earlier.fields.fields()[index].clone())
        };
        let (fields, shapes) = DistanceFields::with_baked(polygons, settings, budget, baked)?;
        let fields = Arc::new(fields);
        *kept = Some(Kept {
            settings,
            fields: Arc::clone(&fields),
            shapes: Arc::new(shapes.iter().map(|&i| lights[i].polygon.clone()).collect()),
            is_current: true,
        });
        Ok(fields)
    }
}
