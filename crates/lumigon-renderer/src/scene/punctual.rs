//! Lights without extent (`KHR_lights_punctual`).

use glam::Vec3;

/// The shape of a [`PunctualLight`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PunctualKind {
    /// Parallel light; the colour is in lux.
    Directional,
    /// From one point all around; the colour is in candela.
    Point,
    /// From one point into a cone; the colour is in candela.
    Spot {
        /// Half angle of the cone that is lit in full, in radians.
        inner_cone_angle: f32,
        /// Half angle of the cone beyond which it is dark, in radians, above the inner one.
        outer_cone_angle: f32,
    },
}

/// A light without extent.
#[derive(Clone, Debug, PartialEq)]
pub struct PunctualLight {
    /// The light's name, or its node's.
    pub name: String,
    /// Directional, point or spot.
    pub kind: PunctualKind,
    /// World-space position; directional lights ignore it.
    pub position: Vec3,
    /// World-space unit vector the light travels along: the node's -Z. Point lights ignore it.
    pub direction: Vec3,
    /// Linear RGB colour times intensity, in candela or lux.
    pub color: Vec3,
    /// Distance in metres beyond which a point or spot light is dark.
    pub range: Option<f32>,
}

impl PunctualLight {
    /// The light at `point`: the unit vector towards it, its distance (infinite for directional
    /// lights) and the irradiance on a surface that faces it, with the extension's inverse square,
    /// range window and cone falloff.
    ///
    /// `None` where the light does not reach, and at the light itself.
    #[must_use]
    pub fn at(&self, point: Vec3) -> Option<(Vec3, f32, Vec3)> {
        if self.kind == PunctualKind::Directional {
            return Some((-self.direction, f32::INFINITY, self.color));
        }
        let to_light = self.position - point;
        let distance = to_light.length();
        let towards = to_light.try_normalize()?;
        let window = self.range.map_or(1.0, |range| {
            (1.0 - (distance / range).powi(4)).clamp(0.0, 1.0)
        });
        let cone = match self.kind {
            PunctualKind::Spot {
                inner_cone_angle,
                outer_cone_angle,
            } => {
                let (inner, outer) = (inner_cone_angle.cos(), outer_cone_angle.cos());
                let scale = 1.0 / (inner - outer).max(0.001);
                let t = ((-self.direction.dot(towards) - outer) * scale).clamp(0.0, 1.0);
                t * t
            }
            _ => 1.0,
        };
        let irradiance = self.color * (window * cone / (distance * distance));
        (irradiance.max_element() > 0.0 && irradiance.is_finite())
            .then_some((towards, distance, irradiance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spot_falls_off_in_the_cone_and_the_range() {
        let mut spot = PunctualLight {
            name: String::new(),
            kind: PunctualKind::Spot {
                inner_cone_angle: 0.3,
                outer_cone_angle: 0.6,
            },
            position: Vec3::new(0.0, 2.0, 0.0),
            direction: Vec3::NEG_Y,
            color: Vec3::ONE,
            range: None,
        };
        let below = spot.at(Vec3::ZERO).unwrap();
        assert_eq!(below, (Vec3::Y, 2.0, Vec3::splat(0.25)));
        assert_eq!(spot.at(Vec3::new(2.0 * 0.61_f32.tan(), 0.0, 0.0)), None);
        let edge = spot.at(Vec3::new(2.0 * 0.45_f32.tan(), 0.0, 0.0)).unwrap();
        assert!(edge.2.x > 0.0 && edge.2.x < 0.25 * 0.45_f32.cos().powi(2));
        spot.range = Some(2.0);
        assert_eq!(spot.at(Vec3::ZERO), None);
        assert_eq!(spot.at(spot.position), None);
    }
}
