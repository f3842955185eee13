//! Where on a light rays of visibility go.

use glam::{DVec2, DVec3, Vec3};
use lumigon::Sides;
use lumigon_wgpu::Light;

use super::Facets;
use super::footprint::{PlaneFrame, bounds};
use crate::scene::{PunctualKind, PunctualLight};

/// Points of a light that shadows before the first bounce are asked for.
const POINTS: usize = 16;

/// Points tried at most: an outline that fills little of its box may get fewer, and repeats them.
const MOST_TRIED: u32 = 4096;

/// Points on lights that rays of visibility go to, as many for each.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LightTargets {
    pub(crate) per_light: usize,
    /// Light after light.
    pub(crate) points: Vec<Vec3>,
}

impl LightTargets {
    /// Points spread evenly over each light's area.
    pub(crate) fn spread(lights: &[Light]) -> Self {
        Self {
            per_light: POINTS,
            points: lights.iter().flat_map(spread).collect(),
        }
    }
}

/// The lights that have a place, counted as [`BounceLights::One`](super::BounceLights) does, and from
/// where they see what they light.
pub(crate) fn light_places(
    lights: &[Light],
    punctual: &[PunctualLight],
    facets: &Facets,
) -> Vec<(usize, Vec3)> {
    // Off its own face.
    let off = facets.scene_diagonal as f32 * 1e-4;
    let of_polygon = |light: &Light| {
        let vector = |v: lumigon::Vec3<f32>| Vec3::new(v.x, v.y, v.z);
        let normal = match light.polygon.sides() {
            Sides::Front => vector(light.polygon.normal()),
            Sides::Both => Vec3::ZERO,
        };
        vector(light.polygon.centroid()) + normal * off
    };
    let polygons = lights.iter().map(of_polygon).enumerate();
    let others = punctual.iter().enumerate();
    let others = others.filter(|(_, light)| light.kind != PunctualKind::Directional);
    let others = others.map(|(i, light)| (lights.len() + i, light.position));
    polygons.chain(others).collect()
}

fn spread(light: &Light) -> [Vec3; POINTS] {
    let polygon = &light.polygon;
    let double = |v: lumigon::Vec3<f32>| DVec3::new(v.x.into(), v.y.into(), v.z.into());
    let frame = PlaneFrame::new(double(polygon.centroid()), double(polygon.normal()));
    let loops: Vec<Vec<DVec2>> = polygon
        .loops()
        .map(|vertices| vertices.iter().map(|&v| frame.flat(double(v))).collect())
        .collect();
    let [low, high] = bounds(loops.iter().flatten());
    let mut inside = (1..=MOST_TRIED)
        .map(|i| low + (high - low) * DVec2::new(radical_inverse(2, i), radical_inverse(3, i)))
        .filter(|&place| contains(&loops, place))
        .map(|place| frame.raised(place).as_vec3())
        .take(POINTS)
        .collect::<Vec<_>>();
    if inside.is_empty() {
        inside.push(frame.origin.as_vec3());
    }
    std::array::from_fn(|i| inside[i % inside.len()])
}

/// The digits of `index` mirrored at the point: Halton's sequence in one dimension.
fn radical_inverse(base: u32, mut index: u32) -> f64 {
    let (mut sum, mut place) = (0.0, 1.0);
    while index > 0 {
        place /= f64::from(base);
        sum += place * f64::from(index % base);
        index /= base;
    }
    sum
}

/// By crossing number.
fn contains(loops: &[Vec<DVec2>], point: DVec2) -> bool {
    let crossings = loops.iter().map(|vertices| {
        let following = vertices.iter().cycle().skip(1);
        let edges = vertices.iter().zip(following);
        let crosses = |(a, b): (&DVec2, &DVec2)| {
            (a.y > point.y) != (b.y > point.y)
                && point.x < a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y)
        };
        edges.filter(|&edge| crosses(edge)).count()
    });
    crossings.sum::<usize>() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumigon::{PolygonLight, Sides};

    #[test]
    fn points_lie_on_the_light_and_balance() {
        let square = |r: f64| vec![[-r, 1.0, -r], [-r, 1.0, r], [r, 1.0, r], [r, 1.0, -r]];
        let hole: Vec<_> = square(1.0).into_iter().rev().collect();
        let polygon = PolygonLight::new(&[square(2.0), hole], Sides::Front).unwrap();
        let light = Light {
            polygon: polygon.cast().unwrap(),
            radiance: [1.0; 3],
            image: None,
        };
        let targets = LightTargets::spread(&[light]);
        assert_eq!(targets.points.len(), targets.per_light);
        for point in &targets.points {
            let reach = point.x.abs().max(point.z.abs());
            assert!((1.0..=2.0).contains(&reach) && (point.y - 1.0).abs() < 1e-6);
        }
        let mean = targets.points.iter().sum::<Vec3>() / targets.per_light as f32;
        assert!(mean.x.abs() < 0.4 && mean.z.abs() < 0.4, "{mean}");
    }
}
