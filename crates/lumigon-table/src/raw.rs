use half::f16;

/// Little-endian numbers, rounded to the nearest of 16 bits (ties to even) where `half`.
pub(crate) fn bytes(values: &[f32], half: bool) -> Vec<u8> {
    if half {
        let halves = values.iter().map(|&value| f16::from_f32(value));
        halves.flat_map(f16::to_le_bytes).collect()
    } else {
        values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect()
    }
}

/// The other way round.
#[cfg(test)]
pub(crate) fn values(bytes: &[u8], half: bool) -> Vec<f32> {
    if half {
        let halves = bytes.as_chunks::<2>().0.iter();
        halves.map(|b| f16::from_le_bytes(*b).to_f32()).collect()
    } else {
        let singles = bytes.as_chunks::<4>().0.iter();
        singles.map(|b| f32::from_le_bytes(*b)).collect()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::format::Format;
    use crate::image::tests::{bits, example};

    /// Bit for bit, or to half a unit in the last of 11 places, and no less than the spacing of
    /// denormals.
    pub(crate) fn assert_same(read: &[f32], written: &[f32], half: bool) {
        if !half {
            assert_eq!(bits(read), bits(written));
            return;
        }
        assert_eq!(read.len(), written.len());
        for (read, written) in read.iter().zip(written) {
            let bound = (written.abs() * 2.0_f32.powi(-11)).max(2.0_f32.powi(-25));
            assert!((read - written).abs() <= bound, "{read} {written}");
        }
    }

    #[test]
    fn round_trip() {
        let image = example(&[3, 2, 5, 4]);
        for (format, half) in [(Format::F32, false), (Format::F16, true)] {
            let bytes = image.encode(format).unwrap();
            assert_same(&values(&bytes, half), image.values(), half);
        }
        // Independently: 1, -2 and 65504 in binary16 are 0x3c00, 0xc000 and 0x7bff.
        let known = bytes(&[1.0, -2.0, 65504.0], true);
        assert_eq!(known, [0x00, 0x3c, 0x00, 0xc0, 0xff, 0x7b]);
    }
}
