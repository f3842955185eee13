//! What each texel of a textured polygon light adds to what a shading point sees.
//!
//! Light is linear in a texture's colours, so the integral of a textured light is a weighted sum of its texels. The
//! weights are integrals themselves: the light's outline, clipped at the horizon, is cut along the cells within which
//! the texture is a polynomial, and each piece is integrated by product Gauss rules, then the worst ones by halves.

use std::collections::BinaryHeap;

use glam::{DMat3, DVec2, DVec3};

use crate::cubature::{CubatureError, position, shading_frame, to_frame, unit};
use crate::integrands::{Cosine, GgxLobe, LtcDensity, One, ProjectedArea};
use crate::polygon::Polygon;
use crate::quadrature::{Integrand, Tolerance, edge_lengths};
use crate::texture::TexelGrid;

/// What a direction of light counts. All normals, axes and views are unit vectors in the frame of the light; light from
/// below the normal's horizon counts nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Weighting {
    /// Its cosine with the normal: the weights add up to the irradiance of [`irradiance`](crate::irradiance).
    Cosine {
        /// Of the surface.
        normal: [f64; 3],
    },
    /// One: they add up to the solid angle above the horizon.
    SolidAngle {
        /// Of the surface.
        normal: [f64; 3],
    },
    /// The inverse cube of its cosine with an axis: they add up to the area projected, from the point, on a plane at
    /// right angles to the axis at a distance of 1. What is at right angles to the axis or behind has no such area.
    ProjectedArea {
        /// Of the projection.
        axis: [f64; 3],
        /// Of the surface.
        normal: [f64; 3],
    },
    /// The density of a linearly transformed cosine: they add up to the share of the lobe that the light covers.
    TransformedCosine {
        /// Rows of the map from the light's frame to the space where the lobe is the clamped cosine about z, of
        /// positive determinant; a factor does not matter.
        to_cosine: [[f64; 3]; 3],
        /// Of the surface.
        normal: [f64; 3],
    },
    /// The GGX lobe and the cosine, as [`ggx`](crate::ggx): they add up to its value.
    Ggx {
        /// Of the surface.
        normal: [f64; 3],
        /// From the point to the viewer.
        view: [f64; 3],
        /// Width, in (0, 1].
        alpha: f64,
    },
}

/// The weights of a texture's texels at one shading point.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelWeights {
    weights: Vec<f64>,
    total: f64,
    error: f64,
}

/// A mean colour and the estimate of its absolute error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanColor {
    /// Linear RGB.
    pub value: [f64; 3],
    /// Estimated absolute error of the worst channel, usually pessimistic.
    pub error: f64,
}

impl TexelWeights {
    /// One weight a texel, row by row.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Their sum: the integral over the untextured light.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Estimated absolute error of the weights, all together.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// The weighted mean of these texels; `None` where nothing of the light is seen.
    ///
    /// # Panics
    /// Unless there are as many texels as weights.
    pub fn mean(&self, texels: &[[f32; 3]]) -> Option<MeanColor> {
        assert_eq!(texels.len(), self.weights.len(), "one texel a weight");
        if self.total <= 0.0 {
            return None;
        }
        let colors = || {
            texels
                .iter()
                .map(|&[r, g, b]| DVec3::new(r.into(), g.into(), b.into()))
        };
        let sum: DVec3 = self.weights.iter().zip(colors()).map(|(w, c)| *w * c).sum();
        let value = sum / self.total;
        // Weights that are off by so much shift the mean by no more than the colours differ from it.
        let farthest = colors().fold(0.0, |m: f64, c| m.max((c - value).abs().max_element()));
        Some(MeanColor {
            value: value.into(),
            error: farthest * self.error / self.total,
        })
    }
}

/// What each texel of `grid`, as a texture on the light, adds to what a point sees.
///
/// The grid lies in the light's plane; texels that the outline cuts or the horizon hides count by what is left. All
/// weights are 0 behind a one-sided light. `tolerance` is for the sum of their errors, relative to the sum of the
/// weights; a fine grid needs some fifteen evaluations a texel in any case.
///
/// # Errors
/// As [`irradiance`](crate::irradiance); also a lobe that is none.
pub fn texel_weights(
    light: &Polygon,
    grid: &TexelGrid,
    point: [f64; 3],
    weighting: &Weighting,
    tolerance: Tolerance,
) -> Result<TexelWeights, CubatureError> {
    let point = position(point)?;
    let identity = [DVec3::X, DVec3::Y, DVec3::Z];
    match *weighting {
        Weighting::Cosine { normal } => {
            let rows = shading_frame(unit("normal", normal)?, DVec3::ZERO);
            let seen = SeenGrid::new(light, grid, point, rows);
            seen.integrate(light, &Cosine, &[DVec3::Z], tolerance)
        }
        Weighting::SolidAngle { normal } => {
            let horizon = unit("normal", normal)?;
            let seen = SeenGrid::new(light, grid, point, identity);
            seen.integrate(light, &One, &[horizon], tolerance)
        }
        Weighting::ProjectedArea { axis, normal } => {
            let (axis, horizon) = (unit("axis", axis)?, unit("normal", normal)?);
            let seen = SeenGrid::new(light, grid, point, identity);
            let projection = ProjectedArea { axis };
            seen.integrate(light, &projection, &[horizon, axis], tolerance)
        }
        Weighting::TransformedCosine { to_cosine, normal } => {
            let horizon = unit("normal", normal)?;
            let map = DMat3::from_cols_array_2d(&to_cosine).transpose();
            let lobe = LtcDensity::new(map).ok_or(CubatureError::NoLobe(to_cosine))?;
            let seen = SeenGrid::new(light, grid, point, identity);
            seen.integrate(light, &lobe, &[horizon, lobe.horizon()], tolerance)
        }
        Weighting::Ggx {
            normal,
            view,
            alpha,
        } => {
            let (normal, view) = (unit("normal", normal)?, unit("view", view)?);
            let rows = shading_frame(normal, view);
            let lobe = GgxLobe::new(to_frame(&rows, view), [alpha; 2])?;
            let seen = SeenGrid::new(light, grid, point, rows);
            if lobe.view.z <= 0.0 {
                return Ok(seen.dark());
            }
            seen.integrate(light, &lobe, &[DVec3::Z], tolerance)
        }
    }
}

/// A grid as a point sees it; coordinates in texels.
struct SeenGrid<'a> {
    grid: &'a TexelGrid,
    lit: bool,
    /// From the point to coordinates (0, 0), and what one texel adds across and down.
    corner: DVec3,
    across: DVec3,
    down: DVec3,
    /// Solid angle of a unit of coordinates, but for the inverse cube of the distance.
    measure: f64,
}

impl<'a> SeenGrid<'a> {
    fn new(light: &Polygon, grid: &'a TexelGrid, point: DVec3, rows: [DVec3; 3]) -> Self {
        let height = light.height(point);
        let [width, rows_of_texels] = grid.size.map(|n| n as f64);
        let corner = to_frame(&rows, grid.corner - point);
        let across = to_frame(&rows, grid.edge_u / width);
        let down = to_frame(&rows, grid.edge_v / rows_of_texels);
        Self {
            grid,
            lit: height > 0.0 || (height < 0.0 && light.is_two_sided()),
            corner,
            across,
            down,
            // The light's own height: the grid's plane may be off by rounding.
            measure: across.cross(down).length() * height.abs(),
        }
    }

    fn dark(&self) -> TexelWeights {
        let [width, height] = self.grid.size;
        TexelWeights {
            weights: vec![0.0; width * height],
            total: 0.0,
            error: 0.0,
        }
    }

    fn place(&self, at: DVec2) -> DVec3 {
        self.corner + self.across * at.x + self.down * at.y
    }

    fn integrate<const N: usize>(
        &self,
        light: &Polygon,
        integrand: &impl Integrand<N>,
        horizons: &[DVec3],
        tolerance: Tolerance,
    ) -> Result<TexelWeights, CubatureError> {
        let mut result = self.dark();
        if !self.lit {
            return Ok(result);
        }
        let [width, height] = self.grid.size.map(|n| n as f64);
        let mut evaluations = 0;
        let mut pieces: BinaryHeap<Piece> = BinaryHeap::new();
        let mut pending = Vec::new();
        for triangle in light.triangle_vertices() {
            let scale = DVec2::new(width, height);
            let mut outline = triangle.map(|v| self.grid.coordinates(v) * scale).to_vec();
            for horizon in horizons {
                let [at_corner, across, down] =
                    [self.corner, self.across, self.down].map(|v| horizon.dot(v));
                outline = clip(&outline, |at| at_corner + across * at.x + down * at.y);
            }
            cut(self.grid, &outline, |cell, corners| {
                pending.push((cell, corners));
            });
        }
        let mut unresolved = false;
        loop {
            while let Some((cell, corners)) = pending.pop() {
                let along = self.too_large(integrand, &corners);
                if let Some(along) = along
                    && evaluations < tolerance.max_evaluations
                {
                    evaluations += 1;
                    pending.extend(halves(&corners, along).map(|half| (cell, half)));
                    continue;
                }
                unresolved |= along.is_some();
                let piece = self.measure(integrand, cell, corners);
                evaluations += RULE_POINTS;
                if evaluations > tolerance.max_evaluations.saturating_add(RULE_POINTS) {
                    return Err(CubatureError::NotConverged {
                        error: f64::INFINITY,
                    });
                }
                self.add(&mut result, &piece, 1.0);
                if piece.error > 1e-15 * piece.value.iter().sum::<f64>() {
                    pieces.push(piece);
                }
            }
            let goal = tolerance
                .absolute
                .max(tolerance.relative * result.total.abs());
            let converged = result.error <= goal && !unresolved;
            if converged {
                // Rounding only: rule and integrand are nowhere negative, but pieces were taken back.
                for weight in &mut result.weights {
                    *weight = weight.max(0.0);
                }
                result.error = result.error.max(0.0);
                return Ok(result);
            }
            let out_of_reach = result.error.is_nan()
                || pieces.is_empty()
                || evaluations >= tolerance.max_evaluations;
            if out_of_reach {
                return Err(CubatureError::NotConverged {
                    error: result.error,
                });
            }
            let mut left = result.error;
            while left > 0.5 * goal {
                let Some(worst) = pieces.pop() else { break };
                left -= worst.error;
                self.add(&mut result, &worst, -1.0);
                let along = longer(&self.extents(integrand, &worst.corners));
                pending.extend(halves(&worst.corners, along).map(|half| (worst.cell, half)));
            }
        }
    }

    fn add(&self, result: &mut TexelWeights, piece: &Piece, sign: f64) {
        let width = self.grid.size[0];
        let (columns, _) = self.grid.blend(0, piece.cell[0], 0.0);
        let (rows, _) = self.grid.blend(1, piece.cell[1], 0.0);
        for (k, value) in piece.value.iter().enumerate() {
            result.weights[rows[k / 2] * width + columns[k % 2]] += sign * value;
            result.total += sign * value;
        }
        result.error += sign * piece.error;
    }

    /// The axis along which a piece must be halved before anything is sampled: a narrow peak may hide in it.
    fn too_large<const N: usize>(
        &self,
        integrand: &impl Integrand<N>,
        corners: &Corners,
    ) -> Option<usize> {
        let lengths = self.extents_by(corners, edge_lengths);
        let extents = match lengths.iter().any(|l| *l > LONGEST_SIDE) {
            // The ends of an arc of nearly 180 degrees say nothing about what lies between.
            true => return Some(longer(&lengths)),
            false => self.extents(integrand, corners),
        };
        extents.iter().any(|e| *e > 1.0).then(|| longer(&extents))
    }

    fn extents<const N: usize>(
        &self,
        integrand: &impl Integrand<N>,
        corners: &Corners,
    ) -> [f64; 3] {
        self.extents_by(corners, |triangle| integrand.edge_extents(triangle))
    }

    /// Greatest extent along a piece's first axis, its second, and across.
    fn extents_by(&self, corners: &Corners, measure: impl Fn(&[DVec3; 3]) -> [f64; 3]) -> [f64; 3] {
        let [a, b, c, d] = corners.map(|at| self.place(at).normalize_or_zero());
        let [bc, ca, ab] = measure(&[a, b, c]);
        if corners[2] == corners[3] {
            return [ab, bc, ca];
        }
        let [cd, da, ac] = measure(&[a, c, d]);
        [ab.max(cd), bc.max(da), ca.max(ac)]
    }

    /// Integrates a piece, by 3 x 3 Gauss points and, for the error, by 2 x 2.
    fn measure<const N: usize>(
        &self,
        integrand: &impl Integrand<N>,
        cell: [usize; 2],
        corners: Corners,
    ) -> Piece {
        let [a, b, c, d] = corners;
        let (first, second, twist) = (b - a, d - a, a - b + c - d);
        let rule = |nodes: &[(f64, f64)]| {
            let mut sum = [0.0; 4];
            for &(s, weight_s) in nodes {
                for &(t, weight_t) in nodes {
                    let at = a + first * s + second * t + twist * (s * t);
                    let jacobian = (first + twist * t).perp_dot(second + twist * s).abs();
                    let place = self.place(at);
                    let distance = place.length();
                    let value = integrand.evaluate(place / distance)[0];
                    let solid_angle = self.measure * jacobian / (distance * distance * distance);
                    let weight = weight_s * weight_t * value * solid_angle;
                    let (_, right) = self.grid.blend(0, cell[0], at.x);
                    let (_, lower) = self.grid.blend(1, cell[1], at.y);
                    sum[0] += weight * (1.0 - right) * (1.0 - lower);
                    sum[1] += weight * right * (1.0 - lower);
                    sum[2] += weight * (1.0 - right) * lower;
                    sum[3] += weight * right * lower;
                }
            }
            sum
        };
        let value = rule(&GAUSS_3);
        let check = rule(&GAUSS_2);
        let differences = value.iter().zip(check).map(|(v, c)| (v - c).abs());
        Piece {
            cell,
            corners,
            value,
            error: differences.sum(),
        }
    }
}

/// Nodes and weights on \[0, 1\].
const GAUSS_2: [(f64, f64); 2] = [
    (0.211_324_865_405_187_1, 0.5),
    (0.788_675_134_594_812_9, 0.5),
];
const GAUSS_3: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

const RULE_POINTS: usize = 13;

/// Chord beyond which a piece is halved whatever is integrated.
const LONGEST_SIDE: f64 = 1.0;

/// A convex quadrilateral in texels, in order; a triangle repeats its last corner.
type Corners = [DVec2; 4];

/// One quadrilateral with its integral.
struct Piece {
    cell: [usize; 2],
    corners: Corners,
    /// Parts of the cell's texels: upper left, upper right, lower left, lower right.
    value: [f64; 4],
    error: f64,
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.error.total_cmp(&other.error)
    }
}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Piece {}

/// The longer of a piece's two axes.
fn longer(extents: &[f64; 3]) -> usize {
    usize::from(extents[1] > extents[0])
}

/// A piece halved across its first (0) or second (1) axis.
fn halves([a, b, c, d]: &Corners, along: usize) -> [Corners; 2] {
    let (a, b, c, d) = (*a, *b, *c, *d);
    match along {
        0 => {
            let (upper, lower) = (0.5 * (a + b), 0.5 * (c + d));
            [[a, upper, lower, d], [upper, b, c, lower]]
        }
        _ => {
            let (left, right) = (0.5 * (a + d), 0.5 * (b + c));
            [[a, b, right, left], [left, right, c, d]]
        }
    }
}

/// The part of a convex polygon where a linear function is not negative.
fn clip(outline: &[DVec2], height: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(outline.len() + 1);
    for (i, &a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        let (at_a, at_b) = (height(a), height(b));
        if at_a >= 0.0 {
            kept.push(a);
        }
        if (at_a >= 0.0) != (at_b >= 0.0) {
            kept.push(a + (b - a) * (at_a / (at_a - at_b)));
        }
    }
    if kept.len() < 3 {
        kept.clear();
    }
    kept
}

/// Cuts a convex polygon along the grid's cells into quadrilaterals and triangles.
fn cut(grid: &TexelGrid, outline: &[DVec2], mut each: impl FnMut([usize; 2], Corners)) {
    let range = |points: &[DVec2], axis: usize| {
        let cells = points.iter().map(|p| grid.cell(axis, p[axis]));
        cells.fold([usize::MAX, 0], |[low, high], cell| {
            [low.min(cell), high.max(cell)]
        })
    };
    let ends = |axis: usize, cell: usize| {
        let last = grid.cells(axis) - 1;
        [
            (cell > 0).then(|| grid.border(cell - 1)),
            (cell < last).then(|| grid.border(cell)),
        ]
    };
    let within = |points: &[DVec2], axis: usize, [low, high]: [Option<f64>; 2]| {
        let mut points = points.to_vec();
        if let Some(low) = low {
            points = clip(&points, |p| p[axis] - low);
        }
        if let Some(high) = high {
            points = clip(&points, |p| high - p[axis]);
        }
        points
    };
    if outline.is_empty() {
        return;
    }
    let [top, bottom] = range(outline, 1);
    for row in top..=bottom {
        let rows = ends(1, row);
        let strip = within(outline, 1, rows);
        if strip.is_empty() {
            continue;
        }
        let [left, right] = range(&strip, 0);
        for column in left..=right {
            let columns = ends(0, column);
            let cell = [column, row];
            if let ([Some(x0), Some(x1)], [Some(y0), Some(y1)]) = (columns, rows) {
                let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(DVec2::from);
                if corners.iter().all(|corner| contains(&strip, *corner)) {
                    each(cell, corners);
                    continue;
                }
            }
            let piece = within(&strip, 0, columns);
            let mut next = 1;
            while next + 1 < piece.len() {
                let last = (next + 2).min(piece.len() - 1);
                each(cell, [piece[0], piece[next], piece[next + 1], piece[last]]);
                next += 2;
            }
        }
    }
}

/// Whether a convex polygon has a point, which may be on its border.
fn contains(outline: &[DVec2], point: DVec2) -> bool {
    let turns = || {
        outline.iter().enumerate().map(|(i, &a)| {
            let b = outline[(i + 1) % outline.len()];
            (b - a).perp_dot(point - a)
        })
    };
    turns().all(|turn| turn >= -1e-12) || turns().all(|turn| turn <= 1e-12)
}

#[cfg(test)]
mod tests;
