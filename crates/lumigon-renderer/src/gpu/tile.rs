//! Parts of a picture.

use std::ops::Range;

use super::shading::PIXEL;
use crate::render::Rendering;

/// Some pixels of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    pub(super) origin: [u32; 2],
    pub(super) size: [u32; 2],
}

impl Tile {
    pub(super) fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// Puts the tile's three parts where they belong.
    pub(super) fn write(&self, bytes: &[u8], picture: &mut Rendering) {
        let [width, height] = self.size.map(|x| x as usize);
        let [x, y] = self.origin.map(|x| x as usize);
        let row_length = picture.width as usize;
        let parts = [
            &mut picture.emitted,
            &mut picture.diffuse,
            &mut picture.specular,
        ];
        let row_bytes = width * PIXEL as usize;
        for (to, from) in parts.into_iter().zip(bytes.chunks(height * row_bytes)) {
            for (row, from) in from.chunks(row_bytes).enumerate() {
                let start = (y + row) * row_length + x;
                let to = &mut to[start..start + width];
                for (to, from) in to.iter_mut().zip(from.chunks(PIXEL as usize)) {
                    let [r, g, b, _]: [f32; 4] = bytemuck::pod_read_unaligned(from);
                    *to = [r, g, b];
                }
            }
        }
    }
}

/// A part of the picture in tiles of at most `largest`, row by row.
pub(super) fn tiles(columns: Range<u32>, rows: Range<u32>, largest: [u32; 2]) -> Vec<Tile> {
    let mut tiles = Vec::new();
    for y in rows.clone().step_by(largest[1] as usize) {
        for x in columns.clone().step_by(largest[0] as usize) {
            tiles.push(Tile {
                origin: [x, y],
                size: [
                    largest[0].min(columns.end - x),
                    largest[1].min(rows.end - y),
                ],
            });
        }
    }
    tiles
}

/// Pixels across and down of a tile of at most `most` pixels, or of a workgroup's few; none of its
/// sides is longer than `longest`.
pub(super) fn tile_size([width, height]: [u32; 2], longest: u32, most: u64) -> [u32; 2] {
    let most = most.max(64 * 64);
    // As wide as it may be where that makes it the whole picture, else square: few triangles are in
    // several tiles.
    let side = (most.isqrt() as u32).max((most / u64::from(height)).min(longest.into()) as u32);
    let across = width.min(side).min(longest);
    let down = (most / u64::from(across)).min(longest.into()) as u32;
    [across, height.min(down)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        let mut seen = vec![0; 7 * 5];
        for tile in tiles(0..7, 0..5, [3, 2]) {
            for y in 0..tile.size[1] {
                for x in 0..tile.size[0] {
                    seen[((tile.origin[1] + y) * 7 + tile.origin[0] + x) as usize] += 1;
                }
            }
        }
        assert_eq!(seen, vec![1; 35]);
        let of_columns = tiles(2..6, 0..2, [3, 2]);
        let tile = |x, width| Tile {
            origin: [x, 0],
            size: [width, 2],
        };
        assert_eq!(of_columns, [tile(2, 3), tile(5, 1)]);
    }

    #[test]
    fn tiles_hold_whole_pictures_where_they_may() {
        assert_eq!(tile_size([1440, 900], 2048, 1 << 21), [1440, 900]);
        assert_eq!(tile_size([900, 1440], 2048, 1 << 21), [900, 1440]);
        assert_eq!(tile_size([1, 1], 2048, 1 << 21), [1, 1]);
        assert_eq!(tile_size([32_768, 1], 2048, 1 << 21), [2048, 1]);
        assert_eq!(tile_size([1440, 900], 2048, 1), [64, 64]);
        for size in [[32_768, 32_768], [32_768, 3], [3, 32_768], [5000, 700]] {
            let [across, down] = tile_size(size, 2048, 1 << 21);
            assert!(across.max(down) <= 2048 && across * down <= 1 << 21);
            assert!(across * down >= (size[0] * size[1]).min(6000));
        }
    }
}
