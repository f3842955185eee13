use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::{
    brdf::{Brdf, LightSample, schlick_factor},
    limit::Limit,
};

/// GGX with height-correlated Smith masking-shadowing (Walter et al. 2007; Heitz 2014,
/// "Understanding the masking-shadowing function", eqs. 84 to 99), F = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// Widths along x and y, in `(0,1]`; alike for an isotropic surface.
    pub alpha: [f64; 2],
}

impl Ggx {
    /// The same width in all directions.
    pub fn isotropic(alpha: f64) -> Self {
        Self {
            alpha: [alpha, alpha],
        }
    }

    /// Density of the microfacet normals; written with the sine, as the difference from the cosine
    /// cancels at small alpha.
    fn distribution(&self, h: DVec3) -> f64 {
        let [ax, ay] = self.alpha;
        let (x, y) = (h.x / ax, h.y / ay);
        let d = x * x + y * y + h.z * h.z;
        1.0 / (PI * ax * ay * d * d)
    }

    /// Smith's auxiliary function.
    fn lambda(&self, w: DVec3) -> f64 {
        let [ax, ay] = self.alpha;
        let squared = ((ax * w.x).powi(2) + (ay * w.y).powi(2)) / (w.z * w.z);
        0.5 * ((1.0 + squared).sqrt() - 1.0)
    }
}

impl Brdf for Ggx {
    fn eval(&self, view: DVec3, light: DVec3) -> f64 {
        if light.z <= 0.0 || view.z <= 0.0 {
            return 0.0;
        }
        let masking = 1.0 / (1.0 + self.lambda(view) + self.lambda(light));
        self.distribution((view + light).normalize()) * masking / (4.0 * view.z)
    }

    fn secondary(&self, view: DVec3, light: DVec3) -> f64 {
        schlick_factor(view, light)
    }

    fn limit(&self, view: DVec3) -> Limit {
        Limit::mirror(self.alpha, view)
    }

    fn pdf(&self, view: DVec3, light: DVec3) -> f64 {
        if view.z <= 0.0 {
            return 0.0;
        }
        let h = (view + light).normalize_or(DVec3::Z);
        if h.z <= 0.0 {
            return 0.0;
        }
        self.distribution(h) / ((1.0 + self.lambda(view)) * 4.0 * view.z)
    }

    /// Visible normals (Heitz 2018, "Sampling the GGX distribution of visible normals").
    fn sample(&self, view: DVec3, u: [f64; 2]) -> Option<LightSample> {
        let [ax, ay] = self.alpha;
        let stretched = DVec3::new(ax * view.x, ay * view.y, view.z).normalize();
        let across = DVec2::new(-stretched.y, stretched.x).normalize_or(DVec2::X);
        let t1 = across.extend(0.0);
        let t2 = stretched.cross(t1);
        let (radius, phi) = (u[0].sqrt(), TAU * u[1]);
        let p1 = radius * phi.cos();
        let s = 0.5 * (1.0 + stretched.z);
        let p2 = (1.0 - s) * (1.0 - p1 * p1).max(0.0).sqrt() + s * radius * phi.sin();
        let p3 = (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
        let h = p1 * t1 + p2 * t2 + p3 * stretched;
        let h = DVec3::new(ax * h.x, ay * h.y, h.z.max(1e-9)).normalize();
        let light = (2.0 * view.dot(h) * h - view).normalize();
        if light.z <= 0.0 {
            return None;
        }
        let lambda = self.lambda(view);
        let weight = (1.0 + lambda) / (1.0 + lambda + self.lambda(light));
        Some(LightSample { light, weight })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Midpoint rule over the hemisphere, independent of `sample` and `pdf`.
    #[test]
    fn sampling_agrees_with_evaluation() {
        for (alpha, azimuth, cos_theta) in [
            ([0.3, 0.3], 0.0_f64, 0.9_f64),
            ([0.6, 0.6], 0.0, 0.4),
            ([1.0, 1.0], 0.0, 0.05),
            ([0.8, 0.2], 0.7, 0.5),
        ] {
            let brdf = Ggx { alpha };
            let sine = (1.0 - cos_theta * cos_theta).sqrt();
            let view = DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cos_theta);
            let n = 500;
            let (mut albedo, mut first_moment) = (0.0, 0.0);
            for i in 0..n {
                for j in 0..n {
                    let z = (f64::from(i) + 0.5) / f64::from(n);
                    let phi = TAU * (f64::from(j) + 0.5) / f64::from(n);
                    let r = (1.0 - z * z).sqrt();
                    let light = DVec3::new(r * phi.cos(), r * phi.sin(), z);
                    let value = brdf.eval(view, light) * TAU / f64::from(n * n);
                    albedo += value;
                    first_moment += value * light.x;
                }
            }
            let (mut sampled, mut sampled_moment) = (0.0, 0.0);
            for i in 0..n {
                for j in 0..n {
                    let u = [
                        (f64::from(i) + 0.5) / f64::from(n),
                        (f64::from(j) + 0.5) / f64::from(n),
                    ];
                    if let Some(s) = brdf.sample(view, u) {
                        let ratio = brdf.eval(view, s.light) / brdf.pdf(view, s.light);
                        assert!((s.weight - ratio).abs() < 1e-9 * ratio.max(1.0));
                        sampled += s.weight / f64::from(n * n);
                        sampled_moment += s.weight * s.light.x / f64::from(n * n);
                    }
                }
            }
            assert!(
                (albedo - sampled).abs() < 1e-3,
                "{alpha:?}: {albedo} {sampled}"
            );
            assert!((first_moment - sampled_moment).abs() < 1e-3);
        }
    }

    #[test]
    fn finite_at_the_corners() {
        for alpha in [1e-4, 1.0] {
            for cos_theta in [1.0, 0.5, 0.00174_f64] {
                let view = DVec3::new((1.0 - cos_theta * cos_theta).sqrt(), 0.0, cos_theta);
                for u in [[0.0, 0.0], [0.5, 0.25], [1.0, 0.75], [1.0, 1.0]] {
                    if let Some(s) = Ggx::isotropic(alpha).sample(view, u) {
                        assert!(s.light.is_finite() && (0.0..=1.0).contains(&s.weight));
                        assert!(Ggx::isotropic(alpha).eval(view, s.light).is_finite());
                    }
                }
            }
        }
    }
}
