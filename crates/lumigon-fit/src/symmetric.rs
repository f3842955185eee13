//! Symmetric 2x2 matrices `[[xx, xy], [xy, yy]]`, as `[xx, xy, yy]`: the shapes of lobes.

/// Eigenvalues and the unit eigenvector of the first.
fn eigen([xx, xy, yy]: [f64; 3]) -> ([f64; 2], [f64; 2]) {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = half.hypot(xy);
    let angle = 0.5 * xy.atan2(half);
    ([mean + radius, mean - radius], [angle.cos(), angle.sin()])
}

fn map(matrix: [f64; 3], f: impl Fn(f64) -> f64) -> [f64; 3] {
    let (values, [c, s]) = eigen(matrix);
    let [a, b] = values.map(f);
    [
        a * c * c + b * s * s,
        (a - b) * c * s,
        a * s * s + b * c * c,
    ]
}

/// The matrix exponential.
pub(crate) fn exp(matrix: [f64; 3]) -> [f64; 3] {
    map(matrix, f64::exp)
}

/// The matrix logarithm of a positive definite matrix.
pub(crate) fn ln(matrix: [f64; 3]) -> [f64; 3] {
    map(matrix, f64::ln)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_and_logarithm() {
        let rotated = exp([0.3, -0.7, -0.2]);
        // det exp(A) = exp(trace A).
        let determinant = rotated[0] * rotated[2] - rotated[1] * rotated[1];
        assert!((determinant - 0.1_f64.exp()).abs() < 1e-14);
        for (a, b) in ln(rotated).iter().zip([0.3, -0.7, -0.2]) {
            assert!((a - b).abs() < 1e-14);
        }
        assert_eq!(exp([0.0; 3]), [1.0, 0.0, 1.0]);
        let scaled = exp([2.0, 0.0, 1.0]);
        assert!((scaled[0] - 2.0_f64.exp()).abs() < 1e-14 && scaled[1].abs() < 1e-15);
    }
}
