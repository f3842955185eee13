//! Exact distances from texels to an outline, tile by tile.

use alloc::vec;
use alloc::vec::Vec;

use super::settings::DistanceFieldSettings;
use crate::polygon::PolygonLight;
use crate::real::Scalar;

/// Below this many texels a side a tile is no longer split.
const SMALLEST_TILE: usize = 4;

/// An outline's edge, in the field's units: the square is \[-1, 1\]^2.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    start: [f64; 2],
    along: [f64; 2],
    /// One over the squared length, or 0 where the edge is a point.
    inverse_squared: f64,
}

impl Edge {
    fn new(a: [f64; 2], b: [f64; 2]) -> Self {
        // Of one direction, so that edges that lie on each other are found.
        let [a, b] = if b < a { [b, a] } else { [a, b] };
        let along = [b[0] - a[0], b[1] - a[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        Self {
            start: a,
            along,
            inverse_squared: if squared > 0.0 { 1.0 / squared } else { 0.0 },
        }
    }

    fn squared_distance(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x - self.start[0], y - self.start[1]);
        let t = (x * self.along[0] + y * self.along[1]) * self.inverse_squared;
        let t = t.clamp(0.0, 1.0);
        let (x, y) = (x - self.along[0] * t, y - self.along[1] * t);
        x * x + y * y
    }
}

/// A light's outline in the field's units.
pub(super) struct Outline {
    /// Start and end of every edge: what crossings are counted of.
    crossed: Vec<[[f64; 2]; 2]>,
    /// The edges once each: what distances are measured to.
    edges: Vec<Edge>,
}

impl Outline {
    pub(super) fn new<S: Scalar>(light: &PolygonLight<S>, phi: f64) -> Self {
        let vertex = |i: usize| light.plane_offsets[i].map(|x| x.to_f64() / phi);
        let mut crossed = Vec::with_capacity(light.plane_offsets.len());
        for range in light.loop_ranges() {
            let mut start = vertex(range.end - 1);
            for i in range {
                let end = vertex(i);
                crossed.push([start, end]);
                start = end;
            }
        }
        let mut edges: Vec<_> = crossed.iter().map(|&[a, b]| Edge::new(a, b)).collect();
        // Edges that lie on each other are equally far from everywhere: no tile could drop them.
        let order = |e: &Edge| [e.start, e.along];
        edges.sort_by(|a, b| {
            let order = order(a).partial_cmp(&order(b));
            order.unwrap_or(core::cmp::Ordering::Equal)
        });
        edges.dedup();
        Self { crossed, edges }
    }

    /// Distances at the texels of some rows, `texels.len() / resolution` of them.
    pub(super) fn bake_rows(
        &self,
        settings: DistanceFieldSettings,
        first_row: usize,
        texels: &mut [f32],
    ) {
        let resolution = settings.resolution() as usize;
        let rows = texels.len() / resolution;
        let mut band = Band {
            settings,
            resolution,
            first_row,
            inside: self.inside(settings, first_row, rows),
            texels,
        };
        let mut candidates = self.edges.clone();
        let count = candidates.len();
        for column in (0..resolution).step_by(rows) {
            band.fill(column, 0, rows, &mut candidates, 0..count);
        }
    }

    /// Which texels of some rows are in the outline by crossing number (Franklin, "PNPOLY").
    fn inside(&self, settings: DistanceFieldSettings, first_row: usize, rows: usize) -> Vec<bool> {
        let resolution = settings.resolution() as usize;
        let mut odd = vec![false; rows * resolution];
        let texels = 0.5 * resolution as f64;
        for &[start, end] in &self.crossed {
            // Rows whose texels' centres lie between the end points.
            let row = |y: f64| (y + 1.0) * texels - 0.5;
            let (low, high) = (start[1].min(end[1]), start[1].max(end[1]));
            let first = ((row(low) - 1.0) as usize).max(first_row);
            let last = ((row(high) + 2.0) as usize).min(first_row + rows);
            for y_row in first..last {
                let y = (y_row as f64 + 0.5) / texels - 1.0;
                let up = start[1] <= y && end[1] > y;
                let down = end[1] <= y && start[1] > y;
                if !(up || down) {
                    continue;
                }
                let t = (y - start[1]) / (end[1] - start[1]);
                let x = start[0] + t * (end[0] - start[0]);
                // The texels whose centres are to the left of the crossing, which are the first.
                let left = libm::ceil((x + 1.0) * texels - 0.5).clamp(0.0, resolution as f64);
                if left > 0.0 {
                    odd[(y_row - first_row) * resolution + left as usize - 1] ^= true;
                }
            }
        }
        for row in odd.chunks_mut(resolution) {
            let mut inside = false;
            for texel in row.iter_mut().rev() {
                inside ^= *texel;
                *texel = inside;
            }
        }
        odd
    }
}

/// Rows of a field while they are baked.
struct Band<'a> {
    settings: DistanceFieldSettings,
    resolution: usize,
    first_row: usize,
    inside: Vec<bool>,
    texels: &'a mut [f32],
}

impl Band<'_> {
    /// The centre of a texel, or of a tile between texels, by its column or row.
    fn place(&self, column_or_row: f64) -> f64 {
        (2.0 * column_or_row + 1.0) / self.resolution as f64 - 1.0
    }

    /// Fills the tile of `side` texels from (column, row) on, whose distances are to those of
    /// `edges` in `candidates`; what follows in `edges` is room for work.
    ///
    /// With c the tile's centre and r the farthest texel's distance from it, an edge at a distance
    /// of more than d + 2 r from c, d the nearest one's, is the nearest to no texel of the tile.
    fn fill(
        &mut self,
        column: usize,
        row: usize,
        side: usize,
        edges: &mut Vec<Edge>,
        candidates: core::ops::Range<usize>,
    ) {
        let phi = f64::from(self.settings.phi());
        let half = 0.5 * (side as f64 - 1.0);
        let x = self.place(column as f64 + half);
        let y = self.place((self.first_row + row) as f64 + half);
        let reach = half * 2.0 * core::f64::consts::SQRT_2 / self.resolution as f64 + 1e-12;
        let squared = |edge: &Edge| edge.squared_distance(x, y);
        let nearest = edges[candidates.clone()].iter().map(squared);
        let nearest = libm::sqrt(nearest.fold(f64::INFINITY, f64::min));
        let inside = self.inside[row * self.resolution + column];
        if nearest > reach && inside && !self.settings.is_signed() {
            // No edge crosses the tile: all of it is inside.
            self.fill_with(column, row, side, 0.0);
            return;
        }
        if nearest - reach > phi {
            let far = if inside { -phi } else { phi };
            self.fill_with(column, row, side, far as f32);
            return;
        }
        let most = nearest + 2.0 * reach;
        let start = edges.len();
        for i in candidates {
            let edge = edges[i];
            if edge.squared_distance(x, y) <= most * most {
                edges.push(edge);
            }
        }
        let kept = start..edges.len();
        if side <= SMALLEST_TILE || kept.len() == 1 {
            self.measure(column, row, side, &edges[kept]);
        } else {
            let half = side / 2;
            for (right, down) in [(0, 0), (half, 0), (0, half), (half, half)] {
                self.fill(column + right, row + down, half, edges, kept.clone());
            }
        }
        edges.truncate(start);
    }

    fn fill_with(&mut self, column: usize, row: usize, side: usize, value: f32) {
        for row in row..row + side {
            let start = row * self.resolution + column;
            self.texels[start..start + side].fill(value);
        }
    }

    /// Each texel's distance to the nearest of these.
    fn measure(&mut self, column: usize, row: usize, side: usize, edges: &[Edge]) {
        let phi = f64::from(self.settings.phi());
        for row in row..row + side {
            let y = self.place((self.first_row + row) as f64);
            for column in column..column + side {
                let x = self.place(column as f64);
                let nearest = edges.iter().map(|edge| edge.squared_distance(x, y));
                let distance = libm::sqrt(nearest.fold(f64::INFINITY, f64::min)).min(phi);
                let texel = row * self.resolution + column;
                self.texels[texel] = match (self.inside[texel], self.settings.is_signed()) {
                    (false, _) => distance as f32,
                    (true, false) => 0.0,
                    (true, true) => -distance as f32,
                };
            }
        }
    }
}
