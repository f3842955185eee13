//! What bounce light asks of the CPU: rays for cube maps, and light on what they meet.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;
use lumigon::{DiffuseMethod, ImageMethod, SpecularMethod};
use rayon::prelude::*;

use super::CpuRenderer;
use super::hits::{Hits, Wanted};
use super::lobes::Scattered;
use super::shade::{self, Visibility};
use crate::bounce::{
    BounceLights, BounceSettings, CubeMap, CubeTexel, Facets, Gather, LightTargets, VirtualLights,
    light_places, virtual_lights,
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
        let hit = self.geometry.hit(&self.scene, origin, direction, 0.0)?;
        Some((hit.surface(&self.scene), direction, hit.triangle_of_scene()))
    }

    /// What the hits scatter of `lights` by their diffuse lobes.
    fn bounce_light(
        &self,
        hits: &Hits,
        lights: BounceLights<'_>,
        watch: Watch<'_>,
    ) -> Vec<Scattered> {
        let methods = shade::Methods {
            diffuse: DiffuseMethod::default(),
            specular: SpecularMethod::None,
            images: ImageMethod::default(),
        };
        let mut light = vec![Scattered::default(); hits.surfaces().len()];
        let all = self.lights(methods.images);
        let punctual = self.scene.punctual_lights.as_slice();
        let (range, punctual, shadows) = match lights {
            BounceLights::Virtual(lights) => {
                self.add_virtual_lights(&mut light, hits, lights, methods, watch);
                return light;
            }
            BounceLights::All { shadows } => (0..all.len(), punctual, shadows),
            BounceLights::One { light, shadows } if light < all.len() => {
                (light..light + 1, &[][..], shadows)
            }
            BounceLights::One { light, shadows } => {
                let own = light - all.len();
                let one = punctual.get(own..=own).unwrap_or_default();
                (0..0, one, shadows)
            }
        };
        let targets;
        let mut visibility = Visibility::Whole;
        let is_cancelled = || watch.is_cancelled();
        if shadows {
            targets = self.light_targets(range.clone());
            visibility = self.traced(&targets, &is_cancelled);
        }
        shade::add_polygons(&mut light, hits, &all[range], &[], methods, visibility);
        for one in punctual {
            let is_visible = |position, towards, distance| {
                let epsilon = self.geometry.epsilon;
                let farthest = distance - epsilon;
                let geometry = &self.geometry;
                !shadows || !geometry.occluded(&self.scene, position, towards, epsilon, farthest)
            };
            shade::add_punctual(&mut light, hits, one, methods.specular, is_visible);
        }
        light
    }

    /// Adds what the hits scatter of virtual lights.
    pub(super) fn add_virtual_lights(
        &self,
        light: &mut [Scattered],
        hits: &Hits,
        lights: &VirtualLights,
        methods: shade::Methods,
        watch: Watch<'_>,
    ) {
        let is_cancelled = || watch.is_cancelled();
        let visibility = match &lights.targets {
            Some(targets) => self.traced(targets, &is_cancelled),
            None => Visibility::Whole,
        };
        shade::add_polygons(light, hits, &lights.polygons, &[], methods, visibility);
        shade::add_virtual_points(light, hits, &lights.points, methods.specular, visibility);
    }

    fn traced<'b>(
        &'b self,
        targets: &'b LightTargets,
        is_cancelled: &'b dyn Fn() -> bool,
    ) -> Visibility<'b> {
        Visibility::Traced {
            geometry: &self.geometry,
            scene: &self.scene,
            targets,
            is_cancelled,
        }
    }

    /// Where rays to some of the scene's lights go.
    fn light_targets(&self, range: Range<usize>) -> LightTargets {
        let all = self
            .targets
            .get_or_init(|| LightTargets::spread(&self.lights));
        let per_light = all.per_light;
        LightTargets {
            per_light,
            points: all.points[range.start * per_light..range.end * per_light].to_vec(),
        }
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
            lobes: true,
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
                let light = self.bounce_light(hits, lights, watch);
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
        self.facets.get_or_init(|| {
            Arc::new(match &self.earlier_facets {
                Some(earlier) => Facets::edited(&self.scene, earlier),
                None => Facets::new(&self.scene),
            })
        })
    }

    fn light_places(&self) -> Vec<(usize, Vec3)> {
        light_places(&self.lights, &self.scene.punctual_lights, self.facets())
    }
}
