//! Vertices that share a position become one.

use std::collections::HashMap;

use glam::DVec3;

/// Two vertices closer than this fraction of the mesh's size are one.
const WELD_FRACTION: f64 = 1e-6;

/// Triangles on shared vertices: no two are alike and none is thinner than the tolerance.
pub(super) struct Welded {
    pub(super) vertices: Vec<DVec3>,
    /// Indices into `vertices`.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Vertices this close to an edge lie on it, in metres.
    pub(super) tolerance: f64,
    /// Indices of the mesh's triangles, those of `triangles[i]` from `source_starts[i]`.
    source_list: Vec<u32>,
    source_starts: Vec<u32>,
}

impl Welded {
    /// The mesh's triangles that a welded one stands for: more than one where they coincide.
    pub(super) fn sources(&self, triangle: u32) -> impl Iterator<Item = u32> {
        let i = triangle as usize;
        let range = self.source_starts[i] as usize..self.source_starts[i + 1] as usize;
        self.source_list[range].iter().copied()
    }

    pub(super) fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|i| self.vertices[i as usize])
    }

    /// Half the cross product: the triangle's area along its normal.
    pub(super) fn area_vector(&self, triangle: u32) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a) * 0.5
    }
}

/// Welds `positions` and drops triangles that have no width or stand there already.
pub(super) fn weld(positions: &[DVec3], triangles: &[[u32; 3]], noise: f64) -> Welded {
    let corners = || triangles.iter().flatten().map(|&i| positions[i as usize]);
    let low = corners().fold(DVec3::INFINITY, DVec3::min);
    let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
    let size = (high - low).length();
    let tolerance = if size.is_finite() {
        size * WELD_FRACTION
    } else {
        0.0
    };

    let mut welder = Welder::new(tolerance);
    let mut welded_index: Vec<u32> = vec![u32::MAX; positions.len()];
    let mut faces: Vec<([u32; 3], u32)> = Vec::with_capacity(triangles.len());
    for (source, triangle) in triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|i| {
            let welded = &mut welded_index[i as usize];
            if *welded == u32::MAX {
                *welded = welder.insert(positions[i as usize]);
            }
            *welded
        });
        let corners = [a, b, c].map(|i| welder.vertices[i as usize]);
        if a != b && b != c && c != a && has_width(corners, noise) {
            // Turned so that its smallest index leads: alike triangles become equal.
            let turned = match a.min(b).min(c) {
                least if least == a => [a, b, c],
                least if least == b => [b, c, a],
                _ => [c, a, b],
            };
            faces.push((turned, source as u32));
        }
    }
    faces.sort_unstable();

    let mut welded = Welded {
        vertices: welder.vertices,
        triangles: Vec::with_capacity(faces.len()),
        tolerance,
        source_list: Vec::with_capacity(faces.len()),
        source_starts: Vec::with_capacity(faces.len() + 1),
    };
    for (triangle, source) in faces {
        if welded.triangles.last() != Some(&triangle) {
            welded.source_starts.push(welded.source_list.len() as u32);
            welded.triangles.push(triangle);
        }
        welded.source_list.push(source);
    }
    welded.source_starts.push(welded.source_list.len() as u32);
    welded
}

/// Whether a triangle is wide enough for its normal to mean something.
fn has_width([a, b, c]: [DVec3; 3], noise: f64) -> bool {
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let height = (b - a).cross(c - a).length() / longest;
    height > noise.max(1e-9 * longest)
}

/// A hash grid of vertices no two of which are within the tolerance of each other.
struct Welder {
    vertices: Vec<DVec3>,
    tolerance: f64,
    /// The last vertex of each cell.
    cells: HashMap<[i64; 3], u32>,
    /// The vertex before it in the same cell.
    previous: Vec<u32>,
}

impl Welder {
    fn new(tolerance: f64) -> Self {
        Self {
            vertices: Vec::new(),
            tolerance,
            cells: HashMap::new(),
            previous: Vec::new(),
        }
    }

    /// Cells four tolerances wide: most vertices have all of their neighbourhood in one.
    fn cell(&self, p: DVec3) -> [i64; 3] {
        if self.tolerance > 0.0 {
            // The cast saturates.
            (p / (4.0 * self.tolerance))
                .floor()
                .to_array()
                .map(|x| x as i64)
        } else {
            // Zeros of both signs are one position.
            (p + 0.0).to_array().map(|x| x.to_bits() as i64)
        }
    }

    fn insert(&mut self, p: DVec3) -> u32 {
        let reach = DVec3::splat(self.tolerance);
        let (low, high) = (self.cell(p - reach), self.cell(p + reach));
        let span =
            |axis: usize| low[axis]..=high[axis].min(low[axis].saturating_add(1)).max(low[axis]);
        for x in span(0) {
            for y in span(1) {
                for z in span(2) {
                    let mut next = self.cells.get(&[x, y, z]).copied();
                    while let Some(i) = next.filter(|&i| i != u32::MAX) {
                        if self.vertices[i as usize].distance(p) <= self.tolerance {
                            return i;
                        }
                        next = Some(self.previous[i as usize]);
                    }
                }
            }
        }
        let new = self.vertices.len() as u32;
        self.vertices.push(p);
        let before = self.cells.insert(self.cell(p), new);
        self.previous.push(before.unwrap_or(u32::MAX));
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_vertices_meet_and_alike_triangles_count_once() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let positions = [
            p(0.0, 0.0),
            p(1.0, 0.0),
            p(0.0, 1.0),
            p(1.0 + 3e-7, -3e-7),
            p(0.5, 5e-10),
        ];
        let triangles = [[0, 1, 2], [3, 2, 0], [2, 1, 0], [0, 1, 1], [0, 4, 1]];
        let welded = weld(&positions, &triangles, 0.0);
        assert_eq!(welded.triangles, [[0, 1, 2], [0, 2, 1]]);
        assert_eq!(welded.sources(0).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(welded.sources(1).collect::<Vec<_>>(), [2]);
    }
}
