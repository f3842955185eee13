//! What is compared: every method with its words and its source.

use lumigon::{
    DiffuseMethod, DistanceFieldSettings, DistanceFieldSmoothness, ImageMethod, InclusionRule,
    LocalOcclusion, LtcLobes, ProjectionBasis, SpecularMethod,
};
use lumigon_renderer::{Pixels, Rendering, Scene};
use serde::Serialize;

/// The part of a rendering that a method is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Part {
    /// Emitted, diffuse and specular light.
    Radiance,
    /// Light scattered by the diffuse lobe.
    Diffuse,
    /// Light scattered by the specular lobe.
    Specular,
}

impl Part {
    /// Every part, in the order of the report.
    pub(super) const ALL: [Self; 3] = [Self::Radiance, Self::Diffuse, Self::Specular];

    /// The part's name in file names.
    pub(super) fn id(self) -> &'static str {
        match self {
            Self::Radiance => "radiance",
            Self::Diffuse => "diffuse",
            Self::Specular => "specular",
        }
    }

    /// What comes after a reference's name.
    pub(super) fn suffix(self) -> &'static str {
        match self {
            Self::Radiance => " without shadows",
            Self::Diffuse => ", diffuse part",
            Self::Specular => ", specular part",
        }
    }

    /// The heading of the part's methods.
    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Radiance => "The whole picture",
            Self::Diffuse => "Diffuse light",
            Self::Specular => "Specular light",
        }
    }

    /// Takes the part out of a rendering.
    pub(super) fn of(self, rendering: Rendering) -> Pixels {
        match self {
            Self::Radiance => rendering.radiance(),
            Self::Diffuse => rendering.diffuse,
            Self::Specular => rendering.specular,
        }
    }
}

/// One method, or one pair of a diffuse and a specular method.
#[derive(Clone, Debug)]
pub(super) struct Method {
    /// Unique; a file name.
    pub(super) id: &'static str,
    /// The method's name.
    pub(super) title: &'static str,
    /// What it is judged by.
    pub(super) part: Part,
    /// How diffuse light is computed meanwhile.
    pub(super) diffuse: DiffuseMethod,
    /// How specular light is computed meanwhile.
    pub(super) specular: SpecularMethod,
    /// How the images on lights are averaged meanwhile.
    pub(super) images: ImageMethod,
    /// What it does, in plain words.
    pub(super) words: &'static str,
    /// Where it was published.
    pub(super) source: &'static str,
}

/// The exact diffuse method's [`Method::id`]: all times are compared to its own.
pub(super) const EXACT: &str = "exact";

const LAMBERT: &str = "J. H. Lambert, Photometria, 1760; in Stokes' form: M. Iwanicki, Deriving \
    the analytical formula for a diffuse response from a polygonal light source; without a \
    clipped polygon after M. M. Stark, Vertex-based Formulations of Irradiance from Polygonal Sources, 2000";
const ARVO: &str = "J. Arvo, The Irradiance Jacobian for Partially Occluded Polyhedral Sources, \
    SIGGRAPH 1994; Polygonal Area Light Sources on DX11-Class Hardware, 2013";
const PETRYAEV: &str =
    "A. Petryaev, Polygons as lights: algebraic approximation of polygonal area lights";
const HEITZ: &str = "E. Heitz, J. Dupuy, S. Hill and D. Neubelt, Real-Time Polygonal-Light \
    Shading with Linearly Transformed Cosines, ACM TOG 35(4), 2016";

const QUADRATURE: &str = "lumigon's own: a product rule at even steps of the weight";

/// The path tracer's words.
pub(super) const REFERENCE_WORDS: &str = "Path traced in double precision: light paths sampled from the \
    lights and from the surfaces, both weighted by multiple importance sampling. It shares no \
    light-integration code with the methods, and knows its own noise.";
/// The path tracer's sources.
pub(super) const REFERENCE_SOURCE: &str = "E. Veach and L. J. Guibas, Optimally Combining Sampling \
    Techniques for Monte Carlo Rendering, SIGGRAPH 1995";

/// Every method that is compared. `bias` is the biased projection's, in scene units; `images`: lights
/// have images, to be averaged in every way.
pub(super) fn methods(bias: f64, images: bool) -> Vec<Method> {
    let mut methods = vec![Method {
        id: "exact-ltc",
        title: "Exact diffuse + LTC specular",
        part: Part::Radiance,
        diffuse: DiffuseMethod::default(),
        specular: SpecularMethod::default(),
        images: ImageMethod::default(),
        words: "What lumigon renders by default: the exact diffuse integral and linearly \
            transformed cosines. There is no noise, and there are no shadows.",
        source: "The two methods below",
    }];
    if images {
        methods.extend(image_methods());
    }
    methods.extend(diffuse_methods(bias));
    methods.extend(specular_methods());
    methods
}

fn image_methods() -> impl Iterator<Item = Method> {
    let rows = [
        (
            "images-lookup",
            "Exact + LTC, images by one lookup",
            ImageMethod::Lookup,
            "Common practice: the image is blurred to levels beforehand, and one is looked up where the \
             light vector meets the light.",
            HEITZ,
        ),
        (
            "images-1x1",
            "Exact + LTC, images by 1 x 1 tap",
            ImageMethod::Quadrature { taps: 1 },
            "One tap where the image's weight is, as wide as the weight.",
            QUADRATURE,
        ),
        (
            "images-3x3",
            "Exact + LTC, images by 3 x 3 taps",
            ImageMethod::Quadrature { taps: 3 },
            "Nine taps instead of the default's four.",
            QUADRATURE,
        ),
        (
            "images-4x4",
            "Exact + LTC, images by 4 x 4 taps",
            ImageMethod::Quadrature { taps: 4 },
            "Sixteen taps instead of the default's four.",
            QUADRATURE,
        ),
    ];
    rows.into_iter()
        .map(|(id, title, images, words, source)| Method {
            id,
            title,
            part: Part::Radiance,
            diffuse: DiffuseMethod::default(),
            specular: SpecularMethod::default(),
            images,
            words,
            source,
        })
}

fn diffuse_methods(bias: f64) -> Vec<Method> {
    use LocalOcclusion::{Circle, Exact};
    let area = |basis, occlusion| DiffuseMethod::ProjectedArea { basis, occlusion };
    let biased = ProjectionBasis::Biased { bias };
    let rows = [
        (
            EXACT,
            "Exact",
            DiffuseMethod::Exact { occlusion: Exact },
            "The integral itself: Stokes' theorem turns it into a sum over the polygon's edges, \
             each weighted by the angle it subtends. The surface's horizon clips the light edge \
             by edge.",
            LAMBERT,
        ),
        (
            "exact-circle",
            "Exact, circle occlusion",
            DiffuseMethod::Exact { occlusion: Circle },
            "The same sum over the whole polygon; what the horizon hides is guessed from the \
             height of the light's circumscribed circle.",
            "Lambert, as above; the circle: A. Petryaev, Polygons as lights",
        ),
        (
            "light-vector",
            "Light vector",
            DiffuseMethod::LightVector { occlusion: Exact },
            "All light is taken to come along the light vector, as from a point light there; its \
             solid angle above the horizon is its strength.",
            ARVO,
        ),
        (
            "light-vector-circle",
            "Light vector, circle occlusion",
            DiffuseMethod::LightVector { occlusion: Circle },
            "The light vector of the whole polygon, scaled by the circle's height above the \
             horizon.",
            ARVO,
        ),
        (
            "projected-area-centroid",
            "Projected area, centroid",
            area(ProjectionBasis::Centroid, Exact),
            "The area of the light in a perspective projection towards its centroid stands for \
             the integral. It has no cosine and a free intensity. The horizon clips exactly.",
            PETRYAEV,
        ),
        (
            "projected-area-weighted",
            "Projected area, weighted",
            area(ProjectionBasis::Weighted, Exact),
            "Projected towards the mean of the vertices weighted by inverse distance.",
            PETRYAEV,
        ),
        (
            "projected-area-biased",
            "Projected area, biased",
            area(biased, Exact),
            "Projected towards the centroid from a point moved back behind the surface, so that \
             more vertices stay in front.",
            PETRYAEV,
        ),
        (
            "projected-area-optimal",
            "Projected area, optimal",
            area(ProjectionBasis::Optimal, Exact),
            "Projected along the axis of the right pyramid, which passes through the centroid of \
             its own cross-section: it exists for every polygon and keeps all vertices in front.",
            "The open problem of A. Petryaev, Polygons as lights, solved",
        ),
        (
            "projected-area-centroid-circle",
            "Projected area, centroid, circle occlusion",
            area(ProjectionBasis::Centroid, Circle),
            "As published: towards the centroid, and the circle's height above the horizon for \
             what the surface itself hides.",
            PETRYAEV,
        ),
        (
            "projected-area-weighted-circle",
            "Projected area, weighted, circle occlusion",
            area(ProjectionBasis::Weighted, Circle),
            "The weighted projection with the circle's height above the horizon.",
            PETRYAEV,
        ),
        (
            "projected-area-biased-circle",
            "Projected area, biased, circle occlusion",
            area(biased, Circle),
            "The biased projection with the circle's height above the horizon.",
            PETRYAEV,
        ),
        (
            "projected-area-optimal-circle",
            "Projected area, optimal, circle occlusion",
            area(ProjectionBasis::Optimal, Circle),
            "The right pyramid's projection with the circle's height above the horizon.",
            "The open problem of A. Petryaev, Polygons as lights, solved",
        ),
    ];
    rows.into_iter()
        .map(|(id, title, diffuse, words, source)| Method {
            id,
            title,
            part: Part::Diffuse,
            diffuse,
            specular: SpecularMethod::None,
            images: ImageMethod::default(),
            words,
            source,
        })
        .collect()
}

fn specular_methods() -> Vec<Method> {
    let rows = [
        (
            "ltc",
            "Linearly transformed cosines",
            SpecularMethod::default(),
            "A fitted linear map turns the reflection's lobe into a cosine; the light, seen \
             through the same map, is then integrated exactly. The fit is the only error.",
            HEITZ,
        ),
        (
            "ltc-2",
            "Linearly transformed cosines, two lobes",
            SpecularMethod::Ltc {
                lobes: LtcLobes::Two,
            },
            "The sum of two transformed cosines, fitted together: closer to the lobe, for a second \
             integral over each light.",
            HEITZ,
        ),
        (
            "specular-light-vector",
            "Light vector",
            SpecularMethod::LightVector,
            "The reflection of a point light along the light vector: highlights are too small and \
             have no shape.",
            ARVO,
        ),
        (
            "reflected-crossing",
            "Reflected ray, crossing number",
            SpecularMethod::ReflectedInclusion(InclusionRule::CrossingNumber),
            "The mirrored view ray either meets the polygon or does not: every surface is a \
             mirror, however rough it is.",
            PETRYAEV,
        ),
        (
            "reflected-winding",
            "Reflected ray, winding number",
            SpecularMethod::ReflectedInclusion(InclusionRule::WindingNumber),
            "The same mirror with the other rule for what is inside; for outlines that do not \
             cross themselves both agree.",
            PETRYAEV,
        ),
        (
            "reflected-distance",
            "Reflected ray, distance field",
            SpecularMethod::ReflectedDistanceField {
                field: DistanceFieldSettings::default(),
                smoothness: DistanceFieldSmoothness::default(),
            },
            "The mirrored view ray meets the polygon's plane some way from the polygon: the nearer, \
             the brighter. The distance is baked once, and smoothed as the reflection's lobe widens.",
            PETRYAEV,
        ),
    ];
    rows.into_iter()
        .map(|(id, title, specular, words, source)| Method {
            id,
            title,
            part: Part::Specular,
            diffuse: DiffuseMethod::default(),
            specular,
            images: ImageMethod::default(),
            words,
            source,
        })
        .collect()
}

/// The bias where none is asked for: half of the median light's radius about its vertices' mean.
pub(super) fn default_bias(scene: &Scene) -> f64 {
    let mut radii: Vec<f64> = scene
        .polygon_lights
        .iter()
        .filter_map(|light| light.loops.first())
        .map(|outline| {
            let vertices = || outline.iter().copied().map(glam::DVec3::from);
            let center = vertices().sum::<glam::DVec3>() / outline.len().max(1) as f64;
            vertices().map(|v| v.distance(center)).fold(0.0, f64::max)
        })
        .filter(|radius| radius.is_finite())
        .collect();
    radii.sort_by(f64::total_cmp);
    radii
        .get(radii.len() / 2)
        .map_or(0.0, |radius| 0.5 * radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_method_has_its_own_name_and_place() {
        let methods = methods(0.25, true);
        let ids: BTreeSet<_> = methods.iter().map(|m| m.id).collect();
        assert_eq!(ids.len(), methods.len());
        let choices: BTreeSet<_> = methods
            .iter()
            .map(|m| format!("{:?} {:?} {:?}", m.diffuse, m.specular, m.images))
            .collect();
        // "Exact + LTC" and "LTC" are one rendering, judged by different parts.
        assert_eq!(choices.len(), methods.len() - 1);
        assert!(
            methods
                .iter()
                .any(|m| m.id == EXACT && m.part == Part::Diffuse)
        );
        assert!(methods.is_sorted_by_key(|m| m.part));
    }

    #[test]
    fn bias_follows_the_lights_size() {
        assert_eq!(default_bias(&Scene::default()), 0.0);
    }
}
