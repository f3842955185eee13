//! A vector of three numbers.

use core::ops::{Add, AddAssign, Mul, Neg, Sub};

use crate::real::Real;

/// A vector in right-handed Cartesian coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3<T> {
    /// First coordinate.
    pub x: T,
    /// Second coordinate.
    pub y: T,
    /// Third coordinate.
    pub z: T,
}

impl<T> Vec3<T> {
    /// The vector (x, y, z).
    #[inline(always)]
    pub const fn new(x: T, y: T, z: T) -> Self {
        Self { x, y, z }
    }
}

impl<T: Copy> From<[T; 3]> for Vec3<T> {
    #[inline(always)]
    fn from([x, y, z]: [T; 3]) -> Self {
        Self { x, y, z }
    }
}

impl<T> From<Vec3<T>> for [T; 3] {
    #[inline(always)]
    fn from(v: Vec3<T>) -> Self {
        [v.x, v.y, v.z]
    }
}

impl<T: Real> Vec3<T> {
    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        self.x
            .mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }

    /// Vector product.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y.mul_add(other.z, -(self.z * other.y)),
            self.z.mul_add(other.x, -(self.x * other.z)),
            self.x.mul_add(other.y, -(self.y * other.x)),
        )
    }

    /// `self * factor + other`.
    #[inline(always)]
    pub fn mul_add(self, factor: T, other: Self) -> Self {
        Self::new(
            self.x.mul_add(factor, other.x),
            self.y.mul_add(factor, other.y),
            self.z.mul_add(factor, other.z),
        )
    }

    /// Length.
    #[inline(always)]
    pub fn length(self) -> T {
        self.dot(self).sqrt()
    }

    /// The unit vector of the same direction; the zero vector stays zero.
    #[inline(always)]
    pub fn normalize_or_zero(self) -> Self {
        let squared = self.dot(self);
        let zero = squared.constant(0.0);
        let positive = squared.gt(zero);
        let root = T::select(positive, squared, squared.constant(1.0)).sqrt();
        self * T::select(positive, squared.constant(1.0) / root, zero)
    }

    /// `value` in every lane, beside `like`.
    #[inline(always)]
    pub fn broadcast(like: T, value: Vec3<T::Scalar>) -> Self {
        Self::new(
            like.broadcast(value.x),
            like.broadcast(value.y),
            like.broadcast(value.z),
        )
    }

    /// `if_true` where `mask` holds, else `if_false`.
    #[inline(always)]
    pub fn select(mask: T::Mask, if_true: Self, if_false: Self) -> Self {
        Self::new(
            T::select(mask, if_true.x, if_false.x),
            T::select(mask, if_true.y, if_false.y),
            T::select(mask, if_true.z, if_false.z),
        )
    }

    /// Two unit vectors that make a right-handed orthonormal frame (first, second, `self`).
    ///
    /// `self` must be a unit vector. Duff et al., "Building an Orthonormal Basis, Revisited",
    /// JCGT 6(1), 2017: continuous but on the plane z = 0, with no degenerate direction.
    #[inline(always)]
    pub fn orthonormal_basis(self) -> (Self, Self) {
        let zero = self.z.constant(0.0);
        let one = self.z.constant(1.0);
        let sign = T::select(self.z.lt(zero), -one, one);
        let a = -one / (sign + self.z);
        let b = self.x * self.y * a;
        (
            Self::new(
                (sign * self.x).mul_add(self.x * a, one),
                sign * b,
                -(sign * self.x),
            ),
            Self::new(b, self.y.mul_add(self.y * a, sign), -self.y),
        )
    }
}

impl<T: Real> Add for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<T: Real> AddAssign for Vec3<T> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<T: Real> Sub for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<T: Real> Mul<T> for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<T: Real> Neg for Vec3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orthonormal_basis_is_right_handed() {
        for n in [
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [0.6, 0.0, -0.8],
            [-0.36, 0.48, 0.8],
        ] {
            let n: Vec3<f64> = n.into();
            let (s, t) = n.orthonormal_basis();
            let error = s.cross(t) - n;
            assert!(error.dot(error) < 1e-30);
            assert!(s.dot(n).abs() + t.dot(n).abs() + s.dot(t).abs() < 1e-15);
        }
    }

    #[test]
    fn zero_has_no_direction() {
        let zero: Vec3<f32> = Vec3::default();
        assert_eq!(zero.normalize_or_zero(), zero);
    }
}
