use std::fmt::Write;

use nalgebra::DMatrix;

use crate::{errors::ErrorReport, fit::FitError, ltc::Ltc, table::Table};

/// A table's numbers as polynomials of its two coordinates: small enough to stand in a shader's
/// source, where a table would have to be loaded and bound.
///
/// Least squares over the texels. Coordinates run from -1 to 1; number `c` of a texel is the sum of
/// `coefficients[c][j][i] x^i y^j` for i and j from 0 to the degree, with x from the first axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    table: Table,
    coefficients: Vec<Vec<Vec<f64>>>,
}

impl Table {
    /// The polynomial of a degree, 1 to 12, along both axes.
    ///
    /// # Errors
    /// For a table of more than two axes, a degree out of range or beyond the table's size.
    pub fn polynomial(&self, degree: usize) -> Result<Polynomial, FitError> {
        let [columns, rows] = self.sizes()[..] else {
            return Err(FitError::Settings(
                "polynomials are for tables of two axes".into(),
            ));
        };
        if !(1..=12).contains(&degree) || degree >= columns.min(rows) {
            return Err(FitError::Settings(format!(
                "degree is {degree}; choose 1 to {}",
                12.min(columns.min(rows) - 1)
            )));
        }
        let terms = degree + 1;
        let coordinate = |i: usize, size: usize| 2.0 * i as f64 / (size - 1) as f64 - 1.0;
        let basis = DMatrix::from_fn(columns * rows, terms * terms, |texel, term| {
            let x = coordinate(texel % columns, columns);
            let y = coordinate(texel / columns, rows);
            // Chebyshev polynomials keep the normal equations well conditioned.
            chebyshev(term % terms, x) * chebyshev(term / terms, y)
        });
        let channels = self.channel_count();
        let right = DMatrix::from_fn(columns * rows, channels, |texel, channel| {
            f64::from(self.texels()[texel * channels + channel])
        });
        let normal = (basis.transpose() * &basis)
            .cholesky()
            .ok_or_else(|| FitError::Settings("the texels do not determine a polynomial".into()))?;
        let solved = normal.solve(&(basis.transpose() * right));
        let powers: Vec<Vec<f64>> = (0..terms).map(chebyshev_powers).collect();
        let coefficients = (0..channels)
            .map(|channel| {
                let mut powers_of_both = vec![vec![0.0; terms]; terms];
                for j in 0..terms {
                    for i in 0..terms {
                        let weight = solved[(j * terms + i, channel)];
                        for (n, &y) in powers[j].iter().enumerate() {
                            for (m, &x) in powers[i].iter().enumerate() {
                                powers_of_both[n][m] += weight * x * y;
                            }
                        }
                    }
                }
                powers_of_both
            })
            .collect();
        Ok(Polynomial {
            table: self.clone(),
            coefficients,
        })
    }
}

fn chebyshev(order: usize, x: f64) -> f64 {
    (order as f64 * x.clamp(-1.0, 1.0).acos()).cos()
}

/// Coefficients of the powers of x in the Chebyshev polynomial of an order.
fn chebyshev_powers(order: usize) -> Vec<f64> {
    let (mut before, mut here) = (vec![1.0], vec![0.0, 1.0]);
    for _ in 0..order {
        let mut next = vec![0.0];
        next.extend(here.iter().map(|c| 2.0 * c));
        for (n, b) in next.iter_mut().zip(&before) {
            *n -= b;
        }
        (before, here) = (here, next);
    }
    before
}

impl Polynomial {
    /// The lobes at a place, each coordinate in `[0,1]` and clamped; amplitudes are clamped to
    /// `[0,1]`, which a polynomial may pass.
    pub fn lookup_at(&self, place: [f64; 2]) -> Vec<Ltc> {
        let [x, y] = place.map(|u| 2.0 * if u > 0.0 { u.min(1.0) } else { 0.0 } - 1.0);
        let horner = |terms: &[f64], x: f64| terms.iter().rev().fold(0.0, |sum, c| sum * x + c);
        let numbers: Vec<f64> = self
            .coefficients
            .iter()
            .map(|rows| {
                let of_x: Vec<f64> = rows.iter().map(|row| horner(row, x)).collect();
                horner(&of_x, y)
            })
            .collect();
        let (brdf, view) = self.table.brdf().at(&[0.5 * (x + 1.0), 0.5 * (y + 1.0)]);
        let mut lobes = self.table.layout().unpack(&brdf.limit(view), &numbers);
        for lobe in &mut lobes {
            lobe.amplitude = lobe.amplitude.clamp(0.0, 1.0);
            lobe.secondary = lobe.secondary.clamp(0.0, 1.0);
        }
        lobes
    }

    /// Measures the polynomial as [`Table::errors`] does the table.
    pub fn errors(
        &self,
        perceptual_roughness: [f64; 2],
        seed: u64,
        nodes: u32,
        lights: u32,
    ) -> ErrorReport {
        let lookup = |place: &[f64]| self.lookup_at([place[0], place[1]]);
        ErrorReport::measure(
            self.table.settings(),
            &lookup,
            perceptual_roughness,
            seed,
            [nodes, lights],
        )
    }

    /// The coefficients as the text of a Rust array `[[[f32; terms]; terms]; channels]`: by
    /// channel, by power of y, by power of x.
    pub fn to_rust(&self) -> String {
        let channels = self.table.layout().channels();
        let mut text = String::from("[\n");
        for (name, rows) in channels.iter().zip(&self.coefficients) {
            // Writing to a string does not fail.
            let _ = writeln!(text, "    // {name}\n    [");
            for row in rows {
                let numbers: Vec<String> = row.iter().map(|c| format!("{:?}", *c as f32)).collect();
                let _ = writeln!(text, "        [{}],", numbers.join(", "));
            }
            text.push_str("    ],\n");
        }
        text.push(']');
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn powers_of_chebyshev_polynomials() {
        assert_eq!(chebyshev_powers(0), [1.0]);
        assert_eq!(chebyshev_powers(1), [0.0, 1.0]);
        assert_eq!(chebyshev_powers(4), [1.0, 0.0, -8.0, 0.0, 8.0]);
        let x: f64 = 0.3;
        let sum: f64 = (0..)
            .zip(chebyshev_powers(5))
            .map(|(n, c)| c * x.powi(n))
            .sum();
        assert!((sum - chebyshev(5, x)).abs() < 1e-13);
    }

    /// A table that is a polynomial comes back.
    #[test]
    fn a_polynomial_is_its_own_fit() {
        let size = 6;
        let number = |c: usize, x: f64, y: f64| match c {
            0 | 3 => 1.0 + 0.1 * x - 0.2 * y * y,
            4 => 0.5 + 0.2 * x * y,
            _ => 0.0,
        };
        let texels = (0..size * size)
            .flat_map(|i| {
                let at = |k: usize| 2.0 * k as f64 / (size - 1) as f64 - 1.0;
                let (x, y) = (at(i % size), at(i / size));
                (0..8).map(move |c| number(c, x, y) as f32)
            })
            .collect();
        let settings = Settings {
            size: size as u32,
            ..Settings::default()
        };
        let table = Table { settings, texels };
        let polynomial = table.polynomial(3).unwrap();
        let (place, x, y) = ([0.35, 0.9], -0.3, 0.8);
        let lobes = polynomial.lookup_at(place);
        assert!((lobes[0].amplitude - number(4, x, y)).abs() < 1e-6);
        assert!(polynomial.to_rust().contains("// amplitude\n"));
        assert!(table.polynomial(6).is_err() && table.polynomial(0).is_err());
    }
}
