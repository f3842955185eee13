//! Adaptive cubature over spherical triangles.
//!
//! A triangle of directions (a, b, c) is integrated over its chord: with x = a + u (b - a) + v (c - a) the solid angle
//! element is det(a, b, c) / |x|^3 du dv. Working with directions, the 1/r^2 and cosine of the light are gone before
//! the first sample: a point a micrometre from a light is no harder than one a metre away.

use std::collections::BinaryHeap;

use glam::DVec3;

/// How exact an integral has to be.
///
/// It is done when its estimated error is at most `absolute` or at most `relative` times the value, whichever is
/// larger. It gives up after `max_evaluations` of the integrand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Largest absolute error, in units of the result.
    pub absolute: f64,
    /// Largest relative error.
    pub relative: f64,
    /// Largest number of integrand evaluations.
    pub max_evaluations: usize,
}

impl Default for Tolerance {
    /// 1e-9 absolute or relative, within two million evaluations (a few thousand are usual).
    fn default() -> Self {
        Self {
            absolute: 1e-9,
            relative: 1e-9,
            max_evaluations: 2_000_000,
        }
    }
}

/// A function of unit directions, together with how fast it varies.
pub(crate) trait Integrand<const N: usize> {
    fn evaluate(&self, direction: DVec3) -> [f64; N];

    /// For the edge opposite each vertex, its length in units of the length over which the function varies there.
    ///
    /// A triangle is split while an edge is longer than 1, before anything is sampled: sampling alone cannot find a
    /// narrow peak it has never hit.
    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3];
}

/// Spans between unit directions on which 1/|x|^3 and low-order polynomials are well behaved.
pub(crate) const SMOOTH_ANGLE: f64 = 0.7;

/// Chord beyond which a triangle is split whatever is integrated.
const LONGEST_EDGE: f64 = 1.0;

/// Lengths of the edges opposite each vertex.
pub(crate) fn edge_lengths([a, b, c]: &[DVec3; 3]) -> [f64; 3] {
    [b.distance(*c), c.distance(*a), a.distance(*b)]
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Outcome<const N: usize> {
    pub(crate) value: [f64; N],
    pub(crate) error: f64,
    pub(crate) converged: bool,
}

/// Integrates over triangles of unit directions; clockwise ones (seen from the origin) count positive.
///
/// Clockwise, because light polygons are counter-clockwise seen from the outside of the cone they span.
pub(crate) fn integrate<const N: usize>(
    integrand: &impl Integrand<N>,
    triangles: impl IntoIterator<Item = [DVec3; 3]>,
    tolerance: Tolerance,
) -> Outcome<N> {
    let rule = Rule::new();
    let mut evaluations = 0;
    let mut too_large = false;
    let mut pieces = BinaryHeap::new();
    let mut finished = Sum::default();
    let mut pending: Vec<[DVec3; 3]> = triangles.into_iter().collect();
    loop {
        while let Some(triangle) = pending.pop() {
            // Plain length first: the ends of an arc of nearly 180 degrees say nothing about what lies between.
            let (mut longest_edge, length) = longest(edge_lengths(&triangle));
            let mut split = length > LONGEST_EDGE;
            if !split {
                let (edge, extent) = longest(integrand.edge_extents(&triangle));
                (longest_edge, split) = (edge, extent > 1.0);
            }
            if split && evaluations < tolerance.max_evaluations {
                // Counted, so that splitting too is bounded.
                evaluations += 1;
                pending.extend(bisect(&triangle, longest_edge));
                continue;
            }
            // A triangle that is still too large may hide anything from its samples.
            too_large |= split;
            let piece = rule.apply(integrand, triangle);
            evaluations += rule.points.len();
            if piece.error <= piece.roundoff {
                finished.add(&piece);
            } else {
                pieces.push(piece);
            }
        }
        // The running sum would drift after many subtractions; the true one is cheap beside the sampling.
        let total = pieces
            .iter()
            .fold(finished, |mut sum: Sum<N>, piece: &Piece<N>| {
                sum.add(piece);
                sum
            });
        let mut error = total.error;
        let magnitude = total.value.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let converged =
            !too_large && error <= tolerance.absolute.max(tolerance.relative * magnitude);
        // A NaN converges nowhere and is worth no splitting.
        let hopeless =
            error.is_nan() || pieces.is_empty() || evaluations >= tolerance.max_evaluations;
        if converged || hopeless {
            return Outcome {
                value: total.value,
                error: total.error,
                converged,
            };
        }
        // Split the worst few at once: enough that what is left would do.
        let goal = 0.5 * tolerance.absolute.max(tolerance.relative * magnitude);
        while error > goal {
            let Some(worst) = pieces.pop() else { break };
            error -= worst.error;
            let (edge, _) = longest(integrand.edge_extents(&worst.triangle));
            pending.extend(bisect(&worst.triangle, edge));
        }
    }
}

/// Index and size of the largest of three.
fn longest(extents: [f64; 3]) -> (usize, f64) {
    let index = (0..3)
        .max_by(|&i, &j| extents[i].total_cmp(&extents[j]))
        .unwrap_or(0);
    (index, extents[index])
}

/// Halves a triangle at the middle of the arc opposite `vertex`.
fn bisect(triangle: &[DVec3; 3], vertex: usize) -> [[DVec3; 3]; 2] {
    let [a, b, c] = [0, 1, 2].map(|i| triangle[(vertex + i) % 3]);
    let middle = (b + c).normalize_or(b);
    [[a, b, middle], [a, middle, c]]
}

#[derive(Debug, Clone, Copy)]
struct Sum<const N: usize> {
    value: [f64; N],
    error: f64,
}

impl<const N: usize> Default for Sum<N> {
    fn default() -> Self {
        Self {
            value: [0.0; N],
            error: 0.0,
        }
    }
}

impl<const N: usize> Sum<N> {
    fn add(&mut self, piece: &Piece<N>) {
        for (sum, value) in self.value.iter_mut().zip(piece.value) {
            *sum += value;
        }
        self.error += piece.error;
    }
}

/// One triangle with its integral.
struct Piece<const N: usize> {
    triangle: [DVec3; 3],
    value: [f64; N],
    error: f64,
    roundoff: f64,
}

impl<const N: usize> Ord for Piece<N> {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.error.total_cmp(&other.error)
    }
}

impl<const N: usize> PartialOrd for Piece<N> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<const N: usize> PartialEq for Piece<N> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<const N: usize> Eq for Piece<N> {}

/// Number of nested shells of the rule; its degree is twice this, less one.
const SHELLS: usize = 6;

/// The Grundmann-Moeller rules for the triangle (Grundmann and Moeller 1978, theorem 4), of degree 1, 3, ... 11.
///
/// Rule s uses the points of all rules before it, so 56 samples give six estimates, and their differences the error.
struct Rule {
    /// Barycentric (u, v) and shell of each point.
    points: Vec<(f64, f64, usize)>,
    /// `weights[s][shell]`: weight of each of the shell's points in the rule of degree 2 s + 1, adding up to 1.
    weights: [[f64; SHELLS]; SHELLS],
}

impl Rule {
    fn new() -> Self {
        let mut points = Vec::new();
        for shell in 0..SHELLS {
            let scale = 1.0 / (2 * shell + 3) as f64;
            for i in 0..=shell {
                for j in 0..=shell - i {
                    points.push((
                        (2 * i + 1) as f64 * scale,
                        (2 * j + 1) as f64 * scale,
                        shell,
                    ));
                }
            }
        }
        let factorial = |n: usize| (1..=n).map(|i| i as f64).product::<f64>();
        let mut weights = [[0.0; SHELLS]; SHELLS];
        for (s, row) in weights.iter_mut().enumerate() {
            for (shell, weight) in row.iter_mut().enumerate().take(s + 1) {
                let sign = if (s - shell).is_multiple_of(2) {
                    1.0
                } else {
                    -1.0
                };
                *weight = sign
                    * 2.0
                    * 0.25_f64.powi(s as i32)
                    * ((2 * shell + 3) as f64).powi(2 * s as i32 + 1)
                    / (factorial(s - shell) * factorial(s + shell + 3));
            }
        }
        Self { points, weights }
    }

    fn apply<const N: usize>(
        &self,
        integrand: &impl Integrand<N>,
        triangle: [DVec3; 3],
    ) -> Piece<N> {
        let [a, b, c] = triangle;
        let (ab, ac) = (b - a, c - a);
        // Clockwise counts positive; half of it is the chord's area element over the unit triangle.
        let jacobian = 0.5 * a.dot(ac.cross(ab));
        let mut shells = [[0.0; N]; SHELLS];
        let mut largest = 0.0_f64;
        for &(u, v, shell) in &self.points {
            let x = a + u * ab + v * ac;
            let inverse = x.length_recip();
            let element = jacobian * inverse * inverse * inverse;
            for (sum, f) in shells[shell]
                .iter_mut()
                .zip(integrand.evaluate(x * inverse))
            {
                *sum += element * f;
                largest = largest.max((element * f).abs());
            }
        }
        let mut value = [0.0; N];
        let mut error = 0.0_f64;
        for (k, result) in value.iter_mut().enumerate() {
            let estimate = |s: usize| -> f64 {
                (0..=s)
                    .map(|shell| self.weights[s][shell] * shells[shell][k])
                    .sum()
            };
            let estimates: [f64; 4] =
                [SHELLS - 1, SHELLS - 2, SHELLS - 3, SHELLS - 4].map(estimate);
            *result = estimates[0];
            error = error.max(estimate_error(estimates));
        }
        Piece {
            triangle,
            value,
            error,
            // The weights' magnitudes add up to about 30.
            roundoff: 100.0 * f64::EPSILON * largest,
        }
    }
}

/// Error of the first of four estimates of falling degree.
///
/// The difference to the second is the second's error. Where the differences fall at a steady rate the first is better
/// by that rate; where they don't, nothing is known beyond the difference (after Berntsen and Espelid 1991).
fn estimate_error(estimates: [f64; 4]) -> f64 {
    let [d0, d1, d2] = [0, 1, 2].map(|i| (estimates[i] - estimates[i + 1]).abs());
    if d0 == 0.0 {
        return 0.0;
    }
    let rate = (d0 / d1).max(d1 / d2);
    if rate < 0.1 {
        10.0 * rate * d0
    } else {
        d0.max(0.25 * d1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_rule_is_exact_to_its_degree_and_no_further() {
        let rule = Rule::new();
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        for s in 0..SHELLS as u32 {
            for (p, q) in (0..=2 * s + 2).flat_map(|p| (0..=2 * s + 2 - p).map(move |q| (p, q))) {
                let sum: f64 = rule
                    .points
                    .iter()
                    .map(|&(u, v, shell)| {
                        rule.weights[s as usize][shell] * u.powi(p as i32) * v.powi(q as i32)
                    })
                    .sum();
                let exact = 2.0 * factorial(p) * factorial(q) / factorial(p + q + 2);
                if p + q <= 2 * s + 1 {
                    assert!(
                        (sum - exact).abs() < 1e-13,
                        "degree {s}: u^{p} v^{q}: {sum} {exact}"
                    );
                } else if q == 0 {
                    assert!(
                        (sum - exact).abs() > 1e-9,
                        "degree {s}: u^{p} is integrated exactly"
                    );
                }
            }
        }
    }

    struct Power(i32);

    impl Integrand<1> for Power {
        fn evaluate(&self, direction: DVec3) -> [f64; 1] {
            [direction.z.powi(self.0)]
        }

        fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
            edge_lengths(triangle).map(|length| length / SMOOTH_ANGLE)
        }
    }

    #[test]
    fn octant_of_a_power_of_the_cosine() {
        for n in [0, 1, 2, 9, 300] {
            let outcome = integrate(
                &Power(n),
                [[DVec3::Z, DVec3::Y, DVec3::X]],
                Tolerance::default(),
            );
            let exact = std::f64::consts::FRAC_PI_2 / f64::from(n + 1);
            assert!(outcome.converged, "{n}: {outcome:?}");
            assert!(
                (outcome.value[0] - exact).abs() <= outcome.error + 1e-14,
                "{n}: {outcome:?} {exact}"
            );
        }
    }
}
