//! Linearly transformed cosines of any shape: anisotropic lobes.

use crate::ltc::{PreparedLtc, cofactors, half_space_share};
use crate::real::{Mask, Real};
use crate::vec3::Vec3;

/// A lobe about one view direction that keeps no symmetry, in the frame (tangent, bitangent,
/// normal).
///
/// KT, Heitz, Dupuy and Narayanan, "Bringing Linearly Transformed Cosines to Anisotropic GGX",
/// PACMCGIT 5(1), 2022.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnisotropicLtc<T> {
    /// Rows of M^-1, up to a positive factor. The determinant must be positive.
    pub shading_to_cosine: [[T; 3]; 3],
    /// Integral of the lobe over the sphere with F = 1;
    /// [`AnisotropicLtc::share_above_horizon`] of it is above the surface.
    pub amplitude: T,
    /// The same weighted by Schlick's (1 - h.v)^5.
    pub schlick: T,
}

impl<T: Real> AnisotropicLtc<T> {
    #[inline(always)]
    fn rows(&self) -> [Vec3<T>; 3] {
        let [a, b, c] = self.shading_to_cosine;
        [
            Vec3::new(a[0], a[1], a[2]),
            Vec3::new(b[0], b[1], b[2]),
            Vec3::new(c[0], c[1], c[2]),
        ]
    }

    /// The lobe in world space, for [`ltc_form_factor`](crate::ltc_form_factor).
    ///
    /// The frame is orthonormal and right-handed.
    #[inline(always)]
    pub fn prepare(&self, tangent: Vec3<T>, bitangent: Vec3<T>, normal: Vec3<T>) -> PreparedLtc<T> {
        let [a, b, c] = self.rows();
        let to_world = [
            tangent * a.x + bitangent * a.y + normal * a.z,
            tangent * b.x + bitangent * b.y + normal * b.z,
            tangent * c.x + bitangent * c.y + normal * c.z,
        ];
        PreparedLtc::from_world_to_cosine(to_world, normal)
    }

    /// Density of the lobe in the direction `light` of the shading frame (unit), in 1/sr; it
    /// integrates to 1 over the sphere. 0 outside the transformed hemisphere.
    #[inline(always)]
    pub fn density(&self, light: Vec3<T>) -> T {
        let rows = self.rows();
        let cosine = Vec3::new(rows[0].dot(light), rows[1].dot(light), rows[2].dot(light));
        let zero = light.x.constant(0.0);
        let above = cosine.z.gt(zero);
        if !above.any() {
            return zero;
        }
        let determinant = rows[0].dot(rows[1].cross(rows[2]));
        let squared = cosine.dot(cosine);
        // D0(w0) |M^-1| / |M^-1 w|^3 with w0 normalised: the fourth power of the length.
        let value = cosine.z * determinant * light.x.constant(core::f64::consts::FRAC_1_PI)
            / (squared * squared);
        T::select(above, value, zero)
    }

    /// Response for Schlick's Fresnel term, `f0` at normal and `f90` at grazing incidence, to be
    /// multiplied by [`ltc_form_factor`](crate::ltc_form_factor) and the light's radiance.
    #[inline(always)]
    pub fn reflectance(&self, f0: T, f90: T) -> T {
        f0.mul_add(self.amplitude - self.schlick, f90 * self.schlick)
    }

    /// Share of the normalised lobe above the surface's horizon, in \[0, 1\].
    ///
    /// Times [`AnisotropicLtc::amplitude`] it is the directional albedo.
    #[inline(always)]
    pub fn share_above_horizon(&self) -> T {
        let [a, b, c] = cofactors(self.rows());
        half_space_share(Vec3::new(a.z, b.z, c.z).normalize_or_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ltc;

    const FLAT: Ltc<f64> = Ltc {
        shading_to_cosine: [1.4, -0.3, 0.2, 0.8],
        amplitude: 0.9,
        schlick: 0.1,
    };

    /// An isotropic lobe in the clothes of an anisotropic one.
    fn dressed(ltc: Ltc<f64>) -> AnisotropicLtc<f64> {
        let [m11, m13, m31, m33] = ltc.shading_to_cosine;
        AnisotropicLtc {
            shading_to_cosine: [[m11, 0.0, m13], [0.0, 1.0, 0.0], [m31, 0.0, m33]],
            amplitude: ltc.amplitude,
            schlick: ltc.schlick,
        }
    }

    #[test]
    fn an_isotropic_lobe_is_one_of_them() {
        let other = dressed(FLAT);
        assert!((FLAT.share_above_horizon() - other.share_above_horizon()).abs() < 1e-15);
        assert_eq!(FLAT.reflectance(0.3, 0.7), other.reflectance(0.3, 0.7));
        for light in [[0.6, 0.0, 0.8], [-0.48, 0.6, 0.64], [0.0, -0.6, -0.8]] {
            let light = Vec3::from(light);
            assert!((FLAT.density(light) - other.density(light)).abs() < 1e-15);
        }
        let normal = Vec3::new(0.36, 0.48, 0.8);
        let view = Vec3::new(0.6, 0.64, 0.48);
        let tangent = (view - normal * normal.dot(view)).normalize_or_zero();
        let prepared = PreparedLtc::new(&FLAT, normal, view).world_to_cosine();
        let others = other.prepare(tangent, normal.cross(tangent), normal);
        for (a, b) in prepared.into_iter().zip(others.world_to_cosine()) {
            assert!((a - b).length() < 1e-15, "{a:?} {b:?}");
        }
    }

    /// Schlick's term splits the response: f0 = f90 = 1 is all of it.
    #[test]
    fn reflectance_is_linear_in_both_ends() {
        assert_eq!(FLAT.reflectance(1.0, 1.0), FLAT.amplitude);
        assert_eq!(FLAT.reflectance(0.0, 1.0), FLAT.schlick);
        assert_eq!(FLAT.reflectance(0.0, 0.0), 0.0);
        assert_eq!(Ltc::cosine(1.0).share_above_horizon(), 1.0);
    }
}
