use std::f64::consts::PI;

use glam::{DMat3, DVec3};

/// One linearly transformed cosine with its amplitudes. A BRDF's response is the sum over one or
/// several of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ltc {
    /// Maps shading space to the space of the clamped cosine about z; a positive factor does not
    /// matter, the determinant is positive.
    pub shading_to_cosine: DMat3,
    /// Response with F = 1 per unit of form factor.
    pub amplitude: f64,
    /// Response under the BRDF's second weight ([`crate::Brdf::secondary`]), per unit of form
    /// factor: Schlick's `(1 - h.v)^5` where the BRDF has a Fresnel term.
    pub secondary: f64,
}

impl Ltc {
    /// The clamped cosine itself, without amplitude.
    pub fn cosine() -> Self {
        Self {
            shading_to_cosine: DMat3::IDENTITY,
            amplitude: 0.0,
            secondary: 0.0,
        }
    }

    /// Reflectance of a material with Schlick's Fresnel term and `F90 = 1`, per unit of form
    /// factor: `f0 + (1 - f0) (1 - h.v)^5` integrated against the lobe, in `[0,1]`.
    pub fn specular(&self, f0: f64) -> f64 {
        f0 * self.amplitude + (1.0 - f0) * self.secondary
    }

    /// The distribution's density at a unit direction of shading space in 1/sr, normalised over
    /// the whole cosine hemisphere (also the part below the true horizon).
    /// Heitz et al. 2016, eq. 1, with the Jacobian of the normalised transformation.
    pub fn density(&self, light: DVec3) -> f64 {
        let w = self.shading_to_cosine * light;
        let length2 = w.length_squared();
        if w.z <= 0.0 || length2 <= 0.0 {
            return 0.0;
        }
        self.shading_to_cosine.determinant().abs() * w.z / (PI * length2 * length2)
    }

    /// Draws from the distribution: a cosine-distributed direction through the inverse matrix.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        let (radius, phi) = (u[0].sqrt(), 2.0 * PI * u[1]);
        let w = DVec3::new(
            radius * phi.cos(),
            radius * phi.sin(),
            (1.0 - u[0]).max(0.0).sqrt(),
        );
        // The inverse up to a positive factor.
        let [a, b, c] = cofactors(&self.shading_to_cosine);
        (a * w.x + b * w.y + c * w.z).normalize_or(DVec3::Z)
    }

    /// Share of the distribution above the true horizon, in `[0.5,1]` for lobes that point upwards:
    /// the cosine's form factor of the lune between both planes, `(1 + cos(angle)) / 2`.
    pub fn share_above_horizon(&self) -> f64 {
        // Normals map by the cofactors: the horizon's, z, to their third entries.
        let normal = DVec3::from(cofactors(&self.shading_to_cosine).map(|row| row.z));
        0.5 * (1.0 + normal.normalize_or(DVec3::Z).z)
    }
}

/// Rows of the cofactor matrix: the inverse's columns times the determinant.
fn cofactors(matrix: &DMat3) -> [DVec3; 3] {
    let rows = matrix.transpose();
    [
        rows.y_axis.cross(rows.z_axis),
        rows.z_axis.cross(rows.x_axis),
        rows.x_axis.cross(rows.y_axis),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skewed() -> Ltc {
        Ltc {
            shading_to_cosine: DMat3::from_cols(
                DVec3::new(1.3, 0.1, -0.3),
                DVec3::new(-0.1, 1.0, 0.2),
                DVec3::new(0.6, 0.0, 0.5),
            ),
            amplitude: 1.0,
            secondary: 0.0,
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
