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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounce::{BounceCenters, CubeTexel};
    use crate::gpu::{Gpu, GpuPreference};
    use crate::{CpuRenderer, Scene};

    fn load(name: &str) -> Scene {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        Scene::load(folder.join("../../scenes").join(name)).unwrap()
    }

    fn lit(backend: &impl Gather, center: Vec3, lights: BounceLights<'_>) -> CubeMap {
        let mut map = backend.see(center, 24, Watch::none()).unwrap();
        let radiance = backend.radiance(&map, lights, Watch::none()).unwrap();
        for (texel, radiance) in map.texels.iter_mut().zip(radiance) {
            if let Some(texel) = texel {
                texel.radiance = radiance.to_array();
            }
        }
        map
    }

    /// The largest difference, relative to a length.
    fn off(a: [f32; 3], b: [f32; 3], scale: f32) -> f32 {
        Vec3::from(a).distance(Vec3::from(b)) / scale
    }

    /// Asserts that both see the same but for a share of the texels, which edges cross.
    fn assert_same(name: &str, cpu_map: &CubeMap, gpu_map: &CubeMap, share: f32) {
        assert_eq!(cpu_map.texels.len(), gpu_map.texels.len());
        let triangle = |texel: &Option<CubeTexel>| texel.map(|texel| texel.triangle);
        let all = cpu_map.texels.iter().flatten();
        let brightest = all.flat_map(|texel| texel.radiance).fold(0.0, f32::max);
        assert!(brightest > 0.0, "{name}");
        let mut on_edges = 0;
        for (cpu, gpu) in cpu_map.texels.iter().zip(&gpu_map.texels) {
            if triangle(cpu) != triangle(gpu) {
                on_edges += 1;
                continue;
            }
            let (Some(a), Some(b)) = (cpu, gpu) else {
                continue;
            };
            let distance = Vec3::from(a.position).distance(Vec3::from(b.position));
            let position = Vec3::from(a.position);
            let reach = position.length() + position.distance(cpu_map.center.into());
            // Where a light hardly reaches, single precision is left with little of it.
            let radiance = Vec3::from(a.radiance).max_element().max(0.01 * brightest);
            assert!(distance <= 1e-5 * reach, "{name}: {a:?} {b:?}");
            assert!(off(a.normal, b.normal, 1.0) <= 1e-4, "{name}: {a:?} {b:?}");
            assert!(off(a.albedo, b.albedo, 1.0) <= 2e-3, "{name}: {a:?} {b:?}");
            let error = off(a.radiance, b.radiance, radiance);
            assert!(error <= 1e-3, "{name}, {error}: {a:?} {b:?}");
        }
        let most = share * cpu_map.texels.len() as f32;
        assert!(on_edges as f32 <= most, "{name}: {on_edges} on edges");
    }

    #[test]
    fn cube_maps_are_those_of_the_cpu() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        for (name, share) in [
            ("cornell.glb", 0.005),
            ("room.glb", 0.01),
            ("materials.glb", 0.01),
        ] {
            let scene = load(name);
            let camera = &scene.cameras[0];
            let cpu = CpuRenderer::new(&scene);
            let gpu = GpuRenderer::new(&gpu, &scene).unwrap();
            // Between the camera and the middle of the scene.
            let (low, high) = scene.bounds().unwrap();
            let eye = Vec3::from(camera.world_from_camera.translation);
            let center = eye.lerp(low.midpoint(high), 0.6);
            let all = BounceLights::All { shadows: false };
            let (on_cpu, on_gpu) = (lit(&cpu, center, all), lit(&gpu, center, all));
            assert_same(name, &on_cpu, &on_gpu, share);
            let settings = BounceSettings {
                centers: BounceCenters::Camera,
                virtual_lights: 50,
                face_size: 8,
                ..BounceSettings::default()
            };
            let lights = cpu.virtual_lights(camera, &settings, Watch::none());
            let lights = lights.unwrap();
            let by = BounceLights::Virtual(&lights);
            let (on_cpu, on_gpu) = (lit(&cpu, center, by), lit(&gpu, center, by));
            assert_same(&format!("{name}, again"), &on_cpu, &on_gpu, share);
        }
    }

    /// Lights are sorted on the GPU, and are called by the same numbers all the same.
    #[test]
    fn each_light_is_that_of_the_cpu() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let mut scene = load("quads-10.glb");
        scene.polygon_lights[3].loops[0].truncate(2);
        for (i, light) in (0..).zip(&mut scene.polygon_lights) {
            light.radiance *= 1.0 + i as f32;
        }
        let sun = crate::PunctualLight {
            name: String::new(),
            kind: crate::PunctualKind::Directional,
            position: Vec3::ZERO,
            direction: Vec3::NEG_Y,
            color: Vec3::new(0.1, 0.2, 0.3),
            range: None,
        };
        let bulb = crate::PunctualLight {
            kind: crate::PunctualKind::Point,
            position: Vec3::new(0.3, 1.0, 0.2),
            ..sun.clone()
        };
        scene.punctual_lights = vec![sun, bulb];
        let cpu = CpuRenderer::new(&scene);
        let gpu = GpuRenderer::new(&gpu, &scene).unwrap();
        let places = cpu.light_places();
        assert_eq!(places.len(), 10);
        assert_eq!(places, gpu.light_places());
        let center = Vec3::from(scene.cameras[0].world_from_camera.translation);
        for (light, _) in places {
            let shadows = false;
            let one = BounceLights::One { light, shadows };
            let (on_cpu, on_gpu) = (lit(&cpu, center, one), lit(&gpu, center, one));
            assert_same(&format!("light {light}"), &on_cpu, &on_gpu, 0.01);
        }
    }
}
