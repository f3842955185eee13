use std::f64::consts::PI;

use glam::{DMat3, DVec3};

/// One linearly transformed cosine with its amplitudes: what a table lookup returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ltc {
    /// The entries of [`Ltc::shading_to_cosine`] that vary, in the table's order:
    /// (row 1, column 1), `(1,3)`, `(3,1)`, `(3,3)`, all divided by the middle element `(2,2)`.
    pub matrix: [f64; 4],
    /// Response with F = 1 per unit of form factor.
    pub amplitude: f64,
    /// Response weighted with Schlick's `(1 - h.v)^5`, per unit of form factor. Both together
    /// make a Fresnel term: [`Ltc::specular`].
    pub schlick: f64,
}

impl Ltc {
    /// Maps shading space to the space of the clamped cosine about z:
    /// `[[m0, 0, m1], [0, 1, 0], [m2, 0, m3]]`, row by row.
    pub fn shading_to_cosine(&self) -> DMat3 {
        let [a, b, c, d] = self.matrix;
        DMat3::from_cols(DVec3::new(a, 0.0, c), DVec3::Y, DVec3::new(b, 0.0, d))
    }

    /// Reflectance of a material with Schlick's Fresnel term, per unit of form factor:
    /// `f0 + (1 - f0) (1 - h.v)^5` integrated against the lobe, in `[0,1]`.
    pub fn specular(&self, f0: f64) -> f64 {
        f0 * self.amplitude + (1.0 - f0) * self.schlick
    }

    /// The distribution's density at a unit direction of shading space in 1/sr, normalised over
    /// the whole cosine hemisphere (also the part below the true horizon).
    /// Heitz et al. 2016, eq. 1, with the Jacobian of the normalised transformation.
    pub fn density(&self, light: DVec3) -> f64 {
        let [a, b, c, d] = self.matrix;
        let w = self.shading_to_cosine() * light;
        let length2 = w.length_squared();
        if w.z <= 0.0 || length2 <= 0.0 {
            return 0.0;
        }
        (a * d - b * c).abs() * w.z / (PI * length2 * length2)
    }

    /// Draws from the distribution: a cosine-distributed direction through the inverse matrix.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        let (radius, phi) = (u[0].sqrt(), 2.0 * PI * u[1]);
        let w = DVec3::new(
            radius * phi.cos(),
            radius * phi.sin(),
            (1.0 - u[0]).max(0.0).sqrt(),
        );
        let [a, b, c, d] = self.matrix;
        let inverse = DVec3::new(d * w.x - b * w.z, (a * d - b * c) * w.y, a * w.z - c * w.x);
        inverse.normalize_or(DVec3::Z)
    }

    /// Share of the distribution above the true horizon, in `[0.5,1]` for lobes that point upwards:
    /// the cosine's form factor of the lune between both planes, `(1 + cos(angle)) / 2`.
    pub fn share_above_horizon(&self) -> f64 {
        let [a, _, c, _] = self.matrix;
        // The horizon's normal in cosine space is M^T n, the last row of the inverse of M^-1;
        // up to a positive factor (-c, 0, a).
        let length = a.hypot(c);
        if length > 0.0 {
            0.5 * (1.0 + a / length)
        } else {
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skewed() -> Ltc {
        Ltc {
            matrix: [1.3, 0.6, -0.3, 0.5],
            amplitude: 1.0,
            schlick: 0.0,
        }
    }

    #[test]
    fn density_is_normalised_and_share_matches() {
        let n = 1000;
        let (mut total, mut above) = (0.0, 0.0);
        for i in 0..n {
            for j in 0..n {
                let z = 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
                let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(n);
                let r = (1.0 - z * z).sqrt();
                let value =
                    skewed().density(DVec3::new(r * phi.cos(), r * phi.sin(), z)) * 4.0 * PI
                        / f64::from(n * n);
                total += value;
                above += if z > 0.0 { value } else { 0.0 };
            }
        }
        assert!((total - 1.0).abs() < 1e-4, "{total}");
        let share = skewed().share_above_horizon();
        assert!((above - share).abs() < 1e-3, "{above} {share}");
    }

    #[test]
    fn samples_follow_the_density() {
        let (n, mut mean) = (400, DVec3::ZERO);
        for i in 0..n {
            for j in 0..n {
                let u = [
                    (f64::from(i) + 0.5) / f64::from(n),
                    (f64::from(j) + 0.5) / f64::from(n),
                ];
                mean += skewed().sample(u) / f64::from(n * n);
            }
        }
        let mut expected = DVec3::ZERO;
        for i in 0..n {
            for j in 0..n {
                let z = 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
                let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(n);
                let r = (1.0 - z * z).sqrt();
                let w = DVec3::new(r * phi.cos(), r * phi.sin(), z);
                expected += w * skewed().density(w) * 4.0 * PI / f64::from(n * n);
            }
        }
        assert!((mean - expected).length() < 1e-3, "{mean} {expected}");
    }
}
