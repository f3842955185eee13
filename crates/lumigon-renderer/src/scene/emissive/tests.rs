//! Shapes whose outlines are known.

use std::f64::consts::TAU;

use glam::{DVec3, Vec2, Vec3};
use proptest::prelude::*;

use super::*;
use crate::scene::{Sampler, TextureRef};

/// A mesh of these triangles, with positions as they are.
struct Shape {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    noise: f64,
}

impl Shape {
    fn new(triangles: impl IntoIterator<Item = [DVec3; 3]>) -> Self {
        let positions: Vec<DVec3> = triangles.into_iter().flatten().collect();
        let count = positions.len() as u32 / 3;
        let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Self {
            positions,
            triangles,
            noise: 0.0,
        }
    }

    /// Two triangles for each cell of a pattern, `#` being there; y falls from line to line.
    fn cells(lines: &[&str]) -> Self {
        let mut triangles = Vec::new();
        for (j, line) in lines.iter().enumerate() {
            for (i, _) in line.chars().enumerate().filter(|&(_, c)| c == '#') {
                let (x, y) = (i as f64, -(j as f64));
                let p = |dx: f64, dy: f64| DVec3::new(x + dx, y + dy, 0.0);
                triangles.push([p(0., 0.), p(1., 0.), p(1., 1.)]);
                triangles.push([p(0., 0.), p(1., 1.), p(0., 1.)]);
            }
        }
        Self::new(triangles)
    }

    fn area_vector(&self) -> DVec3 {
        let corners = self
            .triangles
            .iter()
            .map(|t| t.map(|i| self.positions[i as usize]));
        corners.map(|[a, b, c]| (b - a).cross(c - a) * 0.5).sum()
    }

    fn polygons(&self) -> Vec<EmissivePolygon> {
        self.polygons_with(
            &Material {
                emissive: Vec3::ONE,
                ..Material::default()
            },
            &[],
            Vec::new(),
        )
    }

    fn polygons_with(
        &self,
        material: &Material,
        textures: &[Texture],
        uv: Vec<Vec2>,
    ) -> Vec<EmissivePolygon> {
        let mesh = Mesh {
            positions: self.positions.iter().map(|p| p.as_vec3()).collect(),
            triangles: self.triangles.clone(),
            texcoords: [uv, Vec::new()],
            ..Mesh::default()
        };
        let emitter = Emitter {
            mesh: &mesh,
            index: 0,
            positions: &self.positions,
            noise: self.noise,
            material,
            textures,
        };
        emitter.polygons(4096).polygons
    }
}

/// Outer loops, holes and vertices of the polygons, which must have the shape's area.
fn counts(shape: &Shape) -> Vec<(usize, usize)> {
    let polygons = shape.polygons();
    let total: DVec3 = polygons.iter().map(|p| DVec3::from(p.area_vector())).sum();
    let expected = shape.area_vector();
    assert!((total - expected).length() <= 1e-9, "{total} {expected}");
    let triangles: usize = polygons.iter().map(|p| p.triangles.len()).sum();
    assert_eq!(triangles, shape.triangles.len());
    polygons
        .iter()
        .map(|p| (p.hole_count(), p.vertex_count()))
        .collect()
}

#[test]
fn square_has_four_corners_counter_clockwise() {
    let square = Shape::cells(&["#"]);
    assert_eq!(counts(&square), [(0, 4)]);
    assert_eq!(square.polygons()[0].area_vector(), [0.0, 0.0, 1.0]);
    assert_eq!(counts(&Shape::cells(&["####", "####"])), [(0, 4)]);
}

#[test]
fn letters_have_their_holes() {
    assert_eq!(counts(&Shape::cells(&["###", "# #", "###"])), [(1, 8)]);
    assert_eq!(
        counts(&Shape::cells(&["###", "# #", "###", "# #", "###"])),
        [(2, 12)]
    );
    assert_eq!(counts(&Shape::cells(&["# #", "###", "# #"])), [(0, 12)]);
    // Separate pieces are separate polygons; an island in a hole is one of them.
    assert_eq!(counts(&Shape::cells(&["# #"])), [(0, 4), (0, 4)]);
    let island = Shape::cells(&["#####", "#   #", "# # #", "#   #", "#####"]);
    let mut found = counts(&island);
    found.sort_unstable();
    assert_eq!(found, [(0, 4), (1, 8)]);
}

#[test]
fn pieces_that_touch_at_a_vertex_stay_simple() {
    assert_eq!(counts(&Shape::cells(&["# ", " #"])), [(0, 4), (0, 4)]);
    // A hole that touches the outside, and two holes that touch each other.
    assert_eq!(counts(&Shape::cells(&["###", "# #", "## "])), [(1, 10)]);
    let found = counts(&Shape::cells(&["####", "# ##", "## #", "####"]));
    assert_eq!(found, [(2, 12)]);
    for polygon in Shape::cells(&["####", "# ##", "## #", "####"]).polygons() {
        for vertices in &polygon.loops {
            for (i, a) in vertices.iter().enumerate() {
                assert!(!vertices[..i].contains(a), "{vertices:?}");
            }
        }
    }
}

#[test]
fn ring_and_star_are_exact() {
    let at = |radius: f64, i: u32, n: u32| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
        DVec3::new(radius * cos, 2.0, -radius * sin)
    };
    let ring = Shape::new((0..64).flat_map(|i| {
        let [a, b] = [i, i + 1].map(|i| at(2.0, i % 64, 64));
        let [c, d] = [i, i + 1].map(|i| at(1.0, i % 64, 64));
        [[a, b, d], [a, d, c]]
    }));
    assert_eq!(counts(&ring), [(1, 128)]);
    let area = ring.polygons()[0].area();
    assert!((area - 1.5 * 64.0 * (TAU / 64.0).sin()).abs() < 1e-12);

    let star = Shape::new((0..10).map(|i| {
        let radius = |i: u32| if i.is_multiple_of(2) { 2.0 } else { 0.8 };
        [
            DVec3::Y * 2.0,
            at(radius(i), i, 10),
            at(radius(i + 1), (i + 1) % 10, 10),
        ]
    }));
    assert_eq!(counts(&star), [(0, 10)]);
}

#[test]
fn cube_has_six_faces() {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut normal = DVec3::ZERO;
            normal[axis] = sign;
            let (u, v) = normal.any_orthonormal_pair();
            let (u, v) = if u.cross(v).dot(normal) > 0.0 {
                (u, v)
            } else {
                (v, u)
            };
            let [a, b, c, d] = [-u - v, u - v, u + v, v - u].map(|p| p + normal);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let cube = Shape::new(triangles);
    assert_eq!(counts(&cube), [(0, 4); 6]);
    for polygon in cube.polygons() {
        let outward = DVec3::from(polygon.area_vector());
        assert!(outward.dot(DVec3::from(polygon.loops[0][0])) > 3.9);
    }
}

/// A sphere of 20 × 4^level triangles with the corners of an icosahedron.
fn icosphere(level: u32) -> Shape {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut corners = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        corners.extend([
            DVec3::new(0., a, b),
            DVec3::new(a, b, 0.),
            DVec3::new(b, 0., a),
        ]);
    }
    let mut triangles = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in corners.iter().skip(j + 1) {
                let near = |p: DVec3, q: DVec3| (p.distance(q) - 2.0).abs() < 1e-9;
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    triangles.push(if outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..level {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (a + b, b + c, c + a);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .map(|t| t.map(DVec3::normalize))
            .collect();
    }
    Shape::new(triangles)
}

#[test]
fn curved_mesh_gives_a_polygon_a_face() {
    for level in 0..4 {
        let sphere = icosphere(level);
        assert_eq!(counts(&sphere), vec![(0, 3); 20 * 4_usize.pow(level)]);
    }
}

#[test]
fn junctions_inside_a_face_vanish() {
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let quad = |[a, b, c, d]: [DVec3; 4]| [[a, b, c], [a, c, d]];
    // One wide cell below two narrow ones.
    let wide = quad([p(0., 0.), p(2., 0.), p(2., 1.), p(0., 1.)]);
    let left = quad([p(0., 1.), p(0.7, 1.), p(0.7, 2.), p(0., 2.)]);
    let right = quad([p(0.7, 1.), p(2., 1.), p(2., 2.), p(0.7, 2.)]);
    assert_eq!(counts(&Shape::new([wide, left, right].concat())), [(0, 4)]);
    // Bricks that share no vertex at all.
    let upper = quad([p(0.5, 1.), p(2.5, 1.), p(2.5, 2.), p(0.5, 2.)]);
    assert_eq!(counts(&Shape::new([wide, upper].concat())), [(0, 8)]);
}

/// Positions rounded to f32 in a turned plane away from the origin are no longer quite flat.
#[test]
fn rounded_positions_stay_in_one_facet() {
    for turn in 1..40 {
        let mut shape = Shape::cells(&["########"; 8]);
        let place = glam::DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.02),
            glam::DQuat::from_scaled_axis(DVec3::new(0.37, -0.71, 0.2) * f64::from(turn)),
            DVec3::new(11.3, -4.7, 29.1),
        );
        for p in &mut shape.positions {
            *p = place.transform_point3(*p).as_vec3().as_dvec3();
        }
        shape.noise = 3.0 * 29.2 * f64::from(f32::EPSILON) * 0.5;
        let polygons = shape.polygons();
        assert_eq!(
            (polygons.len(), polygons[0].vertex_count()),
            (1, 4),
            "turn {turn}"
        );
        assert!((polygons[0].area() - 0.0256).abs() < 1e-5);
    }
}

#[test]
fn repeated_and_flat_triangles_do_not_count_twice() {
    let mut shape = Shape::cells(&["##"]);
    let area = shape.area_vector();
    shape
        .triangles
        .extend([[0, 1, 2], [1, 2, 0], [0, 1, 1], [0, 3, 0]]);
    let polygons = shape.polygons();
    assert_eq!(polygons.len(), 1);
    assert_eq!(DVec3::from(polygons[0].area_vector()), area);
    assert_eq!(polygons[0].triangles.len(), 6);
    // A sheet with both sides is two polygons, back to back.
    let sheet = Shape::cells(&["#"]);
    let back: Vec<[u32; 3]> = sheet.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let triangles = [sheet.triangles, back].concat();
    let both = Shape {
        positions: sheet.positions,
        triangles,
        noise: 0.0,
    };
    assert_eq!(counts(&both), [(0, 4), (0, 4)]);
}

#[test]
fn texture_lights_with_its_mean_and_black_faces_are_dark() {
    let shape = Shape::cells(&["#", " ", "#"]);
    // The first square shows white and black halves, the second black alone.
    let texels = vec![[255, 255, 255, 255], [0, 0, 0, 255]];
    let sampler = Sampler {
        filter: crate::scene::Filter::Nearest,
        ..Sampler::default()
    };
    let texture = Texture::from_rgba8("", [2, 1], texels, true, sampler).unwrap();
    let uv = shape.positions.iter().map(|p| {
        if p.y > -0.5 {
            Vec2::new(p.x as f32, 0.5)
        } else {
            Vec2::new(0.6 + 0.3 * p.x as f32, 0.5)
        }
    });
    let material = Material {
        emissive: Vec3::new(8.0, 4.0, 0.0),
        emissive_texture: Some(TextureRef::default()),
        double_sided: true,
        ..Material::default()
    };
    let polygons = shape.polygons_with(&material, &[texture], uv.collect());
    assert_eq!(polygons.len(), 1);
    let error = (polygons[0].radiance - Vec3::new(4.0, 2.0, 0.0))
        .abs()
        .max_element();
    // All v are alike: the triangles have no area in texture space and are sampled.
    assert!(error < 0.2, "{}", polygons[0].radiance);
    assert!(polygons[0].two_sided);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Any pattern of cells, anywhere in space: areas add up, loops stay in their plane, and every
    /// triangle is inside one polygon.
    #[test]
    fn areas_add_up(
        rows in prop::collection::vec(0_u32..256, 1..8),
        scale in -3.0_f64..3.0,
        turn in prop::array::uniform3(-3.0_f64..3.0),
        shift in prop::array::uniform3(-50.0_f64..50.0),
    ) {
        let lines: Vec<String> = rows
            .iter()
            .map(|row| (0..8).map(|i| if row >> i & 1 == 1 { '#' } else { ' ' }).collect())
            .collect();
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        let mut shape = Shape::cells(&lines);
        let place = glam::DAffine3::from_scale_rotation_translation(
            DVec3::splat(10_f64.powf(scale)),
            glam::DQuat::from_scaled_axis(DVec3::from(turn)),
            DVec3::from(shift),
        );
        shape.positions.iter_mut().for_each(|p| *p = place.transform_point3(*p));
        let polygons = shape.polygons();
        let total: DVec3 = polygons.iter().map(|p| DVec3::from(p.area_vector())).sum();
        let expected = shape.area_vector();
        prop_assert!((total - expected).length() <= 1e-8 * expected.length());
        let mut triangles: Vec<u32> = polygons.iter().flat_map(|p| p.triangles.clone()).collect();
        triangles.sort_unstable();
        prop_assert_eq!(triangles, (0..shape.triangles.len() as u32).collect::<Vec<_>>());
        let normal = expected.normalize_or_zero();
        for polygon in &polygons {
            let origin = DVec3::from(polygon.loops[0][0]);
            for (i, vertices) in polygon.loops.iter().enumerate() {
                let mut area = DVec3::ZERO;
                for (k, &a) in vertices.iter().enumerate() {
                    let (a, b) = (DVec3::from(a), DVec3::from(vertices[(k + 1) % vertices.len()]));
                    prop_assert!((a - origin).dot(normal).abs() <= 1e-9 * (1.0 + place.matrix3.x_axis.length()));
                    area += (a - origin).cross(b - origin);
                }
                prop_assert!((area.dot(normal) > 0.0) == (i == 0), "loop {i} of {polygon:?}");
            }
        }
    }
}

/// Meshes that are large, or built to make a careless search quadratic.
#[test]
#[ignore = "takes seconds: a measurement"]
fn large_meshes_are_not_quadratic() {
    let time = |name: &str, shape: &Shape| {
        let start = std::time::Instant::now();
        let polygons = shape.polygons();
        let vertices: usize = polygons.iter().map(EmissivePolygon::vertex_count).sum();
        println!(
            "{name}: {} triangles, {} polygons, {vertices} vertices, {:.2} s",
            shape.triangles.len(),
            polygons.len(),
            start.elapsed().as_secs_f64()
        );
    };
    time("sphere", &icosphere(8));
    let p = |x: u32, y: u32| DVec3::new(f64::from(x), f64::from(y), 0.0);
    let n = 700;
    let cells = (0..n * n).map(|i| (i % n, i / n));
    let grid = cells.clone().flat_map(|(x, y)| {
        let [a, b, c, d] = [p(x, y), p(x + 1, y), p(x + 1, y + 1), p(x, y + 1)];
        [[a, b, c], [a, c, d]]
    });
    time("grid", &Shape::new(grid));
    let checks = cells.filter(|(x, y)| (x + y) % 2 == 0).flat_map(|(x, y)| {
        let [a, b, c, d] = [p(x, y), p(x + 1, y), p(x + 1, y + 1), p(x, y + 1)];
        [[a, b, c], [a, c, d]]
    });
    time("chequers", &Shape::new(checks));
    let angle = |i: u32| f64::from(i) * TAU / 3e5;
    let pages = (0..300_000).map(|i| {
        [
            DVec3::ZERO,
            DVec3::Z,
            DVec3::new(angle(i).cos(), angle(i).sin(), 0.5),
        ]
    });
    time("pages on a spine", &Shape::new(pages));
    let petals = (0..300_000).map(|i| {
        let at = |i: u32| DVec3::new(angle(i).cos(), angle(i).sin(), 0.0);
        [DVec3::ZERO, at(i), at(i) * 0.5 + at(i + 1) * 0.5]
    });
    time("petals on a vertex", &Shape::new(petals));
    let comb = (0..200_000).map(|i| {
        let x = f64::from(i % 1000) / 3000.0;
        [
            DVec3::X * x,
            DVec3::X * (1.0 - x * x),
            DVec3::new(0.5, 1.0 + f64::from(i), f64::from(i % 7)),
        ]
    });
    time("edges on one line", &Shape::new(comb));
    let shards = (0..300_000_u32).map(|i| {
        let random =
            |k: u32| f64::from((i * 9 + k).wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
        [0, 3, 6].map(|k| DVec3::new(random(k), random(k + 1), 0.0))
    });
    time("overlapping shards in a plane", &Shape::new(shards));
}
