use std::f64::consts::TAU;

use glam::DVec3;

/// Most vertices a clipped training quad has: each of two planes adds one.
const CAPACITY: usize = 6;

/// A convex polygon in a fixed buffer, for clipping without allocation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clipped {
    vertices: [DVec3; CAPACITY],
    len: usize,
}

impl Clipped {
    /// At most [`CAPACITY`] vertices are kept.
    pub(crate) fn new(vertices: impl IntoIterator<Item = DVec3>) -> Self {
        let mut clipped = Self {
            vertices: [DVec3::ZERO; CAPACITY],
            len: 0,
        };
        for v in vertices {
            clipped.push(v);
        }
        clipped
    }

    pub(crate) fn vertices(&self) -> &[DVec3] {
        &self.vertices[..self.len]
    }

    fn push(&mut self, v: DVec3) {
        if self.len < CAPACITY {
            self.vertices[self.len] = v;
            self.len += 1;
        }
    }

    /// The part with `plane . v > 0` (Sutherland and Hodgman 1974).
    pub(crate) fn clip(&self, plane: DVec3) -> Self {
        let mut kept = Self::new([]);
        for i in 0..self.len {
            let (a, b) = (self.vertices[i], self.vertices[(i + 1) % self.len]);
            let (da, db) = (plane.dot(a), plane.dot(b));
            if da > 0.0 {
                kept.push(a);
            }
            if (da > 0.0) != (db > 0.0) {
                kept.push(a + (da / (da - db)) * (b - a));
            }
        }
        kept
    }
}

/// Form factor in `[0,1]` of a convex polygon, counter-clockwise seen from the origin, for the
/// clamped cosine about z; parts below the plane z = 0 do not count (Lambert's edge sum).
/// Absolute error below 1e-12 for polygons wider than 1e-3.
pub(crate) fn form_factor(polygon: &Clipped) -> f64 {
    let clipped = if polygon.vertices().iter().all(|v| v.z > 0.0) {
        *polygon
    } else {
        polygon.clip(DVec3::Z)
    };
    let v = clipped.vertices();
    let mut sum = 0.0;
    for i in 0..v.len() {
        let (a, b) = (v[i], v[(i + 1) % v.len()]);
        let q = a.cross(b);
        let s = q.length();
        if s > 0.0 {
            sum -= q.z * s.atan2(a.dot(b)) / s;
        }
    }
    (sum / TAU).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The half space above a square at z = h, as its half width grows; and one below the horizon.
    #[test]
    fn square_overhead() {
        let square = |h: f64| {
            Clipped::new([
                DVec3::new(-1.0, -1.0, h),
                DVec3::new(-1.0, 1.0, h),
                DVec3::new(1.0, 1.0, h),
                DVec3::new(1.0, -1.0, h),
            ])
        };
        // Four quarters, each the textbook corner element (Howell, configuration C-4).
        let (x, root) = (1.0_f64, 2.0_f64.sqrt());
        let corner = 2.0 * (x / root) * (x / root).atan() / TAU;
        assert!((form_factor(&square(1.0)) - 4.0 * corner).abs() < 1e-14);
        assert!((form_factor(&square(1e-9)) - 1.0).abs() < 1e-8);
        assert!(form_factor(&square(-1.0)).abs() < 1e-15);
    }

    #[test]
    fn wall_down_to_the_horizon() {
        // A wall from below to above the horizon counts like its upper half.
        let wall = |low: f64| {
            Clipped::new([
                DVec3::new(2.0, 1.0, low),
                DVec3::new(2.0, -1.0, low),
                DVec3::new(2.0, -1.0, 1.0),
                DVec3::new(2.0, 1.0, 1.0),
            ])
        };
        let upper = form_factor(&wall(0.0));
        assert!(upper > 0.01);
        assert!((form_factor(&wall(-3.0)) - upper).abs() < 1e-14);
    }
}
