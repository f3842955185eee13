//! Light by the lobe that reflected it.

use std::ops::{Add, AddAssign, Mul};

use glam::DVec3;

/// An RGB quantity kept apart by the lobe of the first surface that reflected it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Lobes {
    pub(crate) diffuse: DVec3,
    /// GGX, sheen and clearcoat.
    pub(crate) specular: DVec3,
}

impl Lobes {
    pub(crate) fn sum(self) -> DVec3 {
        self.diffuse + self.specular
    }
}

impl Add for Lobes {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            diffuse: self.diffuse + other.diffuse,
            specular: self.specular + other.specular,
        }
    }
}

impl AddAssign for Lobes {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<DVec3> for Lobes {
    type Output = Self;

    fn mul(self, colour: DVec3) -> Self {
        Self {
            diffuse: self.diffuse * colour,
            specular: self.specular * colour,
        }
    }
}
