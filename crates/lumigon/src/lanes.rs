//! SIMD lanes: one shading point per lane, the light shared.

use core::ops::{Add, AddAssign, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub, SubAssign};

use fearless_simd::{ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdMask};

use crate::real::{Mask, Real};

/// As many f32 as one register of the processor holds (4, 8 or 16).
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd>(pub S::f32s);

/// A truth value for each of [`Lanes`].
#[derive(Clone, Copy)]
pub struct LaneMask<S: Simd>(pub S::mask32s);

/// Lanes of the widest registers.
const MOST_LANES: usize = 16;

impl<S: Simd> Lanes<S> {
    /// Number of lanes.
    pub const COUNT: usize = <S::f32s as SimdBase<S>>::LEN;

    /// `value` in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f32) -> Self {
        Self(S::f32s::splat(simd, value))
    }

    /// The first [`Lanes::COUNT`] numbers of `slice`, which must have as many.
    #[inline(always)]
    pub fn from_slice(simd: S, slice: &[f32]) -> Self {
        Self(S::f32s::from_slice(simd, &slice[..Self::COUNT]))
    }

    /// Writes the lanes over the first [`Lanes::COUNT`] numbers of `slice`.
    #[inline(always)]
    pub fn store(self, slice: &mut [f32]) {
        self.0.store_slice(&mut slice[..Self::COUNT]);
    }
}

impl<S: Simd> Mask for LaneMask<S> {
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any_true()
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.all_true()
    }
}

macro_rules! lane_operator {
    ($wrapper:ident, $($operator:ident $method:ident),*) => {$(
        impl<S: Simd> $operator for $wrapper<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($operator::$method(self.0, other.0))
            }
        }
    )*};
}
lane_operator!(Lanes, Add add, Sub sub, Mul mul, Div div);
lane_operator!(LaneMask, BitAnd bitand, BitOr bitor, BitXor bitxor);

impl<S: Simd> Not for LaneMask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl<S: Simd> SubAssign for Lanes<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        self.0 -= other.0;
    }
}

impl<S: Simd> Real for Lanes<S> {
    type Scalar = f32;
    type Mask = LaneMask<S>;

    #[inline(always)]
    fn broadcast(self, value: f32) -> Self {
        Self::splat(self.0.token(), value)
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(self.0.mul_add(a.0, b.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> LaneMask<S> {
        LaneMask(self.0.simd_lt(other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> LaneMask<S> {
        LaneMask(self.0.simd_le(other.0))
    }
    #[inline(always)]
    fn select(mask: LaneMask<S>, if_true: Self, if_false: Self) -> Self {
        Self(mask.0.select(if_true.0, if_false.0))
    }
    #[inline(always)]
    fn lookup<const N: usize, const M: usize>(
        inputs: [Self; N],
        mut read: impl FnMut([f32; N]) -> [f32; M],
    ) -> [Self; M] {
        let simd = inputs[0].0.token();
        let mut numbers = [[0.0; MOST_LANES]; N];
        for (numbers, input) in numbers.iter_mut().zip(inputs) {
            input.store(numbers);
        }
        let mut found = [[0.0; MOST_LANES]; M];
        for lane in 0..Self::COUNT {
            let values = read(core::array::from_fn(
                #[inline(always)]
                |i| numbers[i][lane],
            ));
            for (found, value) in found.iter_mut().zip(values) {
                found[lane] = value;
            }
        }
        found.map(
            #[inline(always)]
            |found| Self::from_slice(simd, &found),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[inline(always)]
    fn lanes_equal_scalars<S: Simd>(simd: S) {
        let n = Lanes::<S>::COUNT;
        let mut y = [0.0_f32; 16];
        let mut x = [0.0_f32; 16];
        for trial in 0..200 {
            for i in 0..n {
                let angle = (trial * n + i) as f32 * 0.37;
                y[i] = libm::sinf(angle) * 3.0;
                x[i] = libm::cosf(angle) * 3.0;
            }
            let (ly, lx) = (Lanes::from_slice(simd, &y), Lanes::from_slice(simd, &x));
            let (mut azimuth, mut quotient) = ([0.0; 16], [0.0; 16]);
            ly.atan2(lx).store(&mut azimuth);
            Lanes::angle_over_sine(ly * ly, lx).store(&mut quotient);
            let mut swapped = [[0.0; 16]; 2];
            for (to, from) in swapped
                .iter_mut()
                .zip(Lanes::lookup([ly, lx], |[y, x]| [x, y]))
            {
                from.store(to);
            }
            assert_eq!(swapped, [x, y]);
            for i in 0..n {
                assert!((azimuth[i] - Real::atan2(y[i], x[i])).abs() < 5e-7);
                let scalar = f32::angle_over_sine(y[i] * y[i], x[i]);
                assert!((quotient[i] / scalar - 1.0).abs() < 5e-7);
            }
        }
    }

    #[test]
    fn lanes_compute_what_scalars_do() {
        dispatch!(Level::new(), simd => lanes_equal_scalars(simd));
    }
}
