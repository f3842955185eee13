//! Display-referred sRGB with 8 bits a channel.

use std::sync::LazyLock;

use rayon::prelude::*;

use super::ToneMap;

/// Linear radiance as sRGB bytes, RGB: scaled by 2^`exposure_ev`, tone mapped, encoded with the
/// transfer function of IEC 61966-2-1 and rounded to nearest.
///
/// The same bytes on every machine. Pixels that are not finite have no colour: callers that write
/// files refuse them, here they come out as magenta.
#[must_use]
pub fn srgb8(radiance: &[[f32; 3]], exposure_ev: f32, tone_map: ToneMap) -> Vec<u8> {
    let scale = libm::exp2f(exposure_ev);
    let thresholds = &*THRESHOLDS;
    radiance
        .par_iter()
        .flat_map_iter(|pixel| {
            if pixel.iter().all(|x| x.is_finite()) {
                let scaled = pixel.map(|x| (x * scale).min(f32::MAX));
                tone_map
                    .apply(scaled)
                    .map(|linear| byte(thresholds, linear))
            } else {
                [255, 0, 255]
            }
        })
        .collect()
}

/// The least linear values that [`encode`] takes to 1, 2, ... 255: comparing with these is several
/// times faster than the power.
static THRESHOLDS: LazyLock<[f32; 255]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        // Positive floats are in the order of their bits.
        let (mut below, mut least) = (0, 1.0_f32.to_bits());
        while least - below > 1 {
            let middle = below + (least - below) / 2;
            if usize::from(encode(f32::from_bits(middle))) > i {
                least = middle;
            } else {
                below = middle;
            }
        }
        f32::from_bits(least)
    })
});

/// [`encode`], by its thresholds.
fn byte(thresholds: &[f32; 255], linear: f32) -> u8 {
    thresholds.partition_point(|&least| least <= linear) as u8
}

/// The transfer function and the rounding; `linear` in \[0, 1\].
fn encode(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        // Not the system's power: it differs between systems in the last bit.
        1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055
    };
    (255.0 * encoded + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_comes_back_from_its_color() {
        for byte in 0..=255_u8 {
            let encoded = f64::from(byte) / 255.0;
            let linear = if encoded <= 0.04045 {
                encoded / 12.92
            } else {
                ((encoded + 0.055) / 1.055).powf(2.4)
            };
            assert_eq!(encode(linear as f32), byte);
        }
    }

    #[test]
    fn thresholds_are_the_function() {
        for i in 0..=1_000_000_u32 {
            let linear = i as f32 / 1e6;
            assert_eq!(byte(&THRESHOLDS, linear), encode(linear), "{linear}");
        }
        for linear in THRESHOLDS.iter().flat_map(|x| [x.next_down(), *x]) {
            assert_eq!(byte(&THRESHOLDS, linear), encode(linear), "{linear}");
        }
    }

    #[test]
    fn exposure_doubles() {
        let dim = srgb8(&[[0.1, 0.2, 0.05]], 1.0, ToneMap::None);
        assert_eq!(dim, srgb8(&[[0.2, 0.4, 0.1]], 0.0, ToneMap::None));
        let wild = [[f32::MAX, 0.0, 1e-45], [f32::NAN, 0.0, 0.0]];
        let bytes = srgb8(&wild, 100.0, ToneMap::None);
        assert_eq!(bytes[..2], [255, 0]);
        assert_eq!(bytes[3..], [255, 0, 255]);
    }
}
