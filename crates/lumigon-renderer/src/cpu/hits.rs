//! What a tile's rays have met, sorted by lobe.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use lumigon::{DiffuseMethod, SpecularMethod};

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
    pub(super) diffuse: DiffuseMethod,
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
    /// Surfaces to gather irradiance: position and normal. BRDFs.
    pub(super) diffuse: Batch<6, Vec3>,
    /// Rough diffuse lobes to evaluate: position, normal, view and roughness. Weights of light
    /// scattered once and more than once.
    pub(super) rough: Batch<10, [Vec3; 2]>,
    /// The base's specular lobes, the sheens and the coats: those of one kind are alike, and so
    /// are the branches they take. Weights of their form factors.
    pub(super) fitted: [Batch<FITTED, Vec3>; 3],
    /// GGX lobes to evaluate, base and coat. Reflectances at normal and at grazing incidence.
    pub(super) direct: [Batch<DIRECT, [Vec3; 2]>; 2],
    /// Those whose two widths differ.
    pub(super) direct_anisotropic: Batch<DIRECT, [Vec3; 2]>,
    /// Sheens to evaluate: they have no SIMD form.
    pub(super) sheens: Vec<(u32, Lobes)>,
}

/// Indices into [`Hits::fitted`].
const SHEEN: usize = 1;
const COAT: usize = 2;

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
        self.diffuse(index, &lobes, wanted.diffuse);
        self.specular(index, 0, &lobes, &lobes.specular, wanted.specular);
        if let Some(sheen) = &lobes.sheen {
            match wanted.specular {
                SpecularMethod::None => {}
                SpecularMethod::Ltc { .. } => {
                    let numbers = sheen.fitted.numbers(lobes.position);
                    let weight = sheen.weight * sheen.fitted.amplitude;
                    self.fitted[SHEEN].push(index, weight, numbers);
                }
                SpecularMethod::ReflectedInclusion(_) | SpecularMethod::LightVector => {
                    self.sheens.push((index, lobes));
                }
            }
        }
        if let Some(coat) = &lobes.clearcoat {
            self.specular(index, COAT, &lobes, coat, wanted.specular);
        }
        if wanted.punctual {
            self.lobes.push(lobes);
        }
    }

    fn diffuse(&mut self, index: u32, lobes: &Lobes, method: DiffuseMethod) {
        let lobe = &lobes.diffuse;
        if lobe.is_black() {
            return;
        }
        if lobe.roughness > 0.0 && matches!(method, DiffuseMethod::LightVector { .. }) {
            let roughness = Vec3::splat(lobe.roughness);
            let numbers = concatenated([lobes.position, lobes.normal, lobes.view, roughness]);
            let weights = [lobe.single, lobe.multiple];
            self.rough.push(index, weights, numbers);
        } else {
            // What yields irradiance alone lights a rough surface as a smooth one of its albedo.
            let albedo = lobe.albedo(lobes.normal.dot(lobes.view));
            let numbers = concatenated([lobes.position, lobes.normal]);
            self.diffuse.push(index, albedo * FRAC_1_PI, numbers);
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
                let batch = match (lobe.is_isotropic(), kind) {
                    (false, _) => &mut self.direct_anisotropic,
                    (true, COAT) => &mut self.direct[1],
                    (true, _) => &mut self.direct[0],
                };
                batch.push(index, [lobe.f0, lobe.f90], numbers);
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
        self.rough.pad();
        self.direct_anisotropic.pad();
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
