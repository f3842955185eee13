//! Lights that stand for the surfaces that light bounces off.

use glam::{DVec2, DVec3, Vec3};
use lumigon::{PolygonLight, Sides};
use lumigon_wgpu::Light;
use rayon::prelude::*;

use super::footprint::{Convex, PlaneFrame};
use super::gather::Gathered;
use super::reduction::Patch;
use super::targets::LightTargets;
use super::{BounceSettings, BounceVisibility, VirtualLightKind};

/// A point that emits by the cosine about its normal; `radiance x area` of a small patch there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VirtualPoint {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    /// Linear RGB radiant intensity along the normal: flux over pi.
    pub(crate) intensity: Vec3,
    /// Nearer than this its light no longer grows.
    pub(crate) least_distance: f32,
}

impl VirtualPoint {
    /// Unit vector towards it and the irradiance on a surface that faces it; `None` behind it.
    pub(crate) fn at(&self, point: Vec3) -> Option<(Vec3, Vec3)> {
        let offset = self.position - point;
        let squared = offset.length_squared();
        let towards = offset.try_normalize()?;
        let cosine = -towards.dot(self.normal);
        let nearest = self.least_distance * self.least_distance;
        (cosine > 0.0).then(|| (towards, self.intensity * (cosine / squared.max(nearest))))
    }
}

/// What lights a scene's further bounces.
///
/// All of the lights are polygons, or all are points. A scene without surfaces or without light has none.
#[derive(Clone, Debug, Default)]
pub struct VirtualLights {
    pub(crate) polygons: Vec<Light>,
    pub(crate) points: Vec<VirtualPoint>,
    /// One for each light, if surfaces block them.
    pub(crate) targets: Option<LightTargets>,
    pub(super) gathered: Gathered,
    pub(super) warnings: Vec<String>,
    pub(super) centers: Vec<[f32; 3]>,
}

impl VirtualLights {
    /// `gathered` is what the patches came of.
    pub(super) fn new(
        patches: &[Patch],
        settings: &BounceSettings,
        scene_diagonal: f32,
        gathered: Gathered,
    ) -> Self {
        let mut this = Self {
            gathered,
            ..Self::default()
        };
        let mut targets = Vec::new();
        match settings.kind {
            VirtualLightKind::Polygon => {
                let lights = patches
                    .par_iter()
                    .map(|patch| Some((patch, polygon(patch)?)));
                let lights: Vec<_> = lights.flatten().collect();
                targets.extend(lights.iter().map(|(patch, _)| patch.target.as_vec3()));
                this.polygons = lights.into_iter().map(|(_, light)| light).collect();
            }
            VirtualLightKind::Point { least_distance } => {
                let least_distance = least_distance.unwrap_or(scene_diagonal / 20.0);
                this.points = patches
                    .iter()
                    .map(|patch| VirtualPoint {
                        position: patch.target.as_vec3(),
                        normal: patch.normal.as_vec3(),
                        intensity: (patch.flux / std::f64::consts::PI).as_vec3(),
                        least_distance,
                    })
                    .collect();
                targets.extend(this.points.iter().map(|point| point.position));
            }
        }
        this.targets = (settings.visibility == BounceVisibility::Traced).then_some(LightTargets {
            per_light: 1,
            points: targets,
        });
        this
    }

    pub(super) fn warn(&mut self, warnings: Vec<String>) {
        self.warnings.extend(warnings);
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.polygons.len() + self.points.len()
    }

    /// Whether nothing is lit by them.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The flux that all of them emit, linear RGB in watts or lumens.
    #[must_use]
    pub fn flux(&self) -> [f64; 3] {
        let polygons = self
            .polygons
            .iter()
            .map(|light| Vec3::from(light.radiance).as_dvec3() * f64::from(light.polygon.area()));
        let points = self.points.iter().map(|point| point.intensity.as_dvec3());
        (polygons.chain(points).sum::<DVec3>() * std::f64::consts::PI).to_array()
    }

    /// The flux that the cube maps saw leave the surfaces. That of the lights is the same, but for
    /// rounding.
    #[must_use]
    pub fn gathered_flux(&self) -> [f64; 3] {
        self.gathered.flux.to_array()
    }

    /// Where the cube maps have looked from. Given as [`BounceCenters::Points`](super::BounceCenters), the
    /// next ones look from there too, whatever has moved.
    #[must_use]
    pub fn centers(&self) -> &[[f32; 3]] {
        &self.centers
    }

    /// Texels of all cube maps that see a surface.
    #[must_use]
    pub fn texels(&self) -> usize {
        self.gathered.texels
    }

    /// What cube maps could not see, and what would mend it.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

fn polygon(patch: &Patch) -> Option<Light> {
    // What clipping has left of an outline may have no area; the light is there all the same.
    let outline = PolygonLight::new(&patch.loops, Sides::Front);
    let polygon = outline.or_else(|_| PolygonLight::new(&[square(patch)], Sides::Front));
    let polygon = polygon.ok()?;
    let radiance = patch.flux / (std::f64::consts::PI * polygon.area());
    Some(Light {
        polygon: polygon.cast().ok()?,
        radiance: radiance.as_vec3().to_array(),
        image: None,
    })
}

/// As large as the surfaces that a patch stands for.
fn square(patch: &Patch) -> Vec<[f64; 3]> {
    let frame = PlaneFrame::new(patch.target, patch.normal);
    let square = Convex::square(DVec2::ZERO, 0.5 * patch.area.sqrt());
    let corners = square.corners().iter();
    corners.map(|&p| frame.raised(p).to_array()).collect()
}
