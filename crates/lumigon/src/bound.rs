//! What a light can add at most: cheap bounds, for leaving lights out.
//!
//! Every point of a light is within its radius of its centre, so that none is nearer, lower or more
//! steeply lit than the sphere about it allows.

use crate::clip::Seen;
use crate::ltc::PreparedLtc;
use crate::polygon::PolygonLight;
use crate::real::{Mask, Real};
use crate::vec3::Vec3;

/// An upper bound of [`irradiance`](crate::irradiance), in \[0, pi\]: 0 only where that is 0.
///
/// Tight from afar: there it tends to area times both cosines over the squared distance.
#[inline(always)]
pub fn irradiance_bound<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    normal: Vec3<T>,
) -> T {
    let seen = Seen::new(light, point);
    let (zero, one) = (point.x.constant(0.0), point.x.constant(1.0));
    let height = normal.dot(seen.center);
    let visible = seen.lit & height.gt(-one);
    if !visible.any() {
        return zero;
    }
    let area = point.x.broadcast(light.doubled_area) * point.x.constant(0.5);
    let bound = sphere_bound(seen.center.length(), seen.plane_distance, height, area);
    T::select(visible, bound, zero)
}

/// An upper bound of [`ltc_form_factor`](crate::ltc_form_factor), in \[0, 1\]: 0 only where that
/// is 0.
#[inline(always)]
pub fn ltc_form_factor_bound<T: Real>(
    light: &PolygonLight<T::Scalar>,
    point: Vec3<T>,
    lobe: &PreparedLtc<T>,
) -> T {
    let seen = Seen::new(light, point);
    let (zero, one) = (point.x.constant(0.0), point.x.constant(1.0));
    // In cosine space the light is another polygon: no vertex farther than 1 from its centre, the
    // area grown with the normal.
    let center = lobe.transform(seen.center);
    let visible = seen.lit & lobe.normal().dot(seen.center).gt(-one) & center.z.gt(-one);
    if !visible.any() {
        return zero;
    }
    let normal = lobe.transform_normal(seen.away);
    let stretch = normal.length();
    let area = point.x.broadcast(light.doubled_area) * point.x.constant(0.5) * stretch;
    let safe = T::select(stretch.gt(zero), stretch, one);
    let plane_distance = normal.dot(center).abs() / safe;
    let bound = sphere_bound(center.length(), plane_distance, center.z, area)
        * point.x.constant(core::f64::consts::FRAC_1_PI);
    T::select(visible, bound, zero)
}

/// An upper bound of the normalised lobe's density in any direction, in 1/sr.
///
/// Tight where the map stretches two of three directions alike and shrinks the third, as GGX's does.
#[inline(always)]
pub fn ltc_density_bound<T: Real>(lobe: &PreparedLtc<T>) -> T {
    // det / (pi s^3) with the map's least singular value s; the other two multiply to at most 1/2,
    // since the squares of all three sum to 1.
    let [x, y, z] = lobe.world_to_cosine();
    let determinant = x.dot(y.cross(z));
    let squared = (determinant * determinant).max(determinant.constant(1e-30));
    determinant.constant(0.125 * core::f64::consts::FRAC_1_PI * (1.0 + 1e-5)) / squared
}

/// Irradiance from a flat light of this area within a unit sphere, at most: `distance` and `height`
/// over the horizon are its centre's, `plane_distance` is its plane's.
#[inline(always)]
fn sphere_bound<T: Real>(distance: T, plane_distance: T, height: T, area: T) -> T {
    let one = distance.constant(1.0);
    let pi = distance.constant(core::f64::consts::PI);
    let nearest = distance - one;
    let outside = nearest.gt(distance.constant(1e-3));
    let inverse = one / T::select(outside, nearest, one);
    let at_light = (plane_distance * inverse).min(one);
    let at_surface = ((height + one) * inverse).min(one);
    let bound = area * at_light * at_surface * inverse * inverse;
    // What rounding may add.
    let bound = (bound * distance.constant(1.0 + 1e-5)).min(pi);
    T::select(outside, bound, pi)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LtcTable, PreparedLtc, Sides, irradiance, ltc_form_factor};
    use alloc::vec;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    #[test]
    fn nothing_adds_more_than_its_bound() {
        let outline = vec![
            [-1.0, -0.4, 0.0],
            [1.2, -0.5, 0.0],
            [0.1, 0.1, 0.0],
            [-0.3, 1.0, 0.0],
        ];
        let table = LtcTable::ggx();
        let mut random = Pcg32::seed_from_u64(7);
        let mut unit = move || -> Vec3<f64> {
            loop {
                let v = Vec3::from([0; 3].map(|_| random.random_range(-1.0..1.0)));
                if v.dot(v) > 0.01 {
                    return v.normalize_or_zero();
                }
            }
        };
        let (mut loosest, mut densest) = (0.0_f64, 0.0_f64);
        for i in 0..4_000 {
            let sides = if i % 2 == 0 {
                Sides::Front
            } else {
                Sides::Both
            };
            let light = PolygonLight::new(&[&outline], sides).unwrap();
            let distance = libm::exp(f64::from(i % 100) * 0.09 - 2.0);
            let point = unit() * distance;
            let normal = unit();
            let exact = irradiance(&light, point, normal);
            let bound = irradiance_bound(&light, point, normal);
            assert!(exact <= bound, "{exact} {bound} at {point:?} {normal:?}");
            // The sphere about a light far away spoils cosines by 1 / distance, and no more.
            if distance > 100.0 && exact * distance * distance > 0.2 {
                loosest = loosest.max(bound / exact - 1.0);
            }
            let view = unit();
            let view = if normal.dot(view) < 0.0 { -view } else { view };
            let perceptual_roughness = (i % 17) as f32 / 16.0;
            let ltc = table
                .lookup(perceptual_roughness, normal.dot(view) as f32)
                .lobes[0];
            let ltc = crate::Ltc {
                shading_to_cosine: ltc.shading_to_cosine.map(f64::from),
                amplitude: 1.0,
                schlick: 0.0,
            };
            let lobe = PreparedLtc::new(&ltc, normal, view);
            let highest = ltc_density_bound(&lobe);
            let density = ltc.density(unit());
            assert!(density <= highest, "{density} {highest}");
            densest = densest.max(density / highest);
            let exact = ltc_form_factor(&light, point, &lobe);
            let bound = ltc_form_factor_bound(&light, point, &lobe);
            assert!(exact <= bound, "{exact} {bound} at {point:?} {normal:?}");
        }
        assert!((0.001..0.3).contains(&loosest), "{loosest}");
        assert!(densest > 0.3, "{densest}");
    }
}
