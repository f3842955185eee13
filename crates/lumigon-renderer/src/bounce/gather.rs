//! From a scene to its virtual lights.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::centers::centers;
use super::footprint::{PlaneFrame, footprint};
use super::reduction::{Patch, Reduction, Sample, reduced};
use super::{
    BounceMethod, BounceSettings, BounceVisibility, CubeMap, CubeTexel, Facets, MAXIMUM_BOUNCES,
    MAXIMUM_FACE_SIZE, MAXIMUM_VIRTUAL_LIGHTS, VirtualLightKind, VirtualLights,
};
use crate::render::{RenderError, Watch};
use crate::scene::Camera;

/// Most texels of all cube maps of a picture: they take some 400 bytes each.
const MOST_TEXELS: u64 = 1 << 22;

/// How far a place may lie behind the surface that a texel sees and still be that surface, in widths
/// of the texel and relative to its distance.
const SAME_BY_TEXEL: f64 = 1.0;
const SAME_BY_DISTANCE: f64 = 1e-3;

/// What a backend does for bounce light: see, and light what is seen.
pub(crate) trait Gather {
    /// What is seen around a point, not lit yet.
    fn see(&self, center: Vec3, face_size: u32, watch: Watch<'_>) -> Result<CubeMap, RenderError>;

    /// The diffuse radiance of each texel, lit by `lights`; black where it sees nothing.
    fn radiance(
        &self,
        map: &CubeMap,
        lights: BounceLights<'_>,
        watch: Watch<'_>,
    ) -> Result<Vec<Vec3>, RenderError>;

    /// The flat parts of the scene.
    fn facets(&self) -> &Facets;

    /// The lights that have a place, by what [`BounceLights::One`] calls them, and from where they see
    /// what they light: polygon lights, then those without extent.
    fn light_places(&self) -> Vec<(usize, Vec3)>;
}

/// What lights the texels.
#[derive(Clone, Copy)]
pub(crate) enum BounceLights<'a> {
    /// The scene's lights; whether surfaces block them.
    All { shadows: bool },
    /// One of them: polygon lights are counted first, then those without extent.
    One { light: usize, shadows: bool },
    /// Virtual lights.
    Virtual(&'a VirtualLights),
}

/// Sees, lights and reduces.
pub(crate) fn virtual_lights(
    backend: &impl Gather,
    camera: &Camera,
    settings: &BounceSettings,
    watch: Watch<'_>,
) -> Result<VirtualLights, RenderError> {
    match settings.method {
        BounceMethod::CubeMap => by_cube_maps(backend, camera, settings, watch),
        BounceMethod::ReflectiveShadowMaps => by_shadow_maps(backend, settings, watch),
    }
}

fn by_cube_maps(
    backend: &impl Gather,
    camera: &Camera,
    settings: &BounceSettings,
    watch: Watch<'_>,
) -> Result<VirtualLights, RenderError> {
    check(settings)?;
    let places = centers(backend, camera, &settings.centers, watch)?;
    let texels_a_map = 6 * u64::from(settings.face_size).pow(2);
    in_range(
        "the number of cube maps",
        places.len() as u64,
        MOST_TEXELS / texels_a_map,
    )?;
    let mut maps = Vec::new();
    let mut direct = Vec::new();
    let lights = BounceLights::All {
        shadows: settings.shadows,
    };
    for center in places {
        let mut map = backend.see(center, settings.face_size, watch)?;
        let radiance = backend.radiance(&map, lights, watch)?;
        show(&mut map, &radiance, &vec![Vec3::ZERO; radiance.len()]);
        maps.push(map);
        direct.push(radiance);
    }
    let facets = backend.facets();
    let count = settings.virtual_lights as usize;
    let reduce = |maps: &[CubeMap]| {
        let samples = samples(maps, facets, settings.merges);
        let gathered = Gathered::new(&samples);
        let patches = reduced(&samples, facets, reduction(settings, count));
        VirtualLights::new(&patches, settings, facets.scene_diagonal as f32, gathered)
    };
    let mut lights = reduce(&maps);
    for _ in 1..settings.bounces {
        for (map, direct) in maps.iter_mut().zip(&direct) {
            let indirect = backend.radiance(map, BounceLights::Virtual(&lights), watch)?;
            show(map, direct, &indirect);
        }
        lights = reduce(&maps);
    }
    lights.warn(warnings(&maps, facets));
    lights.centers = maps.iter().map(|map| map.center).collect();
    Ok(lights)
}

fn by_shadow_maps(
    backend: &impl Gather,
    settings: &BounceSettings,
    watch: Watch<'_>,
) -> Result<VirtualLights, RenderError> {
    check(settings)?;
    // What a light does not reach is not in its map: no map sees all second bounces once.
    in_range(
        "the number of bounces by reflective shadow maps",
        settings.bounces.into(),
        1,
    )?;
    let facets = backend.facets();
    let places = backend.light_places();
    let count = settings.virtual_lights as usize;
    let mut patches: Vec<Patch> = Vec::new();
    let mut gathered = Gathered::default();
    let mut waiting = Vec::new();
    let mut given = 0;
    for (i, &(light, center)) in places.iter().enumerate() {
        let mut map = backend.see(center, settings.face_size, watch)?;
        let shadows = settings.shadows;
        let radiance = backend.radiance(&map, BounceLights::One { light, shadows }, watch)?;
        show(&mut map, &radiance, &vec![Vec3::ZERO; radiance.len()]);
        waiting.extend(samples(&[map], facets, settings.merges));
        // Each light has its share of the virtual lights; where they are fewer, some share one.
        let due = count * (i + 1) / places.len();
        if due > given || i + 1 == places.len() {
            gathered.add(&waiting);
            let share = reduction(settings, (due - given).max(1));
            patches.extend(reduced(&waiting, facets, share));
            given = due;
            waiting.clear();
        } else {
            waiting.retain(|sample| sample.radiance != DVec3::ZERO);
        }
    }
    let diagonal = facets.scene_diagonal as f32;
    let mut lights = VirtualLights::new(&patches, settings, diagonal, gathered);
    if places.is_empty() {
        lights.warn(vec![
            "no light has a place: there are no reflective shadow maps and no bounce light"
                .to_owned(),
        ]);
    }
    Ok(lights)
}

fn check(settings: &BounceSettings) -> Result<(), RenderError> {
    for (what, value, greatest) in [
        ("the number of bounces", settings.bounces, MAXIMUM_BOUNCES),
        (
            "the cube map's face size",
            settings.face_size,
            MAXIMUM_FACE_SIZE,
        ),
        (
            "the number of virtual lights",
            settings.virtual_lights,
            MAXIMUM_VIRTUAL_LIGHTS,
        ),
    ] {
        in_range(what, value.into(), greatest.into())?;
    }
    Ok(())
}

fn in_range(what: &'static str, value: u64, greatest: u64) -> Result<(), RenderError> {
    if (1..=greatest).contains(&value) {
        return Ok(());
    }
    Err(RenderError::OutOfRange {
        what,
        value,
        least: 1,
        greatest,
    })
}

/// Gives each texel its radiance, direct and indirect.
fn show(map: &mut CubeMap, direct: &[Vec3], indirect: &[Vec3]) {
    let light = direct.iter().zip(indirect);
    for (texel, (&direct, &indirect)) in map.texels.iter_mut().zip(light) {
        if let Some(texel) = texel {
            texel.radiance = (direct + indirect).to_array();
        }
    }
}

fn reduction(settings: &BounceSettings, count: usize) -> Reduction {
    // A polygon's light is exact at any size; what a ray or a point stands for must be small.
    let is_whole =
        settings.kind == VirtualLightKind::Polygon && settings.visibility == BounceVisibility::None;
    Reduction {
        merges: settings.merges,
        count: settings.clusters.then_some(count),
        extent_weight: if is_whole { 0.0 } else { 1.0 },
    }
}

/// What the cube maps have seen.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gathered {
    /// Texels that see a surface.
    pub(super) texels: usize,
    /// Linear RGB, in watts or lumens.
    pub(super) flux: DVec3,
}

impl Gathered {
    fn new(samples: &[Sample]) -> Self {
        let mut this = Self::default();
        this.add(samples);
        this
    }

    fn add(&mut self, samples: &[Sample]) {
        self.texels += samples.len();
        self.flux += samples.iter().map(Sample::flux).sum::<DVec3>();
    }
}

/// What all texels see, each with its share where several cube maps see the same.
fn samples(maps: &[CubeMap], facets: &Facets, merges: bool) -> Vec<Sample> {
    let of_map = |map: &CubeMap| {
        let eye = Vec3::from(map.center).as_dvec3();
        let spacing = 2.0 / f64::from(map.face_size);
        let of_texel = |(index, texel): (usize, &Option<CubeTexel>)| {
            let texel = texel.as_ref()?;
            let position = Vec3::from(texel.position).as_dvec3();
            let normal = Vec3::from(texel.normal).as_dvec3();
            let radiance = Vec3::from(texel.radiance).as_dvec3();
            let is_usable = position.is_finite() && radiance.is_finite() && eye != position;
            if !is_usable {
                return None;
            }
            let facet = facets.of(texel.triangle).filter(|_| merges);
            let frame = match facet {
                Some(facet) => facets.get(facet).frame,
                None => PlaneFrame::new(position, normal),
            };
            Some(Sample {
                facet,
                position,
                normal,
                radiance,
                weight: share(map, maps, position, normal),
                footprint: footprint(eye, &map.corners(index), spacing, position, &frame),
                frame,
            })
        };
        let seen = map.texels.par_iter().enumerate().filter_map(of_texel);
        seen.collect::<Vec<_>>()
    };
    maps.iter().flat_map(of_map).collect()
}

/// How much of a place is left to one of the maps that see it: as its texels are dense there.
fn share(own: &CubeMap, maps: &[CubeMap], position: DVec3, normal: DVec3) -> f64 {
    if maps.len() == 1 {
        return 1.0;
    }
    let density = |map: &CubeMap| {
        let offset = position - Vec3::from(map.center).as_dvec3();
        let size = f64::from(map.face_size);
        let depth = offset.abs().max_element();
        let density = -normal.dot(offset) * size * size / (depth * depth * depth);
        if density.is_finite() {
            density.max(0.0)
        } else {
            0.0
        }
    };
    let of_own = density(own);
    let others = maps
        .iter()
        .filter(|&map| !std::ptr::eq(map, own) && sees(map, position))
        .map(density);
    let all = of_own + others.sum::<f64>();
    if all > 0.0 { of_own / all } else { 1.0 }
}

/// Whether nothing lies between a cube map and a place, as far as its texels know.
fn sees(map: &CubeMap, position: DVec3) -> bool {
    let offset = position - Vec3::from(map.center).as_dvec3();
    let Some(index) = map.texel_towards(offset) else {
        return false;
    };
    let Some(Some(texel)) = map.texels.get(index) else {
        return false;
    };
    // Behind the plane that the texel sees by no more than it may be wrong about it.
    let normal = Vec3::from(texel.normal).as_dvec3();
    let met = Vec3::from(texel.position).as_dvec3();
    let depth = normal.dot(met - position);
    let distance = offset.length();
    let texel_width = 2.0 / f64::from(map.face_size);
    depth <= distance * (SAME_BY_DISTANCE + SAME_BY_TEXEL * texel_width)
}

/// What the cube maps could not see.
fn warnings(maps: &[CubeMap], facets: &Facets) -> Vec<String> {
    if facets.len() == 0 {
        return vec!["the scene has no surfaces: nothing bounces light".to_owned()];
    }
    let seen = |map: &CubeMap| map.texels.iter().flatten().count();
    let is_lit = |map: &CubeMap| map.texels.iter().flatten().any(|t| t.radiance != [0.0; 3]);
    maps.iter()
        .filter_map(|map| {
            let [x, y, z] = map.center;
            let fault = if seen(map) == 0 {
                "sees no surface"
            } else if !is_lit(map) {
                "sees no surface that is lit"
            } else {
                return None;
            };
            Some(format!(
                "the cube map at ({x}, {y}, {z}) {fault}, and adds no bounce light: move it into the \
                 open, or let it be placed in the scene"
            ))
        })
        .collect()
}
