//! What a tile's rays have met, sorted by lobe.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use lumigon::{DiffuseMethod, LocalOcclusion, Ltc, LtcLobes, SpecularMethod};

use super::batch::Batch;
use super::fitted_lobes::{Amplitudes, AnisotropicLobe, FittedBrdf, FittedLobes};
use super::lobes::{Lobes, Scattered, SheenLobe, SpecularLobe};
use crate::scene::SurfaceSample;

/// Fitted lobes, for their integrals over lights: position, surface normal, view and
/// `shading_to_cosine`.
pub(super) const FITTED: usize = 13;

/// The same without symmetry: position, surface normal, and the rows of `world_to_cosine`.
pub(super) const FITTED_ANISOTROPIC: usize = 15;

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
    /// Whether the lobes will be asked for: by lights without extent, and by rays to lights.
    pub(super) lobes: bool,
}

/// Every surface the rays of a tile have met. Only lobes that reflect something are listed, so
/// that what a scene does not use costs nothing.
#[derive(Default)]
pub(super) struct Hits {
    surfaces: Vec<Hit>,
    /// Each surface's lobes, where wanted.
    lobes: Vec<Lobes>,
    /// Surfaces to gather irradiance by the method that is wanted: position and normal. What they
    /// scatter of it.
    pub(super) irradiance: Batch<6, Scattered>,
    /// The same where it has to be exact.
    pub(super) exact_irradiance: Batch<6, Scattered>,
    /// Rough diffuse lobes to evaluate: position, normal, view and roughness. Weights of light
    /// scattered once and more than once.
    pub(super) rough: Batch<10, [Vec3; 2]>,
    /// Fitted lobes of rough diffuse surfaces, of the base's specular layer, of sheens and of
    /// coats: those of one kind are alike, and so are the branches they take. Weights of their form
    /// factors.
    pub(super) fitted: [Batch<FITTED, Scattered>; 4],
    /// Those whose two widths differ.
    pub(super) fitted_anisotropic: Batch<FITTED_ANISOTROPIC, Scattered>,
    /// GGX lobes to evaluate, base and coat. Reflectances at normal and at grazing incidence.
    pub(super) direct: [Batch<DIRECT, [Vec3; 2]>; 2],
    /// Those whose two widths differ.
    pub(super) direct_anisotropic: Batch<DIRECT, [Vec3; 2]>,
    /// Sheens to evaluate: they have no SIMD form.
    pub(super) sheens: Vec<(u32, Lobes)>,
}

/// Indices into [`Hits::fitted`].
const DIFFUSE: usize = 0;
const SPECULAR: usize = 1;
const SHEEN: usize = 2;
const COAT: usize = 3;

/// The method whose irradiance is the integral itself.
const EXACT: DiffuseMethod = DiffuseMethod::Exact {
    occlusion: LocalOcclusion::Exact,
};

impl Hits {
    /// Forgets every surface, but keeps the memory for the next ones.
    pub(super) fn clear(&mut self) {
        self.surfaces.clear();
        self.lobes.clear();
        self.irradiance.clear();
        self.exact_irradiance.clear();
        self.rough.clear();
        self.fitted.iter_mut().for_each(Batch::clear);
        self.fitted_anisotropic.clear();
        self.direct.iter_mut().for_each(Batch::clear);
        self.direct_anisotropic.clear();
        self.sheens.clear();
    }

    pub(super) fn push(
        &mut self,
        pixel: u32,
        surface: &SurfaceSample,
        view: Vec3,
        fitted: &FittedLobes,
        wanted: Wanted,
    ) {
        let index = self.surfaces.len() as u32;
        let count = match wanted.specular {
            SpecularMethod::Ltc { lobes } => lobes,
            _ => LtcLobes::One,
        };
        let lobes = Lobes::new(surface, view, fitted, count);
        self.surfaces.push(Hit {
            pixel,
            emitted: lobes.emitted,
        });
        // Cosines about the shading normal share one irradiance.
        let mut cosine = Scattered::default();
        let mut lambertian = Scattered::default();
        self.diffuse(index, &lobes, wanted.diffuse, &mut lambertian, &mut cosine);
        self.specular(index, &lobes, wanted.specular, &mut cosine);
        let at_normal = concatenated([lobes.position, lobes.normal]);
        if wanted.diffuse == EXACT {
            lambertian += cosine;
        } else if !cosine.is_black() {
            self.exact_irradiance.push(index, cosine, at_normal);
        }
        if !lambertian.is_black() {
            self.irradiance.push(index, lambertian, at_normal);
        }
        if wanted.lobes {
            self.lobes.push(lobes);
        }
    }

    fn diffuse(
        &mut self,
        index: u32,
        lobes: &Lobes,
        method: DiffuseMethod,
        lambertian: &mut Scattered,
        cosine: &mut Scattered,
    ) {
        let lobe = &lobes.diffuse;
        match (&lobe.rough, method) {
            (Some(rough), DiffuseMethod::LightVector { .. }) => {
                let roughness = Vec3::splat(rough.roughness);
                let numbers = concatenated([lobes.position, lobes.normal, lobes.view, roughness]);
                self.rough
                    .push(index, [lobe.single, rough.multiple], numbers);
            }
            (Some(rough), EXACT) => {
                let weight = |amplitudes: &Amplitudes| {
                    lobe.single * amplitudes.whole + rough.multiple * amplitudes.part
                };
                for ltc in rough.fitted.lobes() {
                    let numbers = numbers(ltc, lobes.position, lobes.normal, lobes.view);
                    let weight = Scattered::diffuse(weight(&Amplitudes::new(ltc)));
                    self.fitted[DIFFUSE].push(index, weight, numbers);
                }
                cosine.diffuse += weight(&rough.fitted.cosine) * FRAC_1_PI;
            }
            // What yields irradiance alone lights a rough surface as a smooth one of its albedo.
            _ => lambertian.diffuse += lobe.albedo() * FRAC_1_PI,
        }
    }

    fn specular(
        &mut self,
        index: u32,
        lobes: &Lobes,
        method: SpecularMethod,
        cosine: &mut Scattered,
    ) {
        match method {
            SpecularMethod::None => {}
            SpecularMethod::Ltc { .. } => {
                let base = &lobes.specular;
                self.fit(
                    index,
                    SPECULAR,
                    lobes,
                    &base.fitted,
                    [base.f0, base.f90],
                    cosine,
                );
                if let Some(SheenLobe { weight, fitted, .. }) = lobes.sheen.as_deref() {
                    self.fit(index, SHEEN, lobes, fitted, [*weight; 2], cosine);
                }
                if let Some(coat) = &lobes.clearcoat {
                    let mut about_coat = Scattered::default();
                    let reflectances = [coat.f0, coat.f90];
                    self.fit(
                        index,
                        COAT,
                        lobes,
                        &coat.fitted,
                        reflectances,
                        &mut about_coat,
                    );
                    if coat.normal == lobes.normal {
                        *cosine += about_coat;
                    } else if !about_coat.is_black() {
                        let numbers = concatenated([lobes.position, coat.normal]);
                        self.exact_irradiance.push(index, about_coat, numbers);
                    }
                }
            }
            SpecularMethod::ReflectedInclusion(_)
            | SpecularMethod::ReflectedDistanceField { .. }
            | SpecularMethod::LightVector => {
                let coat = lobes.clearcoat.as_deref().map(|coat| (1, coat));
                for (kind, lobe) in [(0, &lobes.specular)].into_iter().chain(coat) {
                    if lobe.f0 == Vec3::ZERO && lobe.f90 == Vec3::ZERO {
                        continue;
                    }
                    let batch = match lobe.is_isotropic() {
                        true => &mut self.direct[kind],
                        false => &mut self.direct_anisotropic,
                    };
                    let numbers = lobe.numbers(lobes.position, lobes.view);
                    batch.push(index, [lobe.f0, lobe.f90], numbers);
                }
                if lobes.sheen.is_some() {
                    self.sheens.push((index, lobes.clone()));
                }
            }
        }
    }

    /// Lists the fitted lobes of one specular BRDF, and adds what it has of the cosine.
    fn fit(
        &mut self,
        index: u32,
        kind: usize,
        lobes: &Lobes,
        fitted: &FittedBrdf,
        [f0, f90]: [Vec3; 2],
        cosine: &mut Scattered,
    ) {
        if f0 == Vec3::ZERO && f90 == Vec3::ZERO {
            return;
        }
        for ltc in fitted.lobes() {
            let weight = Scattered::specular(Amplitudes::new(ltc).reflectance(f0, f90));
            let numbers = numbers(ltc, lobes.position, fitted.normal, lobes.view);
            self.fitted[kind].push(index, weight, numbers);
        }
        if let Some(lobe) = &fitted.anisotropic {
            let weight = Scattered::specular(lobe.amplitudes.reflectance(f0, f90));
            let numbers = lobe.numbers(lobes.position, fitted.normal);
            self.fitted_anisotropic.push(index, weight, numbers);
        }
        cosine.specular += fitted.cosine.reflectance(f0, f90) * FRAC_1_PI;
    }

    pub(super) fn surfaces(&self) -> &[Hit] {
        &self.surfaces
    }

    /// One for each surface, or none where they were not wanted.
    pub(super) fn lobes(&self) -> &[Lobes] {
        &self.lobes
    }
}

#[inline]
fn numbers(ltc: &Ltc<f32>, position: Vec3, normal: Vec3, view: Vec3) -> [f32; FITTED] {
    let [m11, m13, m31, m33] = ltc.shading_to_cosine;
    let (first, last) = (Vec3::new(m11, m13, m31), Vec3::new(m33, 0.0, 0.0));
    concatenated([position, normal, view, first, last])
}

impl AnisotropicLobe {
    fn numbers(&self, position: Vec3, normal: Vec3) -> [f32; FITTED_ANISOTROPIC] {
        let [a, b, c] = self.world_to_cosine;
        concatenated([position, normal, a, b, c])
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
