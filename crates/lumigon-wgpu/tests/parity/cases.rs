//! Lights and places to look at them from: random, and at every degeneracy.

use lumigon::{LtcTable, PolygonLight, Sides, Vec3};

use crate::gpu::Place;
use crate::polygons::{self, KINDS, Placed, Random, SLIVER, Vector, hostile_normal};

/// A light in both precisions: the f64 one has the f32 one's vertices, so that what differs is the
/// functions' own rounding.
#[derive(Debug)]
pub(crate) struct Subject {
    pub(crate) light: PolygonLight<f64>,
    pub(crate) single: PolygonLight<f32>,
    pub(crate) placed: Placed,
}

/// Where a place is, seen from a light: lengths in the light's radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    /// From the place to the light's centre.
    pub(crate) distance: f64,
    /// To the nearest edge, at most 1.
    pub(crate) nearness: f64,
    /// Over the light's plane.
    pub(crate) plane_height: f64,
    /// Within this height the place may be in the plane, but for its rounding.
    pub(crate) in_plane: f64,
    /// Of the light's centre over the place's horizon.
    pub(crate) height: f64,
    /// Least height of a vertex over the place's horizon.
    pub(crate) lowest: f64,
    /// Cosines at light and place of the ray to the light's centre, absolute.
    pub(crate) cos_light: f64,
    pub(crate) cos_place: f64,
    /// Edges, in quadrilaterals, at least 1: every edge adds its rounding.
    pub(crate) edges: f64,
    pub(crate) is_sliver: bool,
    /// Whether both precisions circumscribed the same circle.
    pub(crate) has_same_circle: bool,
}

pub(crate) struct Cases {
    pub(crate) subjects: Vec<Subject>,
    pub(crate) places: Vec<Place>,
}

pub(crate) fn double(v: [f32; 3]) -> Vector {
    v.map(f64::from).into()
}

pub(crate) fn single(v: Vector) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

impl Cases {
    pub(crate) fn lights(&self) -> Vec<PolygonLight<f32>> {
        self.subjects.iter().map(|s| s.single.clone()).collect()
    }

    pub(crate) fn subject(&self, place: &Place) -> &Subject {
        &self.subjects[place.light as usize]
    }
}

impl Subject {
    /// `None` where rounding leaves no area.
    fn new(mut placed: Placed, sides: Sides) -> Option<Self> {
        let single = PolygonLight::new(&placed.loops, sides).ok()?.cast::<f32>();
        let single = single.unwrap();
        let (center, radius) = single.circumscribed_circle();
        let (center, radius) = (double(center.into()), f64::from(radius));
        placed.loops = single
            .loop_ranges()
            .map(|range| {
                let place = |v: &Vec3<f32>| (center + double((*v).into()) * radius).into();
                single.offsets()[range].iter().map(place).collect()
            })
            .collect();
        let light = PolygonLight::new(&placed.loops, sides).ok()?;
        Some(Self {
            light,
            single,
            placed,
        })
    }

    /// Of several circles about an outline, rounding may choose.
    pub(crate) fn has_same_circle(&self) -> bool {
        let (center, radius) = self.light.circumscribed_circle();
        let (center32, radius32) = self.single.circumscribed_circle();
        let moved = (center - double(center32.into())) * (1.0 / radius);
        moved.length() < 3e-7 && (f64::from(radius32) / radius - 1.0).abs() < 3e-7
    }

    pub(crate) fn sight(&self, place: &Place) -> Sight {
        let (center, radius) = self.light.circumscribed_circle();
        let (point, normal) = (double(place.point), double(place.normal));
        // In radii first: squares of lengths may overflow.
        let scaled = |v: Vector| (v - point) * (1.0 / radius);
        let to_center = scaled(center);
        let direction = to_center.normalize_or_zero();
        let heights = self.placed.vertices().into_iter();
        let nearness = self.placed.edges().into_iter().map(|(a, b)| {
            let (a, b) = (scaled(a), scaled(b));
            let along = b - a;
            let t = (-a.dot(along) / along.dot(along).max(1e-300)).clamp(0.0, 1.0);
            (a + along * t).length()
        });
        Sight {
            distance: to_center.length(),
            has_same_circle: self.has_same_circle(),
            nearness: nearness.fold(1.0, f64::min),
            plane_height: -self.light.normal().dot(to_center),
            in_plane: f64::from(self.single.plane_tolerance())
                + (to_center.x.abs() + to_center.y.abs() + to_center.z.abs()) * 4.8e-7,
            height: normal.dot(to_center),
            lowest: heights
                .map(|v| normal.dot(scaled(v)))
                .fold(f64::INFINITY, f64::min),
            cos_light: self.light.normal().dot(direction).abs(),
            cos_place: normal.dot(direction).abs(),
            edges: (self.light.vertex_count() as f64 / 4.0).max(1.0),
            is_sliver: self.placed.kind == SLIVER,
        }
    }
}

/// Lights of every kind, size and place, and `per_light` places each.
pub(crate) fn cases(seed: u64, lights: usize, per_light: usize) -> Cases {
    let mut random = Random::new(seed);
    let table = LtcTable::ggx();
    let mut cases = Cases {
        subjects: Vec::new(),
        places: Vec::new(),
    };
    while cases.subjects.len() < lights {
        let placed = polygon(cases.subjects.len(), &mut random);
        let sides = if random.chance(0.5) {
            Sides::Front
        } else {
            Sides::Both
        };
        let Some(subject) = Subject::new(placed, sides) else {
            // Rounded to eighths, slivers vanish and holes may swallow their outline.
            continue;
        };
        let light = cases.subjects.len() as u32;
        for i in 0..per_light {
            let mut place = place(i, &subject.placed, &table, &mut random);
            place.light = light;
            cases.places.push(place);
        }
        cases.subjects.push(subject);
    }
    cases
}

fn polygon(case: usize, random: &mut Random) -> Placed {
    let kind = case % KINDS;
    let mut shape = polygons::outlines(kind, random);
    if case.is_multiple_of(7) {
        // Round coordinates: exact zeros, exact horizons, exact edges through the zenith.
        for vertex in shape.iter_mut().flatten() {
            *vertex = vertex.map(|x| (x * 8.0).round() / 8.0);
        }
    }
    let normal = if random.chance(0.5) {
        random.axis()
    } else {
        random.direction()
    };
    let size = match case % 6 {
        0 => random.log_range(1e-15, 1e15),
        1 => 1e-15,
        2 => 1e15,
        _ => random.log_range(1e-3, 1e3),
    };
    let origin = match random.index(3) {
        0 => Vec3::default(),
        1 => random.axis() * (size * random.range(0.0, 3.0)),
        _ => random.direction() * (size * random.log_range(1e-3, 1e3)),
    };
    Placed::new(kind, &shape, origin, normal, size)
}

fn place(i: usize, placed: &Placed, table: &LtcTable<1>, random: &mut Random) -> Place {
    let side = if random.chance(0.7) { 1.0 } else { -1.0 };
    let (x, y) = (random.range(-1.5, 1.5), random.range(-1.5, 1.5));
    let point = match i % 4 {
        0 | 1 => placed.at(x, y, side * random.log_range(1e-4, 3.0)),
        2 => {
            let towards = random.direction_above(placed.axes[2] * side);
            placed.origin + towards * (placed.size * random.log_range(2.0, 1e6))
        }
        _ => hostile_point(placed, random),
    };
    // The functions see what f32 holds.
    let point = double(single(point));
    let normal = if i.is_multiple_of(3) {
        hostile_normal(placed, point, random)
    } else {
        random.direction_above((placed.origin - point).normalize_or_zero())
    };
    let view = match random.index(6) {
        0 => normal,
        // Grazing, and below the horizon.
        1 => {
            let (s, _) = normal.orthonormal_basis();
            (s + normal * random.log_range(1e-9, 0.1)).normalize_or_zero()
        }
        2 => -random.direction_above(normal),
        // Whose reflection meets the light.
        3 => {
            let aim = placed.at(random.range(-1.2, 1.2), random.range(-1.2, 1.2), 0.0);
            let aim = ((aim - point) * (1.0 / placed.size)).normalize_or_zero();
            normal * (2.0 * normal.dot(aim)) - aim
        }
        _ => random.direction_above(normal),
    };
    let towards = match random.index(3) {
        // The mirror direction, which is the narrow peak, and straight on.
        0 => (normal * (2.0 * normal.dot(view)) - view).normalize_or_zero(),
        1 => random.direction_above(normal),
        _ => view,
    };
    let perceptual_roughness = match random.index(4) {
        0 => 0.0,
        1 => 1.0,
        _ => random.range(0.0, 1.0),
    };
    let [lobe] = table
        .lookup(perceptual_roughness as f32, normal.dot(view) as f32)
        .lobes;
    Place {
        point: single(point),
        light: 0,
        normal: single(normal),
        alpha: (perceptual_roughness * perceptual_roughness) as f32,
        view: single(view),
        cosine: match random.index(4) {
            0 => random.index(2) as f32,
            1 => random.log_range(1e-9, 1.0) as f32,
            _ => random.range(0.0, 1.0) as f32,
        },
        towards: single(towards),
        bias: (placed.size * random.range(0.0, 2.0)) as f32,
        lobe: lobe.shading_to_cosine,
    }
}

/// A shading point that hits some degeneracy of the polygon.
fn hostile_point(placed: &Placed, random: &mut Random) -> Vector {
    let edges = placed.edges();
    let (a, b) = edges[random.index(edges.len())];
    let on_edge = a + (b - a) * random.range(0.0, 1.0);
    let side = if random.chance(0.7) { 1.0 } else { -1.0 };
    let (x, y) = (random.range(-1.2, 1.2), random.range(-1.2, 1.2));
    let normal = placed.axes[2];
    match random.index(13) {
        // At a vertex, on an edge, on an edge's line.
        0 => a,
        1 => on_edge,
        2 => a + (b - a) * random.range(-2.0, 3.0),
        // In the plane, in the outline or out of it; and hardly over it.
        3 => placed.at(x, y, 0.0),
        4 => placed.at(x * 10.0, y * 10.0, 0.0),
        5 => placed.at(x, y, side * 1e-5),
        6 => on_edge + normal * (placed.size * side * random.log_range(1e-12, 1e-2)),
        7 => a + normal * (placed.size * side * random.log_range(1e-12, 1e-2)),
        8 => placed.at(x, y, side * random.log_range(1e-6, 1e-4)),
        9 => placed.origin + random.direction() * (placed.size * 1e6),
        10 => placed.origin,
        // The origin of the world, and far from it.
        11 => Vec3::default(),
        _ => random.direction() * random.log_range(1e-15, 1e15),
    }
}
