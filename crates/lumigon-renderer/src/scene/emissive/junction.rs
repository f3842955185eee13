//! Edges, split where another triangle's vertex lies on them.
//!
//! Two triangles may share only part of an edge (a T-junction). Split at the vertices that lie on
//! them, such edges share whole pieces, which cancel like any other edge inside a facet.

use glam::DVec3;

use super::weld::Welded;

/// A directed edge of one triangle, or a piece of one. Sorted so that pieces between the same two
/// vertices are neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Edge {
    /// The smaller of its two vertices.
    pub(super) low: u32,
    /// The larger of its two vertices.
    pub(super) high: u32,
    pub(super) triangle: u32,
    /// It runs from `low` to `high`.
    pub(super) forward: bool,
}

impl Edge {
    fn new(from: u32, to: u32, triangle: u32) -> Self {
        Self {
            low: from.min(to),
            high: from.max(to),
            triangle,
            forward: from < to,
        }
    }

    pub(super) fn ends(&self) -> (u32, u32) {
        (self.low, self.high)
    }
}

/// All edges of all triangles, split, sorted by [`Edge::ends`].
pub(super) fn edges(welded: &Welded) -> Vec<Edge> {
    let mut edges: Vec<Edge> = (0_u32..)
        .zip(&welded.triangles)
        .flat_map(|(t, &[a, b, c])| [Edge::new(a, b, t), Edge::new(b, c, t), Edge::new(c, a, t)])
        .collect();
    edges.sort_unstable();

    // Only edges that no other triangle runs along the other way can be part of a T-junction.
    let mut lone: Vec<Edge> = Vec::new();
    let mut matched: Vec<Edge> = Vec::with_capacity(edges.len());
    for run in edges.chunk_by(|a, b| a.ends() == b.ends()) {
        let forward = run.iter().filter(|edge| edge.forward).count();
        let balanced = 2 * forward == run.len();
        if balanced { &mut matched } else { &mut lone }.extend_from_slice(run);
    }
    let mut ends: Vec<u32> = lone.iter().flat_map(|edge| [edge.low, edge.high]).collect();
    ends.sort_unstable();
    ends.dedup();
    let tree = PointTree::new(&welded.vertices, ends);

    // Many edges along one line hold each other's vertices: beyond this much work they stay whole.
    // That leaves slits without area, which add nothing to an integral around the outline.
    let mut work = 64 * lone.len() + 4096;
    let mut split = Vec::new();
    for edge in lone {
        split.clear();
        tree.on_segment(edge.low, edge.high, welded.tolerance, &mut work, &mut split);
        split.sort_unstable_by(|a: &(f64, u32), b| a.0.total_cmp(&b.0));
        let mut from = edge.low;
        for to in split.iter().map(|&(_, vertex)| vertex).chain([edge.high]) {
            let (a, b) = if edge.forward { (from, to) } else { (to, from) };
            matched.push(Edge::new(a, b, edge.triangle));
            from = to;
        }
    }
    matched.sort_unstable();
    matched
}

/// A balanced k-d tree, stored in the order of its points: the middle of a range splits it.
struct PointTree<'a> {
    vertices: &'a [DVec3],
    order: Vec<u32>,
}

impl<'a> PointTree<'a> {
    fn new(vertices: &'a [DVec3], mut order: Vec<u32>) -> Self {
        fn arrange(vertices: &[DVec3], order: &mut [u32], axis: usize) {
            if order.len() < 2 {
                return;
            }
            let middle = order.len() / 2;
            order.select_nth_unstable_by(middle, |&a, &b| {
                vertices[a as usize][axis].total_cmp(&vertices[b as usize][axis])
            });
            let (left, right) = order.split_at_mut(middle);
            arrange(vertices, left, (axis + 1) % 3);
            arrange(vertices, &mut right[1..], (axis + 1) % 3);
        }
        arrange(vertices, &mut order, 0);
        Self { vertices, order }
    }

    /// Finds the vertices within `tolerance` of the inside of a segment, with how far along it
    /// they lie. Stops when `work` is used up.
    fn on_segment(
        &self,
        from: u32,
        to: u32,
        tolerance: f64,
        work: &mut usize,
        found: &mut Vec<(f64, u32)>,
    ) {
        let origin = self.vertices[from as usize];
        let along = self.vertices[to as usize] - origin;
        let length = along.length();
        // Ranges of the order still to visit, with the part of the segment that comes near them.
        let mut stack = vec![(0, self.order.len(), 0, 0.0_f64, 1.0_f64)];
        while let Some((start, end, axis, t0, t1)) = stack.pop() {
            if start == end || *work == 0 {
                continue;
            }
            *work -= 1;
            let middle = start + (end - start) / 2;
            let vertex = self.order[middle];
            let p = self.vertices[vertex as usize] - origin;
            let t = p.dot(along) / (length * length);
            let inside = t * length > tolerance && (1.0 - t) * length > tolerance;
            if inside && vertex != from && vertex != to && (p - along * t).length() <= tolerance {
                found.push((t, vertex));
            }
            let next = (axis + 1) % 3;
            let (plane, slope) = (p[axis], along[axis]);
            if let Some((a, b)) = at_most(plane + tolerance, slope, t0, t1) {
                stack.push((start, middle, next, a, b));
            }
            if let Some((a, b)) = at_most(tolerance - plane, -slope, t0, t1) {
                stack.push((middle + 1, end, next, a, b));
            }
        }
    }
}

/// The part of [t0, t1] where `slope * t <= bound`.
fn at_most(bound: f64, slope: f64, t0: f64, t1: f64) -> Option<(f64, f64)> {
    if slope * t0 <= bound && slope * t1 <= bound {
        return Some((t0, t1));
    }
    if slope * t0 > bound && slope * t1 > bound {
        return None;
    }
    let t = (bound / slope).clamp(t0, t1);
    if slope > 0.0 {
        Some((t0, t))
    } else {
        Some((t, t1))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn tree_finds_what_a_search_finds(
            points in prop::collection::vec((0_i32..6, 0_i32..6, 0_i32..3), 2..80),
        ) {
            let mut points = points;
            points.sort_unstable();
            points.dedup();
            let vertices: Vec<DVec3> = points
                .iter()
                .map(|&(x, y, z)| DVec3::new(f64::from(x), f64::from(y), f64::from(z)))
                .collect();
            let tree = PointTree::new(&vertices, (0..vertices.len() as u32).collect());
            let (from, to) = (0_u32, vertices.len() as u32 - 1);
            prop_assume!(from != to);
            let (a, b) = (vertices[from as usize], vertices[to as usize]);
            let mut found = Vec::new();
            tree.on_segment(from, to, 1e-6, &mut usize::MAX.clone(), &mut found);
            let mut found: Vec<u32> = found.into_iter().map(|(_, vertex)| vertex).collect();
            found.sort_unstable();
            let expected: Vec<u32> = (from + 1..to)
                .filter(|&i| {
                    let p = vertices[i as usize];
                    (p.distance(a) + p.distance(b) - a.distance(b)).abs() < 1e-9
                })
                .collect();
            prop_assert_eq!(found, expected);
        }
    }
}
