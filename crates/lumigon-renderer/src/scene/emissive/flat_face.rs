//! The flat parts of any mesh.

use glam::DVec3;

use super::{facet, junction, outline, weld};
use crate::scene::Mesh;

/// How far rounding to single precision may have moved a coordinate, relative to the largest.
const ROUNDING: f64 = 1e-7;

/// Connected triangles in one plane.
pub(crate) struct FlatFace {
    /// The outer loop, counter-clockwise about the normal, then the holes, clockwise.
    pub(crate) loops: Vec<Vec<[f64; 3]>>,
    /// Unit normal, on the side from which the triangles run counter-clockwise.
    pub(crate) normal: [f64; 3],
    /// Indices into [`Mesh::triangles`].
    pub(crate) triangles: Vec<u32>,
}

/// The flat faces that a mesh's triangles make up.
pub(crate) fn flat_faces(mesh: &Mesh) -> Vec<FlatFace> {
    let positions: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
    let largest = positions.iter().map(|p| p.abs().max_element());
    let noise = ROUNDING * largest.fold(0.0, f64::max);
    let welded = weld::weld(&positions, &mesh.triangles, noise);
    let edges = junction::edges(&welded);
    let facets = facet::facets(&welded, &edges, noise, None);
    let boundaries = outline::boundaries(&edges, &facets, welded.triangles.len());
    let faces = |(facet, boundary): (&facet::Facet, &Vec<(u32, u32)>)| {
        let normal = facet.normal.to_array();
        outline::outlines(&welded, boundary, facet, noise)
            .into_iter()
            .map(|outline| FlatFace {
                loops: outline.loops,
                normal,
                triangles: outline
                    .triangles
                    .iter()
                    .flat_map(|&t| welded.sources(t))
                    .collect(),
            })
            .collect::<Vec<_>>()
    };
    facets.iter().zip(&boundaries).flat_map(faces).collect()
}
