//! Where cube maps look from.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::footprint::{PlaneFrame, footprint};
use super::gather::Gather;
use super::{BounceCenters, CubeMap};
use crate::render::{RenderError, Watch};
use crate::scene::Camera;

/// Texels across a face of the maps that try places.
const FACE_SIZE: u32 = 8;

/// Places along the longest side of the scene's box.
const PLACES: f32 = 5.0;

/// Most places that are chosen.
const MOST_PLACES: usize = 64;

/// Parts of the scene's diagonal that make up a piece of surface.
const PIECES: f64 = 12.0;

/// The points that cube maps are to look from.
pub(super) fn centers(
    backend: &impl Gather,
    camera: &Camera,
    centers: &BounceCenters,
    watch: Watch<'_>,
) -> Result<Vec<Vec3>, RenderError> {
    match centers {
        BounceCenters::Camera => Ok(vec![camera.world_from_camera.translation.into()]),
        BounceCenters::Points(points) => Ok(points.iter().map(|&p| p.into()).collect()),
        BounceCenters::Scene(count) => {
            let kept = &backend.facets().places;
            let all = match kept.get() {
                Some(all) => all,
                None => {
                    let all = chosen(backend, watch)?;
                    kept.get_or_init(|| all)
                }
            };
            Ok(all.iter().copied().take(*count as usize).collect())
        }
    }
}

/// A piece of surface: a cell of space, and which way the surface faces.
type Piece = ([i32; 3], usize);

/// Places on a grid, one after the other that which sees the most surface that the ones before do not,
/// brighter surfaces more so. Whatever the lights do, it stays.
fn chosen(backend: &impl Gather, watch: Watch<'_>) -> Result<Vec<Vec3>, RenderError> {
    let facets = backend.facets();
    let piece_size = facets.scene_diagonal / PIECES;
    let mut open = Vec::new();
    for place in places(facets.scene_bounds) {
        let map = backend.see(place, FACE_SIZE, watch)?;
        open.push((place, pieces(&map, piece_size)));
    }
    let mut seen: HashMap<Piece, f64> = HashMap::new();
    let mut centers = Vec::new();
    while centers.len() < MOST_PLACES {
        let gain = |pieces: &Vec<(Piece, f64)>| -> f64 {
            let missing = |(piece, value): &(Piece, f64)| {
                (value - seen.get(piece).copied().unwrap_or(0.0)).max(0.0)
            };
            pieces.iter().map(missing).sum()
        };
        let gains = open.iter().map(|(_, pieces)| gain(pieces)).enumerate();
        // The first of equals, on any machine.
        let Some((best, _)) = gains
            .filter(|&(_, gain)| gain > 0.0)
            .reduce(|a, b| if b.1 > a.1 { b } else { a })
        else {
            break;
        };
        let (place, pieces) = open.swap_remove(best);
        for (piece, value) in pieces {
            let before = seen.entry(piece).or_default();
            *before = before.max(value);
        }
        centers.push(place);
    }
    if centers.is_empty() {
        // There is no surface: any place sees as much.
        let [low, high] = facets.scene_bounds;
        centers.push((0.5 * (low + high)).as_vec3());
    }
    Ok(centers)
}

/// The middles of the cells of a grid.
fn places([low, high]: [DVec3; 2]) -> Vec<Vec3> {
    let (low, size) = (low.as_vec3(), (high - low).as_vec3());
    let longest = size.max_element();
    if !(longest > 0.0 && longest.is_finite()) {
        return Vec::new();
    }
    let counts = (size / longest * PLACES).round().max(Vec3::ONE);
    let mut places = Vec::new();
    for z in 0..counts.z as u32 {
        for y in 0..counts.y as u32 {
            for x in 0..counts.x as u32 {
                let middle = (Vec3::new(x as f32, y as f32, z as f32) + 0.5) / counts;
                places.push(low + size * middle);
            }
        }
    }
    places
}

/// The area of each piece of surface that a cube map sees, times its albedo over all channels; sorted, so
/// that sums are the same on any machine.
fn pieces(map: &CubeMap, piece_size: f64) -> Vec<(Piece, f64)> {
    let eye = Vec3::from(map.center).as_dvec3();
    let spacing = 2.0 / f64::from(map.face_size);
    let mut seen: HashMap<Piece, [f64; 2]> = HashMap::new();
    for (index, texel) in map.texels.iter().enumerate() {
        let Some(texel) = texel else { continue };
        let position = Vec3::from(texel.position).as_dvec3();
        let normal = Vec3::from(texel.normal).as_dvec3();
        let frame = PlaneFrame::new(position, normal);
        let area = footprint(eye, &map.corners(index), spacing, position, &frame).area();
        let bright = area * f64::from(Vec3::from(texel.albedo).element_sum());
        let axis = normal.abs().max_position();
        let facing = 2 * axis + usize::from(normal[axis] < 0.0);
        let cell = (position / piece_size).floor().as_ivec3().to_array();
        if bright > 0.0 && bright.is_finite() {
            let sums = seen.entry((cell, facing)).or_default();
            *sums = [sums[0] + bright, sums[1] + area];
        }
    }
    // A texel's footprint may reach far beyond the piece: no piece is more than whole.
    let whole = piece_size * piece_size;
    let pieces = seen
        .into_iter()
        .map(|(piece, [value, area])| (piece, value * (whole / area).min(1.0)));
    let mut pieces: Vec<_> = pieces.collect();
    pieces.sort_unstable_by_key(|&(piece, _)| piece);
    pieces
}
