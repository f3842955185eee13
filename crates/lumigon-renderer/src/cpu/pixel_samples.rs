//! Where in a pixel its rays go.

/// `count` positions in \[0, 1)^2, the same for every pixel: the centre alone, or the Hammersley
/// set moved to the middle of its strata, so that rows, columns and (for powers of two) every
/// elementary box hold one each.
pub(crate) fn pixel_samples(count: u32) -> Vec<[f64; 2]> {
    let strata = f64::from(count.next_power_of_two());
    (0..count)
        .map(|i| {
            let x = (f64::from(i) + 0.5) / f64::from(count);
            let radical_inverse = f64::from(i.reverse_bits()) / 4_294_967_296.0;
            [x, radical_inverse + 0.5 / strata]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_the_centre() {
        assert_eq!(pixel_samples(1), [[0.5, 0.5]]);
    }

    #[test]
    fn rows_and_columns_hold_one_each() {
        for count in [2, 4, 16, 64] {
            for axis in 0..2 {
                let mut strata: Vec<_> = pixel_samples(count)
                    .iter()
                    .map(|p| (p[axis] * f64::from(count)) as u32)
                    .collect();
                strata.sort_unstable();
                assert!(strata.into_iter().eq(0..count));
            }
        }
        let inside = |p: &[f64; 2]| p.iter().all(|x| (0.0..1.0).contains(x));
        assert!(pixel_samples(37).iter().all(inside));
    }
}
