//! A planar polygon that emits light: validated once, cut into triangles once.

use glam::DVec3;
use thiserror::Error;

use crate::triangulation::triangulate;

/// Largest coordinate magnitude accepted, so that no product of four lengths overflows.
const LARGEST_COORDINATE: f64 = 1e30;

/// Why loops are not a polygon this crate can integrate over.
///
/// Loops and vertices are counted from 0, in the order given.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PolygonError {
    /// There are no loops at all.
    #[error("the polygon has no loops; give at least the outer one")]
    NoLoops,
    /// A loop has one or two vertices, or none.
    #[error("loop {loop_index} has {count} vertices; a loop needs at least 3")]
    TooFewVertices {
        /// Which loop.
        loop_index: usize,
        /// How many vertices it has.
        count: usize,
    },
    /// A coordinate is NaN, infinite or beyond 1e30.
    #[error(
        "loop {loop_index}, vertex {vertex_index}: {vertex:?} is not a position; coordinates must be finite and within 1e30"
    )]
    NotFinite {
        /// Which loop.
        loop_index: usize,
        /// Which vertex of that loop.
        vertex_index: usize,
        /// The offending vertex.
        vertex: [f64; 3],
    },
    /// A loop encloses nothing: its vertices coincide or lie on a line.
    #[error("loop {loop_index} encloses no area; its vertices coincide or lie on one line")]
    ZeroArea {
        /// Which loop.
        loop_index: usize,
    },
    /// The loops enclose no area together: holes are as large as outlines.
    #[error(
        "the loops enclose no area together; holes run clockwise and lie inside the outer loop"
    )]
    NothingLeft,
    /// A vertex is off the common plane by more than 1e-4 of the polygon's extent.
    #[error(
        "loop {loop_index}, vertex {vertex_index} lies {distance:e} off the polygon's plane; split the polygon into planar ones"
    )]
    NotPlanar {
        /// Which loop.
        loop_index: usize,
        /// Which vertex of that loop.
        vertex_index: usize,
        /// Its distance from the plane, in the unit of the coordinates.
        distance: f64,
    },
    /// A clockwise loop lies in no counter-clockwise loop.
    #[error("loop {loop_index} is a hole (clockwise) but lies inside no outer loop")]
    HoleOutside {
        /// Which loop.
        loop_index: usize,
    },
    /// The triangles do not add up to the outline's area: edges cross.
    #[error(
        "the loops cross themselves or each other: their triangles cover {covered:e} of an area of {enclosed:e}"
    )]
    Crossing {
        /// Sum of the triangles' areas.
        covered: f64,
        /// Signed area enclosed by the loops.
        enclosed: f64,
    },
}

/// A planar polygon that emits light, with its triangulation.
///
/// The outer loop runs counter-clockwise seen from the side that emits, holes clockwise; concave outlines are
/// normal. Loops may come in any order, and several outer loops may share the plane. Coordinates are in one length
/// unit (metres) and any frame.
#[derive(Debug, Clone)]
pub struct Polygon {
    normal: DVec3,
    centroid: DVec3,
    triangles: Vec<[DVec3; 3]>,
    area: f64,
    two_sided: bool,
}

impl Polygon {
    /// Checks the loops and cuts them into triangles.
    ///
    /// # Errors
    /// What is wrong and with which loop and vertex; see [`PolygonError`].
    pub fn new(loops: &[Vec<[f64; 3]>], two_sided: bool) -> Result<Self, PolygonError> {
        if loops.is_empty() {
            return Err(PolygonError::NoLoops);
        }
        for (loop_index, vertices) in loops.iter().enumerate() {
            if vertices.len() < 3 {
                return Err(PolygonError::TooFewVertices {
                    loop_index,
                    count: vertices.len(),
                });
            }
            for (vertex_index, &vertex) in vertices.iter().enumerate() {
                if !is_position(vertex) {
                    return Err(PolygonError::NotFinite {
                        loop_index,
                        vertex_index,
                        vertex,
                    });
                }
            }
        }

        let origin = DVec3::from(loops[0][0]);
        let offsets: Vec<Vec<DVec3>> = loops
            .iter()
            .map(|vertices| vertices.iter().map(|&v| DVec3::from(v) - origin).collect())
            .collect();
        let largest = loops
            .iter()
            .flatten()
            .flatten()
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let extent = offsets
            .iter()
            .flatten()
            .fold(0.0, |m: f64, v| m.max(v.length()));
        // A few dozen roundings of the products below.
        let smallest_area = (1e-14 * extent * extent.max(largest)).max(f64::MIN_POSITIVE);

        let vector_areas: Vec<DVec3> = offsets
            .iter()
            .map(|vertices| vector_area(vertices))
            .collect();
        for (loop_index, area) in vector_areas.iter().enumerate() {
            if area.length() <= smallest_area {
                return Err(PolygonError::ZeroArea { loop_index });
            }
        }
        let vector_area: DVec3 = vector_areas.iter().sum();
        let enclosed = vector_area.length();
        if enclosed <= smallest_area {
            return Err(PolygonError::NothingLeft);
        }
        let normal = vector_area / enclosed;

        let count = offsets.iter().map(Vec::len).sum::<usize>() as f64;
        let plane = offsets
            .iter()
            .flatten()
            .map(|v| normal.dot(*v))
            .sum::<f64>()
            / count;
        for (loop_index, vertices) in offsets.iter().enumerate() {
            for (vertex_index, vertex) in vertices.iter().enumerate() {
                let distance = (normal.dot(*vertex) - plane).abs();
                if distance > 1e-4 * extent + 1e-6 * largest {
                    return Err(PolygonError::NotPlanar {
                        loop_index,
                        vertex_index,
                        distance,
                    });
                }
            }
        }

        let triangles: Vec<[DVec3; 3]> = triangulate(&offsets, &vector_areas, normal)?;
        let covered: f64 = triangles.iter().map(|t| signed_area(t, normal).abs()).sum();
        if (covered - enclosed).abs() > 1e-9 * enclosed + smallest_area * count {
            return Err(PolygonError::Crossing { covered, enclosed });
        }
        let centroid = triangles
            .iter()
            .map(|t| signed_area(t, normal).abs() / covered * (t[0] + t[1] + t[2]) / 3.0)
            .sum::<DVec3>();
        Ok(Self {
            normal,
            centroid: origin + centroid,
            triangles: triangles
                .into_iter()
                // The triangulator's orientation is its own affair; ours is counter-clockwise.
                .map(|[a, b, c]| match signed_area(&[a, b, c], normal) < 0.0 {
                    true => [a, c, b].map(|v| origin + v),
                    false => [a, b, c].map(|v| origin + v),
                })
                .collect(),
            area: covered,
            two_sided,
        })
    }

    /// Unit normal on the emitting side.
    pub fn normal(&self) -> [f64; 3] {
        self.normal.into()
    }

    /// Area in square metres, holes left out.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Centre of mass; of a ring it lies in the hole.
    pub fn centroid(&self) -> [f64; 3] {
        self.centroid.into()
    }

    /// The polygon as triangles, each counter-clockwise seen from the emitting side.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [[f64; 3]; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(Into::into))
    }

    /// Whether the other side emits too.
    pub fn is_two_sided(&self) -> bool {
        self.two_sided
    }

    /// Signed height of a point above the plane, positive on the emitting side.
    pub(crate) fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.centroid)
    }

    pub(crate) fn triangle_vertices(&self) -> &[[DVec3; 3]] {
        &self.triangles
    }
}

/// Whether a coordinate triple is finite and within what the arithmetic here can square twice.
pub(crate) fn is_position(position: [f64; 3]) -> bool {
    position.iter().all(|x| x.abs() <= LARGEST_COORDINATE)
}

/// Half the sum of cross products about the first vertex: area times normal (Newell's method).
fn vector_area(vertices: &[DVec3]) -> DVec3 {
    let first = vertices[0];
    0.5 * vertices
        .windows(2)
        .map(|edge| (edge[0] - first).cross(edge[1] - first))
        .sum::<DVec3>()
}

fn signed_area([a, b, c]: &[DVec3; 3], normal: DVec3) -> f64 {
    0.5 * normal.dot((b - a).cross(c - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half: f64, centre: [f64; 2], hole: bool) -> Vec<[f64; 3]> {
        let mut corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
        if hole {
            corners.reverse();
        }
        corners
            .iter()
            .map(|c| [c[0] + centre[0], c[1] + centre[1], 5.0])
            .collect()
    }

    #[test]
    fn holes_and_islands_keep_their_area_in_any_order() {
        let loops = [
            square(0.5, [0.0, 0.0], true),
            square(2.0, [0.0, 0.0], false),
            square(1.0, [4.0, 0.0], false),
            square(0.25, [4.0, 0.2], true),
        ];
        let polygon = Polygon::new(&loops, false).unwrap();
        assert!((polygon.area() - (16.0 - 1.0 + 4.0 - 0.25)).abs() < 1e-12);
        assert_eq!(polygon.normal(), [0.0, 0.0, 1.0]);
        let triangles: f64 = polygon
            .triangles()
            .map(|t| signed_area(&t.map(DVec3::from), DVec3::Z))
            .sum();
        assert!((triangles - polygon.area()).abs() < 1e-12);
    }

    #[test]
    fn every_defect_is_named() {
        let good = square(1.0, [0.0, 0.0], false);
        let error = |loops: &[Vec<[f64; 3]>]| Polygon::new(loops, false).unwrap_err();
        assert_eq!(error(&[]), PolygonError::NoLoops);
        assert_eq!(
            error(&[good.clone(), vec![[0.0; 3]; 2]]),
            PolygonError::TooFewVertices {
                loop_index: 1,
                count: 2
            }
        );
        let mut broken = good.clone();
        broken[2][1] = f64::NAN;
        assert!(matches!(
            error(&[broken.clone()]),
            PolygonError::NotFinite {
                loop_index: 0,
                vertex_index: 2,
                ..
            }
        ));
        broken[2] = [1.0, 1.0, 5.1];
        assert!(matches!(
            error(&[broken]),
            PolygonError::NotPlanar { loop_index: 0, .. }
        ));
        let line = vec![[0.0; 3], [0.1, 0.2, 0.3], [0.2, 0.4, 0.6], [0.1, 0.2, 0.3]];
        assert_eq!(error(&[line]), PolygonError::ZeroArea { loop_index: 0 });
        assert_eq!(
            error(&[good.clone(), square(1.0, [0.0, 0.0], true)]),
            PolygonError::NothingLeft
        );
        let islands = [
            good.clone(),
            square(1.0, [4.0, 0.0], false),
            square(0.5, [9.0, 0.0], true),
        ];
        assert_eq!(error(&islands), PolygonError::HoleOutside { loop_index: 2 });
        let bow = vec![
            [0.0, 0.0, 0.0],
            [2.0, 2.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
        ];
        assert!(matches!(error(&[bow]), PolygonError::Crossing { .. }));
        assert!(matches!(
            error(&[good, square(0.5, [1.0, 0.0], true)]),
            PolygonError::Crossing { .. }
        ));
    }
}
