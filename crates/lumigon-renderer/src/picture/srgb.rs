//! Display-referred sRGB with 8 bits a channel.

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
    radiance
        .par_iter()
        .flat_map_iter(|pixel| {
            if pixel.iter().all(|x| x.is_finite()) {
                let scaled = pixel.map(|x| (x * scale).min(f32::MAX));
                tone_map.apply(scaled).map(encode)
            } else {
                [255, 0, 255]
            }
        })
        .collect()
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
    fn exposure_doubles() {
        let dim = srgb8(&[[0.1, 0.2, 0.05]], 1.0, ToneMap::None);
        assert_eq!(dim, srgb8(&[[0.2, 0.4, 0.1]], 0.0, ToneMap::None));
        let wild = [[f32::MAX, 0.0, 1e-45], [f32::NAN, 0.0, 0.0]];
        let bytes = srgb8(&wild, 100.0, ToneMap::None);
        assert_eq!(bytes[..2], [255, 0]);
        assert_eq!(bytes[3..], [255, 0, 255]);
    }
}
