//! What the path tracer asks of a scene.

use glam::DVec3;

use crate::emitter::Emitter;
use crate::material::Material;

/// A half line in world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: [f64; 3],
    /// Where it goes; the path tracer scales it to unit length.
    pub direction: [f64; 3],
}

/// A point on a surface, as a ray found it. Both normals are unit vectors that face the ray's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// World position.
    pub position: [f64; 3],
    /// Normal of the geometry: paths don't continue below it.
    pub geometric_normal: [f64; 3],
    /// Normal of the BRDF, with interpolation and normal maps: decides which lights count.
    pub shading_normal: [f64; 3],
    /// What it is made of.
    pub material: Material,
    /// Radiance emitted towards the ray's origin beneath any clearcoat; counted only when the camera sees it.
    pub emitted: [f64; 3],
}

/// Geometry and lights. Directions are unit vectors.
///
/// The implementor keeps rays off the surface they start from: `intersect` and `occluded` are asked with origins that
/// lie on surfaces, as exactly as `Surface::position` was given.
pub trait Scene: Sync {
    /// Nearest surface along the ray, not counting the one at its very origin.
    fn intersect(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<Surface>;

    /// Whether anything lies along the ray between its origin and `distance` (may be infinite), neither end counting.
    fn occluded(&self, origin: [f64; 3], direction: [f64; 3], distance: f64) -> bool;

    /// The polygon lights.
    fn emitters(&self) -> &[Emitter];

    /// RGB radiance of the emitter with that index at a point of it, finite and not negative; its own unless the scene
    /// knows better.
    fn emitter_radiance(&self, emitter: usize, position: [f64; 3]) -> [f64; 3] {
        self.emitters()[emitter].radiance_at(position)
    }

    /// The lights without extent.
    fn punctual_lights(&self) -> &[PunctualLight];
}

/// A light without extent, as glTF's `KHR_lights_punctual` defines it. Directions are unit vectors, the way light travels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PunctualLight {
    /// Parallel light from infinity.
    Directional {
        /// The way light travels.
        direction: [f64; 3],
        /// RGB irradiance at normal incidence (lux).
        irradiance: [f64; 3],
    },
    /// Light from a point in all directions.
    Point {
        /// World position.
        position: [f64; 3],
        /// RGB radiant intensity (candela).
        intensity: [f64; 3],
        /// Distance at which the light has faded to nothing, if it does.
        range: Option<f64>,
    },
    /// Light from a point into a cone.
    Spot {
        /// World position.
        position: [f64; 3],
        /// Axis of the cone, the way light travels.
        direction: [f64; 3],
        /// RGB radiant intensity on the axis (candela).
        intensity: [f64; 3],
        /// Distance at which the light has faded to nothing, if it does.
        range: Option<f64>,
        /// Angle from the axis at which it starts to fall off, radians.
        inner_cone_angle: f64,
        /// Angle from the axis at which it has fallen to nothing, radians.
        outer_cone_angle: f64,
    },
}

impl PunctualLight {
    /// Unit direction to the light, distance, and RGB irradiance on a plane that faces it.
    pub(crate) fn incident(&self, point: DVec3) -> (DVec3, f64, DVec3) {
        let from = |position: [f64; 3], intensity: [f64; 3], range: Option<f64>| {
            let offset = DVec3::from(position) - point;
            let distance = offset.length();
            let window = range.map_or(1.0, |range| {
                (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0)
            });
            let irradiance = DVec3::from(intensity) * (window / (distance * distance));
            (offset / distance, distance, irradiance)
        };
        match *self {
            Self::Directional {
                direction,
                irradiance,
            } => (-DVec3::from(direction), f64::INFINITY, irradiance.into()),
            Self::Point {
                position,
                intensity,
                range,
            } => from(position, intensity, range),
            Self::Spot {
                position,
                direction,
                intensity,
                range,
                inner_cone_angle,
                outer_cone_angle,
            } => {
                let (to_light, distance, irradiance) = from(position, intensity, range);
                let (inner, outer) = (inner_cone_angle.cos(), outer_cone_angle.cos());
                let cosine = -DVec3::from(direction).dot(to_light);
                // The extension's own formula, squared ramp of the cosine.
                let ramp = ((cosine - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0);
                (to_light, distance, irradiance * (ramp * ramp))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn punctual_lights_fall_off_as_their_extension_says() {
        let spot = |range, point: [f64; 3]| {
            let light = PunctualLight::Spot {
                position: [0.0, 2.0, 0.0],
                direction: [0.0, -1.0, 0.0],
                intensity: [8.0, 4.0, 0.0],
                range,
                inner_cone_angle: 0.0,
                outer_cone_angle: std::f64::consts::FRAC_PI_3,
            };
            light.incident(point.into())
        };
        assert_eq!(
            spot(None, [0.0; 3]),
            (DVec3::Y, 2.0, DVec3::new(2.0, 1.0, 0.0))
        );
        // At 45 degrees: ((cos 45 - cos 60) / (1 - cos 60))^2 of 8 / distance^2.
        let ramp = (0.5_f64.sqrt() - 0.5) / 0.5;
        assert!((spot(None, [2.0, 0.0, 0.0]).2.x - ramp * ramp).abs() < 1e-14);
        assert_eq!(spot(None, [4.0, 1.0, 0.0]).2, DVec3::ZERO);
        assert_eq!(spot(Some(2.0), [0.0; 3]).2, DVec3::ZERO);
        assert!((spot(Some(4.0), [0.0; 3]).2.x - 2.0 * 15.0 / 16.0).abs() < 1e-14);
    }
}
