//! What bounce light asks of the GPU: cube maps by raster, and light on what they see.

use glam::Vec3;
use lumigon::{DiffuseMethod, ImageMethod, SpecularMethod};

use super::cube_faces::{FACES, FaceCanvas, FaceRaster, frames};
use super::device::{Waited, lock};
use super::error::GpuError;
use super::frame::View;
use super::light_set::LightSet;
use super::rays::TracedLights;
use super::renderer::{GpuRenderer, Kept};
use crate::bounce::{
    BounceLights, BounceSettings, CubeMap, Facets, Gather, VirtualLights, light_places,
    virtual_lights,
};
use crate::render::{RenderError, RenderSettings, Rendering, Watch};
use crate::scene::Camera;

impl GpuRenderer {
    /// Finds the surfaces that light bounces off, and makes virtual lights of them, as
    /// [`CpuRenderer::virtual_lights`](crate::CpuRenderer::virtual_lights) does.
    ///
    /// # Errors
    /// Where a setting is out of range, when cancelled, and where the device fails.
    pub fn virtual_lights(
        &self,
        camera: &Camera,
        settings: &BounceSettings,
        watch: Watch<'_>,
    ) -> Result<VirtualLights, RenderError> {
        *lock(&self.bounce_time) = 0.0;
        virtual_lights(self, camera, settings, watch)
    }

    /// The scene's lights that light texels.
    fn lights_of(
        &self,
        lights: BounceLights<'_>,
        settings: &RenderSettings,
    ) -> Result<LightSet<'_>, RenderError> {
        let mut set = self.lighting.set(&self.gpu, settings)?;
        set.with_emission = false;
        if let BounceLights::One { light, .. } = lights {
            set.only = Some(self.lighting.part_of(light));
        }
        let shadows = match lights {
            BounceLights::All { shadows } | BounceLights::One { shadows, .. } => shadows,
            BounceLights::Virtual(_) => false,
        };
        if shadows {
            let rays = self.rays()?;
            let of_polygons = || self.lighting.targets(&self.gpu);
            let targets = self.gpu.guarded("points of lights", of_polygons)?;
            set.traced = Some(TracedLights { rays, targets });
        }
        Ok(set)
    }

    /// Adds to what the device did for the last virtual lights.
    fn spent(&self, milliseconds: f64) {
        *lock(&self.bounce_time) += milliseconds;
    }

    /// Rasters all faces at once.
    fn raster_faces(
        &self,
        frames: &[u8],
        face_size: u32,
        kept: &mut Kept,
        map: &mut CubeMap,
        watch: Watch<'_>,
    ) -> Result<Waited, GpuError> {
        let gpu = &self.gpu;
        let raster = self
            .face_raster
            .get_or_init(|| FaceRaster::new(gpu, self.visibility.raster()));
        let canvas = match &mut kept.faces {
            Some(canvas) if canvas.face_size == face_size => canvas,
            other => other.insert(FaceCanvas::new(gpu, face_size)),
        };
        gpu.queue().write_buffer(&self.scene.frames, 0, frames);
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        for face in 0..FACES {
            let stamps = self.clock.as_ref().map(|clock| clock.face(face));
            raster.encode(&mut encoder, &self.scene, canvas, face, stamps);
        }
        let mut reads = vec![canvas.all()];
        if let Some(clock) = &self.clock {
            reads.push(clock.finish_faces(&mut encoder, FACES));
        }
        let submission = gpu.queue().submit([encoder.finish()]);
        let cancelled = || watch.is_cancelled();
        gpu.read(&submission, &reads, cancelled, |i, bytes| {
            if i == 0 {
                map.texels = canvas.texels(bytes, &self.scene.order);
            } else if let Some(clock) = &self.clock {
                self.spent(clock.faces(bytes));
            }
        })
    }
}

impl Gather for GpuRenderer {
    fn see(&self, center: Vec3, face_size: u32, watch: Watch<'_>) -> Result<CubeMap, RenderError> {
        if watch.is_cancelled() {
            return Err(RenderError::Cancelled);
        }
        let mut map = CubeMap {
            center: center.to_array(),
            face_size,
            texels: vec![None; FACES * (face_size as usize).pow(2)],
        };
        let Some(frames) = frames(center, face_size, &self.scene) else {
            return Ok(map);
        };
        let mut kept = lock(&self.kept);
        let done = self.gpu.guarded("a cube map", || {
            self.raster_faces(&frames, face_size, &mut kept, &mut map, watch)
        });
        match done {
            Ok(Waited::Done) => Ok(map),
            Ok(Waited::Cancelled) => Err(RenderError::Cancelled),
            Err(fault) => {
                kept.faces = None;
                Err(fault.into())
            }
        }
    }

    fn radiance(
        &self,
        map: &CubeMap,
        lights: BounceLights<'_>,
        watch: Watch<'_>,
    ) -> Result<Vec<Vec3>, RenderError> {
        let size = map.face_size;
        let settings = RenderSettings {
            width: size,
            height: size,
            samples: 1,
            diffuse: DiffuseMethod::default(),
            specular: SpecularMethod::None,
            image_method: ImageMethod::default(),
            light_bound: 0.0,
            ..RenderSettings::default()
        };
        let mut kept = lock(&self.kept);
        let Kept {
            face,
            virtual_lighting,
            ..
        } = &mut *kept;
        let set = match lights {
            BounceLights::Virtual(lights) => self.virtual_light_set(virtual_lighting, lights)?,
            _ => self.lights_of(lights, &settings)?,
        };
        let sets = [set];
        let mut radiance = Vec::with_capacity(map.texels.len());
        let still = Watch {
            progress: &|_, _| {},
            ..watch
        };
        for index in 0..FACES {
            let mut picture = Rendering::black(size, size)?;
            let camera = CubeMap::camera(map.center, index);
            if let Some(view) = View::new(&camera, [size; 2], self.scene.bounds) {
                let done = self.gpu.guarded("light on a cube map", || {
                    self.render_into(&mut picture, &view, &settings, &sets, still, face)
                });
                match done {
                    Ok(Some([visibility, shading])) => self.spent(visibility + shading),
                    Ok(None) => return Err(RenderError::Cancelled),
                    Err(fault) => {
                        *face = None;
                        return Err(fault.into());
                    }
                }
            }
            radiance.extend(picture.diffuse.into_iter().map(Vec3::from));
            (watch.progress)(index as u64 + 1, FACES as u64);
        }
        Ok(radiance)
    }

    fn facets(&self) -> &Facets {
        self.facets.get_or_init(|| Facets::new(&self.shapes))
    }

    fn light_places(&self) -> Vec<(usize, Vec3)> {
        self.lighting.in_order_of_the_scene(light_places(
            self.lighting.polygons(),
            &self.shapes.punctual_lights,
            self.facets(),
        ))
    }
}
