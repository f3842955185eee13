use serde::{Deserialize, Serialize};

use crate::{
    coordinates::Parametrisation, density::Density, integral::Integral, kind::BrdfKind,
    objective::Objective,
};

/// Which objective a fit minimises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObjectiveKind {
    /// [`Density`].
    Density,
    /// [`Integral`].
    Integral,
}

/// All that determines a table. The same settings give the same table on any number of threads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// The BRDF.
    pub brdf: BrdfKind,
    /// Texels along the longest axes, in `[2,512]` (`[2,64]` for four axes);
    /// [`BrdfKind::sizes`] has them all.
    pub size: u32,
    /// Lobes of their own a texel, 1 or 2.
    pub lobes: u32,
    /// One more lobe: the clamped cosine itself, which costs no form factor where diffuse light is
    /// computed anyway ([`Integral`]).
    pub cosine: bool,
    /// What is minimised.
    pub objective: ObjectiveKind,
    /// What moves.
    pub parametrisation: Parametrisation,
    /// Seed of the training lights.
    pub seed: u64,
    /// Directions that stand for a lobe, in `[64,2^20]`.
    pub directions: u32,
    /// Training lights a node ([`Integral`]), or directions from either distribution
    /// ([`Density`]), in `[8,2^16]`.
    pub samples: u32,
    /// Whole-table sweeps after the first march, at most 64.
    pub sweeps: u32,
    /// Weight of the pull towards the neighbours' mean in the last sweep, >= 0; every sweep before
    /// pulls twice as hard as the next, up to 16 times as hard, which draws neighbours together
    /// that have settled in different minima.
    pub smoothing: f64,
    /// Weight of the white furnace among the residuals, >= 0 ([`Integral`]).
    pub furnace: f64,
    /// Weight of the responses under the second weight, >= 0 ([`Integral`]).
    pub secondary: f64,
    /// Response below which errors count as absolute, in `[1e-6,1]` ([`Integral`]).
    pub floor: f64,
}

impl Default for Settings {
    /// One lobe and the cosine for isotropic GGX: the shipped table.
    fn default() -> Self {
        Self {
            brdf: BrdfKind::Ggx,
            size: 32,
            lobes: 1,
            cosine: true,
            objective: ObjectiveKind::Integral,
            parametrisation: Parametrisation::Free,
            seed: 1,
            directions: 10_946,
            samples: 320,
            sweeps: 3,
            smoothing: 0.015,
            furnace: 1.0,
            secondary: 0.4,
            floor: 0.05,
        }
    }
}

impl Settings {
    /// What suits a BRDF, fitted on integrals with one lobe or two: each shipped table's settings.
    pub fn of(brdf: BrdfKind, lobes: u32) -> Self {
        let base = Self {
            brdf,
            lobes,
            cosine: lobes == 1,
            ..Self::default()
        };
        match brdf {
            BrdfKind::Ggx if lobes > 1 => Self { sweeps: 5, ..base },
            BrdfKind::Ggx | BrdfKind::Eon => base,
            // A dim lobe on which the cosine is of no use.
            BrdfKind::Charlie => Self {
                cosine: false,
                floor: 0.005,
                ..base
            },
            BrdfKind::GgxAnisotropic => Self {
                size: 16,
                cosine: false,
                samples: 200,
                sweeps: 2,
                ..base
            },
        }
    }

    /// The published recipe: pointwise density in the lobe's mean-direction frame.
    pub fn published() -> Self {
        Self {
            objective: ObjectiveKind::Density,
            parametrisation: Parametrisation::MeanDirection,
            samples: 1024,
            sweeps: 0,
            size: 64,
            cosine: false,
            ..Self::default()
        }
    }

    /// Name of the table's files: the BRDF, its lobes if several, and the size.
    pub fn name(&self) -> String {
        let lobes = match self.lobes {
            1 => String::new(),
            lobes => format!("-{lobes}"),
        };
        format!("{}{lobes}-{}", self.brdf.name(), self.size)
    }

    pub(crate) fn objective(&self) -> Box<dyn Objective> {
        match self.objective {
            ObjectiveKind::Density => Box::new(Density {
                samples: self.samples,
            }),
            ObjectiveKind::Integral => Box::new(Integral {
                samples: self.samples,
                seed: self.seed,
                furnace: self.furnace,
                secondary: self.secondary,
                floor: self.floor,
                cosine: self.cosine,
            }),
        }
    }

    /// Weight of the pull in a sweep, counted from 1.
    pub(crate) fn smoothing_in(&self, sweep: usize) -> f64 {
        let before_last = (self.sweeps as usize).saturating_sub(sweep).min(4);
        self.smoothing * f64::from(1_u32 << before_last)
    }

    /// Names the first value outside its range.
    pub(crate) fn validate(&self) -> Result<(), String> {
        let in_range = |name: &str, value: u32, low: u32, high: u32| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                Err(format!("{name} is {value}; choose {low} to {high}"))
            }
        };
        let greatest = if self.brdf.axes().len() > 2 { 64 } else { 512 };
        in_range("size", self.size, 2, greatest)?;
        in_range("lobes", self.lobes, 1, 2)?;
        if self.cosine && self.objective == ObjectiveKind::Density {
            return Err("cosine is for the integral objective".into());
        }
        if !self.brdf.is_isotropic() && self.lobes > 1 {
            return Err("lobes is 2; an anisotropic table has 1".into());
        }
        if !(1e-6..=1.0).contains(&self.floor) {
            return Err(format!("floor is {}; choose 1e-6 to 1", self.floor));
        }
        in_range("directions", self.directions, 64, 1 << 20)?;
        in_range("samples", self.samples, 8, 1 << 16)?;
        in_range("sweeps", self.sweeps, 0, 64)?;
        for (name, value) in [
            ("smoothing", self.smoothing),
            ("furnace", self.furnace),
            ("secondary", self.secondary),
        ] {
            if !(0.0..=1e6).contains(&value) {
                return Err(format!("{name} is {value}; choose 0 to 1e6"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_checked() {
        assert!(Settings::default().validate().is_ok());
        let bad = Settings {
            size: 1,
            ..Settings::default()
        };
        assert!(bad.validate().unwrap_err().contains("size is 1"));
        let bad = Settings {
            smoothing: f64::NAN,
            ..Settings::default()
        };
        assert!(bad.validate().unwrap_err().contains("smoothing"));
    }
}
