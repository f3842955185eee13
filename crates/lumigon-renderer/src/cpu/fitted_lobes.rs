//! The fitted lobe of each BRDF: the one place that knows which table is whose.

use std::sync::OnceLock;

use glam::Vec3;
use lumigon::{Ltc, LtcTable, charlie_cosine, eon_single_albedo};

/// A linearly transformed cosine in world space.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FittedLobe {
    /// Rows of the map under which the lobe is the clamped cosine.
    pub(super) world_to_cosine: [Vec3; 3],
    pub(super) amplitudes: Amplitudes,
}

/// The responses of one lobe, to be multiplied by its form factor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Amplitudes {
    /// With F = 1; for EON, of light scattered once.
    pub(super) whole: f32,
    /// The same weighted by Schlick's (1 - h.v)^5; for EON, of light scattered more than once.
    pub(super) part: f32,
}

impl Amplitudes {
    fn new(ltc: &Ltc<f32>) -> Self {
        Self {
            whole: ltc.amplitude,
            part: ltc.schlick,
        }
    }

    /// Response where reflectance is `f0` at normal and `f90` at grazing incidence.
    pub(super) fn reflectance(&self, f0: Vec3, f90: Vec3) -> Vec3 {
        f0 * (self.whole - self.part) + f90 * self.part
    }
}

/// One BRDF for one view: the sum of some lobes and of the cosine about the normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct FittedBrdf {
    /// Unit normal of the surface.
    pub(super) normal: Vec3,
    lobes: [FittedLobe; 2],
    count: usize,
    pub(super) cosine: Amplitudes,
    /// Directional albedos.
    pub(super) albedos: Amplitudes,
}

impl FittedBrdf {
    /// Isotropic lobes, in the frame of the view's azimuth.
    fn isotropic(lobes: &[Ltc<f32>], cosine: &Ltc<f32>, normal: Vec3, view: Vec3) -> Self {
        // x leans towards the viewer; any x will do for a view along the normal.
        let tangent = (view - normal * normal.dot(view))
            .try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        let bitangent = normal.cross(tangent);
        let mut brdf = Self {
            normal,
            lobes: [FittedLobe::default(); 2],
            count: lobes.len(),
            cosine: Amplitudes::new(cosine),
            albedos: Amplitudes::new(cosine),
        };
        for (to, ltc) in brdf.lobes.iter_mut().zip(lobes) {
            let [m11, m13, m31, m33] = ltc.shading_to_cosine;
            to.world_to_cosine = [
                tangent * m11 + normal * m13,
                bitangent,
                tangent * m31 + normal * m33,
            ];
            to.amplitudes = Amplitudes::new(ltc);
            let share = ltc.share_above_horizon();
            brdf.albedos.whole += ltc.amplitude * share;
            brdf.albedos.part += ltc.schlick * share;
        }
        brdf
    }

    /// A Lambertian BRDF of this albedo.
    fn lambertian(albedo: f32, normal: Vec3) -> Self {
        let amplitudes = Amplitudes {
            whole: albedo,
            part: 0.0,
        };
        Self {
            normal,
            lobes: [FittedLobe::default(); 2],
            count: 0,
            cosine: amplitudes,
            albedos: amplitudes,
        }
    }

    /// All but the cosine.
    pub(super) fn lobes(&self) -> &[FittedLobe] {
        &self.lobes[..self.count]
    }
}

/// The tables that ship with the library.
pub(super) struct FittedLobes {
    ggx: LtcTable,
}

impl FittedLobes {
    pub(super) fn new() -> Self {
        Self {
            ggx: LtcTable::ggx(),
        }
    }

    /// GGX of this width.
    pub(super) fn ggx(&self, alpha: f32, normal: Vec3, view: Vec3) -> FittedBrdf {
        let ltc = self.ggx.lookup(alpha.sqrt(), normal.dot(view));
        FittedBrdf::isotropic(&[ltc], &NOTHING, normal, view)
    }

    /// GGX of these widths along and across the tangent.
    pub(super) fn ggx_anisotropic(
        &self,
        [along, across]: [f32; 2],
        _tangent: Vec3,
        normal: Vec3,
        view: Vec3,
    ) -> FittedBrdf {
        self.ggx((along * across).sqrt(), normal, view)
    }

    /// Charlie, not yet limited to what it gets: narrow fibres give off more.
    pub(super) fn charlie(&self, alpha: f32, normal: Vec3, view: Vec3) -> FittedBrdf {
        FittedBrdf::lambertian(charlie_albedo(alpha, normal.dot(view)), normal)
    }

    /// EON of this roughness: light scattered once, and more than once.
    pub(super) fn eon(&self, roughness: f32, normal: Vec3, view: Vec3) -> FittedBrdf {
        let single = eon_single_albedo(roughness, normal.dot(view));
        let mut brdf = FittedBrdf::lambertian(single, normal);
        brdf.cosine.part = 1.0 - single;
        brdf.albedos.part = 1.0 - single;
        brdf
    }
}

const NOTHING: Ltc<f32> = Ltc {
    shading_to_cosine: [1.0, 0.0, 0.0, 1.0],
    amplitude: 0.0,
    schlick: 0.0,
};

/// Directional albedo of Charlie, looked up between nodes that are integrated on first use.
fn charlie_albedo(alpha: f32, cos_view: f32) -> f32 {
    const NODES: usize = 24;
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        let node = |i: usize| i as f64 / (NODES - 1) as f64;
        (0..NODES * NODES)
            .map(|i| {
                let (row, column) = (node(i / NODES), node(i % NODES));
                integrated_charlie(row * row, column * column) as f32
            })
            .collect()
    });
    let place = |x: f32| {
        let x = x.clamp(0.0, 1.0).sqrt() * (NODES - 1) as f32;
        let cell = (x as usize).min(NODES - 2);
        (cell, x - cell as f32)
    };
    let ((row, t), (column, s)) = (place(alpha), place(cos_view));
    let at = |i: usize, j: usize| table[(row + i) * NODES + column + j];
    let along = |i: usize| at(i, 0) + (at(i, 1) - at(i, 0)) * s;
    along(0) + (along(1) - along(0)) * t
}

/// Midpoints, in the logarithm of the light's cosine: narrow lobes hug the horizon.
fn integrated_charlie(alpha: f64, cos_view: f64) -> f64 {
    const ROWS: u32 = 96;
    const COLUMNS: u32 = 24;
    let cos_view = cos_view.max(1e-3);
    let normal = lumigon::Vec3::new(0.0, 0.0, 1.0);
    let view = lumigon::Vec3::new((1.0 - cos_view * cos_view).sqrt(), 0.0, cos_view);
    let least = 1e-5_f64.ln();
    let mut sum = 0.0;
    for i in 0..ROWS {
        let cosine = (least * (f64::from(i) + 0.5) / f64::from(ROWS)).exp();
        let sine = (1.0 - cosine * cosine).sqrt();
        for j in 0..COLUMNS {
            let azimuth = std::f64::consts::PI * (f64::from(j) + 0.5) / f64::from(COLUMNS);
            let light = lumigon::Vec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine);
            sum += charlie_cosine(alpha, normal, view, light) * cosine;
        }
    }
    sum * -least * std::f64::consts::TAU / f64::from(ROWS * COLUMNS)
}
