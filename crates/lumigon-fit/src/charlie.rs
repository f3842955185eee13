use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::DVec3;

use crate::{
    brdf::{Brdf, LightSample},
    limit::Limit,
};

/// The sheen of `KHR_materials_sheen`, F = 1: Charlie's distribution of microfacets with its own
/// shadowing (Estevez and Kulla 2017, "Production friendly microfacet sheen BRDF").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Charlie {
    /// Width, in `(0,1]`.
    pub alpha: f64,
}

impl Charlie {
    /// `sin^(1/alpha)`, normalised over the projected hemisphere.
    fn distribution(&self, h: DVec3) -> f64 {
        let inverse = 1.0 / self.alpha;
        let sin2 = (h.x * h.x + h.y * h.y).min(1.0);
        (2.0 + inverse) * sin2.powf(0.5 * inverse) / TAU
    }

    /// The published fit of the shadowing's auxiliary function.
    fn lambda(&self, cosine: f64) -> f64 {
        let t = (1.0 - self.alpha) * (1.0 - self.alpha);
        // Interpolated between the fits for alpha = 0 and alpha = 1.
        let at = |smooth: f64, rough: f64| smooth * t + rough * (1.0 - t);
        let a = at(25.3245, 21.5473);
        let b = at(3.324_35, 3.829_87);
        let c = at(0.168_01, 0.198_23);
        let d = at(-1.273_93, -1.977_60);
        let e = at(-4.859_67, -4.320_54);
        let l = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
        if cosine < 0.5 {
            l(cosine).exp()
        } else {
            (2.0 * l(0.5) - l(1.0 - cosine)).exp()
        }
    }
}

impl Brdf for Charlie {
    fn eval(&self, view: DVec3, light: DVec3) -> f64 {
        if light.z <= 0.0 || view.z <= 0.0 {
            return 0.0;
        }
        let h = (view + light).normalize();
        let shadowing = 1.0 / (1.0 + self.lambda(view.z) + self.lambda(light.z));
        self.distribution(h) * shadowing / (4.0 * view.z)
    }

    fn secondary(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    fn limit(&self, _: DVec3) -> Limit {
        Limit::cosine()
    }

    /// Half uniform over the hemisphere, half by the cosine: the lobe is broad or grazing.
    fn pdf(&self, _: DVec3, light: DVec3) -> f64 {
        if light.z > 0.0 {
            0.5 * (0.5 + light.z) * FRAC_1_PI
        } else {
            0.0
        }
    }

    fn sample(&self, view: DVec3, u: [f64; 2]) -> Option<LightSample> {
        // Inverse of the cumulated density of z, (z + z^2) / 2.
        let z = (0.25 + 2.0 * u[0]).sqrt() - 0.5;
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        let light = DVec3::new(r * cos, r * sin, z.max(1e-9));
        let weight = self.eval(view, light) * PI / (0.25 + 0.5 * light.z);
        Some(LightSample { light, weight })
    }
}
