//! Rotations from libm's sine and cosine, whose bits are the same on every platform.

use glam::{DMat3, DQuat, DVec3};

/// A turn of `degrees` about the unit vector `axis`, counter-clockwise seen from its tip.
pub(crate) fn turn(axis: DVec3, degrees: f64) -> DQuat {
    let half = degrees.to_radians() / 2.0;
    let v = axis * libm::sin(half);
    DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(half))
}

/// Turns +z toward `direction` (any length but zero) with +x level where the direction is not vertical.
///
/// A polygon in the xy plane then emits along `direction`.
pub(crate) fn facing(direction: DVec3) -> DQuat {
    let z = direction.normalize();
    let up = if z.y.abs() > 0.999 {
        DVec3::NEG_Z * z.y.signum()
    } else {
        DVec3::Y
    };
    let x = up.cross(z).normalize();
    DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z))
}

/// Turns a glTF camera, which looks along -z, at `eye` toward `target`.
pub(crate) fn looking(eye: DVec3, target: DVec3) -> DQuat {
    facing(eye - target)
}
