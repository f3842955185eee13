use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;

use crate::{
    brdf::{Brdf, LightSample},
    limit::Limit,
};

/// The energy-preserving Oren-Nayar model (Portsmouth, Kutz and Hill 2025, "EON: a practical
/// energy-preserving rough diffuse BRDF"): single scattering for albedo 1; under the second weight,
/// multiple scattering without its dependence on the albedo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eon {
    r: f64,
    /// The model's normalisation, `A_F` there.
    scale: f64,
    /// Mean of the directional albedo.
    mean_albedo: f64,
}

impl Eon {
    /// A roughness in `[0,1]`.
    pub fn new(r: f64) -> Self {
        let scale = 1.0 / (1.0 + (0.5 - 2.0 / 3.0 * FRAC_1_PI) * r);
        Self {
            r,
            scale,
            mean_albedo: scale * (1.0 + (2.0 / 3.0 - 28.0 / 15.0 * FRAC_1_PI) * r),
        }
    }

    /// Directional albedo of single scattering, exact (the paper's appendix).
    fn albedo(&self, cosine: f64) -> f64 {
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let angle = cosine.clamp(-1.0, 1.0).acos();
        // The last part tends to 0 at the horizon and at the normal.
        let tangent_part = if cosine > 1e-9 {
            2.0 / 3.0 * (sine / cosine * (1.0 - sine.powi(3)) - sine)
        } else {
            -2.0 / 3.0
        };
        let g = sine * (angle - sine * cosine) + tangent_part;
        self.scale * (1.0 + FRAC_1_PI * self.r * g)
    }

    fn single(&self, view: DVec3, light: DVec3) -> f64 {
        let s = view.dot(light) - view.z * light.z;
        let ratio = if s > 0.0 { s / view.z.max(light.z) } else { s };
        FRAC_1_PI * self.scale * (1.0 + self.r * ratio)
    }
}

impl Brdf for Eon {
    fn eval(&self, view: DVec3, light: DVec3) -> f64 {
        if light.z <= 0.0 || view.z <= 0.0 {
            return 0.0;
        }
        self.single(view, light) * light.z
    }

    fn secondary(&self, view: DVec3, light: DVec3) -> f64 {
        let lost = |cosine: f64| (1.0 - self.albedo(cosine)).max(0.0);
        let mean = (1.0 - self.mean_albedo).max(1e-12);
        FRAC_1_PI * lost(view.z) * lost(light.z) / mean / self.single(view, light).max(1e-12)
    }

    fn limit(&self, _: DVec3) -> Limit {
        Limit::cosine()
    }

    fn pdf(&self, _: DVec3, light: DVec3) -> f64 {
        light.z.max(0.0) * FRAC_1_PI
    }

    fn sample(&self, view: DVec3, u: [f64; 2]) -> Option<LightSample> {
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let r = u[0].sqrt();
        let light = DVec3::new(r * cos, r * sin, (1.0 - u[0]).max(1e-18).sqrt());
        let weight = self.eval(view, light) / self.pdf(view, light);
        Some(LightSample { light, weight })
    }
}
