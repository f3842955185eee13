//! The methods' names on the command line and in questions.

use clap::ValueEnum;
use lumigon::{ImageMethod, InclusionRule, LocalOcclusion, ProjectionBasis};
use serde::Deserialize;

/// The bias where none is given, in scene units.
const DEFAULT_BIAS: f64 = 0.5;

/// The projection axis of the projected-area method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Basis {
    /// Towards the light's centroid
    Centroid,
    /// Towards the mean of the vertices, weighted by inverse distance
    Weighted,
    /// Towards the centroid, from a point behind the shading point
    Biased,
    /// The axis of the right pyramid: every vertex stays in front
    Optimal,
}

impl Basis {
    pub(crate) fn with_bias(self, bias: Option<f64>) -> ProjectionBasis {
        match self {
            Self::Centroid => ProjectionBasis::Centroid,
            Self::Weighted => ProjectionBasis::Weighted,
            Self::Biased => ProjectionBasis::Biased {
                bias: bias.unwrap_or(DEFAULT_BIAS),
            },
            Self::Optimal => ProjectionBasis::Optimal,
        }
    }
}

/// What counts of a light that crosses a surface's horizon.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Occlusion {
    /// The part above the horizon
    #[default]
    Exact,
    /// A linear ramp over the height of the light's circumscribed circle
    Circle,
}

impl From<Occlusion> for LocalOcclusion {
    fn from(occlusion: Occlusion) -> Self {
        match occlusion {
            Occlusion::Exact => Self::Exact,
            Occlusion::Circle => Self::Circle,
        }
    }
}

/// How diffuse light is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Diffuse {
    /// The integral itself
    #[default]
    Exact,
    /// As if all light came along the light vector
    LightVector,
    /// The area in a perspective projection
    ProjectedArea,
}

/// How specular light is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Specular {
    /// Linearly transformed cosines through the fitted GGX table
    #[default]
    Ltc,
    /// Two linearly transformed cosines for isotropic GGX, more exact and about twice the cost
    #[value(name = "ltc-2")]
    Ltc2,
    /// The mirrored view ray's inclusion in the polygon
    Reflected,
    /// The distance from the polygon at which the mirrored view ray meets its plane, baked once
    DistanceField,
    /// The BRDF along the light vector
    LightVector,
    /// No specular light
    None,
}

/// How the image on a light is averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Deserialize)]
pub(crate) enum Images {
    /// One lookup in Gaussian levels along the light vector: common practice
    #[value(name = "lookup")]
    #[serde(rename = "lookup")]
    Lookup,
    /// One tap where the weight is
    #[value(name = "1x1")]
    #[serde(rename = "1x1")]
    One,
    /// Four taps
    #[default]
    #[value(name = "2x2")]
    #[serde(rename = "2x2")]
    Two,
    /// Nine taps
    #[value(name = "3x3")]
    #[serde(rename = "3x3")]
    Three,
    /// Sixteen taps
    #[value(name = "4x4")]
    #[serde(rename = "4x4")]
    Four,
}

impl From<Images> for ImageMethod {
    fn from(images: Images) -> Self {
        match images {
            Images::Lookup => Self::Lookup,
            Images::One => Self::Quadrature { taps: 1 },
            Images::Two => Self::Quadrature { taps: 2 },
            Images::Three => Self::Quadrature { taps: 3 },
            Images::Four => Self::Quadrature { taps: 4 },
        }
    }
}

/// What makes a point of the light's plane part of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Inclusion {
    /// A ray from it crosses the outlines an odd number of times
    #[default]
    CrossingNumber,
    /// The outlines wind around it
    WindingNumber,
}

impl From<Inclusion> for InclusionRule {
    fn from(inclusion: Inclusion) -> Self {
        match inclusion {
            Inclusion::CrossingNumber => Self::CrossingNumber,
            Inclusion::WindingNumber => Self::WindingNumber,
        }
    }
}
