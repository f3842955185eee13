//! A number that counts what is done to it.

use std::cell::Cell;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use lumigon::{Real, Scalar};

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
}

/// An f32 of which every operation counts one: what one SIMD lane is asked to do.
///
/// A fused multiply-add counts one, as it is one instruction; so do division, square root,
/// comparison and selection.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub(super) struct Counted(pub(super) f32);

fn count(value: f32) -> Counted {
    OPERATIONS.with(|operations| operations.set(operations.get() + 1));
    Counted(value)
}

/// The operations that `work` does on this thread.
pub(super) fn operations(work: impl FnOnce()) -> u64 {
    let before = OPERATIONS.with(Cell::get);
    work();
    OPERATIONS.with(Cell::get) - before
}

macro_rules! counted_operator {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                count($operator::$method(self.0, other.0))
            }
        }
    )*};
}
counted_operator!(Add add, Sub sub, Mul mul, Div div);

impl AddAssign for Counted {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Counted {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Neg for Counted {
    type Output = Self;
    /// Free: compilers fold signs into the products and sums around them.
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Real for Counted {
    type Scalar = Self;
    type Mask = bool;

    fn broadcast(self, value: Self) -> Self {
        value
    }
    fn mul_add(self, a: Self, b: Self) -> Self {
        count(self.0 * a.0 + b.0)
    }
    fn sqrt(self) -> Self {
        count(self.0.sqrt())
    }
    fn abs(self) -> Self {
        count(self.0.abs())
    }
    fn min(self, other: Self) -> Self {
        count(self.0.min(other.0))
    }
    fn max(self, other: Self) -> Self {
        count(self.0.max(other.0))
    }
    fn lt(self, other: Self) -> bool {
        count(0.0);
        self.0 < other.0
    }
    fn le(self, other: Self) -> bool {
        count(0.0);
        self.0 <= other.0
    }
    fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
        count(if mask { if_true.0 } else { if_false.0 })
    }
    /// Not counted: memory bounds it, not arithmetic.
    fn lookup<const N: usize, const M: usize>(
        inputs: [Self; N],
        mut read: impl FnMut([Self; N]) -> [Self; M],
    ) -> [Self; M] {
        read(inputs)
    }
}

impl Scalar for Counted {
    fn from_f64(value: f64) -> Self {
        Self(value as f32)
    }
    fn to_f64(self) -> f64 {
        self.0.into()
    }
    fn powf(self, exponent: Self) -> Self {
        count(self.0.powf(exponent.0))
    }
}
