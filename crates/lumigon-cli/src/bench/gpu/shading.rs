//! What a pixel reflects.

use serde::Serialize;

/// How much of a light's reflection is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Shading {
    /// Exact diffuse light.
    Diffuse,
    /// With one transformed cosine, and the cosine that goes with it.
    Ltc,
    /// With two.
    TwoLobes,
}

impl Shading {
    pub(super) const ALL: [Self; 3] = [Self::Diffuse, Self::Ltc, Self::TwoLobes];

    pub(super) fn lobes(self) -> u32 {
        self as u32
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::Ltc => "diffuse + LTC",
            Self::TwoLobes => "diffuse + LTC, two lobes",
        }
    }
}
