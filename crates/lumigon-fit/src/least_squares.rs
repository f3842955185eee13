use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

/// Step of the forward differences; every parameter is of order one.
const STEP: f64 = 1e-6;

struct Problem<'a> {
    residuals_at: &'a dyn Fn(&[f64]) -> Vec<f64>,
    params: DVector<f64>,
    residuals: Option<DVector<f64>>,
}

impl Problem<'_> {
    fn finite(&self, params: &[f64]) -> Option<DVector<f64>> {
        let residuals = (self.residuals_at)(params);
        residuals
            .iter()
            .all(|r| r.is_finite())
            .then(|| DVector::from_vec(residuals))
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, params: &DVector<f64>) {
        self.params.copy_from(params);
        self.residuals = self.finite(params.as_slice());
    }

    fn params(&self) -> DVector<f64> {
        self.params.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.residuals.clone()
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let here = self.residuals.as_ref()?;
        let mut jacobian = DMatrix::zeros(here.len(), self.params.len());
        for j in 0..self.params.len() {
            let mut params = self.params.clone();
            params[j] += STEP;
            let there = self.finite(params.as_slice())?;
            jacobian.set_column(j, &((there - here) / STEP));
        }
        Some(jacobian)
    }
}

/// Minimises the sum of squared residuals from `start` by Levenberg-Marquardt (MINPACK's, Moré
/// 1978). Returns the parameters and that sum; the start itself where no step improves it, and a
/// sum of infinity where the start's own residuals are not finite.
pub(crate) fn least_squares(
    start: &[f64],
    residuals_at: &dyn Fn(&[f64]) -> Vec<f64>,
) -> (Vec<f64>, f64) {
    let mut problem = Problem {
        residuals_at,
        params: DVector::from_column_slice(start),
        residuals: None,
    };
    let params = problem.params.clone();
    problem.set_params(&params);
    let sum = |p: &Problem<'_>| {
        p.residuals
            .as_ref()
            .map_or(f64::INFINITY, DVector::norm_squared)
    };
    let before = sum(&problem);
    let (problem, _) = LevenbergMarquardt::new()
        .with_ftol(1e-6)
        .with_xtol(1e-5)
        .with_patience(10)
        .minimize(problem);
    let after = sum(&problem);
    if after < before {
        (problem.params.as_slice().to_vec(), after)
    } else {
        (start.to_vec(), before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rosenbrock() {
        let (params, sum) = least_squares(&[-1.2, 1.0], &|p| {
            vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]
        });
        assert!(sum < 1e-8, "{params:?} {sum}");
    }

    #[test]
    fn non_finite_start_is_returned() {
        let (params, sum) = least_squares(&[3.0], &|p| vec![f64::NAN * p[0]]);
        assert_eq!((params, sum), (vec![3.0], f64::INFINITY));
    }
}
