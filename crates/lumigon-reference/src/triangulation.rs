//! Loops to triangles.

use earcut::Earcut;
use glam::{DVec2, DVec3};

use crate::polygon::PolygonError;

/// Cuts each counter-clockwise loop, less the clockwise loops inside it, into triangles of the given vertices.
pub(crate) fn triangulate(
    loops: &[Vec<DVec3>],
    vector_areas: &[DVec3],
    normal: DVec3,
) -> Result<Vec<[DVec3; 3]>, PolygonError> {
    let (tangent, bitangent) = normal.any_orthonormal_pair();
    let flat: Vec<Vec<DVec2>> = loops
        .iter()
        .map(|vertices| {
            let project = |v: &DVec3| DVec2::new(tangent.dot(*v), bitangent.dot(*v));
            vertices.iter().map(project).collect()
        })
        .collect();
    let areas: Vec<f64> = vector_areas.iter().map(|a| normal.dot(*a)).collect();
    let outers: Vec<usize> = (0..loops.len()).filter(|&i| areas[i] > 0.0).collect();
    let mut holes: Vec<Vec<usize>> = vec![Vec::new(); loops.len()];
    for hole in (0..loops.len()).filter(|&i| areas[i] <= 0.0) {
        // The midpoint of an edge, since holes may touch their outline at vertices.
        let inside = 0.5 * (flat[hole][0] + flat[hole][1]);
        let owner = match outers[..] {
            [only] => Some(only),
            _ => outers
                .iter()
                .copied()
                .filter(|&outer| contains(&flat[outer], inside))
                .min_by(|&a, &b| areas[a].total_cmp(&areas[b])),
        };
        let owner = owner.ok_or(PolygonError::HoleOutside { loop_index: hole })?;
        holes[owner].push(hole);
    }

    let mut earcut = Earcut::new();
    let mut triangles = Vec::new();
    for outer in outers {
        let mut vertices = loops[outer].clone();
        let mut positions = flat[outer].clone();
        let mut hole_starts = Vec::new();
        for &hole in &holes[outer] {
            hole_starts.push(vertices.len());
            vertices.extend(&loops[hole]);
            positions.extend(&flat[hole]);
        }
        let mut indices: Vec<usize> = Vec::new();
        earcut.earcut(
            positions.iter().map(|p| [p.x, p.y]),
            &hole_starts,
            &mut indices,
        );
        triangles.extend(
            indices
                .chunks_exact(3)
                .map(|t| [vertices[t[0]], vertices[t[1]], vertices[t[2]]]),
        );
    }
    Ok(triangles)
}

/// Whether a point lies in a loop, by the crossing number.
fn contains(vertices: &[DVec2], point: DVec2) -> bool {
    let mut inside = false;
    for (i, a) in vertices.iter().enumerate() {
        let b = vertices[(i + 1) % vertices.len()];
        if (a.y > point.y) != (b.y > point.y)
            && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
        {
            inside = !inside;
        }
    }
    inside
}
