//! The fitted lobe of each BRDF: the one place that knows which table is whose.

use glam::Vec3;
use lumigon::{Ltc, LtcTable, PreparedLtc};

use super::vector;

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
        let rows = PreparedLtc::new(ltc, vector(normal), vector(view)).world_to_cosine();
        Self {
            world_to_cosine: rows.map(|row| Vec3::new(row.x, row.y, row.z)),
            normal,
            amplitude: ltc.amplitude,
            schlick: ltc.schlick,
            share: ltc.share_above_horizon(),
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
}
