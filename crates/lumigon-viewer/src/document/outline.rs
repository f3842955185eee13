//! Edits of the loops of an outline, in the light's plane.
//!
//! They change loops and say whether they could; [`super::check`] says whether an outline came of it.

use glam::DVec2;

use super::light::signed_area;

/// Where an edge of an outline starts, or a vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Corner {
    /// Index of the loop.
    pub loop_index: usize,
    /// Index of the vertex in it. As an edge: from this vertex to the next, the last to the first.
    pub vertex: usize,
}

/// Whether a point is inside a loop, by the crossing number.
#[must_use]
pub fn contains(points: &[DVec2], p: DVec2) -> bool {
    let edges = points.iter().zip(points.iter().cycle().skip(1));
    let crossings = edges.filter(|&(&a, &b)| {
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossings.count() % 2 == 1
}

/// The ends of an edge; `None` where there is no such edge.
#[must_use]
pub fn edge(loops: &[Vec<DVec2>], edge: Corner) -> Option<[DVec2; 2]> {
    let points = loops.get(edge.loop_index)?;
    let a = *points.get(edge.vertex)?;
    Some([a, points[(edge.vertex + 1) % points.len()]])
}

/// Puts a vertex somewhere else. False where there is no such vertex.
pub fn move_vertex(loops: &mut [Vec<DVec2>], vertex: Corner, to: DVec2) -> bool {
    let points = loops.get_mut(vertex.loop_index);
    let point = points.and_then(|points| points.get_mut(vertex.vertex));
    point.map(|point| *point = to).is_some()
}

/// Inserts a vertex on an edge; returns which it is. `None` where there is no such edge.
pub fn insert_vertex(loops: &mut [Vec<DVec2>], edge: Corner, at: DVec2) -> Option<Corner> {
    let points = loops.get_mut(edge.loop_index)?;
    if edge.vertex >= points.len() {
        return None;
    }
    points.insert(edge.vertex + 1, at);
    Some(Corner {
        vertex: edge.vertex + 1,
        ..edge
    })
}

/// Deletes a vertex. False where there is none, or its loop would have fewer than three.
pub fn delete_vertex(loops: &mut [Vec<DVec2>], vertex: Corner) -> bool {
    let found = loops.get_mut(vertex.loop_index);
    let found = found.filter(|points| points.len() > 3 && vertex.vertex < points.len());
    found.map(|points| points.remove(vertex.vertex)).is_some()
}

/// Cuts a hole, whichever way its points run; returns its index. `None` for fewer than three points.
pub fn add_hole(loops: &mut Vec<Vec<DVec2>>, mut points: Vec<DVec2>) -> Option<usize> {
    if points.len() < 3 {
        return None;
    }
    if signed_area(&points) > 0.0 {
        points.reverse();
    }
    loops.push(points);
    Some(loops.len() - 1)
}

/// Fills a hole. False where that loop is none.
pub fn delete_hole(loops: &mut Vec<Vec<DVec2>>, loop_index: usize) -> bool {
    let is_hole = loops
        .get(loop_index)
        .is_some_and(|points| signed_area(points) < 0.0);
    if is_hole {
        loops.remove(loop_index);
    }
    is_hole
}

/// Moves a whole loop; an outer one takes the holes in it along. False where there is no such loop.
pub fn move_loop(loops: &mut [Vec<DVec2>], loop_index: usize, by: DVec2) -> bool {
    let Some(moved) = loops.get(loop_index).cloned() else {
        return false;
    };
    let is_outer = signed_area(&moved) > 0.0;
    for (index, points) in loops.iter_mut().enumerate() {
        // Loops may touch at vertices, not along edges.
        let inside = || contains(&moved, (points[0] + points[1]) * 0.5);
        if index == loop_index || (is_outer && points.len() > 1 && inside()) {
            for point in points {
                *point += by;
            }
        }
    }
    true
}

/// The edge nearest to a point, the point of it nearest, and how far that is. `None` without edges.
#[must_use]
pub fn nearest_edge(loops: &[Vec<DVec2>], p: DVec2) -> Option<(Corner, DVec2, f64)> {
    let edges = loops.iter().enumerate().flat_map(|(loop_index, points)| {
        (0..points.len()).map(move |vertex| Corner { loop_index, vertex })
    });
    let near = edges.filter_map(|corner| {
        let [a, b] = edge(loops, corner)?;
        let along = b - a;
        let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let nearest = if t.is_finite() { a + along * t } else { a };
        Some((corner, nearest, nearest.distance(p)))
    });
    near.min_by(|a, b| a.2.total_cmp(&b.2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::check;

    fn square(side: f64) -> Vec<DVec2> {
        let corners = [(0., 0.), (side, 0.), (side, side), (0., side)];
        corners.map(DVec2::from).to_vec()
    }

    fn corner(loop_index: usize, vertex: usize) -> Corner {
        Corner { loop_index, vertex }
    }

    #[test]
    fn vertices_come_move_and_go() {
        let mut loops = vec![square(2.0)];
        // On the last edge, which closes the loop.
        let middle = DVec2::new(0.0, 1.0);
        assert_eq!(
            insert_vertex(&mut loops, corner(0, 3), middle),
            Some(corner(0, 4))
        );
        assert_eq!(edge(&loops, corner(0, 4)), Some([middle, DVec2::ZERO]));
        assert!(move_vertex(&mut loops, corner(0, 4), DVec2::new(-1.0, 1.0)));
        assert_eq!((signed_area(&loops[0]), check(&loops)), (5.0, Ok(())));
        assert!(delete_vertex(&mut loops, corner(0, 0)));
        assert!(delete_vertex(&mut loops, corner(0, 0)));
        // Three are left.
        assert!(!delete_vertex(&mut loops, corner(0, 0)));
        for missing in [corner(0, 3), corner(1, 0)] {
            assert!(!move_vertex(&mut loops, missing, middle));
            assert!(!delete_vertex(&mut loops, missing));
            assert_eq!(insert_vertex(&mut loops, missing, middle), None);
            assert_eq!(edge(&loops, missing), None);
        }
    }

    #[test]
    fn holes_come_move_and_go() {
        let mut loops = vec![square(4.0)];
        let mut hole = square(1.0);
        for p in &mut hole {
            *p += DVec2::ONE;
        }
        assert_eq!(add_hole(&mut loops, hole[..2].to_vec()), None);
        assert_eq!(add_hole(&mut loops, hole), Some(1));
        assert_eq!((signed_area(&loops[1]), check(&loops)), (-1.0, Ok(())));
        assert!(move_loop(&mut loops, 1, DVec2::X));
        assert_eq!(loops[1].iter().map(|p| p.x).fold(0.0, f64::max), 3.0);
        // The outer one takes it along.
        assert!(move_loop(&mut loops, 0, DVec2::Y * 10.0));
        assert_eq!(check(&loops), Ok(()));
        assert!(!move_loop(&mut loops, 2, DVec2::Y));
        assert!(!delete_hole(&mut loops, 0) && !delete_hole(&mut loops, 2));
        assert!(delete_hole(&mut loops, 1));
        assert_eq!(loops.len(), 1);
    }

    #[test]
    fn the_nearest_edge() {
        let loops = vec![square(4.0), square(1.0)];
        let (found, at, distance) = nearest_edge(&loops, DVec2::new(5.0, 3.0)).unwrap();
        assert_eq!(
            (found, at, distance),
            (corner(0, 1), DVec2::new(4.0, 3.0), 1.0)
        );
        assert_eq!(nearest_edge(&[], DVec2::ZERO), None);
        assert!(nearest_edge(&[vec![DVec2::ONE; 3]], DVec2::ZERO).is_some());
    }
}
