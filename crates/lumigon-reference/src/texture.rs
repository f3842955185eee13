//! Textures on a polygon light: where their texels lie, and what they show.

use glam::{DVec2, DVec3};
use thiserror::Error;

use crate::polygon::is_position;

/// Most texels of a texture.
const MOST_TEXELS: usize = 1 << 26;

/// Why there is no such texture.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TextureError {
    /// No texels, or more than 2^26.
    #[error("a texture of {width} x {height} texels; it needs 1 to 2^26 of them")]
    Size {
        /// Texels across.
        width: usize,
        /// Texels down.
        height: usize,
    },
    /// The edges span no parallelogram, or are not finite.
    #[error(
        "the edges {edge_u:?} and {edge_v:?} from {corner:?} span no parallelogram; give two that differ in direction"
    )]
    Frame {
        /// Where u = v = 0.
        corner: [f64; 3],
        /// From there to u = 1.
        edge_u: [f64; 3],
        /// From there to v = 1.
        edge_v: [f64; 3],
    },
    /// There are more or fewer colours than texels.
    #[error("{count} colours for {expected} texels; give one for each, row by row")]
    Count {
        /// How many there are.
        count: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A colour is negative, infinite or NaN.
    #[error("texel ({x}, {y}) is {color:?}; light is finite and not negative")]
    Color {
        /// Column, from 0.
        x: usize,
        /// Row, from 0.
        y: usize,
        /// The offending colour.
        color: [f32; 3],
    },
}

/// What a texture shows between the centres of its texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TexelFilter {
    /// The colour of the texel that a point lies in.
    Nearest,
    /// A blend of the four nearest; beyond the outermost centres their colours go on.
    Bilinear,
}

/// Where the texels of a texture lie: on a parallelogram in a light's plane.
///
/// (u, v) is (0, 0) at `corner`, the outer corner of the first texel, u runs along `edge_u` through the columns, v
/// along `edge_v` through the rows; both are 1 at the other ends. Outside the parallelogram its border goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TexelGrid {
    pub(crate) corner: DVec3,
    pub(crate) edge_u: DVec3,
    pub(crate) edge_v: DVec3,
    pub(crate) size: [usize; 2],
    pub(crate) filter: TexelFilter,
}

impl TexelGrid {
    /// A grid of `size` texels, across and down, in the length unit and frame of the light's vertices.
    ///
    /// # Errors
    /// A size or parallelogram that is none.
    pub fn new(
        [corner, edge_u, edge_v]: [[f64; 3]; 3],
        size: [usize; 2],
        filter: TexelFilter,
    ) -> Result<Self, TextureError> {
        let [width, height] = size;
        let count = width.checked_mul(height);
        if !count.is_some_and(|count| (1..=MOST_TEXELS).contains(&count)) {
            return Err(TextureError::Size { width, height });
        }
        let finite = [corner, edge_u, edge_v].into_iter().all(is_position);
        let (u, v) = (DVec3::from(edge_u), DVec3::from(edge_v));
        let (area, lengths) = (u.cross(v).length(), u.length() * v.length());
        // Also where a length vanishes or the product overflows.
        if !(finite && area > 1e-9 * lengths && area.is_normal()) {
            return Err(TextureError::Frame {
                corner,
                edge_u,
                edge_v,
            });
        }
        Ok(Self {
            corner: corner.into(),
            edge_u: u,
            edge_v: v,
            size,
            filter,
        })
    }

    /// Texels across and down.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// (u, v) of a point's foot on the plane.
    pub(crate) fn coordinates(&self, point: DVec3) -> DVec2 {
        let normal = self.edge_u.cross(self.edge_v);
        let offset = point - self.corner;
        let u = offset.cross(self.edge_v).dot(normal);
        let v = self.edge_u.cross(offset).dot(normal);
        DVec2::new(u, v) / normal.length_squared()
    }

    /// Where the cells within which the texture is smooth end, between the first and the last along an axis: texels,
    /// or the squares between their centres.
    pub(crate) fn border(&self, cell: usize) -> f64 {
        match self.filter {
            TexelFilter::Nearest => cell as f64 + 1.0,
            TexelFilter::Bilinear => cell as f64 + 0.5,
        }
    }

    /// Number of cells along an axis; the outermost go on without end.
    pub(crate) fn cells(&self, axis: usize) -> usize {
        match self.filter {
            TexelFilter::Nearest => self.size[axis],
            TexelFilter::Bilinear => self.size[axis] + 1,
        }
    }

    /// The two texels that a cell blends along an axis, and the second's share at a coordinate in texels.
    pub(crate) fn blend(&self, axis: usize, cell: usize, coordinate: f64) -> ([usize; 2], f64) {
        let last = self.size[axis] - 1;
        match self.filter {
            TexelFilter::Nearest => ([cell, cell], 0.0),
            TexelFilter::Bilinear => {
                let texels = [cell.saturating_sub(1), cell.min(last)];
                (texels, (coordinate + 0.5 - cell as f64).clamp(0.0, 1.0))
            }
        }
    }

    /// The cell that a coordinate in texels lies in.
    pub(crate) fn cell(&self, axis: usize, coordinate: f64) -> usize {
        let shift = match self.filter {
            TexelFilter::Nearest => 0.0,
            TexelFilter::Bilinear => 0.5,
        };
        // NaN becomes 0.
        ((coordinate + shift).max(0.0) as usize).min(self.cells(axis) - 1)
    }
}

/// A texture on a light: its radiance there is the light's own times the texture's colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    grid: TexelGrid,
    texels: Vec<[f32; 3]>,
}

impl Texture {
    /// Linear RGB colours of a grid's texels, row by row.
    ///
    /// # Errors
    /// Where their number is wrong or one is no colour.
    pub fn new(grid: TexelGrid, texels: Vec<[f32; 3]>) -> Result<Self, TextureError> {
        let [width, height] = grid.size;
        if texels.len() != width * height {
            return Err(TextureError::Count {
                count: texels.len(),
                expected: width * height,
            });
        }
        let dark = |c: &[f32; 3]| c.iter().any(|x| !(0.0..f32::INFINITY).contains(x));
        match texels.iter().position(dark) {
            Some(i) => Err(TextureError::Color {
                x: i % width,
                y: i / width,
                color: texels[i],
            }),
            None => Ok(Self { grid, texels }),
        }
    }

    /// Where its texels lie.
    pub fn grid(&self) -> &TexelGrid {
        &self.grid
    }

    /// Its texels, row by row.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// The colour at a point of its plane.
    pub fn color(&self, point: [f64; 3]) -> [f64; 3] {
        let [width, height] = self.grid.size;
        let at = self.grid.coordinates(point.into());
        let axis = |axis: usize, coordinate: f64| {
            self.grid
                .blend(axis, self.grid.cell(axis, coordinate), coordinate)
        };
        let (columns, right) = axis(0, at.x * width as f64);
        let (rows, lower) = axis(1, at.y * height as f64);
        let texel = |x: usize, y: usize| {
            let [r, g, b] = self.texels[y * width + x];
            DVec3::new(r.into(), g.into(), b.into())
        };
        let row = |y: usize| texel(columns[0], y).lerp(texel(columns[1], y), right);
        row(rows[0]).lerp(row(rows[1]), lower).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 3]; 3] = [[1.0, 0.0, 5.0], [4.0, 0.0, 0.0], [1.0, 2.0, 0.0]];

    #[test]
    fn colors_lie_where_they_should() {
        let texels: Vec<[f32; 3]> = (0..8)
            .map(|i| [i as f32, (i % 4) as f32, (i / 4) as f32])
            .collect();
        let at = |u: f64, v: f64| [1.0 + 4.0 * u + v, 2.0 * v, 5.0];
        let nearest = TexelGrid::new(SQUARE, [4, 2], TexelFilter::Nearest).unwrap();
        let texture = Texture::new(nearest, texels.clone()).unwrap();
        assert_eq!(texture.color(at(0.3, 0.9)), [5.0, 1.0, 1.0]);
        assert_eq!(texture.color(at(-3.0, 7.0)), [4.0, 0.0, 1.0]);
        let bilinear = TexelGrid::new(SQUARE, [4, 2], TexelFilter::Bilinear).unwrap();
        let texture = Texture::new(bilinear, texels).unwrap();
        let close = |a: [f64; 3], b: [f64; 3]| DVec3::from(a).distance(b.into()) < 1e-12;
        // Centres are at 1/8, 3/8, ... and 1/4, 3/4.
        assert!(close(texture.color(at(0.375, 0.75)), [5.0, 1.0, 1.0]));
        assert!(close(texture.color(at(0.5, 0.5)), [3.5, 1.5, 0.5]));
        assert!(close(texture.color(at(0.01, 0.5)), [2.0, 0.0, 0.5]));
        assert!(close(texture.color(at(9.0, -9.0)), [3.0, 3.0, 0.0]));
    }

    #[test]
    fn what_is_no_texture_is_refused() {
        let filter = TexelFilter::Bilinear;
        for size in [[0, 1], [1 << 14, 1 << 14], [usize::MAX, 2]] {
            let fault = TexelGrid::new(SQUARE, size, filter).unwrap_err();
            assert!(matches!(fault, TextureError::Size { .. }), "{fault}");
        }
        for frame in [
            [SQUARE[0], SQUARE[1], SQUARE[1]],
            [SQUARE[0], [0.0; 3], SQUARE[1]],
            [SQUARE[0], [f64::NAN, 0.0, 0.0], SQUARE[2]],
            [[f64::INFINITY; 3], SQUARE[1], SQUARE[2]],
            [SQUARE[0], [1e-200, 0.0, 0.0], [0.0, 1e-200, 0.0]],
        ] {
            let fault = TexelGrid::new(frame, [2, 2], filter).unwrap_err();
            assert!(matches!(fault, TextureError::Frame { .. }), "{fault}");
        }
        let grid = TexelGrid::new(SQUARE, [2, 2], filter).unwrap();
        let count = Texture::new(grid, vec![[0.0; 3]; 3]).unwrap_err();
        assert!(count.to_string().contains("3 colours for 4 texels"));
        for bad in [f32::NAN, -1.0, f32::INFINITY] {
            let mut texels = vec![[1.0; 3]; 4];
            texels[3][1] = bad;
            let fault = Texture::new(grid, texels).unwrap_err();
            assert!(
                matches!(fault, TextureError::Color { x: 1, y: 1, .. }),
                "{fault}"
            );
        }
    }
}
