//! The surface's BRDF in its shading frame: Lambert plus GGX.

use std::f64::consts::FRAC_1_PI;
use std::ops::{Add, AddAssign, Mul};

use glam::DVec3;

use crate::ggx::{ggx_distribution, ggx_visibility, schlick_weight};
use crate::sampling::{
    Random, cosine_density, cosine_hemisphere, ggx_reflection, ggx_reflection_density,
};
use crate::scene::Surface;

/// Cosine given to views at or below the shading horizon, which interpolated normals and normal maps produce.
const LOWEST_VIEW: f64 = 1e-4;

/// Width below which a lobe counts as this wide: a true mirror has no density to sample.
const SMALLEST_ALPHA: f64 = 1e-4;

/// An RGB quantity kept apart by the lobe of the first surface that reflected it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Lobes {
    pub(crate) diffuse: DVec3,
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

/// A surface's BRDF for one view. Directions are unit vectors in world space, away from the surface.
pub(crate) struct Bsdf {
    /// Rows of the rotation into the shading frame; the last is the shading normal.
    world_to_shading: [DVec3; 3],
    view: DVec3,
    diffuse_albedo: DVec3,
    f0: DVec3,
    alpha: [f64; 2],
    /// Share of continued paths that follow the GGX lobe.
    specular_share: f64,
}

impl Bsdf {
    pub(crate) fn new(surface: &Surface, view: DVec3) -> Self {
        let normal = DVec3::from(surface.shading_normal).normalize_or(DVec3::Z);
        let (x, y) = normal.any_orthonormal_pair();
        let world_to_shading = [x, y, normal];
        let view = DVec3::from(world_to_shading.map(|row| row.dot(view)));
        let view = view.with_z(view.z.max(LOWEST_VIEW)).normalize();
        let diffuse_albedo = DVec3::from(surface.diffuse_albedo);
        let f0 = DVec3::from(surface.f0);
        let fresnel = f0 + (DVec3::ONE - f0) * schlick_weight(view.z);
        let (diffuse, specular) = (diffuse_albedo.max_element(), fresnel.max_element());
        let specular_share = match diffuse > 0.0 {
            // Bounded: the estimate is rough, and either lobe may be the one that finds the light.
            true => (specular / (diffuse + specular)).clamp(0.1, 0.9),
            false => 1.0,
        };
        Self {
            world_to_shading,
            view,
            diffuse_albedo,
            f0,
            alpha: [surface.alpha.clamp(SMALLEST_ALPHA, 1.0); 2],
            specular_share,
        }
    }

    pub(crate) fn normal(&self) -> DVec3 {
        self.world_to_shading[2]
    }

    fn has_diffuse(&self) -> bool {
        self.specular_share < 1.0
    }

    fn to_shading(&self, direction: DVec3) -> DVec3 {
        DVec3::from(self.world_to_shading.map(|row| row.dot(direction)))
    }

    fn to_world(&self, direction: DVec3) -> DVec3 {
        let [x, y, z] = self.world_to_shading;
        x * direction.x + y * direction.y + z * direction.z
    }

    /// Each lobe's BRDF times the cosine; zero below the shading horizon.
    pub(crate) fn evaluate(&self, direction: DVec3) -> Lobes {
        let light = self.to_shading(direction);
        if light.z <= 0.0 {
            return Lobes::default();
        }
        let half_vector = self.view + light;
        let fresnel = self.f0 + (DVec3::ONE - self.f0) * schlick_weight(0.5 * half_vector.length());
        let ggx = ggx_distribution(half_vector, self.alpha)
            * ggx_visibility(light, self.view, self.alpha);
        Lobes {
            diffuse: self.diffuse_albedo * FRAC_1_PI * light.z,
            specular: fresnel * ggx * light.z,
        }
    }

    /// One direction from each lobe that reflects anything.
    pub(crate) fn sample_each(&self, random: &mut Random) -> impl Iterator<Item = DVec3> + use<> {
        let cosine = self.to_world(cosine_hemisphere(random.uniform2()));
        let ggx = self.to_world(ggx_reflection(self.view, self.alpha, random.uniform2()));
        self.has_diffuse()
            .then_some(cosine)
            .into_iter()
            .chain([ggx])
    }

    /// Sum of the densities of the directions of [`Bsdf::sample_each`], per steradian.
    pub(crate) fn density_of_each(&self, direction: DVec3) -> f64 {
        let light = self.to_shading(direction);
        let ggx = ggx_reflection_density(self.view, light, self.alpha);
        if self.has_diffuse() {
            cosine_density(light) + ggx
        } else {
            ggx
        }
    }

    /// A direction from one lobe or the other, and each lobe's BRDF times cosine over density; `None` below the horizon.
    pub(crate) fn sample(&self, random: &mut Random) -> Option<(DVec3, Lobes)> {
        let (choice, u) = (random.uniform(), random.uniform2());
        let light = match choice < self.specular_share {
            true => ggx_reflection(self.view, self.alpha, u),
            false => cosine_hemisphere(u),
        };
        if light.z <= 0.0 {
            return None;
        }
        let density = self.specular_share * ggx_reflection_density(self.view, light, self.alpha)
            + (1.0 - self.specular_share) * cosine_density(light);
        let direction = self.to_world(light);
        Some((
            direction,
            self.evaluate(direction) * DVec3::splat(1.0 / density),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_below_the_shading_horizon_stay_finite() {
        for alpha in [0.0, 0.01, 1.0] {
            let surface = Surface {
                position: [0.0; 3],
                geometric_normal: [0.0, 0.0, 1.0],
                shading_normal: [0.0, 0.6, 0.8],
                diffuse_albedo: [0.5; 3],
                f0: [0.04; 3],
                alpha,
                emitted: [0.0; 3],
            };
            let bsdf = Bsdf::new(&surface, DVec3::new(0.0, -0.8, 0.59).normalize());
            let mut random = Random::new(1, 2);
            for _ in 0..1000 {
                if let Some((direction, weight)) = bsdf.sample(&mut random) {
                    assert!(direction.is_normalized() && weight.sum().is_finite());
                    assert!(weight.sum().min_element() >= 0.0 && weight.sum().max_element() < 20.0);
                }
            }
        }
    }
}
