use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use crate::brdf::{Brdf, LightSample};

/// Isotropic GGX with height-correlated Smith masking-shadowing (Walter et al. 2007; Heitz 2014,
/// "Understanding the masking-shadowing function", eq. 99), F = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// Width, in `(0,1]`.
    pub alpha: f64,
}

impl Ggx {
    /// Density of the microfacet normals; `sin^2 + alpha^2 cos^2` rather than
    /// `1 + (alpha^2 - 1) cos^2`, which cancels at small alpha.
    fn distribution(&self, h: DVec3) -> f64 {
        let a2 = self.alpha * self.alpha;
        let d = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
        a2 / (PI * d * d)
    }

    /// Smith's auxiliary function.
    fn lambda(&self, w: DVec3) -> f64 {
        let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
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
        let stretched = DVec3::new(self.alpha * view.x, self.alpha * view.y, view.z).normalize();
        let across = DVec2::new(-stretched.y, stretched.x).normalize_or(DVec2::X);
        let t1 = across.extend(0.0);
        let t2 = stretched.cross(t1);
        let (radius, phi) = (u[0].sqrt(), TAU * u[1]);
        let p1 = radius * phi.cos();
        let s = 0.5 * (1.0 + stretched.z);
        let p2 = (1.0 - s) * (1.0 - p1 * p1).max(0.0).sqrt() + s * radius * phi.sin();
        let p3 = (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
        let h = p1 * t1 + p2 * t2 + p3 * stretched;
        let h = DVec3::new(self.alpha * h.x, self.alpha * h.y, h.z.max(1e-9)).normalize();
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
        for (alpha, cos_theta) in [(0.3, 0.9_f64), (0.6, 0.4), (1.0, 0.05)] {
            let brdf = Ggx { alpha };
            let view = DVec3::new((1.0 - cos_theta * cos_theta).sqrt(), 0.0, cos_theta);
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
                "{alpha}: {albedo} {sampled}"
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
                    if let Some(s) = (Ggx { alpha }).sample(view, u) {
                        assert!(s.light.is_finite() && (0.0..=1.0).contains(&s.weight));
                        assert!((Ggx { alpha }).eval(view, s.light).is_finite());
                    }
                }
            }
        }
    }
}
