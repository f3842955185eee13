//! Whether loops are an outline.

use glam::DVec2;
use robust::{Coord, orient2d};

use super::light::signed_area;
use super::outline::{Corner, contains};

/// Vertices and edges closer than this, as a fraction of the outline's size, touch: faces are welded
/// at a millionth of a mesh's size.
const TOUCHING: f64 = 4e-6;
/// Area of a loop below this fraction of its perimeter times the outline's size is none.
const NO_AREA: f64 = 4e-6;

/// What is wrong with an outline. Loops, vertices and edges are counted from 0; an edge starts at the
/// vertex of its number.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum OutlineFault {
    /// There is no loop.
    #[error("the outline has no loop")]
    NoLoop,
    /// A loop has fewer than three vertices.
    #[error("a loop needs at least three vertices, this has {count}")]
    TooFewVertices {
        /// Which loop.
        loop_index: usize,
        /// How many vertices it has.
        count: usize,
    },
    /// A coordinate is NaN, infinite or beyond 1e15 m.
    #[error("a vertex is not at a finite place")]
    NotFinite(Corner),
    /// Two vertices that follow each other are in one place.
    #[error("two neighbouring vertices are in one place: keep them apart, or delete one")]
    ShortEdge(Corner),
    /// Two edges cross, or one touches the other between its ends.
    #[error("the outline would cross or touch itself")]
    Crossing([Corner; 2]),
    /// A loop is too thin to be seen.
    #[error("a loop encloses no area")]
    NoArea {
        /// Which loop.
        loop_index: usize,
    },
    /// A hole is not inside the light.
    #[error("a hole lies outside the light")]
    HoleOutside {
        /// Which loop.
        loop_index: usize,
    },
    /// An outer loop runs clockwise, or lies inside another one.
    #[error("a loop is turned inside out")]
    InsideOut {
        /// Which loop.
        loop_index: usize,
    },
}

impl OutlineFault {
    /// Whether nothing can be made of it.
    pub(super) fn is_hard(self) -> bool {
        matches!(
            self,
            Self::NoLoop | Self::TooFewVertices { .. } | Self::NotFinite(_)
        )
    }
}

/// Whether loops are the outline of a light: outer loops counter-clockwise, holes clockwise and inside
/// them, the first loop an outer one. Loops may touch each other or themselves at vertices.
///
/// # Errors
/// The first fault found.
pub fn check(loops: &[Vec<DVec2>]) -> Result<(), OutlineFault> {
    if loops.is_empty() {
        return Err(OutlineFault::NoLoop);
    }
    let mut edges = Vec::new();
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for (loop_index, points) in loops.iter().enumerate() {
        let count = points.len();
        if count < 3 {
            return Err(OutlineFault::TooFewVertices { loop_index, count });
        }
        for (vertex, &p) in points.iter().enumerate() {
            let corner = Corner { loop_index, vertex };
            let is_in_range = p.abs().max_element() <= 1e15;
            if !is_in_range {
                return Err(OutlineFault::NotFinite(corner));
            }
            (low, high) = (low.min(p), high.max(p));
            let next = (vertex + 1) % count;
            edges.push(Edge {
                corner,
                next,
                a: p,
                b: points[next],
            });
        }
    }
    // NaN passes `max_element` where the other coordinate is a number.
    if let Some(edge) = edges.iter().find(|edge| !edge.a.is_finite()) {
        return Err(OutlineFault::NotFinite(edge.corner));
    }
    let size = (high - low).length();
    let tolerance = TOUCHING * size;
    if let Some(edge) = edges
        .iter()
        .find(|edge| edge.a.distance(edge.b) <= tolerance)
    {
        return Err(OutlineFault::ShortEdge(edge.corner));
    }
    if let Some(pair) = crossing(&mut edges, tolerance) {
        return Err(OutlineFault::Crossing(pair));
    }
    if let Some(pair) = crossing_at_vertex(&edges) {
        return Err(OutlineFault::Crossing(pair));
    }
    for (loop_index, points) in loops.iter().enumerate() {
        let around = points.iter().zip(points.iter().cycle().skip(1));
        let perimeter: f64 = around.map(|(a, b)| a.distance(*b)).sum();
        if signed_area(points).abs() <= NO_AREA * perimeter * size {
            return Err(OutlineFault::NoArea { loop_index });
        }
    }
    nesting(loops)
}

/// Outer loops lie in an even number of others, holes in an odd one.
fn nesting(loops: &[Vec<DVec2>]) -> Result<(), OutlineFault> {
    for (loop_index, points) in loops.iter().enumerate() {
        let inside = (points[0] + points[1]) * 0.5;
        let others = loops
            .iter()
            .enumerate()
            .filter(|&(other, _)| other != loop_index);
        let depth = others.filter(|(_, other)| contains(other, inside)).count();
        let is_outer = signed_area(points) > 0.0;
        match (is_outer, depth % 2) {
            (true, 1) => return Err(OutlineFault::InsideOut { loop_index }),
            (false, 0) if loop_index == 0 => return Err(OutlineFault::InsideOut { loop_index }),
            (false, 0) => return Err(OutlineFault::HoleOutside { loop_index }),
            _ => {}
        }
    }
    Ok(())
}

#[derive(Clone, Copy)]
struct Edge {
    corner: Corner,
    /// The vertex it ends at.
    next: usize,
    a: DVec2,
    b: DVec2,
}

/// The first two edges found that cross, in order of their corners. Sweeps along x.
fn crossing(edges: &mut [Edge], tolerance: f64) -> Option<[Corner; 2]> {
    edges.sort_by(|e, f| e.a.x.min(e.b.x).total_cmp(&f.a.x.min(f.b.x)));
    let mut open: Vec<Edge> = Vec::new();
    for edge in edges.iter() {
        let left = edge.a.x.min(edge.b.x) - tolerance;
        open.retain(|other| other.a.x.max(other.b.x) >= left);
        let (low, high) = (edge.a.y.min(edge.b.y), edge.a.y.max(edge.b.y));
        for other in &open {
            let apart = other.a.y.max(other.b.y) < low - tolerance
                || other.a.y.min(other.b.y) > high + tolerance;
            if !apart && cross(edge, other, tolerance) {
                let key = |corner: &Corner| (corner.loop_index, corner.vertex);
                let mut pair = [edge.corner, other.corner];
                pair.sort_by_key(key);
                return Some(pair);
            }
        }
        open.push(*edge);
    }
    None
}

/// Whether two edges cross, lie along each other, or touch but at a vertex of both.
fn cross(e: &Edge, f: &Edge, tolerance: f64) -> bool {
    let near = |p: DVec2, edge: &Edge| distance_to_segment(p, edge.a, edge.b) <= tolerance;
    // In one place, bit for bit: what merely comes close is drawn together by welding.
    if e.b == f.a {
        return near(e.a, f) || near(f.b, e);
    }
    if e.a == f.b {
        return near(e.b, f) || near(f.a, e);
    }
    if e.a == f.a {
        return near(e.b, f) || near(f.b, e);
    }
    if e.b == f.b {
        return near(e.a, f) || near(f.a, e);
    }
    let side = |edge: &Edge, p: DVec2| orientation(edge.a, edge.b, p);
    let opposite = |x: f64, y: f64| (x > 0.0 && y < 0.0) || (x < 0.0 && y > 0.0);
    let crosses = opposite(side(e, f.a), side(e, f.b)) && opposite(side(f, e.a), side(f, e.b));
    crosses || near(e.a, f) || near(e.b, f) || near(f.a, e) || near(f.b, e)
}

/// Two parts of the outline that pass through each other at a vertex that they share.
fn crossing_at_vertex(edges: &[Edge]) -> Option<[Corner; 2]> {
    // The edges into and out of each vertex.
    let mut visits: Vec<(Edge, Edge)> = Vec::with_capacity(edges.len());
    let by_corner: std::collections::HashMap<(usize, usize), Edge> = edges
        .iter()
        .map(|edge| ((edge.corner.loop_index, edge.corner.vertex), *edge))
        .collect();
    for edge in edges {
        if let Some(next) = by_corner.get(&(edge.corner.loop_index, edge.next)) {
            visits.push((*edge, *next));
        }
    }
    let order = |p: DVec2, q: DVec2| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y));
    visits.sort_by(|v, w| order(v.0.b + 0.0, w.0.b + 0.0));
    for group in visits.chunk_by(|v, w| v.0.b == w.0.b) {
        for (i, v) in group.iter().enumerate() {
            for w in &group[i + 1..] {
                let at = v.0.b;
                let inside = |p: DVec2| in_sector(at, v.1.b, v.0.a, p);
                if inside(w.0.a) != inside(w.1.b) {
                    return Some([v.1.corner, w.1.corner]);
                }
            }
        }
    }
    None
}

/// Whether a point lies in the angle at a vertex counter-clockwise from one direction to another.
fn in_sector(at: DVec2, from: DVec2, to: DVec2, p: DVec2) -> bool {
    let left = |a: DVec2, b: DVec2| orientation(at, a, b) > 0.0;
    if left(from, to) {
        left(from, p) && left(p, to)
    } else {
        !(left(to, p) && left(p, from))
    }
}

/// The sign of the doubled area of a triangle, without rounding: positive where it runs
/// counter-clockwise (Shewchuk 1997, "Adaptive precision floating-point arithmetic and fast robust
/// geometric predicates").
fn orientation(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c)
}

fn distance_to_segment(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (a + along * t).distance(p)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(list: &[(f64, f64)]) -> Vec<DVec2> {
        list.iter().copied().map(DVec2::from).collect()
    }

    fn square(x: f64, y: f64, side: f64) -> Vec<DVec2> {
        points(&[(x, y), (x + side, y), (x + side, y + side), (x, y + side)])
    }

    fn hole(x: f64, y: f64, side: f64) -> Vec<DVec2> {
        let mut points = square(x, y, side);
        points.reverse();
        points
    }

    fn corner(loop_index: usize, vertex: usize) -> Corner {
        Corner { loop_index, vertex }
    }

    #[test]
    fn crossings_name_their_edges() {
        let bow_tie = points(&[(0., 0.), (1., 1.), (1., 0.), (0., 1.)]);
        let fault = OutlineFault::Crossing([corner(0, 0), corner(0, 2)]);
        assert_eq!(check(&[bow_tie]), Err(fault));
        let through = [square(0., 0., 4.), hole(3., 1., 2.)];
        let Err(OutlineFault::Crossing([a, b])) = check(&through) else {
            panic!("{:?}", check(&through))
        };
        assert_eq!((a.loop_index, b.loop_index), (0, 1));
        // A vertex in the middle of another edge, and edges along each other.
        for inner in [hole(0., 1., 1.), points(&[(2., 0.), (1., 2.), (3., 2.)])] {
            let touching = [square(0., 0., 4.), inner];
            assert!(matches!(check(&touching), Err(OutlineFault::Crossing(_))));
        }
        // A spike that folds back on itself.
        let spike = points(&[(0., 0.), (2., 0.), (4., 0.), (2., 1e-9), (2., 2.)]);
        assert!(matches!(check(&[spike]), Err(OutlineFault::Crossing(_))));
    }

    #[test]
    fn loops_may_touch_at_vertices_but_not_pass_there() {
        let diamond = points(&[(0., 2.), (1., 3.), (2., 2.), (1., 1.)]);
        assert_eq!(
            check(&[square(0., 0., 4.), hole(1., 1., 1.), hole(2., 2., 1.)]),
            Ok(())
        );
        let with_corner = points(&[(0., 0.), (4., 0.), (4., 4.), (0., 4.), (0., 2.)]);
        assert_eq!(check(&[with_corner, diamond]), Ok(()));
        // A loop that touches itself, once around its own hole.
        let pinched = points(&[(0., 0.), (4., 0.), (4., 4.), (2., 2.), (0., 4.)]);
        assert_eq!(check(&[pinched]), Ok(()));
        // An eight whose halves run the same way round passes through no vertex ...
        let eight = points(&[
            (0., 0.),
            (1., 0.),
            (1., 1.),
            (2., 1.),
            (2., 2.),
            (1., 2.),
            (1., 1.),
            (0., 1.),
        ]);
        assert_eq!(check(&[eight]), Ok(()));
        // ... one whose halves run opposite ways does.
        let crossed = points(&[(0., 0.), (1., 1.), (2., 2.), (2., 0.), (1., 1.), (0., 2.)]);
        assert!(matches!(check(&[crossed]), Err(OutlineFault::Crossing(_))));
    }

    #[test]
    fn loops_nest_by_their_sense() {
        assert_eq!(
            check(&[square(0., 0., 4.), hole(1., 1., 2.), square(1.5, 1.5, 1.)]),
            Ok(())
        );
        assert_eq!(check(&[square(0., 0., 1.), square(2., 0., 1.)]), Ok(()));
        let inside_out = |loop_index| Err(OutlineFault::InsideOut { loop_index });
        assert_eq!(check(&[hole(0., 0., 1.)]), inside_out(0));
        assert_eq!(
            check(&[square(0., 0., 4.), square(1., 1., 2.)]),
            inside_out(1)
        );
        assert_eq!(
            check(&[square(0., 0., 4.), hole(5., 1., 2.)]),
            Err(OutlineFault::HoleOutside { loop_index: 1 })
        );
    }

    #[test]
    fn what_is_no_loop() {
        assert_eq!(check(&[]), Err(OutlineFault::NoLoop));
        let too_few = OutlineFault::TooFewVertices {
            loop_index: 1,
            count: 2,
        };
        assert_eq!(
            check(&[square(0., 0., 1.), points(&[(0., 0.), (1., 0.)])]),
            Err(too_few)
        );
        for bad in [f64::NAN, f64::INFINITY, 1e200] {
            for place in 0..2 {
                let mut square = square(0., 0., 1.);
                square[2][place] = bad;
                assert_eq!(check(&[square]), Err(OutlineFault::NotFinite(corner(0, 2))));
            }
        }
        let mut repeated = square(0., 0., 1.);
        repeated.push(repeated[3]);
        assert_eq!(
            check(&[repeated]),
            Err(OutlineFault::ShortEdge(corner(0, 3)))
        );
        assert!(check(&[vec![DVec2::ONE; 3]]).is_err());
        assert!(check(&[points(&[(0., 0.), (1., 0.), (2., 0.)])]).is_err());
    }

    #[test]
    fn many_vertices_are_no_hindrance() {
        let circle = |count: u32, radius: f64| -> Vec<DVec2> {
            let angle = |i: u32| f64::from(i) * std::f64::consts::TAU / f64::from(count);
            (0..count)
                .map(|i| DVec2::from_angle(angle(i)) * radius)
                .collect()
        };
        let mut inner = circle(20_000, 0.5);
        inner.reverse();
        let loops = [circle(20_000, 1.0), inner];
        let start = std::time::Instant::now();
        assert_eq!(check(&loops), Ok(()));
        // 10⁹ pairs of edges would take seconds.
        assert!(start.elapsed().as_millis() < 1000, "{:?}", start.elapsed());
    }
}
