use std::sync::Arc;

use glam::DVec3;

use crate::{brdf::Brdf, lobe::Lobe, settings::BrdfKind};

/// Smallest GGX width of a table: narrower lobes are mirrors to an f32 lookup.
pub(crate) const MIN_ALPHA: f64 = 1e-4;
/// `cos(89.9 degrees)`: at 90 degrees every lobe degenerates.
pub(crate) const MIN_COS_THETA: f64 = 0.001_745_328_365_898_309;

/// One problem to be fitted: a BRDF seen from one direction, with what its lobe sums up to.
#[derive(Clone)]
pub struct Node {
    /// The BRDF.
    pub brdf: Arc<dyn Brdf>,
    /// Its width, in `[1e-4,1]`.
    pub alpha: f64,
    /// Angle between normal and view direction in radians, at most 89.9 degrees.
    pub theta: f64,
    /// Unit view direction `(sin theta, 0, cos theta)` in shading space.
    pub view: DVec3,
    /// Directional albedo with F = 1, in `(0,1]`.
    pub albedo: f64,
    /// Directional albedo weighted with Schlick's `(1 - h.v)^5`.
    pub schlick_albedo: f64,
    /// Mean light direction of the lobe, unit length, y = 0.
    pub mean_direction: DVec3,
}

impl Node {
    /// The node at a perceptual roughness and cosine of the view angle, both in `[0,1]` and clamped
    /// to `alpha >= 1e-4` and 89.9 degrees, and its lobe as `directions` weighted directions.
    pub fn new(
        kind: BrdfKind,
        perceptual_roughness: f64,
        cos_theta: f64,
        directions: u32,
    ) -> (Self, Lobe) {
        let alpha = (perceptual_roughness * perceptual_roughness).clamp(MIN_ALPHA, 1.0);
        let theta = cos_theta.clamp(MIN_COS_THETA, 1.0).acos();
        let view = DVec3::new(theta.sin(), 0.0, theta.cos());
        let brdf = kind.with_alpha(alpha);
        let lobe = Lobe::new(brdf.as_ref(), view, directions);
        let node = Self {
            brdf,
            alpha,
            theta,
            view,
            albedo: lobe.albedo().max(1e-9),
            schlick_albedo: lobe.schlick_albedo(),
            mean_direction: lobe.mean_direction(),
        };
        (node, lobe)
    }

    /// About how wide the lobe is, in the plane of incidence and across, radians. A microfacet's
    /// tilt turns the light twice as far; across, it does so by `2 v.h` only, which at grazing
    /// views is of the order of alpha.
    pub fn widths(&self) -> [f64; 2] {
        let alpha = self.alpha;
        [2.0 * alpha, 2.0 * alpha * self.view.z.hypot(alpha)]
    }
}
