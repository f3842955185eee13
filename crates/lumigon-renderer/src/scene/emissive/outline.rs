//! The boundary of a facet as loops.

use std::{collections::HashMap, f64::consts::PI};

use glam::{DVec2, DVec3};

use super::{facet::Facet, junction::Edge, weld::Welded};

/// Vertices closer than this fraction of the facet's size to the line between their neighbours are
/// dropped. A regular polygon of up to 10,000 corners keeps them all.
const STRAIGHT: f64 = 1e-7;
/// Where a facet has several outer loops, its holes and triangles are sought in them up to this much
/// work for each triangle; beyond it they go to the largest.
const MAX_SEARCH: usize = 4096;

/// One outer loop with its holes.
pub(super) struct Outline {
    /// The outer loop, counter-clockwise about the facet's normal, then the holes, clockwise; all
    /// vertices in the facet's plane.
    pub(super) loops: Vec<Vec<[f64; 3]>>,
    /// The facet's triangles inside it, as indices of welded triangles.
    pub(super) triangles: Vec<u32>,
}

/// The directed edges that bound each facet: of those inside, each cancels its opposite.
pub(super) fn boundaries(edges: &[Edge], facets: &[Facet], count: usize) -> Vec<Vec<(u32, u32)>> {
    let mut facet_of = vec![u32::MAX; count];
    for (index, facet) in (0_u32..).zip(facets) {
        for &t in &facet.triangles {
            facet_of[t as usize] = index;
        }
    }
    let mut boundaries = vec![Vec::new(); facets.len()];
    let mut meeting: Vec<(u32, bool)> = Vec::new();
    for run in edges.chunk_by(|a, b| a.ends() == b.ends()) {
        meeting.clear();
        let of_run = run
            .iter()
            .map(|edge| (facet_of[edge.triangle as usize], edge.forward));
        meeting.extend(of_run);
        meeting.sort_unstable();
        let (low, high) = run[0].ends();
        for same in meeting.chunk_by(|a, b| a.0 == b.0) {
            let forward = same.iter().filter(|(_, forward)| *forward).count();
            let backward = same.len() - forward;
            let boundary: &mut Vec<_> = &mut boundaries[same[0].0 as usize];
            boundary.extend(std::iter::repeat_n(
                (low, high),
                forward.saturating_sub(backward),
            ));
            boundary.extend(std::iter::repeat_n(
                (high, low),
                backward.saturating_sub(forward),
            ));
        }
    }
    boundaries
}

/// The outlines that a facet's boundary edges make up, the largest first. There is one, unless
/// the facet's triangles overlap or meet at a vertex alone.
pub(super) fn outlines(
    welded: &Welded,
    boundary: &[(u32, u32)],
    facet: &Facet,
    noise: f64,
) -> Vec<Outline> {
    if let &[triangle] = facet.triangles.as_slice()
        && boundary.len() == 3
    {
        // Most facets of a curved mesh.
        return vec![Outline {
            loops: vec![welded.corners(triangle).map(|p| p.to_array()).to_vec()],
            triangles: vec![triangle],
        }];
    }
    let frame = Frame::new(facet);
    let tolerance = STRAIGHT * facet.extent + 2.0 * noise;
    let point = |vertex: u32| frame.project(welded.vertices[vertex as usize]);

    let mut outers: Vec<Loop> = Vec::new();
    let mut holes: Vec<Loop> = Vec::new();
    for cycle in cycles(boundary, point) {
        for simple in split_at_repeats(&cycle) {
            let points: Vec<DVec2> = simple.into_iter().map(point).collect();
            let Some(outline) = Loop::new(&straightened(&points, tolerance)) else {
                continue;
            };
            // What is no wider than the tolerance is a slit.
            if outline.area > tolerance * outline.perimeter {
                outers.push(outline);
            } else if outline.area < -tolerance * outline.perimeter {
                holes.push(outline);
            }
        }
    }
    outers.sort_by(|a, b| b.area.total_cmp(&a.area));

    let vertices: usize = outers.iter().map(|outer| outer.points.len()).sum();
    let work = vertices.saturating_mul(holes.len() + facet.triangles.len());
    let home = |p: DVec2| {
        let searched = outers.len() > 1 && work / facet.triangles.len() <= MAX_SEARCH;
        // The smallest one around it, if any is.
        let found = searched.then(|| outers.iter().rposition(|outer| outer.contains(p)));
        found.flatten().unwrap_or(0)
    };
    let mut loops: Vec<Vec<Vec<[f64; 3]>>> = outers
        .iter()
        .map(|outer| vec![frame.lift(&outer.points)])
        .collect();
    let mut triangles = vec![Vec::new(); outers.len()];
    if outers.is_empty() {
        return Vec::new();
    }
    for hole in &holes {
        loops[home(hole.middle_of_longest_edge())].push(frame.lift(&hole.points));
    }
    for &t in &facet.triangles {
        let [a, b, c] = welded.corners(t).map(|p| frame.project(p));
        triangles[home((a + b + c) / 3.0)].push(t);
    }
    loops
        .into_iter()
        .zip(triangles)
        .map(|(loops, triangles)| Outline { loops, triangles })
        .collect()
}

/// Coordinates in a facet's plane; x, y and the normal are right-handed.
struct Frame {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
}

impl Frame {
    fn new(facet: &Facet) -> Self {
        let (x, y) = facet.normal.any_orthonormal_pair();
        let (x, y) = if x.cross(y).dot(facet.normal) < 0.0 {
            (y, x)
        } else {
            (x, y)
        };
        Self {
            origin: facet.center,
            x,
            y,
        }
    }

    fn project(&self, p: DVec3) -> DVec2 {
        let p = p - self.origin;
        DVec2::new(p.dot(self.x), p.dot(self.y))
    }

    /// Back to the world: the plane's point nearest to the one that was projected.
    fn lift(&self, points: &[DVec2]) -> Vec<[f64; 3]> {
        let lift = |p: &DVec2| (self.origin + self.x * p.x + self.y * p.y).to_array();
        points.iter().map(lift).collect()
    }
}

/// Follows boundary edges into closed walks of vertices.
///
/// Where several edges meet, the walk turns so that it keeps the same corner of the facet on its
/// left: walks never cross each other or themselves, though they may touch.
fn cycles(boundary: &[(u32, u32)], point: impl Fn(u32) -> DVec2) -> Vec<Vec<u32>> {
    // Ends of edges, gathered by vertex. Each vertex has as many edges out as in.
    let mut ends: Vec<End> = Vec::with_capacity(2 * boundary.len());
    for (edge, &(from, to)) in (0_u32..).zip(boundary) {
        let along = point(to) - point(from);
        ends.push(End::new(from, along, edge, true));
        ends.push(End::new(to, -along, edge, false));
    }
    ends.sort_unstable_by(|a, b| {
        let order = a.vertex.cmp(&b.vertex).then(a.angle.total_cmp(&b.angle));
        order
            .then(b.leaves.cmp(&a.leaves))
            .then(a.edge.cmp(&b.edge))
    });
    let mut next = vec![u32::MAX; boundary.len()];
    let mut open: Vec<u32> = Vec::new();
    for around in ends.chunk_by(|a, b| a.vertex == b.vertex) {
        // Counter-clockwise around the vertex, the facet lies between an edge out and the next edge
        // in: they pair like brackets, on a circle, hence twice around.
        open.clear();
        for (i, end) in around.iter().chain(around).enumerate() {
            if end.leaves {
                // The second time around, those that are still open are on the stack.
                if i < around.len() {
                    open.push(end.edge);
                }
            } else if next[end.edge as usize] == u32::MAX
                && let Some(edge) = open.pop()
            {
                next[end.edge as usize] = edge;
            }
        }
    }

    let mut walked = vec![false; boundary.len()];
    let mut cycles = Vec::new();
    for start in 0..boundary.len() {
        let mut cycle = Vec::new();
        let mut edge = start;
        while !std::mem::replace(&mut walked[edge], true) {
            cycle.push(boundary[edge].0);
            edge = next[edge] as usize;
        }
        if !cycle.is_empty() {
            cycles.push(cycle);
        }
    }
    cycles
}

/// One end of a boundary edge.
struct End {
    vertex: u32,
    /// Of the edge as seen from the vertex.
    angle: f64,
    edge: u32,
    /// The edge starts here.
    leaves: bool,
}

impl End {
    fn new(vertex: u32, away: DVec2, edge: u32, leaves: bool) -> Self {
        Self {
            vertex,
            angle: away.y.atan2(away.x),
            edge,
            leaves,
        }
    }
}

/// Cuts a closed walk into loops that visit no vertex twice.
fn split_at_repeats(cycle: &[u32]) -> Vec<Vec<u32>> {
    let mut loops = Vec::new();
    let mut path: Vec<u32> = Vec::with_capacity(cycle.len());
    let mut place: HashMap<u32, usize> = HashMap::with_capacity(cycle.len());
    for &vertex in cycle {
        if let Some(&start) = place.get(&vertex) {
            let simple = path.split_off(start);
            for visited in &simple {
                place.remove(visited);
            }
            loops.push(simple);
        }
        place.insert(vertex, path.len());
        path.push(vertex);
    }
    loops.push(path);
    loops
}

/// Drops vertices that lie within `tolerance` of the line that replaces them: a line from a kept
/// vertex goes on while its direction passes all dropped ones that closely (sleeve fitting: Zhao
/// and Saalfeld 1997, "Linear-time sleeve-fitting polyline simplification algorithms").
fn straightened(points: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    // A corner for certain, whatever the tolerance: the leftmost vertex.
    let by_x = |&a: &usize, &b: &usize| {
        let (p, q) = (points[a], points[b]);
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y))
    };
    let Some(first) = (0..points.len()).min_by(by_x) else {
        return Vec::new();
    };
    let at = |i: usize| points[(first + i) % points.len()];
    let mut kept = vec![at(0)];
    let mut sleeve: Option<Sleeve> = None;
    let mut previous = at(0);
    for point in (1..=points.len()).map(at) {
        let anchor = kept[kept.len() - 1];
        if let Some(sleeve) = &mut sleeve
            && sleeve.take(point - anchor)
        {
            previous = point;
            continue;
        }
        if sleeve.is_some() {
            kept.push(previous);
        }
        sleeve = Some(Sleeve::new(point - kept[kept.len() - 1], tolerance));
        previous = point;
    }
    kept
}

/// The directions from an anchor that pass every vertex so far within the tolerance.
struct Sleeve {
    /// Towards the first vertex; angles are measured from it.
    axis: DVec2,
    low: f64,
    high: f64,
    reach: f64,
    tolerance: f64,
}

impl Sleeve {
    fn new(first: DVec2, tolerance: f64) -> Self {
        let mut sleeve = Self {
            axis: first,
            low: -PI,
            high: PI,
            reach: 0.0,
            tolerance,
        };
        sleeve.narrow(first, 0.0);
        sleeve
    }

    /// Whether a line to `to`, farther than all before it, passes them closely enough; if so, `to`
    /// becomes one of them.
    fn take(&mut self, to: DVec2) -> bool {
        let angle = self.axis.perp_dot(to).atan2(self.axis.dot(to));
        let fits = to.length() > self.reach && self.low <= angle && angle <= self.high;
        if fits {
            self.narrow(to, angle);
        }
        fits
    }

    fn narrow(&mut self, to: DVec2, angle: f64) {
        self.reach = to.length();
        // Within the tolerance of the anchor itself, every direction passes.
        if self.tolerance < self.reach {
            let half = (self.tolerance / self.reach).asin();
            self.low = self.low.max(angle - half);
            self.high = self.high.min(angle + half);
        }
    }
}

/// A closed loop in the facet's plane.
struct Loop {
    points: Vec<DVec2>,
    /// Signed: counter-clockwise is positive.
    area: f64,
    perimeter: f64,
    low: DVec2,
    high: DVec2,
}

impl Loop {
    /// `None` for fewer than three points.
    fn new(points: &[DVec2]) -> Option<Self> {
        if points.len() < 3 {
            return None;
        }
        let edges = || points.iter().zip(points.iter().cycle().skip(1));
        let area = edges()
            .map(|(&a, &b)| (a - points[0]).perp_dot(b - points[0]))
            .sum::<f64>();
        Some(Self {
            points: points.to_vec(),
            area: 0.5 * area,
            perimeter: edges().map(|(&a, &b)| a.distance(b)).sum(),
            low: points.iter().copied().fold(DVec2::INFINITY, DVec2::min),
            high: points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max),
        })
    }

    /// Crossing number: odd to the right of an inside point.
    fn contains(&self, p: DVec2) -> bool {
        if p.cmplt(self.low).any() || p.cmpgt(self.high).any() {
            return false;
        }
        let edges = self.points.iter().zip(self.points.iter().cycle().skip(1));
        let crossings = edges.filter(|&(&a, &b)| {
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        crossings.count() % 2 == 1
    }

    /// A point of the loop that no loop it touches at a vertex shares.
    fn middle_of_longest_edge(&self) -> DVec2 {
        let edges = self.points.iter().zip(self.points.iter().cycle().skip(1));
        let longest = edges
            .max_by(|(a, b), (c, d)| a.distance_squared(**b).total_cmp(&c.distance_squared(**d)));
        longest.map_or(self.points[0], |(&a, &b)| (a + b) * 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn collinear_vertices_go_and_corners_stay() {
        let square: Vec<DVec2> = (0..40)
            .map(|i| {
                let along = f64::from(i % 10) / 10.0;
                match i / 10 {
                    0 => DVec2::new(along, 0.0),
                    1 => DVec2::new(1.0, along),
                    2 => DVec2::new(1.0 - along, 1.0),
                    _ => DVec2::new(0.0, 1.0 - along),
                }
            })
            .collect();
        for turn in 0..40 {
            let mut turned = square.clone();
            turned.rotate_left(turn);
            assert_eq!(
                straightened(&turned, 1e-9),
                [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(DVec2::from)
            );
        }
    }

    #[test]
    fn a_fine_arc_does_not_drift() {
        let circle: Vec<DVec2> = (0..100_000)
            .map(|i| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 1e5))
            .collect();
        let kept = straightened(&circle, 1e-6);
        let outline = Loop::new(&kept).unwrap();
        // Chords no farther than 1e-6 from the arc are about 2.8e-3 long, 2200 of them.
        assert!((1500..4500).contains(&kept.len()), "{}", kept.len());
        assert!((outline.area - PI).abs() < 5e-6, "{}", outline.area - PI);
    }

    #[test]
    fn walks_are_cut_at_repeated_vertices() {
        let loops = split_at_repeats(&[1, 2, 3, 4, 2, 5]);
        assert_eq!(loops, [vec![2, 3, 4], vec![1, 2, 5]]);
    }
}
