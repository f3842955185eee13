//! What a light's image is on average to a shading point, by every method.

use crate::clip::{Above, AboveZ, Seen, Shared, for_each_edge};
use crate::image_quadrature::{ImageQuadrature, ImageWeight, from_single};
use crate::irradiance::light_vector;
use crate::light_image::{ImageFrame, LightImage};
use crate::ltc::{PreparedLtc, Transformed};
use crate::polygon::PolygonLight;
use crate::projected_area::{LocalOcclusion, ProjectionBasis, projection_axis};
use crate::real::Real;
use crate::technique::DiffuseMethod;
use crate::vec3::Vec3;

/// How a light's image is averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageMethod {
    /// One lookup in Gaussian levels where the light vector meets the light's plane: the
    /// conventional way. The image must have its
    /// [Gaussian levels](LightImage::filter_gaussian_levels), or its plain mean is taken.
    Lookup,
    /// As many taps along either axis, 1 to 16, warped to where the weight is.
    Quadrature {
        /// Along one axis; their square is read.
        taps: u32,
    },
}

impl ImageMethod {
    /// Taps along either axis as they are taken, 1 to 16; 0 for the one lookup.
    #[must_use]
    pub fn taps(self) -> u32 {
        match self {
            Self::Lookup => 0,
            Self::Quadrature { taps } => taps.clamp(1, MOST_TAPS),
        }
    }
}

impl Default for ImageMethod {
    /// 2 x 2 taps.
    fn default() -> Self {
        Self::Quadrature { taps: 2 }
    }
}

/// Most taps along one axis.
const MOST_TAPS: u32 = 16;

/// Heights over no second horizon.
#[inline(always)]
fn uncut<T: Real>(like: T) -> Vec3<T> {
    Vec3::new(like.constant(1.0), like.constant(0.0), like.constant(0.0))
}

/// Where an image lies, relative to a shading point, in radii.
#[inline(always)]
fn relative<T: Real>(image: &LightImage<T::Scalar>, center: Vec3<T>) -> ImageFrame<T> {
    let frame = image.frame().broadcast(center.x);
    ImageFrame {
        corner: frame.corner + center,
        ..frame
    }
}

/// Heights of corner and edges over a horizon.
#[inline(always)]
fn heights<T: Real>(frame: &ImageFrame<T>, normal: Vec3<T>) -> Vec3<T> {
    Vec3::new(
        normal.dot(frame.corner),
        normal.dot(frame.edge_u),
        normal.dot(frame.edge_v),
    )
}

/// The image's plain mean.
#[inline(always)]
fn plain_mean<T: Real>(image: &LightImage<T::Scalar>, like: T) -> [T; 3] {
    let [r, g, b] = image.mean();
    [
        like.broadcast(from_single(r)),
        like.broadcast(from_single(g)),
        like.broadcast(from_single(b)),
    ]
}

impl DiffuseMethod {
    /// The mean of the light's image, weighted as this method weighs directions: by the cosine, by
    /// solid angle, or by projected area, above the surface's horizon. Linear RGB, each channel
    /// within the image's.
    ///
    /// [`DiffuseMethod::irradiance`] times this is the irradiance of the textured light. An
    /// estimate; see [`ImageMethod`]. Exact for constant images.
    #[inline(always)]
    pub fn mean_image<T: Real>(
        self,
        light: &PolygonLight<T::Scalar>,
        image: &LightImage<T::Scalar>,
        point: Vec3<T>,
        normal: Vec3<T>,
        method: ImageMethod,
    ) -> [T; 3] {
        let taps = match method {
            ImageMethod::Lookup => {
                return match image.gaussian_levels() {
                    Some(levels) => {
                        let frame = relative(image, Seen::new(light, point).center);
                        levels.look_up(frame, light_vector(light, point))
                    }
                    None => plain_mean(image, point.x),
                };
            }
            ImageMethod::Quadrature { .. } => method.taps(),
        };
        let mut center = Seen::new(light, point).center;
        let cut = |frame: &ImageFrame<T>, occlusion| match occlusion {
            LocalOcclusion::Exact => heights(frame, normal),
            LocalOcclusion::Circle => uncut(point.x),
        };
        let frame = relative(image, center);
        let (weight, cut) = match self {
            Self::Exact { .. } => (ImageWeight::Cosine, uncut(point.x)),
            Self::LightVector { occlusion } => (ImageWeight::SolidAngle, cut(&frame, occlusion)),
            Self::ProjectedArea { basis, occlusion } => {
                let axis = projection_axis(light, point, basis);
                if let ProjectionBasis::Biased { bias } = basis {
                    let bias = point.x.constant(bias) * point.x.broadcast(light.inverse_radius);
                    center = axis.mul_add(bias, center);
                }
                (ImageWeight::Projection(axis), cut(&frame, occlusion))
            }
        };
        ImageQuadrature::new(relative(image, center), Above(normal), cut, weight)
            .mean(image.pyramid(), taps)
    }
}

/// The mean of the light's image, weighted by a fitted lobe above the surface's horizon. Linear RGB,
/// each channel within the image's.
///
/// [`ltc_form_factor`](crate::ltc_form_factor) times this is the form factor of the textured light. An
/// estimate; see [`ImageMethod`]. Exact for constant images.
#[inline(always)]
pub fn ltc_mean_image<T: Real>(
    light: &PolygonLight<T::Scalar>,
    image: &LightImage<T::Scalar>,
    point: Vec3<T>,
    lobe: &PreparedLtc<T>,
    method: ImageMethod,
) -> [T; 3] {
    let seen = Seen::new(light, point);
    let frame = relative(image, seen.center);
    let transformed = ImageFrame {
        corner: lobe.transform(frame.corner),
        edge_u: lobe.transform(frame.edge_u),
        edge_v: lobe.transform(frame.edge_v),
    };
    match method {
        ImageMethod::Lookup => match image.gaussian_levels() {
            Some(levels) => {
                let direction = transformed_light_vector(light, &seen, lobe);
                levels.look_up(transformed, direction)
            }
            None => plain_mean(image, point.x),
        },
        ImageMethod::Quadrature { .. } => {
            let cut = heights(&frame, lobe.normal());
            ImageQuadrature::new(transformed, AboveZ, cut, ImageWeight::Cosine)
                .mean(image.pyramid(), method.taps())
        }
    }
}

/// Direction of the light vector in cosine space, with no horizon; its length means nothing.
#[inline(always)]
fn transformed_light_vector<T: Real>(
    light: &PolygonLight<T::Scalar>,
    seen: &Seen<T>,
    lobe: &PreparedLtc<T>,
) -> Vec3<T> {
    let zero = seen.plane_distance.constant(0.0);
    let offsets = Transformed::new(Shared::new(light, zero), lobe);
    let mut sum = Vec3::new(zero, zero, zero);
    for_each_edge(
        light,
        lobe.transform(seen.center),
        offsets,
        #[inline(always)]
        |edge| sum = edge.cross.mul_add(edge.angle_over_sine(), sum),
    );
    (sum * seen.orientation).normalize_or_zero()
}
