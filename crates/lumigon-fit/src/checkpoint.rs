use serde::{Deserialize, Serialize};

use crate::{coordinates::Coordinates, fit::Lobes, settings::Settings};

/// An unfinished fit: what [`crate::Fit::resume`] goes on from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Checkpoint {
    /// The settings, in their serialised form.
    settings: String,
    /// 0 for the march, then two a sweep.
    pass: usize,
    /// The pass before, whole.
    previous: Vec<Bits>,
    /// This pass; empty where a texel is not done.
    current: Vec<Bits>,
}

/// Coordinates by their bits, since text would round them.
type Bits = Vec<u64>;

impl Checkpoint {
    pub(crate) fn new(settings: &Settings, count: usize) -> Self {
        Self {
            settings: described(settings),
            pass: 0,
            previous: vec![Bits::new(); count],
            current: vec![Bits::new(); count],
        }
    }

    /// What keeps a fit of these settings from going on from here.
    pub(crate) fn check(&self, settings: &Settings, count: usize) -> Result<(), String> {
        if self.settings != described(settings) {
            return Err("the unfinished fit is one of other settings".into());
        }
        let length = settings.lobes as usize * Coordinates::COUNT;
        let whole = |bits: &Bits| {
            bits.len() == length && bits.iter().all(|&x| f64::from_bits(x).is_finite())
        };
        let previous = match self.pass {
            0 => self.previous.iter().all(Vec::is_empty),
            _ => self.previous.iter().all(whole),
        };
        let current = self
            .current
            .iter()
            .all(|bits| bits.is_empty() || whole(bits));
        let counts = self.previous.len() == count && self.current.len() == count;
        let pass = self.pass <= 2 * settings.sweeps as usize + 1;
        if previous && current && counts && pass {
            Ok(())
        } else {
            Err("the unfinished fit is damaged".into())
        }
    }

    pub(crate) fn pass(&self) -> usize {
        self.pass
    }

    /// Texels finished in all passes.
    pub(crate) fn done(&self) -> usize {
        let current = self.current.iter().filter(|bits| !bits.is_empty()).count();
        self.pass * self.current.len() + current
    }

    pub(crate) fn set(&mut self, index: usize, lobes: &Lobes) {
        self.current[index] = lobes
            .iter()
            .flat_map(|coordinates| coordinates.0.map(f64::to_bits))
            .collect();
    }

    pub(crate) fn get(&self, index: usize) -> Option<Lobes> {
        let bits = &self.current[index];
        (!bits.is_empty()).then(|| lobes(bits))
    }

    pub(crate) fn next_pass(&mut self) {
        self.previous =
            std::mem::replace(&mut self.current, vec![Bits::new(); self.previous.len()]);
        self.pass += 1;
    }

    pub(crate) fn previous(&self) -> Vec<Lobes> {
        self.previous.iter().map(lobes).collect()
    }
}

fn lobes(bits: &Bits) -> Lobes {
    bits.as_chunks::<{ Coordinates::COUNT }>()
        .0
        .iter()
        .map(|bits| Coordinates(bits.map(f64::from_bits)))
        .collect()
}

fn described(settings: &Settings) -> String {
    serde_json::to_string(settings).unwrap_or_default()
}
