//! The fitted lobe of each BRDF: the one place that knows which table is whose.

use std::sync::LazyLock;

use glam::Vec3;
use lumigon::{AnisotropicLtcTable, Ltc, LtcLobes, LtcSum, LtcTable};

use super::vector;

/// A linearly transformed cosine that keeps no symmetry, in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct AnisotropicLobe {
    /// Rows of the map under which the lobe is the clamped cosine.
    pub(super) world_to_cosine: [Vec3; 3],
    pub(super) amplitudes: Amplitudes,
    /// Share of the lobe above the surface's horizon.
    pub(super) share_above_horizon: f32,
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
    pub(super) fn new(ltc: &Ltc<f32>) -> Self {
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
#[derive(Clone, Debug)]
pub(super) struct FittedBrdf {
    /// Unit normal of the surface.
    pub(super) normal: Vec3,
    lobes: [Ltc<f32>; 2],
    count: usize,
    /// Boxed because few surfaces have it.
    pub(super) anisotropic: Option<Box<AnisotropicLobe>>,
    pub(super) cosine: Amplitudes,
}

impl FittedBrdf {
    #[inline]
    fn isotropic<const LOBES: usize>(sum: &LtcSum<LOBES>, normal: Vec3) -> Self {
        let last = LOBES - 1;
        Self {
            normal,
            lobes: [sum.lobes[0], sum.lobes[last]],
            count: LOBES,
            anisotropic: None,
            cosine: Amplitudes::new(&sum.cosine),
        }
    }

    /// Those that are symmetric about the plane of view and normal, in its frame.
    #[inline]
    pub(super) fn lobes(&self) -> &[Ltc<f32>] {
        &self.lobes[..self.count]
    }

    /// Directional albedos: all that the lobes scatter above the surface's horizon.
    pub(super) fn albedos(&self) -> Amplitudes {
        let mut sum = self.cosine;
        let mut add = |lobe: Amplitudes, share: f32| {
            sum.whole += lobe.whole * share;
            sum.part += lobe.part * share;
        };
        for ltc in self.lobes() {
            add(Amplitudes::new(ltc), ltc.share_above_horizon());
        }
        if let Some(lobe) = &self.anisotropic {
            add(lobe.amplitudes, lobe.share_above_horizon);
        }
        sum
    }
}

/// The tables that ship with the library.
pub(super) struct FittedLobes {
    ggx: LtcTable<1>,
    ggx_2: LtcTable<2>,
    charlie: LtcTable<1>,
    eon: LtcTable<1>,
}

impl FittedLobes {
    pub(super) fn new() -> Self {
        Self {
            ggx: LtcTable::ggx(),
            ggx_2: LtcTable::ggx_2(),
            charlie: LtcTable::charlie(),
            eon: LtcTable::eon(),
        }
    }

    /// GGX of this width, by one lobe and the cosine or by two.
    pub(super) fn ggx(&self, alpha: f32, normal: Vec3, view: Vec3, count: LtcLobes) -> FittedBrdf {
        let (perceptual_roughness, cosine) = (alpha.sqrt(), normal.dot(view));
        match count {
            LtcLobes::One => {
                let sum = self.ggx.lookup(perceptual_roughness, cosine);
                FittedBrdf::isotropic(&sum, normal)
            }
            LtcLobes::Two => {
                let sum = self.ggx_2.lookup(perceptual_roughness, cosine);
                FittedBrdf::isotropic(&sum, normal)
            }
        }
    }

    /// GGX of these widths along and across the unit tangent, always by one lobe.
    pub(super) fn ggx_anisotropic(
        &self,
        alpha: [f32; 2],
        tangent: Vec3,
        normal: Vec3,
        view: Vec3,
    ) -> FittedBrdf {
        // By far the largest table, and few scenes ask for it.
        static TABLE: LazyLock<AnisotropicLtcTable> = LazyLock::new(AnisotropicLtcTable::ggx);
        let bitangent = normal.cross(tangent);
        let in_frame = Vec3::new(tangent.dot(view), bitangent.dot(view), normal.dot(view));
        let ltc = TABLE.lookup(alpha, vector(in_frame));
        let to_world = |[x, y, z]: [f32; 3]| tangent * x + bitangent * y + normal * z;
        let amplitudes = Amplitudes {
            whole: ltc.amplitude,
            part: ltc.schlick,
        };
        FittedBrdf {
            normal,
            lobes: [Ltc::cosine(0.0); 2],
            count: 0,
            anisotropic: Some(Box::new(AnisotropicLobe {
                world_to_cosine: ltc.shading_to_cosine.map(to_world),
                amplitudes,
                share_above_horizon: ltc.share_above_horizon(),
            })),
            cosine: Amplitudes::default(),
        }
    }

    /// Charlie; its albedo may pass 1, for narrow fibres seen along the surface.
    pub(super) fn charlie(&self, alpha: f32, normal: Vec3, view: Vec3) -> FittedBrdf {
        let sum = self.charlie.lookup(alpha.sqrt(), normal.dot(view));
        FittedBrdf::isotropic(&sum, normal)
    }

    /// EON of this roughness: light scattered once, and more than once.
    pub(super) fn eon(&self, roughness: f32, normal: Vec3, view: Vec3) -> FittedBrdf {
        let sum = self.eon.lookup(roughness, normal.dot(view));
        FittedBrdf::isotropic(&sum, normal)
    }
}
