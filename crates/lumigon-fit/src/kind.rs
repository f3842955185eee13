use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{brdf::Brdf, charlie::Charlie, eon::Eon, ggx::Ggx};

/// Smallest GGX width of a table: narrower lobes are mirrors to an f32 lookup.
const MIN_ALPHA: f64 = 1e-4;
/// Smallest width of a sheen: below, it shows at grazing angles alone.
const MIN_SHEEN_ALPHA: f64 = 1e-3;
/// `cos(89.9 degrees)`: at 90 degrees every lobe degenerates.
const MIN_COS_THETA: f64 = 0.001_745_328_365_898_309;

const VIEW_AXIS: &str = "sqrt(1 - cos theta_view), 0 to 1; theta_view at most 89.9 degrees";

/// Which BRDF a table holds, and over which axes. Each runs from 0 to 1; axis 0 is the fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BrdfKind {
    /// Isotropic GGX, height-correlated Smith, F = 1.
    Ggx,
    /// The same with two widths.
    GgxAnisotropic,
    /// The sheen of `KHR_materials_sheen`.
    Charlie,
    /// The energy-preserving Oren-Nayar model, single scattering; its second weight makes the
    /// multiple scattering.
    Eon,
}

impl BrdfKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Ggx, Self::GgxAnisotropic, Self::Charlie, Self::Eon];

    /// The name that files and commands use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ggx => "ggx",
            Self::GgxAnisotropic => "ggx-anisotropic",
            Self::Charlie => "charlie",
            Self::Eon => "eon",
        }
    }

    /// Meaning of each axis.
    pub fn axes(self) -> &'static [&'static str] {
        match self {
            Self::Ggx => &[
                "perceptual_roughness, 0 to 1; alpha = max(perceptual_roughness^2, 1e-4)",
                VIEW_AXIS,
            ],
            Self::GgxAnisotropic => &[
                "sqrt(alpha_x), 0 to 1, alpha_x the greater width (at least 1e-4), along x",
                "sqrt(alpha_y / alpha_x), 0 to 1 (alpha_y at least 1e-4)",
                VIEW_AXIS,
                "azimuth of the view from x over pi / 2, 0 to 1; mirror the frame for the rest",
            ],
            Self::Charlie => &[
                "sheen perceptual roughness, 0 to 1; alpha = max(perceptual_roughness^2, 1e-3)",
                VIEW_AXIS,
            ],
            Self::Eon => &["roughness r of the model, 0 to 1", VIEW_AXIS],
        }
    }

    /// What the second amplitude weighs.
    pub fn secondary(self) -> &'static str {
        match self {
            Self::Ggx | Self::GgxAnisotropic => "schlick",
            Self::Charlie => "zero",
            Self::Eon => "multiple_scattering",
        }
    }

    /// Texels along each axis of a table of nominal size `size`. Of four axes, the ratio of the
    /// widths and the view angle need twice the texels of the others.
    pub fn sizes(self, size: u32) -> Vec<usize> {
        let size = size as usize;
        match self {
            Self::GgxAnisotropic => {
                let half = (size / 2).max(2);
                vec![half, size, size, half]
            }
            _ => vec![size, size],
        }
    }

    /// Which axis is the view angle.
    pub fn view_axis(self) -> usize {
        match self {
            Self::GgxAnisotropic => 2,
            _ => 1,
        }
    }

    /// Whether every node is symmetric in y.
    pub fn is_isotropic(self) -> bool {
        self != Self::GgxAnisotropic
    }

    /// The BRDF and the unit view direction at a place of the table, each coordinate in `[0,1]`.
    pub fn at(self, place: &[f64]) -> (Arc<dyn Brdf>, DVec3) {
        let v = place[self.view_axis()].clamp(0.0, 1.0);
        let cosine = (1.0 - v * v).clamp(MIN_COS_THETA, 1.0);
        let sine = (1.0 - cosine * cosine).sqrt();
        let squared = |x: f64, least: f64| (x * x).clamp(least, 1.0);
        let isotropic = DVec3::new(sine, 0.0, cosine);
        match self {
            Self::Ggx => (
                Arc::new(Ggx::isotropic(squared(place[0], MIN_ALPHA))),
                isotropic,
            ),
            Self::GgxAnisotropic => {
                let x = squared(place[0], MIN_ALPHA);
                let y = (x * squared(place[1], 0.0)).max(MIN_ALPHA);
                let (sin, cos) = (FRAC_PI_2 * place[3].clamp(0.0, 1.0)).sin_cos();
                (
                    Arc::new(Ggx { alpha: [x, y] }),
                    DVec3::new(sine * cos, sine * sin, cosine),
                )
            }
            Self::Charlie => (
                Arc::new(Charlie {
                    alpha: squared(place[0], MIN_SHEEN_ALPHA),
                }),
                isotropic,
            ),
            Self::Eon => (Arc::new(Eon::new(place[0].clamp(0.0, 1.0))), isotropic),
        }
    }
}
