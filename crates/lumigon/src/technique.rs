//! The choice of methods, as data: every backend and every comparison takes these.

use crate::distance_field::{DistanceFieldSettings, DistanceFieldSmoothness};
use crate::irradiance::{irradiance, light_vector};
use crate::light_direction::{circle_occlusion, light_direction};
use crate::polygon::PolygonLight;
use crate::projected_area::{LocalOcclusion, ProjectionBasis, projected_area};
use crate::real::Real;
use crate::reflection::InclusionRule;
use crate::vec3::Vec3;

/// How diffuse light is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiffuseMethod {
    /// The integral itself.
    Exact {
        /// What counts of a light that crosses the horizon.
        occlusion: LocalOcclusion,
    },
    /// As if all light came along the light vector.
    LightVector {
        /// What counts of a light that crosses the horizon.
        occlusion: LocalOcclusion,
    },
    /// The area in a perspective projection.
    ProjectedArea {
        /// The projection's axis.
        basis: ProjectionBasis,
        /// What counts of a light that crosses the horizon.
        occlusion: LocalOcclusion,
    },
}

impl Default for DiffuseMethod {
    fn default() -> Self {
        Self::Exact {
            occlusion: LocalOcclusion::Exact,
        }
    }
}

/// How specular light is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpecularMethod {
    /// Linearly transformed cosines through a fitted table.
    Ltc {
        /// How many stand for one BRDF.
        lobes: LtcLobes,
    },
    /// The mirrored view ray's inclusion in the polygon; every surface a mirror.
    ReflectedInclusion(InclusionRule),
    /// The distance from the polygon at which the mirrored view ray meets its plane, read from a baked
    /// field: reflections that are smooth on rough surfaces, at a cost that no outline changes.
    ReflectedDistanceField {
        /// How fields are baked.
        field: DistanceFieldSettings,
        /// How fast reflections fade with the distance.
        smoothness: DistanceFieldSmoothness,
    },
    /// The BRDF along the light vector.
    LightVector,
    /// No specular light.
    None,
}

impl Default for SpecularMethod {
    fn default() -> Self {
        Self::Ltc {
            lobes: LtcLobes::default(),
        }
    }
}

/// How many linearly transformed cosines stand for one BRDF.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LtcLobes {
    /// One: the table named `ggx`.
    #[default]
    One,
    /// The sum of two, at twice the cost of a light: the table named `ggx-2`.
    Two,
}

impl DiffuseMethod {
    /// What this method takes for the irradiance from a light of radiance 1; at least 0.
    ///
    /// The projected area has neither cosine nor 1/pi: radiance stands for its free coefficient.
    #[inline(always)]
    pub fn irradiance<T: Real>(
        self,
        light: &PolygonLight<T::Scalar>,
        point: Vec3<T>,
        normal: Vec3<T>,
    ) -> T {
        let zero = point.x.constant(0.0);
        match self {
            Self::Exact {
                occlusion: LocalOcclusion::Exact,
            } => irradiance(light, point, normal),
            Self::Exact {
                occlusion: LocalOcclusion::Circle,
            } => {
                let whole = normal.dot(light_vector(light, point)).max(zero);
                whole * circle_occlusion(light, point, normal)
            }
            Self::LightVector { occlusion } => {
                let seen = light_direction(light, point, normal, occlusion);
                seen.solid_angle * normal.dot(seen.direction).max(zero)
            }
            Self::ProjectedArea { basis, occlusion } => {
                projected_area(light, point, normal, basis, occlusion)
            }
        }
    }
}
