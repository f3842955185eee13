use glam::DMat3;

use crate::{limit::Limit, ltc::Ltc, settings::Settings};

/// How a texel's numbers make lobes, and back.
///
/// Matrices are stored from the [`Limit`]'s unit space on, `shading_to_cosine = K shading_to_unit`:
/// what is left is smooth down to a mirror and to the sharpest anisotropy, where the matrix itself
/// would need ever finer tables.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    lobes: usize,
    cosine: bool,
    isotropic: bool,
    secondary: &'static str,
}

impl Layout {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            lobes: settings.lobes as usize,
            cosine: settings.cosine,
            isotropic: settings.brdf.is_isotropic(),
            secondary: settings.brdf.secondary(),
        }
    }

    /// Names of a texel's numbers, a multiple of four of them.
    pub fn channels(&self) -> Vec<String> {
        let mut names = Vec::new();
        let secondary = self.secondary;
        for lobe in 1..=self.lobes {
            let suffix = if self.lobes == 1 {
                String::new()
            } else {
                format!("_{lobe}")
            };
            let entries: &[&str] = if self.isotropic {
                &["k11", "k13", "k31", "k33"]
            } else {
                &["k11", "k12", "k13", "k23", "k31", "k32", "k33"]
            };
            names.extend(entries.iter().map(|name| format!("{name}{suffix}")));
        }
        for lobe in 1..=self.lobes {
            let suffix = if self.lobes == 1 {
                String::new()
            } else {
                format!("_{lobe}")
            };
            names.push(format!("amplitude{suffix}"));
            names.push(format!("{secondary}{suffix}"));
        }
        if self.cosine {
            names.push("amplitude_cosine".into());
            names.push(format!("{secondary}_cosine"));
        }
        names.resize(names.len().next_multiple_of(4), "zero".into());
        names
    }

    /// How a texel's numbers make a matrix, in words.
    pub fn normalisation(&self) -> &'static str {
        if self.isotropic {
            "shading_to_cosine = K shading_to_unit, K = [[k11, 0, k13], [0, 1, 0], [k31, 0, k33]] row by row: divided by its MIDDLE element (row 2, column 2), not by the last"
        } else {
            "shading_to_cosine = K shading_to_unit, K = [[k11, k12, k13], [k12, 2 - k11, k23], [k31, k32, k33]] row by row: turned about the cosine's axis until the upper block is symmetric, divided by half that block's trace"
        }
    }

    pub(crate) fn pack(&self, limit: &Limit, lobes: &[Ltc]) -> Vec<f32> {
        let mut numbers = Vec::new();
        for lobe in &lobes[..self.lobes] {
            let k = lobe.shading_to_cosine * limit.shading_to_unit.inverse();
            let (x, y, z) = (k.x_axis, k.y_axis, k.z_axis);
            if self.isotropic {
                numbers.extend([x.x, z.x, x.z, z.z].map(|entry| entry / y.y));
            } else {
                // Turned about the cosine's axis until the upper block is symmetric.
                let (sin, cos) = (x.y - y.x).atan2(x.x + y.y).sin_cos();
                let k11 = cos * x.x + sin * x.y;
                let k12 = cos * y.x + sin * y.y;
                let k22 = cos * y.y - sin * y.x;
                let k13 = cos * z.x + sin * z.y;
                let k23 = cos * z.y - sin * z.x;
                let half_trace = 0.5 * (k11 + k22);
                numbers.extend([k11, k12, k13, k23, x.z, y.z, z.z].map(|entry| entry / half_trace));
            }
        }
        for lobe in lobes {
            numbers.extend([lobe.amplitude, lobe.secondary]);
        }
        numbers.resize(self.channels().len(), 0.0);
        numbers.into_iter().map(|x| x as f32).collect()
    }

    pub(crate) fn unpack(&self, limit: &Limit, numbers: &[f64]) -> Vec<Ltc> {
        let entries = if self.isotropic { 4 } else { 7 };
        let mut lobes: Vec<Ltc> = numbers
            .chunks(entries)
            .take(self.lobes)
            .map(|n| {
                let rows = if self.isotropic {
                    [n[0], 0.0, n[1], 0.0, 1.0, 0.0, n[2], 0.0, n[3]]
                } else {
                    let [k11, k12, k13, k23, k31, k32, k33] = std::array::from_fn(|i| n[i]);
                    [k11, k12, k13, k12, 2.0 - k11, k23, k31, k32, k33]
                };
                let k = DMat3::from_cols_array(&rows).transpose();
                Ltc {
                    shading_to_cosine: k * limit.shading_to_unit,
                    amplitude: 0.0,
                    secondary: 0.0,
                }
            })
            .collect();
        if self.cosine {
            lobes.push(Ltc::cosine());
        }
        for (lobe, pair) in lobes
            .iter_mut()
            .zip(numbers[entries * self.lobes..].chunks(2))
        {
            (lobe.amplitude, lobe.secondary) = (pair[0], pair[1]);
        }
        lobes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{coordinates::Coordinates, kind::BrdfKind};

    #[test]
    fn packs_and_unpacks() {
        for (brdf, lobes, cosine, place, channels) in [
            (BrdfKind::Ggx, 1, true, vec![0.3, 0.8], 8),
            (BrdfKind::Ggx, 2, false, vec![0.01, 0.5], 12),
            (
                BrdfKind::GgxAnisotropic,
                1,
                false,
                vec![0.7, 0.4, 0.8, 0.3],
                12,
            ),
        ] {
            let settings = Settings {
                brdf,
                lobes,
                cosine,
                ..Settings::default()
            };
            let layout = Layout::new(&settings);
            assert_eq!(layout.channels().len(), channels);
            let (model, view) = brdf.at(&place);
            let limit = model.limit(view);
            let mut numbers = [0.2, 0.1, -0.2, 0.9, 0.2, 0.1, 0.15, -0.3];
            if brdf.is_isotropic() {
                for i in [1, 4, 6] {
                    numbers[i] = 0.0;
                }
            }
            let ltc = Coordinates(numbers).to_ltc(&limit);
            let sum = vec![ltc; lobes as usize + usize::from(cosine)];
            let packed = layout.pack(&limit, &sum);
            assert_eq!(packed.len(), channels);
            let wide: Vec<f64> = packed.iter().map(|&x| f64::from(x)).collect();
            let back = layout.unpack(&limit, &wide)[0];
            let again = Coordinates::from_ltc(&back, &limit);
            for (a, b) in numbers.iter().zip(again.0) {
                assert!((a - b).abs() < 1e-4, "{numbers:?} {again:?}");
            }
        }
    }
}
