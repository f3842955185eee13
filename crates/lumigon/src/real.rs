//! The number types the mathematics is written over.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub, SubAssign};

/// A truth value per lane: `bool` for scalars.
pub trait Mask:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self>
{
    /// Whether any lane holds.
    fn any(self) -> bool;
    /// Whether every lane holds.
    fn all(self) -> bool;
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

/// A real number, or one per SIMD lane.
///
/// A light is stored in [`Real::Scalar`]; the shading point is a `Real`. Constants are made
/// *beside* a value (`x.constant(2.0)`), because a SIMD vector carries the proof that the
/// processor has its instructions. Control flow goes through [`Real::Mask`], so that a dual
/// number can take the branch of its real part.
pub trait Real:
    Copy
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + SubAssign
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The number that fills one lane.
    type Scalar: Scalar;
    /// One truth value per lane.
    type Mask: Mask;

    /// `value` in every lane.
    fn broadcast(self, value: Self::Scalar) -> Self;
    /// A literal in every lane.
    #[inline(always)]
    fn constant(self, value: f64) -> Self {
        self.broadcast(Self::Scalar::from_f64(value))
    }
    /// `self * a + b`, fused where the processor does so.
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// Square root; NaN for negative numbers.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The lesser; the other number where one is NaN is not promised.
    fn min(self, other: Self) -> Self;
    /// The greater; the other number where one is NaN is not promised.
    fn max(self, other: Self) -> Self;
    /// `self < other`, lane by lane.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`, lane by lane.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`, lane by lane.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`, lane by lane.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// `if_true` where `mask` holds, else `if_false`.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;
    /// `read` of the inputs' numbers, lane by lane: lookups that have no SIMD form.
    fn lookup<const N: usize, const M: usize>(
        inputs: [Self; N],
        read: impl FnMut([Self::Scalar; N]) -> [Self::Scalar; M],
    ) -> [Self; M];
    /// Azimuth of the point (`x`, `self`) in \[-pi, pi\]; 0 for the origin.
    ///
    /// In single precision a minimax polynomial with absolute error below 4e-7.
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        arctangent::atan2(self, x)
    }
    /// theta / sin-like: the angle between two vectors over the length of their cross product,
    /// from `squared_sine = |a x b|^2` and `cosine = a.b`, neither normalised.
    ///
    /// This is `atan2(s, d) / s` with its limit `1/d` at `s = 0`; it scales as 1/(|a||b|).
    /// For `s = 0` and `d <= 0` (the segment passes through the point) the result is 0, the
    /// value that keeps a sum over edges finite. In single precision the relative error is
    /// below 3e-7.
    #[inline(always)]
    fn angle_over_sine(squared_sine: Self, cosine: Self) -> Self {
        arctangent::angle_over_sine(squared_sine, cosine)
    }
    /// `x Q(x) = atan(sqrt x)/sqrt x - 1` for x in \[0, 1\], without the cancellation.
    #[inline(always)]
    fn angle_over_sine_excess(x: Self) -> Self {
        x * arctangent::excess_quotient(x)
    }
}

/// A [`Real`] of one lane: what lights are stored in.
pub trait Scalar: Real<Scalar = Self, Mask = bool> + PartialOrd + Default + Debug {
    /// Nearest value to a literal.
    fn from_f64(value: f64) -> Self;
    /// The value as f64, exactly for f32 and f64.
    fn to_f64(self) -> f64;
    /// `self` to the power of `exponent`; NaN for negative numbers.
    fn powf(self, exponent: Self) -> Self;
    /// Distance from 1 to the next number.
    #[inline(always)]
    fn epsilon() -> Self {
        Self::from_f64(f64::EPSILON)
    }
}

impl Scalar for f32 {
    #[inline(always)]
    fn from_f64(value: f64) -> f32 {
        value as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn powf(self, exponent: f32) -> f32 {
        power::f32(self, exponent)
    }
    #[inline(always)]
    fn epsilon() -> f32 {
        f32::EPSILON
    }
}

impl Scalar for f64 {
    #[inline(always)]
    fn from_f64(value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn powf(self, exponent: f64) -> f64 {
        power::f64(self, exponent)
    }
}

macro_rules! scalar_real {
    ($t:ident, $sqrt:path, { $($extra:item)* }) => {
        impl Real for $t {
            type Scalar = $t;
            type Mask = bool;
            #[inline(always)]
            fn broadcast(self, value: $t) -> $t {
                value
            }
            #[inline(always)]
            fn mul_add(self, a: $t, b: $t) -> $t {
                // Not fused: without the instruction a fused product is a slow library call.
                self * a + b
            }
            #[inline(always)]
            fn sqrt(self) -> $t {
                $sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> $t {
                $t::abs(self)
            }
            #[inline(always)]
            fn min(self, other: $t) -> $t {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: $t) -> $t {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn lt(self, other: $t) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: $t) -> bool {
                self <= other
            }
            #[inline(always)]
            fn select(mask: bool, if_true: $t, if_false: $t) -> $t {
                if mask { if_true } else { if_false }
            }
            #[inline(always)]
            fn lookup<const N: usize, const M: usize>(
                inputs: [$t; N],
                mut read: impl FnMut([$t; N]) -> [$t; M],
            ) -> [$t; M] {
                read(inputs)
            }
            $($extra)*
        }
    };
}
scalar_real!(f32, square_root::f32, {});
scalar_real!(f64, square_root::f64, {
    #[inline(always)]
    fn atan2(self, x: f64) -> f64 {
        libm::atan2(self, x)
    }
    #[inline(always)]
    fn angle_over_sine(squared_sine: f64, cosine: f64) -> f64 {
        let sine = libm::sqrt(squared_sine);
        if sine > 1e-9 * cosine.abs() {
            libm::atan2(sine, cosine) / sine
        } else if cosine > 0.0 {
            1.0 / cosine
        } else {
            0.0
        }
    }
    #[inline(always)]
    fn angle_over_sine_excess(x: f64) -> f64 {
        if x > 0.01 {
            let root = libm::sqrt(x);
            libm::atan(root) / root - 1.0
        } else {
            // atan's own series; the first term left out is below 1e-17.
            let mut sum = 0.0;
            for k in (1..8).rev() {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                sum = x * (sign / f64::from(2 * k + 1) + sum);
            }
            sum
        }
    }
});

/// The processor's own instruction where the standard library gives it.
mod square_root {
    #[inline(always)]
    pub(super) fn f32(x: f32) -> f32 {
        #[cfg(feature = "std")]
        return x.sqrt();
        #[cfg(not(feature = "std"))]
        return libm::sqrtf(x);
    }
    #[inline(always)]
    pub(super) fn f64(x: f64) -> f64 {
        #[cfg(feature = "std")]
        return x.sqrt();
        #[cfg(not(feature = "std"))]
        return libm::sqrt(x);
    }
}

/// The standard library's own power where there is one.
mod power {
    #[inline(always)]
    pub(super) fn f32(x: f32, exponent: f32) -> f32 {
        #[cfg(feature = "std")]
        return x.powf(exponent);
        #[cfg(not(feature = "std"))]
        return libm::powf(x, exponent);
    }
    #[inline(always)]
    pub(super) fn f64(x: f64, exponent: f64) -> f64 {
        #[cfg(feature = "std")]
        return x.powf(exponent);
        #[cfg(not(feature = "std"))]
        return libm::pow(x, exponent);
    }
}

/// Single-precision arctangents without tables, branches or special cases.
mod arctangent {
    use super::{Mask, Real};

    /// Minimax in relative error of `atan(sqrt x)/sqrt x = 1 + x Q(x)` on \[0, 1\], by Remez
    /// exchange: 1.7e-8 exact, 9e-8 in f32. P(0) = 1 exactly, so that small angles lose nothing.
    const Q: [f64; 8] = [
        -0.333_331_527_33,
        0.199_937_727_779,
        -0.142_110_549_09,
        0.106_660_032_346,
        -0.075_522_115_167_1,
        0.043_211_830_075_8,
        -0.016_367_910_017_8,
        0.002_920_687_917_02,
    ];

    #[inline(always)]
    pub(super) fn excess_quotient<T: Real>(x: T) -> T {
        let mut sum = x.constant(Q[7]);
        for k in (0..7).rev() {
            sum = sum.mul_add(x, x.constant(Q[k]));
        }
        sum
    }

    #[inline(always)]
    fn quotient<T: Real>(x: T) -> T {
        excess_quotient(x).mul_add(x, x.constant(1.0))
    }

    #[inline(always)]
    pub(super) fn atan2<T: Real>(y: T, x: T) -> T {
        let (ay, ax) = (y.abs(), x.abs());
        let tiny = y.constant(1e-37);
        let r = ay.min(ax) / ay.max(ax).max(tiny);
        let mut angle = r * quotient(r * r);
        let half_pi = y.constant(core::f64::consts::FRAC_PI_2);
        let pi = y.constant(core::f64::consts::PI);
        angle = T::select(ay.gt(ax), half_pi - angle, angle);
        let zero = y.constant(0.0);
        angle = T::select(x.lt(zero), pi - angle, angle);
        T::select(y.lt(zero), -angle, angle)
    }

    #[inline(always)]
    pub(super) fn angle_over_sine<T: Real>(squared_sine: T, cosine: T) -> T {
        let zero = squared_sine.constant(0.0);
        let one = squared_sine.constant(1.0);
        let squared_cosine = cosine * cosine;
        let within_octant = cosine.gt(zero) & squared_sine.le(squared_cosine);
        if within_octant.all() {
            // Edges under 45 degrees, nearly all there are, need neither root nor select.
            let inverse = one / cosine;
            return quotient(squared_sine * inverse * inverse) * inverse;
        }
        // Beyond 45 degrees from the axis that is nearer: atan2(s, d) by octants, each divided
        // by s on paper.
        let tiny = squared_sine.constant(1e-37);
        let sine = squared_sine.max(tiny).sqrt();
        let steep = sine.gt(cosine.abs());
        let inverse_sine = one / sine;
        let inverse_major = T::select(steep, inverse_sine, one / cosine.abs().max(tiny));
        let minor = T::select(steep, cosine, sine);
        let r = minor * inverse_major;
        let p = quotient(r * r) * inverse_major;
        let half_pi = squared_sine.constant(core::f64::consts::FRAC_PI_2);
        let pi = squared_sine.constant(core::f64::consts::PI);
        // steep: (pi/2 - atan(d/s))/s;  d > 0: atan(s/d)/s;  d < 0: (pi - atan(s/-d))/s
        let steep_value = (half_pi - cosine * p) * inverse_sine;
        let flat_value = T::select(cosine.gt(zero), p, pi * inverse_sine - p);
        let value = T::select(steep, steep_value, flat_value);
        // s = 0 behind or at the point: the segment meets the point, its arc has no plane.
        let degenerate = squared_sine.le(tiny) & cosine.le(zero);
        T::select(degenerate, zero, value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angle_over_sine_matches_libm() {
        let mut worst: f64 = 0.0;
        for i in 0..=20_000 {
            let theta = core::f64::consts::PI * (f64::from(i) / 20_000.0) * 0.999;
            for scale in [1e-6, 1.0, 1e6] {
                let (s, c) = (libm::sin(theta) * scale, libm::cos(theta) * scale);
                let (s2, c) = ((s * s) as f32, c as f32);
                let s = libm::sqrt(f64::from(s2));
                if s == 0.0 {
                    continue;
                }
                let exact = libm::atan2(s, f64::from(c)) / s;
                let got = f64::from(f32::angle_over_sine(s2, c));
                worst = worst.max((got / exact - 1.0).abs());
            }
        }
        assert!(worst < 3e-7, "{worst:e}");
    }

    #[test]
    fn angle_over_sine_has_its_limits() {
        assert_eq!(f32::angle_over_sine(0.0, 4.0), 0.25);
        assert_eq!(f64::angle_over_sine(0.0, 4.0), 0.25);
        for d in [0.0, -1.0] {
            assert_eq!(f32::angle_over_sine(0.0, d), 0.0);
            assert_eq!(f64::angle_over_sine(0.0, f64::from(d)), 0.0);
        }
    }

    #[test]
    fn atan2_in_every_octant() {
        for i in -3_000..=3_000 {
            let theta = core::f64::consts::PI * f64::from(i) / 3_001.0;
            let (y, x) = (libm::sin(theta) as f32, libm::cos(theta) as f32);
            let exact = libm::atan2(f64::from(y), f64::from(x));
            assert!(
                (f64::from(Real::atan2(y, x)) - exact).abs() < 4e-7,
                "{theta}"
            );
        }
        assert_eq!(Real::atan2(0.0_f32, 0.0), 0.0);
    }

    #[test]
    fn excess_agrees_between_precisions() {
        for i in 0..=1_000 {
            let x = f64::from(i) / 1_000.0;
            let exact = f64::angle_over_sine_excess(x);
            let got = f64::from(f32::angle_over_sine_excess(x as f32));
            assert!((got - exact).abs() <= 2e-6 * x, "{x}: {got} {exact}");
        }
    }
}
