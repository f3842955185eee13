//! Where the study's lights are seen from, and by what surface.

use glam::DVec3;
use lumigon::{LtcTable, PreparedLtc, Vec3};
use rand::{Rng, RngExt};
use serde::Serialize;

use super::light::StudyLight;

/// How far a light is from the shading point; its image's parallelogram has an area of 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Distance {
    /// 0.15 to 0.6
    Near,
    /// 0.6 to 2
    Mid,
    /// 2 to 16
    Far,
    /// 0.35 to 4, and cut by the surface's horizon.
    Horizon,
}

impl Distance {
    pub(super) const ALL: [Self; 4] = [Self::Near, Self::Mid, Self::Far, Self::Horizon];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Near => "near",
            Self::Mid => "mid",
            Self::Far => "far",
            Self::Horizon => "horizon",
        }
    }

    /// Logarithms of base 2.
    fn range(self) -> std::ops::Range<f64> {
        match self {
            Self::Near => -2.74..-0.74,
            Self::Mid => -0.74..1.0,
            Self::Far => 1.0..4.0,
            Self::Horizon => -1.5..2.0,
        }
    }
}

/// What the light falls on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Surface {
    /// A Lambertian one.
    Diffuse,
    /// GGX, by its fitted lobe.
    Specular,
}

impl Surface {
    pub(super) const ALL: [Self; 2] = [Self::Diffuse, Self::Specular];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::Specular => "specular",
        }
    }
}

/// A shading point in the frame of its light.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) point: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) lobe: Option<Lobe>,
}

/// A specular surface's lobe.
#[derive(Clone, Debug)]
pub(super) struct Lobe {
    pub(super) perceptual_roughness: f32,
    pub(super) view: [f32; 3],
    pub(super) prepared: PreparedLtc<f32>,
}

impl Place {
    /// Draws a place of a class, or nothing where what was drawn is of another.
    ///
    /// Specular surfaces are seen so that the mirrored view meets the image's parallelogram or up to
    /// a fifth of it beside.
    pub(super) fn draw(
        light: &StudyLight,
        distance: Distance,
        surface: Surface,
        table: &LtcTable<1>,
        rng: &mut impl Rng,
    ) -> Option<Self> {
        let from = direction(rng);
        // Light leaves within 84 degrees of the light's normal.
        if from.z < 0.1 {
            return None;
        }
        let point = from * rng.random_range(distance.range()).exp2();
        let normal = direction(rng);
        let [corner, u, v] = light.frame.map(DVec3::from);
        let heights = [corner, corner + u, corner + v, corner + u + v]
            .map(|vertex| normal.dot(vertex - point));
        let low = heights.into_iter().fold(f64::INFINITY, f64::min);
        let high = heights.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let fits = match distance {
            Distance::Horizon => low < 0.0 && high > 0.15 * (high - low),
            _ => low > 0.02 * point.length(),
        };
        if !fits {
            return None;
        }
        let single = |v: DVec3| v.to_array().map(|x| x as f32);
        let lobe = match surface {
            Surface::Diffuse => None,
            Surface::Specular => {
                let perceptual_roughness = rng.random_range(0.05..1.0);
                let towards = (DVec3::from(light.target(rng)) - point).normalize();
                let cosine = normal.dot(towards);
                if cosine < 0.05 {
                    return None;
                }
                let view = single((2.0 * cosine * normal - towards).normalize());
                let ltc = table.lookup(perceptual_roughness, cosine as f32).lobes[0];
                let prepared = PreparedLtc::new(&ltc, vector(single(normal)), vector(view));
                Some(Lobe {
                    perceptual_roughness,
                    view,
                    prepared,
                })
            }
        };
        Some(Self {
            point: single(point),
            normal: single(normal),
            lobe,
        })
    }
}

pub(super) fn vector(v: [f32; 3]) -> Vec3<f32> {
    Vec3::from(v)
}

/// A unit vector in f64 along one in f32, which is of unit length only to rounding.
pub(super) fn unit(v: [f32; 3]) -> [f64; 3] {
    DVec3::from(v.map(f64::from)).normalize().to_array()
}

fn direction(rng: &mut impl Rng) -> DVec3 {
    let z = rng.random_range(-1.0..1.0_f64);
    let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * cos, r * sin, z)
}
