//! What is integrated over a light's directions.

use glam::{DVec2, DVec3};

use crate::charlie::{charlie_distribution, charlie_visibility_cosine};
use crate::cubature::CubatureError;
use crate::eon::eon;
use crate::ggx::{ggx_distribution, ggx_visibility, schlick_weight};
use crate::quadrature::{Integrand, SMOOTH_ANGLE, edge_lengths};

pub(crate) struct One;

impl Integrand<1> for One {
    fn evaluate(&self, _: DVec3) -> [f64; 1] {
        [1.0]
    }

    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        edge_lengths(triangle).map(|length| length / SMOOTH_ANGLE)
    }
}

pub(crate) struct Cosine;

impl Integrand<1> for Cosine {
    fn evaluate(&self, direction: DVec3) -> [f64; 1] {
        [direction.z]
    }

    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        One.edge_extents(triangle)
    }
}

pub(crate) struct Direction;

impl Integrand<3> for Direction {
    fn evaluate(&self, direction: DVec3) -> [f64; 3] {
        direction.into()
    }

    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        One.edge_extents(triangle)
    }
}

/// The GGX lobe times the cosine at the light, in the shading frame.
pub(crate) struct GgxLobe {
    pub(crate) view: DVec3,
    alpha: [f64; 2],
}

impl GgxLobe {
    pub(crate) fn new(view: DVec3, alpha: [f64; 2]) -> Result<Self, CubatureError> {
        match alpha.iter().find(|&&a| !is_alpha(a)) {
            None => Ok(Self { view, alpha }),
            Some(&wrong) => Err(CubatureError::Alpha(wrong)),
        }
    }
}

fn is_alpha(alpha: f64) -> bool {
    alpha > 0.0 && alpha <= 1.0
}

impl Integrand<2> for GgxLobe {
    fn evaluate(&self, direction: DVec3) -> [f64; 2] {
        // Rounding may put a direction of the horizon just below it.
        let light = direction.with_z(direction.z.max(0.0));
        let half_vector = direction + self.view;
        let value = ggx_distribution(half_vector, self.alpha)
            * ggx_visibility(light, self.view, self.alpha)
            * light.z;
        // |l + v| = 2 h.v for unit directions, without the cancellation of the dot product.
        [value, value * schlick_weight(0.5 * half_vector.length())]
    }

    /// D varies on the scale of sqrt(1 + slope^2) over slopes of the half vector in units of the widths, G2 on that of
    /// sqrt(alpha^2 + cos^2) over the cosine, and the half vector itself on that of |l + v| over directions.
    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        let slope = |l: DVec3| {
            let half_vector = l + self.view;
            half_vector.truncate() / half_vector.z / DVec2::from(self.alpha)
        };
        let slopes = triangle.map(slope);
        let slope_scale = distance_to_origin(&slopes).hypot(1.0);
        let cosine_scale = lowest(triangle).hypot(self.alpha[0].min(self.alpha[1]));
        let angle_scale = angle_scale(triangle, self.view);
        EDGES.map(|(i, j)| {
            let angle = triangle[i].distance(triangle[j]) / angle_scale;
            // By way of its middle: an arc with both ends on a narrow lobe's crest may bulge far out of the lobe.
            let middle = slope((triangle[i] + triangle[j]).normalize_or(triangle[i]));
            let slope = (slopes[i].distance(middle) + middle.distance(slopes[j])) / slope_scale;
            let cosine = (triangle[i].z - triangle[j].z) / cosine_scale;
            (angle * angle + slope * slope + 0.5 * cosine * cosine).sqrt()
        })
    }
}

/// The Charlie lobe times the cosine at the light, in the shading frame.
pub(crate) struct CharlieLobe {
    pub(crate) view: DVec3,
    alpha: f64,
}

impl CharlieLobe {
    pub(crate) fn new(view: DVec3, alpha: f64) -> Result<Self, CubatureError> {
        match is_alpha(alpha) {
            true => Ok(Self { view, alpha }),
            false => Err(CubatureError::Alpha(alpha)),
        }
    }
}

impl Integrand<1> for CharlieLobe {
    fn evaluate(&self, direction: DVec3) -> [f64; 1] {
        let half_vector = direction + self.view;
        [charlie_distribution(half_vector, self.alpha)
            * charlie_visibility_cosine(direction.z.max(0.0), self.view.z, self.alpha)]
    }

    /// D is about exp(-c^2 / 2 alpha) of the half vector's cosine c. Lambda is a function of powers of about 1/5 of the
    /// cosine and of 1 - cosine, singular at the horizon and at the zenith: layers and rings of constant ratios, down
    /// to where little is left, make it smooth. It has a step in its second derivative at the cosine 1/2.
    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        let cosines = triangle.map(|l| {
            let half_vector = l + self.view;
            half_vector.z / half_vector.length()
        });
        let least = cosines.iter().fold(1.0, |m: f64, c| m.min(*c));
        let half_scale = least.hypot(2.0 * self.alpha.sqrt());
        let cosine_scale = lowest(triangle).hypot(1e-3);
        let zenith = distance_to_origin(&triangle.map(DVec3::truncate));
        let angle_scale = angle_scale(triangle, self.view).min(2.0 * zenith.max(0.01));
        let bends = straddles(triangle, 0.5);
        [0, 1, 2].map(|k| {
            let (i, j) = EDGES[k];
            let angle = triangle[i].distance(triangle[j]) / angle_scale;
            let half = (cosines[i] - cosines[j]) / half_scale;
            let rise = rise(triangle[i], triangle[j]);
            let cosine = match bends {
                true => rise / 0.05,
                false => 0.25 * rise / cosine_scale,
            };
            (angle * angle + half * half + cosine * cosine).sqrt()
        })
    }
}

/// Single and multiple scattering of the EON lobe times the cosine at the light, in the shading frame with x towards
/// the view.
pub(crate) struct EonLobe {
    pub(crate) view: DVec3,
    diffuse_roughness: f64,
}

impl EonLobe {
    pub(crate) fn new(view: DVec3, diffuse_roughness: f64) -> Result<Self, CubatureError> {
        match (0.0..=1.0).contains(&diffuse_roughness) {
            true => Ok(Self {
                view,
                diffuse_roughness,
            }),
            false => Err(CubatureError::DiffuseRoughness(diffuse_roughness)),
        }
    }
}

impl Integrand<2> for EonLobe {
    fn evaluate(&self, direction: DVec3) -> [f64; 2] {
        let cos_theta = direction.z.max(0.0);
        let tangential = direction.truncate().dot(self.view.truncate());
        let brdf = eon(cos_theta, self.view.z, tangential, self.diffuse_roughness);
        [brdf.single * cos_theta, brdf.multiple * cos_theta]
    }

    /// Single scattering bends where the light passes the view's cosine. What it does in a corner that no sample
    /// reaches is not seen, so the triangles there are made thin.
    fn edge_extents(&self, triangle: &[DVec3; 3]) -> [f64; 3] {
        let angles = edge_lengths(triangle).map(|length| length / SMOOTH_ANGLE);
        if !straddles(triangle, self.view.z) {
            return angles;
        }
        [0, 1, 2].map(|k| {
            let (i, j) = EDGES[k];
            angles[k].hypot(rise(triangle[i], triangle[j]) / (THIN * self.view.z))
        })
    }
}

/// Height of triangles across the bend of [`EonLobe`] in units of the view's cosine; leaves an error of about 1e-8.
const THIN: f64 = 0.02;

/// The edges of a triangle, in the order of the vertices they lie opposite of.
const EDGES: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// Whether the spherical triangle may reach to both sides of the circle of this cosine.
fn straddles(triangle: &[DVec3; 3], cosine: f64) -> bool {
    let length2 = edge_lengths(triangle).map(|l| l * l);
    let length2 = length2.iter().fold(0.0, |m: f64, l| m.max(*l));
    // Arcs rise above their ends.
    let highest = triangle.iter().fold(0.0, |m: f64, l| m.max(l.z)) * (1.0 + 0.25 * length2);
    lowest(triangle) < cosine && highest > cosine
}

/// How far the cosine changes along an arc, by way of its middle.
fn rise(a: DVec3, b: DVec3) -> f64 {
    let middle = (a + b).normalize_or(a);
    (a.z - middle.z).abs() + (middle.z - b.z).abs()
}

fn lowest(triangle: &[DVec3; 3]) -> f64 {
    triangle.iter().fold(1.0, |m: f64, l| m.min(l.z))
}

/// Angle over which half vectors vary smoothly: they turn ever faster towards l = -v.
fn angle_scale(triangle: &[DVec3; 3], view: DVec3) -> f64 {
    triangle
        .iter()
        .fold(SMOOTH_ANGLE, |m: f64, l| m.min(l.distance(-view)))
}

/// Distance of a plane triangle from the origin, zero inside.
fn distance_to_origin(triangle: &[DVec2; 3]) -> f64 {
    let edges = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (triangle[i], triangle[j]));
    // Sines of the angles the edges span. A sliver in line with the origin has only rounding here, of any sign; it is
    // the distance to its edges that tells.
    let turns = edges.map(|(a, b)| a.perp_dot(b) / (a.length() * b.length()));
    if turns.iter().all(|t| *t > 1e-12) || turns.iter().all(|t| *t < -1e-12) {
        return 0.0;
    }
    let to_edge = |(a, b): (DVec2, DVec2)| {
        let along = b - a;
        let t = (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        // A NaN from an edge without length loses to the other edges' distances.
        (a + t * along).length()
    };
    edges.map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
}
