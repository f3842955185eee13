//! The methods that light pictures, as the constants of a pipeline.

use lumigon::{
    DiffuseMethod, ImageMethod, InclusionRule, LocalOcclusion, LtcLobes, ProjectionBasis,
    SpecularMethod,
};

use super::scene_buffers::Features;
use crate::render::RenderSettings;

/// What a pipeline is made for: equal methods share one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Methods {
    diffuse: u32,
    basis: u32,
    circle_occlusion: bool,
    specular: u32,
    two_lobes: bool,
    by_winding_number: bool,
    culls_lights: bool,
    has_images: bool,
    conventional_images: bool,
    traces_lights: bool,
}

impl Methods {
    /// For lights of which some have images, or none, and which surfaces block, or not.
    pub(super) fn new(settings: &RenderSettings, has_images: bool, traces_lights: bool) -> Self {
        // The numbers are the shaders' DIFFUSE, BASIS and SPECULAR constants.
        let (diffuse, basis, occlusion) = match settings.diffuse {
            DiffuseMethod::Exact { occlusion } => (0, 0, occlusion),
            DiffuseMethod::LightVector { occlusion } => (1, 0, occlusion),
            DiffuseMethod::ProjectedArea { basis, occlusion } => {
                let basis = match basis {
                    ProjectionBasis::Centroid => 0,
                    ProjectionBasis::Weighted => 1,
                    ProjectionBasis::Biased { .. } => 2,
                    ProjectionBasis::Optimal => 3,
                };
                (2, basis, occlusion)
            }
        };
        let specular = match settings.specular {
            SpecularMethod::None => 0,
            SpecularMethod::Ltc { .. } => 1,
            SpecularMethod::ReflectedInclusion(_) => 2,
            SpecularMethod::LightVector => 3,
            SpecularMethod::ReflectedDistanceField { .. } => 4,
        };
        let circle_occlusion = occlusion == LocalOcclusion::Circle;
        // Bounds hold for the integrals themselves.
        let bounded = diffuse == 0 && !circle_occlusion && specular < 2;
        Self {
            diffuse,
            basis,
            circle_occlusion,
            specular,
            two_lobes: matches!(
                settings.specular,
                SpecularMethod::Ltc {
                    lobes: LtcLobes::Two
                }
            ),
            by_winding_number: matches!(
                settings.specular,
                SpecularMethod::ReflectedInclusion(InclusionRule::WindingNumber)
            ),
            culls_lights: settings.light_bound > 0.0 && bounded,
            has_images,
            conventional_images: has_images && settings.image_method == ImageMethod::Lookup,
            traces_lights,
        }
    }

    /// How often a pixel averages a light's image, at most.
    pub(super) fn image_means(self, features: Features) -> u64 {
        let [coats, sheens, rough] = [
            features.clearcoat,
            features.sheen,
            features.diffuse_roughness,
        ]
        .map(u64::from);
        let lobes = if self.two_lobes { 2 } else { 1 };
        2 + lobes * (1 + coats) + coats + sheens + rough
    }

    /// Whether surfaces block light.
    pub(super) fn traces_lights(self) -> bool {
        self.traces_lights
    }

    /// Whether lights that add too little are left out.
    pub(super) fn culls_lights(self) -> bool {
        self.culls_lights
    }

    /// How often a pixel goes through a light's edges, at most.
    pub(super) fn walks(self, features: Features) -> u64 {
        // The pyramid is found in some five passes, and seldom in ten times as many.
        let diffuse = match (self.diffuse, self.basis) {
            (0, _) => 1,
            (2, 3) => 50,
            _ => 3,
        };
        let lobe = match self.specular {
            0 => 0,
            1 if self.two_lobes => 2,
            1 | 2 => 1,
            // Fields are read without edges.
            4 => 0,
            // Vector and solid angle.
            _ => 2,
        };
        let [coats, sheens, rough] = [
            features.clearcoat,
            features.sheen,
            features.diffuse_roughness,
        ]
        .map(u64::from);
        // One more for what tables have of the cosine, about both normals.
        diffuse + lobe * (1 + coats) + 1 + coats + 2 * sheens + 2 * rough
    }

    /// The shader's constants.
    pub(super) fn constants(self) -> [(&'static str, f64); 9] {
        [
            ("DIFFUSE_METHOD", f64::from(self.diffuse)),
            ("PROJECTION_BASIS", f64::from(self.basis)),
            ("CIRCLE_OCCLUSION", f64::from(self.circle_occlusion)),
            ("SPECULAR_METHOD", f64::from(self.specular)),
            ("TWO_LOBES", f64::from(self.two_lobes)),
            ("BY_WINDING_NUMBER", f64::from(self.by_winding_number)),
            ("CULLS_LIGHTS", f64::from(self.culls_lights)),
            ("HAS_IMAGES", f64::from(self.has_images)),
            ("CONVENTIONAL_IMAGES", f64::from(self.conventional_images)),
        ]
    }
}

/// How far behind the shading point a biased projection is, in scene units; 0 for others.
pub(super) fn bias(method: DiffuseMethod) -> f32 {
    match method {
        DiffuseMethod::ProjectedArea {
            basis: ProjectionBasis::Biased { bias },
            ..
        } => bias as f32,
        _ => 0.0,
    }
}
