//! Random numbers and the distributions the path tracer draws from.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use crate::charlie::charlie_distribution;
use crate::ggx::{ggx_distribution, ggx_masking};

/// Uniform numbers of one pixel, the same whichever thread draws them.
pub(crate) struct Random(Pcg64);

impl Random {
    pub(crate) fn new(seed: u64, pixel: u64) -> Self {
        // Hashed first, so that neighbouring seeds don't share pixels' sequences.
        let base = Pcg64::seed_from_u64(seed).next_u64();
        Self(Pcg64::seed_from_u64(base.wrapping_add(pixel)))
    }

    /// Uniform in [0, 1).
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (0.5 * f64::EPSILON)
    }

    pub(crate) fn uniform2(&mut self) -> DVec2 {
        DVec2::new(self.uniform(), self.uniform())
    }
}

/// Barycentric weights of the second and third vertex for a uniform point in a triangle.
pub(crate) fn uniform_triangle(u: DVec2) -> DVec2 {
    if u.x + u.y <= 1.0 { u } else { DVec2::ONE - u }
}

/// A direction about z with density cos theta / pi.
pub(crate) fn cosine_hemisphere(u: DVec2) -> DVec3 {
    let (sin_phi, cos_phi) = (2.0 * PI * u.x).sin_cos();
    let radius = u.y.sqrt();
    DVec3::new(radius * cos_phi, radius * sin_phi, (1.0 - u.y).sqrt())
}

/// Density of [`cosine_hemisphere`], per steradian.
pub(crate) fn cosine_density(direction: DVec3) -> f64 {
    direction.z.max(0.0) / PI
}

/// A direction about z with equal density over the hemisphere.
pub(crate) fn uniform_hemisphere(u: DVec2) -> DVec3 {
    let (sin_phi, cos_phi) = (2.0 * PI * u.x).sin_cos();
    let z = 1.0 - u.y;
    let radius = (1.0 - z * z).sqrt();
    DVec3::new(radius * cos_phi, radius * sin_phi, z)
}

/// Density of [`uniform_hemisphere`], per steradian.
pub(crate) fn uniform_density(direction: DVec3) -> f64 {
    if direction.z > 0.0 { 0.5 / PI } else { 0.0 }
}

/// The reflection of `view` in a Charlie microfacet normal of density D cos theta; it may point below the horizon.
pub(crate) fn charlie_reflection(view: DVec3, alpha: f64, u: DVec2) -> DVec3 {
    let (sin_phi, cos_phi) = (2.0 * PI * u.x).sin_cos();
    // The sine to the power of 2 + 1/alpha is uniform; its cosine from the logarithm, for narrow lobes.
    let log_sine2 = 2.0 * (1.0 - u.y).ln() / (2.0 + alpha.recip());
    let (sine, cosine) = ((0.5 * log_sine2).exp(), (-log_sine2.exp_m1()).sqrt());
    let normal = DVec3::new(sine * cos_phi, sine * sin_phi, cosine);
    2.0 * view.dot(normal) * normal - view
}

/// Density of [`charlie_reflection`], per steradian, for directions above the horizon.
pub(crate) fn charlie_reflection_density(view: DVec3, direction: DVec3, alpha: f64) -> f64 {
    let half_vector = view + direction;
    let length = half_vector.length();
    // D n.h / (4 h.v), where |l + v| = 2 h.v.
    charlie_distribution(half_vector, alpha) * half_vector.z / (2.0 * length * length)
}

/// The reflection of `view` in a GGX microfacet normal drawn from those visible to it; it may point below the horizon.
///
/// Shading frame, `view.z > 0`. Spherical caps, after Dupuy and Benyoub 2023, listing 3.
pub(crate) fn ggx_reflection(view: DVec3, alpha: [f64; 2], u: DVec2) -> DVec3 {
    let stretch = DVec3::new(alpha[0], alpha[1], 1.0);
    let stretched = (view * stretch).normalize();
    let (sin_phi, cos_phi) = (2.0 * PI * u.x).sin_cos();
    let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    let sine = (1.0 - z * z).max(0.0).sqrt();
    let cap = DVec3::new(sine * cos_phi, sine * sin_phi, z) + stretched;
    let normal = (cap * stretch).normalize();
    2.0 * view.dot(normal) * normal - view
}

/// Density of [`ggx_reflection`], per steradian, for directions above the horizon.
pub(crate) fn ggx_reflection_density(view: DVec3, direction: DVec3, alpha: [f64; 2]) -> f64 {
    ggx_masking(view, alpha) * ggx_distribution(view + direction, alpha) / (4.0 * view.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Densities are right if the mean of g / density over samples is the integral of g for a g that tells directions
    /// apart; here by comparing the mean of g over samples with a quadrature of g times the density.
    fn check(sample: impl Fn(DVec2) -> DVec3, density: impl Fn(DVec3) -> f64) {
        let g = |l: DVec3| {
            if l.z > 0.0 {
                DVec3::new(l.z, l.x * l.z, l.y * l.y)
            } else {
                DVec3::ZERO
            }
        };
        let mut random = Random::new(7, 1);
        let n = 400_000;
        let mut sum = DVec3::ZERO;
        for _ in 0..n {
            sum += g(sample(random.uniform2()));
        }
        let mut quadrature = DVec3::ZERO;
        let (rows, columns) = (800, 1600);
        for i in 0..rows {
            let z = (f64::from(i) + 0.5) / f64::from(rows);
            for j in 0..columns {
                let (sine, cosine) =
                    (2.0 * PI * (f64::from(j) + 0.5) / f64::from(columns)).sin_cos();
                let radius = (1.0 - z * z).sqrt();
                let l = DVec3::new(radius * cosine, radius * sine, z);
                quadrature += g(l) * density(l);
            }
        }
        quadrature *= 2.0 * PI / (f64::from(rows) * f64::from(columns));
        let error = (sum / f64::from(n) - quadrature).abs().max_element();
        // About four standard errors.
        assert!(error < 3e-3, "{error}: {} {quadrature}", sum / f64::from(n));
    }

    #[test]
    fn samples_follow_their_densities() {
        check(cosine_hemisphere, cosine_density);
        check(uniform_hemisphere, uniform_density);
        for (theta, alpha) in [(0.0_f64, 1.0), (0.8, 0.3), (1.4, 0.05), (1.5, 0.01)] {
            let view = DVec3::new(0.8 * theta.sin(), 0.6 * theta.sin(), theta.cos());
            check(
                |u| charlie_reflection(view, alpha, u),
                |l| charlie_reflection_density(view, l, alpha),
            );
        }
        for (theta, alpha) in [
            (0.0_f64, [0.3, 0.3]),
            (0.8, [0.2, 0.2]),
            (1.4, [0.6, 0.2]),
            (0.6, [0.1, 0.7]),
            (1.55, [1.0, 1.0]),
        ] {
            let view = DVec3::new(0.8 * theta.sin(), 0.6 * theta.sin(), theta.cos());
            check(
                |u| ggx_reflection(view, alpha, u),
                |l| ggx_reflection_density(view, l, alpha),
            );
        }
    }

    #[test]
    fn pixels_and_seeds_have_their_own_sequences() {
        let first = |seed, pixel| Random::new(seed, pixel).uniform();
        let draws = [first(0, 0), first(0, 1), first(1, 0), first(1, 1)];
        for (i, a) in draws.iter().enumerate() {
            assert!(
                (0.0..1.0).contains(a) && draws[..i].iter().all(|b| a != b),
                "{draws:?}"
            );
        }
        assert_eq!(first(3, 4), first(3, 4));
    }
}
