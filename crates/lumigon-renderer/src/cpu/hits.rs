//! What a tile's rays have met, sorted by lobe.

use glam::Vec3;
use lumigon::SpecularMethod;

use super::batch::Batch;
use super::fitted_lobes::{FittedLobe, FittedLobes};
use super::lobes::{Lobes, SpecularLobe};
use crate::scene::SurfaceSample;

/// Fitted lobes, for their integrals over lights: position, surface normal, and the rows of
/// `world_to_cosine`.
pub(super) const FITTED: usize = 15;

/// GGX lobes, for their values in directions: position, normal, view, tangent, and the widths.
pub(super) const DIRECT: usize = 14;

/// One met surface.
pub(super) struct Hit {
    /// Index of the pixel in its tile.
    pub(super) pixel: u32,
    pub(super) lobes: Lobes,
}

/// Every surface the rays of a tile have met. Only lobes that reflect something are listed, so
/// that what a scene does not use costs nothing.
#[derive(Default)]
pub(super) struct Hits {
    surfaces: Vec<Hit>,
    /// Surfaces to gather irradiance: position and normal.
    pub(super) diffuse: Batch<6>,
    /// The base's specular lobe, then the coat's: those of one kind are alike, and so are the
    /// branches they take.
    pub(super) fitted: [Batch<FITTED>; 2],
    /// The same lobes where they are not integrated but evaluated.
    pub(super) direct: [Batch<DIRECT>; 2],
}

impl Hits {
    pub(super) fn push(
        &mut self,
        pixel: u32,
        surface: &SurfaceSample,
        view: Vec3,
        fitted: &FittedLobes,
        method: SpecularMethod,
    ) {
        let index = self.surfaces.len() as u32;
        let lobes = Lobes::new(surface, view, fitted);
        if lobes.diffuse_albedo != Vec3::ZERO {
            let [x, y, z] = lobes.position.to_array();
            let [nx, ny, nz] = lobes.normal.to_array();
            self.diffuse.push(index, [x, y, z, nx, ny, nz]);
        }
        for kind in 0..2 {
            let Some(lobe) = lobes.specular_lobe(kind) else {
                continue;
            };
            if lobe.f0 == Vec3::ZERO && lobe.f90 == Vec3::ZERO {
                continue;
            }
            match method {
                SpecularMethod::None => {}
                SpecularMethod::Ltc => {
                    self.fitted[kind].push(index, lobe.fitted.numbers(lobes.position));
                }
                SpecularMethod::ReflectedInclusion(_) | SpecularMethod::LightVector => {
                    self.direct[kind].push(index, lobe.numbers(lobes.position, view));
                }
            }
        }
        self.surfaces.push(Hit { pixel, lobes });
    }

    pub(super) fn surfaces(&self) -> &[Hit] {
        &self.surfaces
    }

    /// To be called after the last surface.
    pub(super) fn pad(&mut self) {
        self.diffuse.pad();
        self.fitted.iter_mut().for_each(Batch::pad);
        self.direct.iter_mut().for_each(Batch::pad);
    }
}

impl FittedLobe {
    fn numbers(&self, position: Vec3) -> [f32; FITTED] {
        let [a, b, c] = self.world_to_cosine;
        concatenated([position, self.normal, a, b, c])
    }
}

impl SpecularLobe {
    fn numbers(&self, position: Vec3, view: Vec3) -> [f32; DIRECT] {
        let widths = Vec3::new(self.alpha[0], self.alpha[1], 0.0);
        concatenated([position, self.normal, view, self.tangent, widths])
    }
}

/// The first `N` coordinates of vectors.
fn concatenated<const M: usize, const N: usize>(vectors: [Vec3; M]) -> [f32; N] {
    std::array::from_fn(|i| vectors[i / 3][i % 3])
}
