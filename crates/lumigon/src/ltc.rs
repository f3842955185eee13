//! Linearly transformed cosines: specular light from polygons.
//!
//! Heitz, Dupuy, Hill and Neubelt, "Real-Time Polygonal-Light Shading with Linearly Transformed
//! Cosines", ACM TOG 35(4), 2016. A lobe D(l) is a clamped cosine D0 seen through a linear map M
//! of directions (`cosine_to_shading`), so its integral over a polygon is the cosine's over the
//! polygon seen through M^-1 (`shading_to_cosine`): a form factor.

use crate::clip::{Above, AboveZ, Compass, Edge, Horizon, Offsets, Seen, Shared, height_range};
use crate::irradiance::unclipped;
use crate::polygon::PolygonLight;
use crate::real::{Mask, Real};
use crate::vec3::Vec3;

/// A lobe about one view direction, in the shading frame: z the normal, the view in the x-z
/// plane, x towards the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ltc<T> {
    /// Rows of M^-1 divided by its middle element, `[[m11, 0, m13], [0, 1, 0], [m31, 0, m33]]`, as
    /// (m11, m13, m31, m33). A factor does not matter: directions have no length.
    ///
    /// m11 m33 - m13 m31 must be positive: the map keeps orientation.
    pub shading_to_cosine: [T; 4],
    /// Integral of the lobe over the sphere with F = 1; [`Ltc::share_above_horizon`] of it is
    /// above the surface.
    pub amplitude: T,
    /// The same weighted by Schlick's (1 - h.v)^5.
    pub schlick: T,
}

impl<T: Real> Ltc<T> {
    /// The diffuse lobe: M the identity.
    #[inline(always)]
    pub fn cosine(like: T) -> Self {
        let (zero, one) = (like.constant(0.0), like.constant(1.0));
        Self {
            shading_to_cosine: [one, zero, zero, one],
            amplitude: one,
            schlick: zero,
        }
    }

    /// Response for Schlick's Fresnel term, `f0` at normal and `f90` at grazing incidence, to be
    /// multiplied by [`ltc_form_factor`] and the light's radiance.
    #[inline(always)]
    pub fn reflectance(&self, f0: T, f90: T) -> T {
        f0.mul_add(self.amplitude - self.schlick, f90 * self.schlick)
    }

    /// Share of the normalised lobe above the surface's horizon, in \[0, 1\].
    ///
    /// Times [`Ltc::amplitude`] it is the directional albedo: [`ltc_form_factor`] of a light that
    /// fills the hemisphere.
    #[inline(always)]
    pub fn share_above_horizon(&self) -> T {
        let [m11, _, m31, _] = self.shading_to_cosine;
        let zero = m11.constant(0.0);
        let horizon = Vec3::new(-m31, zero, m11).normalize_or_zero();
        half_space_share(horizon)
    }

    /// Density of the lobe in the direction `light` of the shading frame (unit), in 1/sr; it
    /// integrates to 1 over the sphere. 0 outside the transformed hemisphere.
    #[inline(always)]
    pub fn density(&self, light: Vec3<T>) -> T {
        let [m11, m13, m31, m33] = self.shading_to_cosine;
        let cosine = Vec3::new(
            m11.mul_add(light.x, m13 * light.z),
            light.y,
            m31.mul_add(light.x, m33 * light.z),
        );
        let zero = m11.constant(0.0);
        let determinant = m11 * m33 - m13 * m31;
        let squared = cosine.dot(cosine);
        // D0(w0) |M^-1| / |M^-1 w|^3 with w0 normalised: the fourth power of the length.
        let value = cosine.z * determinant * m11.constant(core::f64::consts::FRAC_1_PI)
            / (squared * squared);
        T::select(cosine.z.gt(zero), value, zero)
    }

    /// The shading-frame direction (unit) that the cosine-space direction (unit) maps to: cosine
    /// distributed directions become directions distributed as [`Ltc::density`].
    #[inline(always)]
    pub fn cosine_to_shading(&self, direction: Vec3<T>) -> Vec3<T> {
        let [m11, m13, m31, m33] = self.shading_to_cosine;
        // The inverse of M^-1 up to a positive factor.
        let determinant = m11 * m33 - m13 * m31;
        Vec3::new(
            m33 * direction.x - m13 * direction.z,
            direction.y * determinant,
            m11 * direction.z - m31 * direction.x,
        )
        .normalize_or_zero()
    }
}

/// A shading point's lobe in world space, prepared once for all lights.
#[derive(Clone, Copy, Debug)]
pub struct PreparedLtc<T> {
    /// Rows of `world_to_cosine`.
    rows: [Vec3<T>; 3],
    /// Their cofactors, which carry normals.
    cofactors: [Vec3<T>; 3],
    /// Unit normal of the surface.
    normal: Vec3<T>,
    /// The surface's horizon in cosine space: its unit normal.
    horizon: Vec3<T>,
    /// On the lobe's plane z = 0, the direction towards which the horizon rises.
    horizon_rise: Vec3<T>,
    /// On the horizon's plane, the direction towards which z rises.
    lobe_rise: Vec3<T>,
}

impl<T: Real> PreparedLtc<T> {
    /// `normal` and `view` (from the point to the viewer) are unit vectors in world space.
    ///
    /// A view along the normal leaves the lobe's azimuth open; any is taken.
    #[inline(always)]
    pub fn new(ltc: &Ltc<T>, normal: Vec3<T>, view: Vec3<T>) -> Self {
        let tangent = view - normal * normal.dot(view);
        let squared = tangent.dot(tangent);
        let has_azimuth = squared.gt(squared.constant(1e-12));
        let (any_tangent, _) = normal.orthonormal_basis();
        let tangent = Vec3::select(has_azimuth, tangent, any_tangent).normalize_or_zero();
        // Again: seen from close to the normal the difference is short, and what rounding left of
        // the normal in it would lean a narrow lobe by more than its width.
        let tangent = (tangent - normal * normal.dot(tangent)).normalize_or_zero();
        let bitangent = normal.cross(tangent);
        let [m11, m13, m31, m33] = ltc.shading_to_cosine;
        let rows = [
            tangent * m11 + normal * m13,
            bitangent,
            tangent * m31 + normal * m33,
        ];
        let rows = scaled(rows, m11.constant(1.0) / squared_norm(rows).sqrt());
        let (zero, one) = (m11.constant(0.0), m11.constant(1.0));
        // As below, with the sines and cosines of a lobe that only leans: no rounding.
        let sign = T::select(m31.lt(zero), -one, one);
        Self {
            rows,
            cofactors: cofactors(rows),
            normal,
            // M^T n up to a factor: the third row of M.
            horizon: Vec3::new(-m31, zero, m11).normalize_or_zero(),
            horizon_rise: Vec3::new(-sign, zero, zero),
            lobe_rise: Vec3::new(m11 * sign, zero, m31 * sign),
        }
    }

    /// Any lobe: `rows` are those of the map from world space to the space where the lobe is the
    /// clamped cosine about z, `normal` is the surface's unit normal in world space.
    ///
    /// The map's determinant must be positive; a factor does not matter. What is singular or not
    /// finite lights nothing or gives NaN.
    #[inline(always)]
    pub fn from_world_to_cosine(rows: [Vec3<T>; 3], normal: Vec3<T>) -> Self {
        let like = normal.x;
        let (zero, one) = (like.constant(0.0), like.constant(1.0));
        // By the greatest element first: no square overflows or vanishes.
        let greatest = greatest_element(rows).max(like.constant(1e-37));
        let rows = scaled(rows, one / greatest);
        let rows = scaled(rows, one / squared_norm(rows).sqrt());
        let cofactors = cofactors(rows);
        let horizon = transformed(&cofactors, normal).normalize_or_zero();
        // Where the horizon rises on the lobe's plane is hxy / |hxy|, where z rises on the
        // horizon's plane is z - hz h. Where the planes coincide both are open, and any pair of
        // opposite ones is right, but it must be a pair: both from one direction.
        let squared_sine = horizon.x * horizon.x + horizon.y * horizon.y;
        let apart = squared_sine.gt(like.constant(1e-30));
        let sine = T::select(apart, squared_sine, one).sqrt();
        let rise_x = T::select(apart, horizon.x / sine, one);
        let rise_y = T::select(apart, horizon.y / sine, zero);
        let sine = T::select(apart, sine, zero);
        Self {
            rows,
            cofactors,
            normal,
            horizon,
            horizon_rise: Vec3::new(rise_x, rise_y, zero),
            lobe_rise: Vec3::new(-horizon.z * rise_x, -horizon.z * rise_y, sine),
        }
    }

    /// Rows of the map from world space to cosine space, scaled so that no vector grows.
    ///
    /// [`PreparedLtc::from_world_to_cosine`] takes them back.
    #[inline(always)]
    pub fn world_to_cosine(&self) -> [Vec3<T>; 3] {
        self.rows
    }

    /// The surface's unit normal in world space.
    #[inline(always)]
    pub(crate) fn normal(&self) -> Vec3<T> {
        self.normal
    }

    #[inline(always)]
    pub(crate) fn transform(&self, v: Vec3<T>) -> Vec3<T> {
        transformed(&self.rows, v)
    }

    #[inline(always)]
    pub(crate) fn transform_normal(&self, v: Vec3<T>) -> Vec3<T> {
        transformed(&self.cofactors, v)
    }
}

/// The cosine's integral above a plane through the origin: half of 1 + the cosine of its tilt.
#[inline(always)]
pub(crate) fn half_space_share<T: Real>(horizon: Vec3<T>) -> T {
    let half = horizon.z.constant(0.5);
    horizon.z.mul_add(half, half)
}

#[inline(always)]
fn transformed<T: Real>(rows: &[Vec3<T>; 3], v: Vec3<T>) -> Vec3<T> {
    Vec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v))
}

/// Squared Frobenius norm: no vector grows by more than its root.
#[inline(always)]
fn squared_norm<T: Real>(rows: [Vec3<T>; 3]) -> T {
    rows[0].dot(rows[0]) + rows[1].dot(rows[1]) + rows[2].dot(rows[2])
}

#[inline(always)]
fn greatest_element<T: Real>(rows: [Vec3<T>; 3]) -> T {
    let [a, b, c] = rows;
    let a = a.x.abs().max(a.y.abs()).max(a.z.abs());
    let b = b.x.abs().max(b.y.abs()).max(b.z.abs());
    let c = c.x.abs().max(c.y.abs()).max(c.z.abs());
    a.max(b).max(c)
}

#[inline(always)]
fn scaled<T: Real>(rows: [Vec3<T>; 3], factor: T) -> [Vec3<T>; 3] {
    [rows[0] * factor, rows[1] * factor, rows[2] * factor]
}

/// Pairwise cross products (1x2, 2x0, 0x1): the inverse transpose times the determinant.
#[inline(always)]
pub(crate) fn cofactors<T: Real>(rows: [Vec3<T>; 3]) -> [Vec3<T>; 3] {
    [
        rows[1].cross(rows[2]),
        rows[2].cross(rows[0]),
        rows[0].cross(rows[1]),
    ]
}

/// Vertices in cosine space.
#[derive(Clone, Copy)]
pub(crate) struct Transformed<'a, O, T> {
    offsets: O,
    lobe: &'a PreparedLtc<T>,
}

impl<'a, O: Offsets<T>, T: Real> Transformed<'a, O, T> {
    #[inline(always)]
    pub(crate) fn new(offsets: O, lobe: &'a PreparedLtc<T>) -> Self {
        Self { offsets, lobe }
    }
}

impl<O: Offsets<T>, T: Real> Offsets<T> for Transformed<'_, O, T> {
    #[inline(always)]
    fn get(self, i: usize) -> Vec3<T> {
        self.lobe.transform(self.offsets.get(i))
    }
}

/// Integral over the light of the normalised lobe, clipped both where the lobe ends and at the
/// surface's horizon. In \[0, 1\].
///
/// Exact for the lobe. Multiply by [`Ltc::reflectance`] and the light's radiance.
#[inline(always)]
pub fn ltc_form_factor<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    lobe: &PreparedLtc<T>,
) -> T {
    let seen = Seen::new(light, point);
    let (zero, one) = (point.x.constant(0.0), point.x.constant(1.0));
    let height = lobe.normal.dot(seen.center);
    let visible = seen.lit & height.gt(-one);
    if !visible.any() {
        return zero;
    }
    let center = lobe.transform(seen.center);
    let world_offsets = Shared::new(light, point.x);
    let offsets = Transformed::new(world_offsets, lobe);

    let mut whole = height.ge(one) & center.z.ge(one);
    let mut lit = visible;
    if !whole.all() {
        let (least, greatest) = height_range(light, seen.center, world_offsets, Above(lobe.normal));
        let (lobe_least, lobe_greatest) =
            height_range(light, seen.center, world_offsets, Above(lobe.rows[2]));
        whole = least.ge(zero) & lobe_least.ge(zero);
        lit = lit & greatest.gt(zero) & lobe_greatest.gt(zero);
        if !lit.any() {
            return zero;
        }
    }
    let mut sum = zero;
    if (whole & lit).any() {
        let doubled_area = lobe.cofactors[2].dot(Vec3::broadcast(point.x, light.normal))
            * point.x.broadcast(light.doubled_area);
        sum = unclipped(light, center, offsets, AboveZ, doubled_area);
    }
    if (lit & !whole).any() {
        let away = lobe.transform_normal(seen.away).normalize_or_zero();
        let clipped = clipped_by_both(light, &seen, lobe, center, offsets, away);
        sum = T::select(whole, sum, clipped);
    }
    let half_over_pi = point.x.constant(0.5 * core::f64::consts::FRAC_1_PI);
    let value = (sum * seen.orientation * half_over_pi).max(zero).min(one);
    T::select(lit, value, zero)
}

/// The sum over edges in cosine space, above both z = 0, where the lobe ends, and the surface's
/// horizon.
///
/// The boundary of what is left has two chains. On each plane the chain is what the light alone
/// would leave there, intersected with the half circle that the other plane allows: each azimuth
/// is clamped to it. Chains weigh by their plane's z.
#[inline(always)]
fn clipped_by_both<T: Real>(
    light: &PolygonLight<T::Scalar>,
    seen: &Seen<T>,
    lobe: &PreparedLtc<T>,
    center: Vec3<T>,
    offsets: impl Offsets<T>,
    away: Vec3<T>,
) -> T {
    let (zero, one) = (center.x.constant(0.0), center.x.constant(1.0));
    let lobe_chain = Chain::new(AboveZ, lobe.horizon_rise, away);
    let horizon_chain = Chain::new(Above(lobe.horizon), lobe.lobe_rise, away);
    let world_offsets = Shared::new(light, center.x);
    let center_height = lobe.normal.dot(seen.center);
    // Both planes are one, as where the view is along the normal: cut twice, by heights rounded
    // apart, an edge along it would leave the chains' ends apart.
    let squared_sine = lobe.horizon.x * lobe.horizon.x + lobe.horizon.y * lobe.horizon.y;
    let one_plane = squared_sine.lt(center.x.constant(1e-12));
    let mut sum = zero;
    for range in light.loop_ranges() {
        let mut start_offset = offsets.get(range.end - 1);
        let mut start = start_offset + center;
        // Heights over the surface need no transform and share the diffuse term's rounding.
        let mut start_height = lobe.normal.dot(world_offsets.get(range.end - 1)) + center_height;
        for i in range {
            let end_offset = offsets.get(i);
            let end = end_offset + center;
            let end_height = lobe.normal.dot(world_offsets.get(i)) + center_height;
            let along = end_offset - start_offset;
            let by_horizon = Cut::new(start_height, end_height);
            let by_lobe = Cut::new(
                T::select(one_plane, start_height, start.z),
                T::select(one_plane, end_height, end.z),
            );
            if by_lobe.crosses.any() {
                let crossing = along.mul_add(by_lobe.at, start);
                sum += lobe_chain.part(crossing, by_lobe.sign);
            }
            if by_horizon.crosses.any() {
                let crossing = along.mul_add(by_horizon.at, start);
                let part = horizon_chain.part(crossing, by_horizon.sign);
                sum += part * lobe.horizon.z;
            }
            let from = by_lobe.from.max(by_horizon.from);
            let to = by_lobe.to.min(by_horizon.to);
            let left = (to - from).max(zero);
            if left.gt(zero).any() {
                let edge = Edge {
                    start: Vec3::select(from.gt(zero), along.mul_add(from, start), start),
                    end: Vec3::select(to.lt(one), along.mul_add(to, start), end),
                    cross: start.cross(along) * left,
                    kept: one,
                };
                sum = edge.cross.z.mul_add(edge.angle_over_sine(), sum);
            }
            (start_offset, start, start_height) = (end_offset, end, end_height);
        }
    }
    sum
}

/// What a plane leaves of an edge, as parameters from 0 at its start to 1 at its end.
#[derive(Clone, Copy)]
struct Cut<T: Real> {
    from: T,
    to: T,
    at: T,
    crosses: T::Mask,
    /// +1 where the edge rises through the plane, -1 where it sets, else 0.
    sign: T,
}

impl<T: Real> Cut<T> {
    #[inline(always)]
    fn new(start: T, end: T) -> Self {
        let (zero, one) = (start.constant(0.0), start.constant(1.0));
        let start_up = start.gt(zero);
        let end_up = end.gt(zero);
        let crosses = start_up ^ end_up;
        let at = start / T::select(crosses, start - end, one);
        let rises = crosses & end_up;
        let sets = crosses & start_up;
        Self {
            from: T::select(rises, at, zero),
            to: T::select(sets, at, T::select(end_up, one, zero)),
            at,
            crosses,
            sign: T::select(rises, one, T::select(sets, -one, zero)),
        }
    }
}

/// The chain along one plane, within the half circle that another plane allows.
#[derive(Clone, Copy)]
struct Chain<T> {
    compass: Compass<T>,
    least: T,
    greatest: T,
}

impl<T: Real> Chain<T> {
    #[inline(always)]
    fn new(plane: impl Horizon<T>, other_rises: Vec3<T>, away: Vec3<T>) -> Self {
        let compass = Compass::new(plane, away);
        let half_pi = away.x.constant(core::f64::consts::FRAC_PI_2);
        let zero = away.x.constant(0.0);
        let up = compass.azimuth(other_rises);
        Self {
            compass,
            least: up.max(zero) - half_pi,
            greatest: up.min(zero) + half_pi,
        }
    }

    #[inline(always)]
    fn part(&self, crossing: Vec3<T>, sign: T) -> T {
        let azimuth = self.compass.azimuth(crossing);
        azimuth.max(self.least).min(self.greatest) * sign
    }
}
