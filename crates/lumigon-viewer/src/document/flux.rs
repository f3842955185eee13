//! Units of light.
//!
//! A Lambertian emitter of area A and radiance L sends Φ = π A L from each side that emits. Radiance and
//! luminance are one number here: glTF's emission is in nits (`KHR_materials_emissive_strength`), so a
//! channel of 1 is 1 cd m⁻², and what a light sends is in lumens. A scene whose radiances are meant in
//! W m⁻² sr⁻¹ has the same numbers in watts.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::{Document, Light, LightId};

/// Luminance of linear red, green and blue of ITU-R BT.709, which add up to 1.
pub const LUMINANCE_WEIGHTS: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// The luminance of a linear RGB radiance, in nits.
#[must_use]
pub fn luminance(radiance: Vec3) -> f64 {
    radiance.as_dvec3().dot(LUMINANCE_WEIGHTS)
}

/// The mean of the channels: the radiance of a light of no colour, in W m⁻² sr⁻¹.
#[must_use]
pub fn mean_radiance(radiance: Vec3) -> f64 {
    radiance.as_dvec3().element_sum() / 3.0
}

/// A radiance as its colour, the largest channel 1, and that channel; black is white of strength 0.
#[must_use]
pub fn color_and_strength(radiance: Vec3) -> (Vec3, f32) {
    let strength = radiance.max_element();
    if strength > 0.0 && strength.is_finite() {
        (radiance / strength, strength)
    } else {
        (Vec3::ONE, 0.0)
    }
}

/// What a Lambertian emitter sends: lumens for a luminance in nits, watts for a radiance. `area` in
/// square metres, of one side.
#[must_use]
pub fn flux(radiance: f64, area: f64, two_sided: bool) -> f64 {
    let sides = if two_sided { 2.0 } else { 1.0 };
    PI * area * radiance * sides
}

/// The inverse of [`flux`]; `None` without area.
#[must_use]
pub fn radiance_of_flux(flux_: f64, area: f64, two_sided: bool) -> Option<f64> {
    let radiance = flux_ / flux(1.0, area, two_sided);
    (area > 0.0 && radiance.is_finite()).then_some(radiance)
}

/// A radiance of the same colour whose luminance, in nits, is what is asked; white where it was black.
#[must_use]
pub fn with_luminance(radiance: Vec3, nits: f64) -> Vec3 {
    scaled(radiance, nits / luminance(color_and_strength(radiance).0))
}

/// A radiance of the same colour whose mean over the channels is what is asked; white where it was black.
#[must_use]
pub fn with_mean_radiance(radiance: Vec3, mean: f64) -> Vec3 {
    scaled(
        radiance,
        mean / mean_radiance(color_and_strength(radiance).0),
    )
}

fn scaled(radiance: Vec3, strength: f64) -> Vec3 {
    (color_and_strength(radiance).0.as_dvec3() * strength).as_vec3()
}

impl Light {
    /// Lumens that it sends, without a picture.
    #[must_use]
    pub fn lumens(&self) -> f64 {
        flux(luminance(self.radiance), self.area(), self.two_sided)
    }

    /// Watts that it sends, without a picture, where radiance is in W m⁻² sr⁻¹.
    #[must_use]
    pub fn watts(&self) -> f64 {
        flux(mean_radiance(self.radiance), self.area(), self.two_sided)
    }

    /// The light in the same colour, sending so many lumens without a picture. `None` where that is
    /// negative or not finite, or it has no area.
    #[must_use]
    pub fn with_lumens(&self, lumens: f64) -> Option<Self> {
        let nits = radiance_of_flux(lumens, self.area(), self.two_sided)?;
        self.with_radiance(with_luminance(self.radiance, nits))
    }

    /// The light in the same colour, sending so many watts without a picture. `None` as for
    /// [`Light::with_lumens`].
    #[must_use]
    pub fn with_watts(&self, watts: f64) -> Option<Self> {
        let mean = radiance_of_flux(watts, self.area(), self.two_sided)?;
        self.with_radiance(with_mean_radiance(self.radiance, mean))
    }

    /// The light with another radiance; `None` where that is negative or not finite.
    #[must_use]
    pub fn with_radiance(&self, radiance: Vec3) -> Option<Self> {
        let is_radiance = radiance.is_finite() && radiance.min_element() >= 0.0;
        is_radiance.then(|| Self {
            radiance,
            ..self.clone()
        })
    }
}

impl<S: Clone + PartialEq> Document<S> {
    /// What a light sends in all, linear RGB, its picture included: π times area times mean radiance,
    /// of both sides where it has two. [`luminance`] of it is in lumens, [`mean_radiance`] of it in watts.
    #[must_use]
    pub fn flux_of(&self, id: LightId) -> DVec3 {
        self.scene.polygon_lights[self.polygons_of(id)]
            .iter()
            .map(|polygon| {
                polygon.radiance.as_dvec3() * flux(1.0, polygon.area(), polygon.two_sided)
            })
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Preset, plane_frame};

    #[test]
    fn a_square_metre_of_1000_nits() {
        let preset = Preset::Rectangle {
            width: 1.0,
            height: 1.0,
        };
        let mut light = preset.light(plane_frame(DVec3::ZERO, DVec3::Y)).unwrap();
        light.radiance = Vec3::splat(1000.0);
        assert!((light.lumens() - 1000.0 * PI).abs() < 1e-9);
        assert!((light.watts() - 1000.0 * PI).abs() < 1e-9);
        light.two_sided = true;
        assert!((light.lumens() - 2000.0 * PI).abs() < 1e-9);
        light.radiance = Vec3::new(0.0, 5.0, 0.0);
        assert!((light.lumens() - 2.0 * PI * 5.0 * 0.7152).abs() < 1e-6);
        let brighter = light.with_lumens(800.0).unwrap();
        assert!((brighter.lumens() - 800.0).abs() < 1e-3);
        assert_eq!((brighter.radiance.x, brighter.radiance.z), (0.0, 0.0));
        assert!((light.with_watts(60.0).unwrap().watts() - 60.0).abs() < 1e-4);
    }

    #[test]
    fn black_becomes_white_and_nonsense_is_refused() {
        let preset = Preset::Disk { diameter: 1.0 };
        let mut light = preset.light(plane_frame(DVec3::ZERO, DVec3::Y)).unwrap();
        light.radiance = Vec3::ZERO;
        assert_eq!(color_and_strength(light.radiance), (Vec3::ONE, 0.0));
        let lit = light.with_lumens(100.0).unwrap();
        assert_eq!(lit.radiance.x, lit.radiance.y);
        assert!((lit.lumens() - 100.0).abs() < 1e-4);
        assert_eq!(lit.with_lumens(0.0).unwrap().radiance, Vec3::ZERO);
        for bad in [-1.0, f64::NAN, f64::INFINITY, 1e300] {
            assert!(light.with_lumens(bad).is_none(), "{bad}");
        }
        light.loops.clear();
        assert!(light.with_lumens(1.0).is_none());
    }
}
