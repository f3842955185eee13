//! The fitted lobe of each BRDF: the one place that knows which table is whose.

use std::sync::OnceLock;

use glam::Vec3;
use lumigon::{Ltc, LtcTable, charlie_cosine};

/// One BRDF's lobe for one view, in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct FittedLobe {
    /// Rows of the map under which the lobe is the clamped cosine.
    pub(super) world_to_cosine: [Vec3; 3],
    /// Unit normal of the surface.
    pub(super) normal: Vec3,
    /// Response with F = 1, to be multiplied by the form factor.
    pub(super) amplitude: f32,
    /// The same weighted by Schlick's (1 - h.v)^5.
    pub(super) schlick: f32,
    /// Share of the lobe above the horizon.
    share: f32,
}

impl FittedLobe {
    fn isotropic(ltc: &Ltc<f32>, normal: Vec3, view: Vec3) -> Self {
        // x leans towards the viewer; any x will do for a view along the normal.
        let tangent = (view - normal * normal.dot(view))
            .try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        let [m11, m13, m31, m33] = ltc.shading_to_cosine;
        Self {
            world_to_cosine: [
                tangent * m11 + normal * m13,
                normal.cross(tangent),
                tangent * m31 + normal * m33,
            ],
            normal,
            amplitude: ltc.amplitude,
            schlick: ltc.schlick,
            share: ltc.share_above_horizon(),
        }
    }

    /// A Lambertian lobe of this albedo.
    fn cosine(albedo: f32, normal: Vec3, view: Vec3) -> Self {
        Self {
            amplitude: albedo,
            ..Self::isotropic(&Ltc::cosine(1.0), normal, view)
        }
    }

    /// Response where reflectance is `f0` at normal and `f90` at grazing incidence.
    pub(super) fn reflectance(&self, f0: Vec3, f90: Vec3) -> Vec3 {
        f0 * (self.amplitude - self.schlick) + f90 * self.schlick
    }

    /// Reflectance towards the view of light from everywhere.
    pub(super) fn albedo(&self, f0: Vec3, f90: Vec3) -> Vec3 {
        self.reflectance(f0, f90) * self.share
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
    pub(super) fn ggx(&self, alpha: f32, normal: Vec3, view: Vec3) -> FittedLobe {
        let ltc = self.ggx.lookup(alpha.sqrt(), normal.dot(view));
        FittedLobe::isotropic(&ltc, normal, view)
    }

    /// GGX of these widths along and across the tangent.
    pub(super) fn ggx_anisotropic(
        &self,
        [along, across]: [f32; 2],
        _tangent: Vec3,
        normal: Vec3,
        view: Vec3,
    ) -> FittedLobe {
        self.ggx((along * across).sqrt(), normal, view)
    }

    /// Charlie, at most white: where narrow fibres would give off more light than they get, the
    /// whole lobe is scaled down to what they get. The second value is the scale.
    pub(super) fn charlie(&self, alpha: f32, normal: Vec3, view: Vec3) -> (FittedLobe, f32) {
        let albedo = charlie_albedo(alpha, normal.dot(view));
        let scale = 1.0 / albedo.max(1.0);
        (FittedLobe::cosine(albedo * scale, normal, view), scale)
    }
}

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
