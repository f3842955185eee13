//! The lights' distance fields on the device, kept from picture to picture.

use std::sync::Mutex;

use lumigon::{DistanceFieldSettings, DistanceFields, PolygonLight, check_budget, field_shapes};
use lumigon_wgpu::{DistanceFieldBaker, DistanceFieldBuffers, Light, LightBuffers};

use super::device::{Gpu, lock};
use super::error::GpuError;
use crate::render::RenderError;

/// More vertices than software Vulkan goes through in one loop are the CPU's to bake.
const MOST_VERTICES: usize = 50_000;

/// The lights' polygons, and what was last baked of them.
pub(super) struct FieldCache {
    polygons: Vec<PolygonLight<f32>>,
    kept: Mutex<Option<Kept>>,
}

struct Kept {
    settings: DistanceFieldSettings,
    shapes: usize,
    fields: DistanceFieldBuffers,
}

impl FieldCache {
    pub(super) fn new(lights: &[Light]) -> Self {
        Self {
            polygons: lights.iter().map(|light| light.polygon.clone()).collect(),
            kept: Mutex::default(),
        }
    }

    /// The bind group of the lights, which are in `lights`, with their fields, made by `bind_group`;
    /// the fields unless they were the last ones that were asked for.
    pub(super) fn get(
        &self,
        gpu: &Gpu,
        lights: &LightBuffers,
        settings: DistanceFieldSettings,
        budget: u64,
        bind_group: impl Fn(&DistanceFieldBuffers) -> wgpu::BindGroup,
    ) -> Result<wgpu::BindGroup, RenderError> {
        let mut kept = lock(&self.kept);
        if let Some(kept) = &*kept
            && kept.settings == settings
        {
            check_budget(kept.shapes, settings, budget)?;
            return Ok(bind_group(&kept.fields));
        }
        // Not both at once in memory.
        *kept = None;
        let polygons: Vec<_> = self.polygons.iter().collect();
        let (shapes, placements) = field_shapes(&polygons, settings.phi().into());
        check_budget(shapes.len(), settings, budget)?;
        let too_long = |&shape: &usize| polygons[shape].vertex_count() > MOST_VERTICES;
        let fields = if gpu.adapter().is_software() && shapes.iter().any(too_long) {
            let fields = DistanceFields::new(polygons, settings, budget)?;
            gpu.guarded("distance fields", || {
                let (device, queue) = (gpu.device(), gpu.queue());
                let buffers = DistanceFieldBuffers::upload(device, queue, &fields)?;
                Ok::<_, GpuError>(buffers)
            })?
        } else {
            gpu.guarded("distance fields", || {
                let (device, queue) = (gpu.device(), gpu.queue());
                let baker = DistanceFieldBaker::new(device).map_err(|fault| GpuError::Refused {
                    what: "to link its shaders",
                    reason: fault.to_string(),
                })?;
                let of_lights = (&*shapes, &*placements);
                let fields = baker.bake(device, queue, lights, &polygons, of_lights, settings)?;
                Ok::<_, GpuError>(fields)
            })?
        };
        let found = bind_group(&fields);
        *kept = Some(Kept {
            settings,
            shapes: shapes.len(),
            fields,
        });
        Ok(found)
    }
}
