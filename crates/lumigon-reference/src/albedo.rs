//! Directional albedos for layering: what a lobe reflects of a uniform hemisphere, and so what it leaves for the lobe
//! below it.

use std::f64::consts::PI;
use std::sync::OnceLock;

use glam::{DVec2, DVec3};

use crate::charlie::charlie_lambda;
use crate::ggx::{ggx_visibility, schlick_weight};

/// Nodes along each axis of the tables.
const NODES: usize = 40;

/// Points of the rules in each variable: for tables, which are made once, and for single surfaces.
const FINE: usize = 20;
const COARSE: usize = 10;

/// Widths below which the tables are too coarse for grazing views.
const NARROW: f64 = 0.01;

/// Albedo of the GGX lobe with Fresnel factor 1, and the same weighted by (1 - h.v)^5; within 1e-4, but 1e-3 for
/// grazing views of `alpha` near 0.01.
///
/// `view` is a unit vector in the shading frame, its z at least 1e-4; widths are in [1e-4, 1]. Equal widths are looked
/// up in a table made at the first call, other ones integrated.
pub(crate) fn ggx_albedos(view: DVec3, alpha: [f64; 2]) -> [f64; 2] {
    static TABLE: OnceLock<Table<2>> = OnceLock::new();
    static RULE: OnceLock<[(f64, f64); COARSE]> = OnceLock::new();
    if alpha[0] != alpha[1] || (alpha[0] < NARROW && view.z < 0.2) {
        return integrate_ggx(view, alpha, RULE.get_or_init(gauss_legendre));
    }
    let table = TABLE.get_or_init(|| {
        let rule = gauss_legendre::<FINE>();
        Table::new(|cos_theta, alpha| {
            integrate_ggx(view_of(cos_theta), [alpha.max(1e-4); 2], &rule)
        })
    });
    table.look_up(view.z, alpha[0])
}

/// Albedo of the Charlie sheen, within 2e-3 of its larger values; above 1 for small `alpha` at grazing views, where the model is not
/// physical.
///
/// The cosine is at least 1e-4, `alpha` in [1e-6, 1]. Looked up in a table made at the first call.
pub(crate) fn charlie_albedo(cos_theta_view: f64, alpha: f64) -> f64 {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    static RULE: OnceLock<[(f64, f64); FINE]> = OnceLock::new();
    let rule = RULE.get_or_init(gauss_legendre);
    if alpha < NARROW {
        return integrate_charlie(cos_theta_view, alpha, rule);
    }
    let table = TABLE.get_or_init(|| {
        // The narrowest of these only help to interpolate.
        Table::new(|cos_theta, alpha| [integrate_charlie(cos_theta, alpha.max(1e-3), rule)])
    });
    table.look_up(cos_theta_view, alpha)[0]
}

fn view_of(cos_theta: f64) -> DVec3 {
    DVec3::new((1.0 - cos_theta * cos_theta).sqrt(), 0.0, cos_theta)
}

/// The integral over half vectors of D n.h times V 4 n.l h.v / n.h, the latter being the BRDF's share of it.
///
/// In slopes of the half vector in units of the widths, r (cos psi, sin psi), D n.h is 2 r / (1 + r^2)^2 dr dpsi / 2 pi.
fn integrate_ggx(view: DVec3, alpha: [f64; 2], rule: &Rule) -> [f64; 2] {
    let stretch = DVec2::from(alpha);
    let mut sums = [0.0; 2];
    for_each_azimuth(view, stretch, rule, |along, limit, azimuth_weight| {
        let farthest = limit.tan() / along.length();
        let end = farthest / (1.0 + farthest);
        for &(t, weight) in rule {
            // Dense where the reflection nears the horizon.
            let x = end * t * (2.0 - t);
            let r = x / (1.0 - x);
            let dx = end * 2.0 * (1.0 - t);
            let measure = 2.0 * r / (1.0 + r * r).powi(2) / (1.0 - x).powi(2) * dx;
            let half_vector = (r * along).extend(1.0).normalize();
            let h_dot_v = half_vector.dot(view);
            let light = 2.0 * h_dot_v * half_vector - view;
            if light.z > 0.0 {
                let value = ggx_visibility(light, view, alpha) * 4.0 * light.z * h_dot_v;
                let part = azimuth_weight * weight * measure * value / half_vector.z;
                sums[0] += part;
                sums[1] += part * schlick_weight(h_dot_v);
            }
        }
    });
    sums
}

/// The same for Charlie: with s the sine of the half vector's angle, u = s^(2 + 1/alpha) is uniform, and the BRDF's
/// share is h.v / (n.h n.v (1 + Lambda(v) + Lambda(l))).
fn integrate_charlie(cos_theta_view: f64, alpha: f64, rule: &Rule) -> f64 {
    let view = view_of(cos_theta_view);
    let exponent = 2.0 + alpha.recip();
    let lambda_view = 1.0 + charlie_lambda(view.z, alpha);
    let mut sum = 0.0;
    for_each_azimuth(view, DVec2::ONE, rule, |along, limit, azimuth_weight| {
        let end = limit.sin().powf(exponent);
        for &(t, weight) in rule {
            let u = end * (1.0 - (1.0 - t).powi(3));
            let du = end * 3.0 * (1.0 - t).powi(2);
            // From the logarithm: the sine is next to 1 for narrow lobes.
            let log_sine2 = 2.0 * u.ln() / exponent;
            let (sine, cosine) = ((0.5 * log_sine2).exp(), (-log_sine2.exp_m1()).sqrt());
            let h_dot_v = (sine * along).extend(cosine).dot(view).max(0.0);
            let light = (2.0 * h_dot_v * cosine - view.z).clamp(0.0, 1.0);
            let lambda = lambda_view + charlie_lambda(light, alpha);
            sum += azimuth_weight * weight * du * h_dot_v / (cosine * view.z * lambda);
        }
    });
    sum
}

/// Calls `body` with directions `stretch` (cos psi, sin psi), the largest angle from the normal at which a half vector
/// of that azimuth reflects the view above the horizon, and weights that add up to 1.
///
/// That angle is pi/4 + delta/2, where tan(delta) = cos(phi) tan(theta) of the view, phi being the azimuth from the view's. It moves
/// fastest where the azimuths are a right angle apart, and `along` is short, and turns fast, at the narrow axis of the
/// lobe: between those azimuths the rule is applied anew, dense at its ends.
fn for_each_azimuth(
    view: DVec3,
    stretch: DVec2,
    rule: &Rule,
    mut body: impl FnMut(DVec2, f64, f64),
) {
    let across = view.truncate().perp() / stretch;
    let start = across.y.atan2(across.x);
    let narrow = match stretch.x < stretch.y {
        true => 0.0,
        false => 0.5 * PI,
    };
    let turn = match stretch.x == stretch.y {
        true => PI,
        false => (narrow - start).rem_euclid(PI),
    };
    for (from, length) in [(start, turn), (start + turn, PI - turn)] {
        if length == 0.0 {
            continue;
        }
        for &(t, weight) in rule {
            let psi = from + length * t * t * (3.0 - 2.0 * t);
            let weight = weight * length * 6.0 * t * (1.0 - t) / (2.0 * PI);
            // A lobe is the same half a turn further, the view is not.
            for side in [stretch, -stretch] {
                let along = side * DVec2::from_angle(psi);
                let cosine = along.normalize().dot(view.truncate());
                let limit = 0.25 * PI + 0.5 * cosine.atan2(view.z);
                body(along, limit, weight);
            }
        }
    }
}

/// Points and weights of a rule on [0, 1].
type Rule = [(f64, f64)];

/// The Gauss-Legendre rule of `N` points.
fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
    let n = N as f64;
    std::array::from_fn(|i| {
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        // Newton's method on the Legendre polynomial; the start is good to 1e-3.
        for _ in 0..4 {
            let (mut previous, mut value) = (1.0, x);
            for k in 2..=N {
                let k = k as f64;
                let next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * previous) / k;
                (previous, value) = (value, next);
            }
            slope = n * (x * value - previous) / (x * x - 1.0);
            x -= value / slope;
        }
        (0.5 + 0.5 * x, 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

/// Values over the square roots of the view's cosine, from 0.01 to 1, and of alpha, from 0 to 1.
struct Table<const N: usize>(Vec<[f64; N]>);

impl<const N: usize> Table<N> {
    fn new(value: impl Fn(f64, f64) -> [f64; N]) -> Self {
        let node = |i: usize| i as f64 / (NODES - 1) as f64;
        let cos_theta = |i: usize| (0.01 + 0.99 * node(i)).powi(2);
        let alpha = |i: usize| node(i).powi(2);
        Self(
            (0..NODES * NODES)
                .map(|i| value(cos_theta(i % NODES), alpha(i / NODES)))
                .collect(),
        )
    }

    /// Cubic through the four nearest nodes along each axis.
    fn look_up(&self, cos_theta: f64, alpha: f64) -> [f64; N] {
        let (column, x) = cubic((cos_theta.sqrt() - 0.01) / 0.99);
        let (row, y) = cubic(alpha.sqrt());
        let mut sum = [0.0; N];
        for (j, wy) in y.into_iter().enumerate() {
            for (i, wx) in x.into_iter().enumerate() {
                let node = self.0[(row + j) * NODES + column + i];
                for (sum, value) in sum.iter_mut().zip(node) {
                    *sum += wx * wy * value;
                }
            }
        }
        sum
    }
}

/// The first of four nodes about a coordinate in [0, 1], and the weights with which a cubic interpolates them.
fn cubic(coordinate: f64) -> (usize, [f64; 4]) {
    let x = coordinate.clamp(0.0, 1.0) * (NODES - 1) as f64;
    let first = (x.floor() as usize).saturating_sub(1).min(NODES - 4);
    let t = x - first as f64;
    let [a, b, c, d] = [t, t - 1.0, t - 2.0, t - 3.0];
    (
        first,
        [
            -b * c * d / 6.0,
            a * c * d / 2.0,
            -a * b * d / 2.0,
            a * b * c / 6.0,
        ],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tolerance;

    const TOLERANCE: Tolerance = Tolerance {
        absolute: 1e-5,
        relative: 0.0,
        max_evaluations: 4_000_000,
    };

    #[test]
    fn isotropic_albedos_agree_with_cubature() {
        for alpha in [1e-4, 0.0099, 0.0101, 0.12, 1.0] {
            for cos_theta in [1e-4, 0.0012, 0.0098, 0.052, 0.19, 0.21, 0.64, 1.0] {
                let case = format!("alpha {alpha}, cosine {cos_theta}");
                let [value, schlick] = ggx_albedos(view_of(cos_theta), [alpha; 2]);
                let truth = crate::ggx_albedo(cos_theta, alpha, TOLERANCE).unwrap();
                let errors = [value - truth.value, schlick - truth.schlick];
                let bound = if alpha < 0.1 && cos_theta < 0.1 {
                    1e-3
                } else {
                    1e-4
                };
                assert!(errors.iter().all(|e| e.abs() < bound), "{case}: {errors:?}");

                let value = charlie_albedo(cos_theta, alpha);
                let truth = crate::charlie_albedo(cos_theta, alpha, TOLERANCE)
                    .unwrap()
                    .value;
                assert!(
                    (value - truth).abs() < 2e-3 * truth.max(1.0),
                    "{case}: {value} {truth}"
                );
            }
        }
    }

    #[test]
    fn anisotropic_albedos_agree_with_cubature() {
        for alpha in [[1e-3, 1.0], [0.3, 0.1], [1.0, 0.04]] {
            for cos_theta in [1e-3, 0.05, 0.3, 0.9, 1.0] {
                for phi in [0.0, 0.05, 0.7, 0.5 * PI] {
                    let across = view_of(cos_theta).x * DVec2::from_angle(phi);
                    let view = across.extend(cos_theta);
                    let [value, schlick] = ggx_albedos(view, alpha);
                    let truth =
                        crate::ggx_anisotropic_albedo(view.into(), alpha, TOLERANCE).unwrap();
                    let errors = [value - truth.value, schlick - truth.schlick];
                    let case = format!("{alpha:?} {cos_theta} {phi}: {errors:?}");
                    assert!(errors.iter().all(|e| e.abs() < 2e-4), "{case}");
                }
            }
        }
    }
}
