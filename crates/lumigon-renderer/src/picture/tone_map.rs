//! Tone mapping: linear radiance of any brightness to what a display can show.

use std::str::FromStr;

/// How linear Rec. 709 radiance, 1 the display's white, becomes display-linear colour in \[0, 1\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Clamp: true colours up to white, and nothing beyond.
    None,
    /// Luminance L to L / (1 + L): Reinhard, Stark, Shirley and Ferwerda, "Photographic Tone
    /// Reproduction for Digital Images", SIGGRAPH 2002, eq. 3.
    Reinhard,
    /// Stephen Hill's fit of the ACES reference rendering transform and its sRGB output transform
    /// ("ACES.hlsl" in MJP's `BakingLab`, 2016), without an exposure of its own. White is reached
    /// late: radiance 1 becomes 0.62.
    Aces,
    /// The Khronos PBR Neutral tone mapper (Khronos Group, specification 1.0, 2024): colours up to
    /// 0.8 keep hue and saturation, which is what glTF's base colours are made for.
    #[default]
    KhronosPbrNeutral,
}

impl ToneMap {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::None,
        Self::Reinhard,
        Self::Aces,
        Self::KhronosPbrNeutral,
    ];

    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Reinhard => "reinhard",
            Self::Aces => "aces",
            Self::KhronosPbrNeutral => "khronos-pbr-neutral",
        }
    }

    /// Display-linear colour in \[0, 1\] for finite radiance; negative radiance counts as 0.
    #[must_use]
    pub fn apply(self, radiance: [f32; 3]) -> [f32; 3] {
        // Far beyond any display's white, and low enough that no square of it overflows.
        let radiance = radiance.map(|x| x.clamp(0.0, 1e9));
        let color = match self {
            Self::None => radiance,
            Self::Reinhard => reinhard(radiance),
            Self::Aces => aces(radiance),
            Self::KhronosPbrNeutral => khronos_pbr_neutral(radiance),
        };
        color.map(|x| x.clamp(0.0, 1.0))
    }
}

impl FromStr for ToneMap {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|map| map.name() == name);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("there is no tone map {name:?}: choose one of {names}")
        })
    }
}

fn reinhard([r, g, b]: [f32; 3]) -> [f32; 3] {
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    [r, g, b].map(|x| x / (1.0 + luminance))
}

/// Rows from linear sRGB into the space the curve works in, desaturation included.
const ACES_INPUT: [[f32; 3]; 3] = [
    [0.59719, 0.35458, 0.04823],
    [0.07600, 0.90834, 0.01566],
    [0.02840, 0.13383, 0.83777],
];

/// Rows back to linear sRGB.
const ACES_OUTPUT: [[f32; 3]; 3] = [
    [1.60475, -0.53108, -0.07367],
    [-0.10208, 1.10813, -0.00605],
    [-0.00327, -0.07276, 1.07602],
];

fn aces(radiance: [f32; 3]) -> [f32; 3] {
    let curve = |v: f32| {
        let numerator = v * (v + 0.024_578_6) - 0.000_090_537;
        let denominator = v * (0.983_729 * v + 0.432_951) + 0.238_081;
        numerator / denominator
    };
    multiply(ACES_OUTPUT, multiply(ACES_INPUT, radiance).map(curve))
}

fn multiply(rows: [[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn khronos_pbr_neutral(radiance: [f32; 3]) -> [f32; 3] {
    // Fresnel reflection at normal incidence, which the mapping takes off the darks.
    const F90: f32 = 0.04;
    const START_COMPRESSION: f32 = 0.8 - F90;
    const DESATURATION: f32 = 0.15;
    let least = radiance[0].min(radiance[1]).min(radiance[2]);
    let offset = if least <= 2.0 * F90 {
        least - least * least / (4.0 * F90)
    } else {
        F90
    };
    let color = radiance.map(|x| x - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak <= START_COMPRESSION {
        return color;
    }
    let room = 1.0 - START_COMPRESSION;
    let new_peak = 1.0 - room * room / (peak + room - START_COMPRESSION);
    let to_white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    color.map(|x| {
        let compressed = x * (new_peak / peak);
        compressed + (new_peak - compressed) * to_white
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        a.into_iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
    }

    #[test]
    fn khronos_pbr_neutral_keeps_colors_and_compresses_highlights() {
        let map = |c| ToneMap::KhronosPbrNeutral.apply(c);
        // Base colours lit by white light, with the 4 % of reflection on top, come out as painted.
        assert!(near(map([0.54, 0.34, 0.14]), [0.5, 0.3, 0.1]));
        // x^2 / (4 * 0.04) in the darks.
        assert!(near(map([0.04, 0.04, 0.04]), [0.01, 0.01, 0.01]));
        // By hand: peak 1.96, 1 - 0.24^2 / (1.96 + 0.24 - 0.76) = 0.96.
        assert!(near(map([2.0, 2.0, 2.0]), [0.96, 0.96, 0.96]));
        let [r, g, b] = map([1000.0, 0.0, 0.0]);
        assert!(
            r > 0.99 && g > 0.9 && b == g,
            "a glaring red is nearly white"
        );
    }

    #[test]
    fn reinhard_and_aces_at_known_points() {
        assert!(near(ToneMap::Reinhard.apply([1.0; 3]), [0.5; 3]));
        // The matrices' rows sum to 1 within 1e-5, so that grey stays grey: the curve by hand.
        let curve = (1.024_578_6 - 0.000_090_537) / (0.983_729 + 0.432_951 + 0.238_081);
        for x in ToneMap::Aces.apply([1.0; 3]) {
            assert!((x - curve).abs() < 2e-4, "{x} {curve}");
        }
    }

    #[test]
    fn greys_grow_with_radiance_and_stay_in_range() {
        for map in ToneMap::ALL {
            let mut last = 0.0;
            for i in 0..400 {
                let x = 1e-4 * 1.1_f32.powi(i);
                let [r, g, b] = map.apply([x; 3]);
                assert!((r - g).abs() < 1e-3 && (g - b).abs() < 1e-3, "{map:?}");
                assert!(r >= last - 1e-6 && r <= 1.0, "{map:?} at {x}");
                last = r;
            }
            assert!(last > 0.95, "{map:?} {last}");
            assert_eq!(map.apply([-1.0, -0.0, 0.0]), [0.0; 3]);
            let white = map.apply([f32::MAX; 3]);
            assert!(white.iter().all(|x| (0.95..=1.0).contains(x)), "{white:?}");
            assert_eq!(map.name().parse(), Ok(map));
        }
        assert!("filmic".parse::<ToneMap>().unwrap_err().contains("aces"));
    }
}
