//! What a tile's rays have met, sorted by lobe.

use std::f32::consts::FRAC_1_PI;

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
    /// Radiance from the surface itself.
    pub(super) emitted: Vec3,
}

/// What to keep of the surfaces.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    pub(super) specular: SpecularMethod,
    /// Whether lights without extent will ask for the lobes' values.
    pub(super) punctual: bool,
}

/// Every surface the rays of a tile have met. Only lobes that reflect something are listed, so
/// that what a scene does not use costs nothing.
#[derive(Default)]
pub(super) struct Hits {
    surfaces: Vec<Hit>,
    /// Each surface's lobes, where wanted.
    lobes: Vec<Lobes>,
    /// Surfaces to gather irradiance, position and normal; BRDFs.
    pub(super) diffuse: Batch<6, Vec3>,
    /// The base's specular lobe, then the coat's: those of one kind are alike, and so are the
    /// branches they take. Weights of their form factors.
    pub(super) fitted: [Batch<FITTED, Vec3>; 2],
    /// The same lobes where they are not integrated but evaluated. Reflectances at normal and at
    /// grazing incidence.
    pub(super) direct: [Batch<DIRECT, [Vec3; 2]>; 2],
}

impl Hits {
    pub(super) fn push(
        &mut self,
        pixel: u32,
        surface: &SurfaceSample,
        view: Vec3,
        fitted: &FittedLobes,
        wanted: Wanted,
    ) {
        let index = self.surfaces.len() as u32;
        let lobes = Lobes::new(surface, view, fitted);
        self.surfaces.push(Hit {
            pixel,
            emitted: lobes.emitted,
        });
        if lobes.diffuse_albedo != Vec3::ZERO {
            let numbers = concatenated([lobes.position, lobes.normal]);
            self.diffuse
                .push(index, lobes.diffuse_albedo * FRAC_1_PI, numbers);
        }
        self.specular(index, 0, &lobes, &lobes.specular, wanted.specular);
        if let Some(coat) = &lobes.clearcoat {
            self.specular(index, 1, &lobes, coat, wanted.specular);
        }
        if wanted.punctual {
            self.lobes.push(lobes);
        }
    }

    fn specular(
        &mut self,
        index: u32,
        kind: usize,
        lobes: &Lobes,
        lobe: &SpecularLobe,
        method: SpecularMethod,
    ) {
        if lobe.f0 == Vec3::ZERO && lobe.f90 == Vec3::ZERO {
            return;
        }
        match method {
            SpecularMethod::None => {}
            SpecularMethod::Ltc { .. } => {
                let weight = lobe.fitted.reflectance(lobe.f0, lobe.f90);
                let numbers = lobe.fitted.numbers(lobes.position);
                self.fitted[kind].push(index, weight, numbers);
            }
            SpecularMethod::ReflectedInclusion(_) | SpecularMethod::LightVector => {
                let numbers = lobe.numbers(lobes.position, lobes.view);
                self.direct[kind].push(index, [lobe.f0, lobe.f90], numbers);
            }
        }
    }

    pub(super) fn surfaces(&self) -> &[Hit] {
        &self.surfaces
    }

    /// One for each surface, or none where they were not wanted.
    pub(super) fn lobes(&self) -> &[Lobes] {
        &self.lobes
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
