use glam::DVec3;

use crate::limit::Limit;

/// A direction towards the light drawn from a BRDF, with its importance-sampling weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit direction towards the light in shading space, z > 0.
    pub light: DVec3,
    /// `eval / pdf`: the mean of the weights is the directional albedo.
    pub weight: f64,
}

/// A reflectance to be fitted, without its Fresnel term (F = 1).
///
/// All directions are unit vectors in shading space that point away from the surface.
pub trait Brdf: Send + Sync {
    /// `f(view, light) * light.z` in 1/sr, 0 for a light at or below the horizon.
    fn eval(&self, view: DVec3, light: DVec3) -> f64;

    /// Density of [`Brdf::sample`] in 1/sr.
    fn pdf(&self, view: DVec3, light: DVec3) -> f64;

    /// Maps a point of the unit square to a light direction; `None` where it falls below the
    /// horizon, which counts as a sample of weight 0.
    fn sample(&self, view: DVec3, u: [f64; 2]) -> Option<LightSample>;

    /// A second weight that the lobe is integrated under, in the same form factors: Schlick's
    /// `(1 - h.v)^5` for a BRDF with a Fresnel term, 0 for one that needs none.
    fn secondary(&self, view: DVec3, light: DVec3) -> f64;

    /// The lobe this BRDF tends to, which a fit starts from.
    fn limit(&self, view: DVec3) -> Limit;
}

/// Schlick's `(1 - h.v)^5` with the half vector of two unit directions, in `[0,1]`.
pub(crate) fn schlick_factor(view: DVec3, light: DVec3) -> f64 {
    let half = (view + light).normalize_or(view);
    (1.0 - half.dot(view)).clamp(0.0, 1.0).powi(5)
}
