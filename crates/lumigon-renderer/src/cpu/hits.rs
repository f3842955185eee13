//! What a tile's rays have met, in the order SIMD lanes want it.

use glam::Vec3;
use lumigon::LtcTable;

use crate::scene::SurfaceSample;

/// Reflectance of dielectrics at normal incidence: glTF's fixed index of refraction, 1.5.
const DIELECTRIC_F0: f32 = 0.04;

/// Most lanes a processor has: lists are padded to a multiple, so that the last packet is full.
pub(super) const PADDING: usize = 16;

/// A material at one point, as its two lobes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lobes {
    /// Lambertian reflectance: what of the base colour is neither metal nor reflected before it
    /// gets in.
    pub(super) diffuse_albedo: [f32; 3],
    /// Reflectance at normal incidence.
    pub(super) f0: [f32; 3],
    /// GGX width.
    pub(super) alpha: f32,
}

impl Lobes {
    pub(super) fn new(surface: &SurfaceSample) -> Self {
        if surface.unlit {
            return Self::default();
        }
        let metallic = surface.metallic.clamp(0.0, 1.0);
        let perceptual_roughness = surface.perceptual_roughness.clamp(0.0, 1.0);
        let base = surface.base_color.clamp(Vec3::ZERO, Vec3::ONE);
        let diffuse_albedo = base * (1.0 - metallic) * (1.0 - DIELECTRIC_F0);
        let f0 = Vec3::splat(DIELECTRIC_F0).lerp(base, metallic);
        Self {
            diffuse_albedo: diffuse_albedo.to_array(),
            f0: f0.to_array(),
            alpha: perceptual_roughness * perceptual_roughness,
        }
    }
}

/// Radiance a surface sends to the viewer by itself.
pub(super) fn emitted(surface: &SurfaceSample) -> [f32; 3] {
    if surface.unlit {
        surface.base_color.to_array()
    } else {
        surface.emissive.to_array()
    }
}

/// One met surface.
pub(super) struct Hit {
    /// Index of the pixel in its tile.
    pub(super) pixel: u32,
    pub(super) emitted: [f32; 3],
    pub(super) lobes: Lobes,
}

/// Three lists of coordinates.
#[derive(Default)]
pub(super) struct Coordinates {
    pub(super) x: Vec<f32>,
    pub(super) y: Vec<f32>,
    pub(super) z: Vec<f32>,
}

impl Coordinates {
    fn push(&mut self, v: Vec3) {
        self.x.push(v.x);
        self.y.push(v.y);
        self.z.push(v.z);
    }
}

/// Every surface the rays of a tile have met.
#[derive(Default)]
pub(super) struct Hits {
    surfaces: Vec<Hit>,
    pub(super) position: Coordinates,
    pub(super) normal: Coordinates,
    /// Unit vector to the viewer.
    pub(super) view: Coordinates,
    pub(super) alpha: Vec<f32>,
    /// `shading_to_cosine` and the two amplitudes of the GGX lobe, where looked up.
    pub(super) ltc: [Vec<f32>; 6],
}

impl Hits {
    pub(super) fn push(&mut self, pixel: u32, surface: &SurfaceSample, view: Vec3) {
        let lobes = Lobes::new(surface);
        self.surfaces.push(Hit {
            pixel,
            emitted: emitted(surface),
            lobes,
        });
        self.position.push(surface.position);
        self.normal.push(surface.shading_normal);
        self.view.push(view);
        self.alpha.push(lobes.alpha);
    }

    pub(super) fn surfaces(&self) -> &[Hit] {
        &self.surfaces
    }

    /// Fills in the lobes.
    pub(super) fn look_up(&mut self, table: &LtcTable) {
        for (i, hit) in self.surfaces.iter().enumerate() {
            let cos_view = self.normal.x[i] * self.view.x[i]
                + self.normal.y[i] * self.view.y[i]
                + self.normal.z[i] * self.view.z[i];
            let lobe = table.lookup(hit.lobes.alpha.sqrt(), cos_view);
            let [m11, m13, m31, m33] = lobe.shading_to_cosine;
            let numbers = [m11, m13, m31, m33, lobe.amplitude, lobe.schlick];
            for (list, number) in self.ltc.iter_mut().zip(numbers) {
                list.push(number);
            }
        }
    }

    /// Lanes from `start` on, the last ones repeated beyond the end.
    pub(super) fn packet(list: &[f32], start: usize) -> [f32; PADDING] {
        let mut packet = [0.0; PADDING];
        let end = list.len().min(start + PADDING);
        let count = end - start;
        packet[..count].copy_from_slice(&list[start..end]);
        packet[count..].fill(list[end - 1]);
        packet
    }
}
