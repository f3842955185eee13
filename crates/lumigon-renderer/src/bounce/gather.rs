//! From a scene to its virtual lights.

use glam::{DVec3, Vec3};

use super::footprint::{PlaneFrame, footprint};
use super::reduction::{Reduction, Sample, reduced};
use super::{
    BounceCenters, BounceMethod, BounceSettings, BounceVisibility, CubeMap, Facets,
    MAXIMUM_BOUNCES, MAXIMUM_FACE_SIZE, MAXIMUM_VIRTUAL_LIGHTS, VirtualLightKind, VirtualLights,
};
use crate::render::{RenderError, Watch};
use crate::scene::Camera;

/// What a backend does for bounce light: see, and light what is seen.
pub(crate) trait Gather {
    /// What is seen around a point, not lit yet.
    fn see(&self, center: Vec3, face_size: u32, watch: Watch<'_>) -> Result<CubeMap, RenderError>;

    /// The diffuse radiance of each texel, lit by `lights`; black where there is none.
    fn radiance(
        &self,
        map: &CubeMap,
        lights: BounceLights<'_>,
        watch: Watch<'_>,
    ) -> Result<Vec<Vec3>, RenderError>;

    /// The flat parts of the scene.
    fn facets(&self) -> &Facets;

    /// The centre of each light of the scene, and where it is one-sided its normal.
    fn light_places(&self) -> Vec<(Vec3, Option<Vec3>)>;
}

/// What lights the texels.
#[derive(Clone, Copy)]
pub(crate) enum BounceLights<'a> {
    /// The scene's lights; whether surfaces block them.
    All { shadows: bool },
    /// One of them: an index into [`Gather::light_places`].
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
    check(settings)?;
    let shadows = settings.shadows;
    let mut maps = Vec::new();
    match settings.method {
        BounceMethod::CubeMap => {
            for center in centers(backend, camera, settings) {
                let map = backend.see(center, settings.face_size, watch)?;
                maps.push((map, BounceLights::All { shadows }));
            }
        }
        BounceMethod::ReflectiveShadowMaps => {
            for (light, (center, _)) in backend.light_places().into_iter().enumerate() {
                let map = backend.see(center, settings.face_size, watch)?;
                maps.push((map, BounceLights::One { light, shadows }));
            }
        }
    }
    for (map, lights) in &mut maps {
        let radiance = backend.radiance(map, *lights, watch)?;
        for (texel, radiance) in map.texels.iter_mut().zip(radiance) {
            if let Some(texel) = texel {
                texel.radiance = radiance.to_array();
            }
        }
    }
    let maps: Vec<_> = maps.into_iter().map(|(map, _)| map).collect();
    Ok(reduce(&maps, backend.facets(), settings))
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
        if !(1..=greatest).contains(&value) {
            return Err(RenderError::OutOfRange {
                what,
                value: value.into(),
                least: 1,
                greatest: greatest.into(),
            });
        }
    }
    Ok(())
}

fn centers(_backend: &impl Gather, camera: &Camera, settings: &BounceSettings) -> Vec<Vec3> {
    match &settings.centers {
        BounceCenters::Points(points) => points.iter().map(|&p| p.into()).collect(),
        _ => vec![camera.world_from_camera.translation.into()],
    }
}

fn reduce(maps: &[CubeMap], facets: &Facets, settings: &BounceSettings) -> VirtualLights {
    let mut samples = Vec::new();
    for map in maps {
        let eye = Vec3::from(map.center).as_dvec3();
        let spacing = 2.0 / f64::from(map.face_size);
        for (index, texel) in map.texels.iter().enumerate() {
            let Some(texel) = texel else { continue };
            let position = Vec3::from(texel.position).as_dvec3();
            let normal = Vec3::from(texel.normal).as_dvec3();
            let frame = PlaneFrame::new(position, normal);
            samples.push(Sample {
                facet: facets.of(texel.triangle),
                position,
                normal,
                radiance: Vec3::from(texel.radiance).as_dvec3(),
                weight: 1.0,
                footprint: footprint(eye, &map.corners(index), spacing, position, &frame),
                frame,
            });
        }
    }
    let reduction = Reduction {
        merges: settings.merges,
        count: settings
            .clusters
            .then_some(settings.virtual_lights as usize),
        extent_counts: settings.visibility == BounceVisibility::Traced
            || settings.kind != VirtualLightKind::Polygon,
    };
    let flux: DVec3 = samples.iter().map(Sample::flux).sum();
    let patches = reduced(&samples, facets, reduction);
    let diagonal = facets.scene_diagonal as f32;
    VirtualLights::new(&patches, settings, diagonal, samples.len(), flux)
}
