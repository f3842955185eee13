//! What bounce light asks of the CPU: rays for cube maps, and light on what they meet.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use lumigon::{DiffuseMethod, ImageMethod, SpecularMethod};
use rayon::prelude::*;

use super::hits::{Hits, Wanted};
use super::lobes::Scattered;
use super::{CpuRenderer, shade};
use crate::bounce::{
    BounceLights, BounceSettings, CubeMap, CubeTexel, Facets, Gather, VirtualLights, virtual_lights,
};
use crate::render::{RenderError, Watch};
use crate::scene::{Camera, SurfaceSample};

/// Texels that are lit together.
const TEXELS_AT_ONCE: usize = 256;

impl CpuRenderer<'_> {
    /// Finds the surfaces that light bounces off, and makes virtual lights of them.
    ///
    /// # Errors
    /// Where a setting is out of range, or when cancelled.
    pub fn virtual_lights(
        &self,
        camera: &Camera,
        settings: &BounceSettings,
        watch: Watch<'_>,
    ) -> Result<VirtualLights, RenderError> {
        virtual_lights(self, camera, settings, watch)
    }

    /// The surface that a texel's central ray meets.
    fn surface(
        &self,
        camera: &Camera,
        size: u32,
        column: u32,
        row: u32,
    ) -> Option<(SurfaceSample, Vec3, u32)> {
        let at = |texel: u32| (f64::from(texel) + 0.5) / f64::from(size);
        let (origin, direction) = camera.ray(at(column) as f32, at(row) as f32, 1.0);
        let hit = self.geometry.hit(self.scene, origin, direction, 0.0)?;
        Some((hit.surface(self.scene), direction, hit.triangle_of_scene()))
    }
}

impl CpuRenderer<'_> {
    /// What the hits scatter of `lights` by their diffuse lobes.
    fn bounce_light(&self, hits: &Hits, lights: BounceLights<'_>) -> Vec<Scattered> {
        let methods = shade::Methods {
            diffuse: DiffuseMethod::default(),
            specular: SpecularMethod::None,
            images: ImageMethod::default(),
        };
        let mut light = vec![Scattered::default(); hits.surfaces().len()];
        match lights {
            BounceLights::All { .. } => {
                let lights = self.lights(methods.images);
                shade::add_polygons(&mut light, hits, lights, &[], methods);
                for punctual in &self.scene.punctual_lights {
                    shade::add_punctual(&mut light, hits, punctual, methods.specular);
                }
            }
            BounceLights::One { light: one, .. } => {
                let lights = self.lights.get(one..=one).unwrap_or_default();
                shade::add_polygons(&mut light, hits, lights, &[], methods);
            }
            BounceLights::Virtual(lights) => {
                shade::add_polygons(&mut light, hits, &lights.polygons, &[], methods);
            }
        }
        light
    }
}

impl Gather for CpuRenderer<'_> {
    fn see(&self, center: Vec3, face_size: u32, watch: Watch<'_>) -> Result<CubeMap, RenderError> {
        let center = center.to_array();
        let rows: Vec<Option<Vec<Option<CubeTexel>>>> = (0..6 * face_size)
            .into_par_iter()
            .map(|i| {
                let (face, row) = (i / face_size, i % face_size);
                let camera = CubeMap::camera(center, face as usize);
                let texel = |column| {
                    let (surface, _, triangle) = self.surface(&camera, face_size, column, row)?;
                    Some(CubeTexel {
                        position: surface.position.to_array(),
                        normal: surface.geometric_normal.to_array(),
                        albedo: (surface.base_color * (1.0 - surface.metallic)).to_array(),
                        radiance: [0.0; 3],
                        triangle,
                    })
                };
                (!watch.is_cancelled()).then(|| (0..face_size).map(texel).collect())
            })
            .collect();
        let mut texels = Vec::with_capacity(6 * (face_size as usize).pow(2));
        for row in rows {
            texels.extend(row.ok_or(RenderError::Cancelled)?);
        }
        Ok(CubeMap {
            center,
            face_size,
            texels,
        })
    }

    fn radiance(
        &self,
        map: &CubeMap,
        lights: BounceLights<'_>,
        watch: Watch<'_>,
    ) -> Result<Vec<Vec3>, RenderError> {
        let wanted = Wanted {
            diffuse: DiffuseMethod::default(),
            specular: SpecularMethod::None,
            punctual: !self.scene.punctual_lights.is_empty(),
        };
        let size = map.face_size;
        let count = map.texels.len();
        let chunks = count.div_ceil(TEXELS_AT_ONCE);
        let done = AtomicU64::new(0);
        let lit: Vec<Option<Vec<Vec3>>> = (0..chunks)
            .into_par_iter()
            .map_init(Hits::default, |hits, chunk| {
                if watch.is_cancelled() {
                    return None;
                }
                let range = chunk * TEXELS_AT_ONCE..count.min((chunk + 1) * TEXELS_AT_ONCE);
                hits.clear();
                for index in range.clone() {
                    if map.texels[index].is_none() {
                        continue;
                    }
                    let per_face = (size * size) as usize;
                    let camera = CubeMap::camera(map.center, index / per_face);
                    let (column, row) = (index as u32 % size, index as u32 % (size * size) / size);
                    if let Some((surface, direction, _)) = self.surface(&camera, size, column, row)
                    {
                        let place = (index - range.start) as u32;
                        hits.push(place, &surface, -direction, &self.fitted, wanted);
                    }
                }
                let mut radiance = vec![Vec3::ZERO; range.len()];
                let light = self.bounce_light(hits, lights);
                for (hit, light) in hits.surfaces().iter().zip(light) {
                    radiance[hit.pixel as usize] = light.diffuse;
                }
                (watch.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, chunks as u64);
                Some(radiance)
            })
            .collect();
        let mut radiance = Vec::with_capacity(count);
        for chunk in lit {
            radiance.extend(chunk.ok_or(RenderError::Cancelled)?);
        }
        Ok(radiance)
    }

    fn facets(&self) -> &Facets {
        self.facets.get_or_init(|| Facets::new(self.scene))
    }

    fn light_places(&self) -> Vec<(Vec3, Option<Vec3>)> {
        Vec::new()
    }
}
