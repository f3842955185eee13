//! Polygon lights: validated once, prepared once, evaluated many times.

use alloc::vec::Vec;

use crate::real::Scalar;
use crate::vec3::Vec3;

/// Why loops of vertices are not a polygon light.
///
/// Loops and vertices are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PolygonError {
    /// There is no loop.
    #[error("the polygon has no loop: give at least one loop of three vertices")]
    NoLoop,
    /// A loop has fewer than three vertices.
    #[error("loop {loop_index} has {count} vertices: a loop needs at least three")]
    TooFewVertices {
        /// Which loop.
        loop_index: usize,
        /// How many vertices it has.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex_index} of loop {loop_index} is not finite: mend or drop it")]
    NotFinite {
        /// Which loop.
        loop_index: usize,
        /// Which vertex of it.
        vertex_index: usize,
    },
    /// The loops enclose no area, so that there is no plane and no light.
    #[error("the loops enclose no area: all vertices lie on a line, or the loops cancel")]
    NoArea,
    /// A vertex is too far from the plane of the others.
    #[error(
        "vertex {vertex_index} of loop {loop_index} is {distance} of the polygon's radius off its \
         plane: split the light into flat polygons"
    )]
    NotPlanar {
        /// Which loop.
        loop_index: usize,
        /// Which vertex of it.
        vertex_index: usize,
        /// Distance from the plane in units of the circumscribed circle's radius.
        distance: f64,
    },
    /// The size or place is outside what the number type can hold without overflow.
    #[error("the polygon's radius {radius} or position is out of range for this precision")]
    OutOfRange {
        /// Radius of the circumscribed circle.
        radius: f64,
    },
}

/// Which sides of its plane a light emits from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Sides {
    /// From the front only: the side from which outer loops run counter-clockwise.
    #[default]
    Front,
    /// From both sides alike.
    Both,
}

/// A planar polygon that emits uniformly, prepared for evaluation.
///
/// Made of one or more loops in one plane: outer loops counter-clockwise seen from the emitting
/// side, holes clockwise. Any vertex count; concave outlines are nothing special. The sign of a
/// loop is its orientation, so overlapping loops add and holes subtract; crossing outlines emit
/// by winding number.
///
/// Vertices are kept relative to the centre of a circumscribed circle and divided by its radius:
/// all the integrals are invariant to scale, and this is what keeps them accurate in single
/// precision at any size and distance.
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonLight<S> {
    /// Centre of the circumscribed circle: the origin of `offsets`.
    pub(crate) center: Vec3<S>,
    /// Radius of the circumscribed circle.
    pub(crate) radius: S,
    pub(crate) inverse_radius: S,
    /// Vertices of all loops, one loop after the other, in units of the radius from the centre.
    pub(crate) offsets: Vec<Vec3<S>>,
    /// End of each loop in `offsets`.
    pub(crate) loop_ends: Vec<usize>,
    /// Unit normal, towards the emitting side.
    pub(crate) normal: Vec3<S>,
    /// Twice the area in units of the squared radius.
    pub(crate) doubled_area: S,
    /// Centroid in units of the radius from the centre.
    pub(crate) centroid: Vec3<S>,
    /// Two unit vectors in the plane, right-handed with the normal.
    pub(crate) plane_axes: (Vec3<S>, Vec3<S>),
    /// `offsets` along `plane_axes`.
    pub(crate) plane_offsets: Vec<[S; 2]>,
    /// In radii: points no farther from the plane may lie in it, but for rounding of positions.
    pub(crate) plane_tolerance: S,
    pub(crate) sides: Sides,
}

/// Vertices may lie this far off the plane, in units of the circumscribed circle's radius.
///
/// Coordinates stored in single precision far from the origin are rarely closer; the light is
/// moved onto the plane, so this is no error of the integrals.
pub const PLANARITY_TOLERANCE: f64 = 1e-3;

impl PolygonLight<f64> {
    /// A light from its loops.
    ///
    /// # Errors
    /// Where the loops are empty, not finite, without area or not in one plane.
    pub fn new<P>(loops: &[P], sides: Sides) -> Result<Self, PolygonError>
    where
        P: AsRef<[[f64; 3]]>,
    {
        let loops: Vec<&[[f64; 3]]> = loops.iter().map(AsRef::as_ref).collect();
        validate(&loops)?;
        // Everything below is relative to the first vertex: sums of products of coordinates far
        // from the origin would lose the area.
        let origin = Vec3::from(loops[0][0]);
        let mut vertices = Vec::new();
        let mut loop_ends = Vec::with_capacity(loops.len());
        for vertex_loop in &loops {
            vertices.extend(vertex_loop.iter().map(|&v| Vec3::from(v) - origin));
            loop_ends.push(vertices.len());
        }
        let extent = vertices.iter().fold(0.0_f64, |m, v| {
            m.max(v.x.abs()).max(v.y.abs()).max(v.z.abs())
        });
        if extent <= 0.0 {
            return Err(PolygonError::NoArea);
        }
        if !(1e-100..=1e100).contains(&extent) {
            return Err(PolygonError::OutOfRange { radius: extent });
        }
        let vertices: Vec<_> = vertices.iter().map(|&v| v * (1.0 / extent)).collect();

        let doubled = edges(&vertices, &loop_ends)
            .map(|(a, b)| a.cross(b))
            .fold(Vec3::default(), |sum, q| sum + q);
        let doubled_area = doubled.length();
        // A sliver 1e-12 as wide as it is long still has a plane; rounding alone reaches 1e-16.
        if doubled_area <= 1e-14 {
            return Err(PolygonError::NoArea);
        }
        let normal = doubled * (1.0 / doubled_area);
        let plane = normal.dot(centroid(&vertices, &loop_ends, normal));

        let flat: Vec<_> = vertices
            .iter()
            .map(|&v| v - normal * (normal.dot(v) - plane))
            .collect();
        let (center, radius) = circumscribed_circle(&flat);
        let mut start = 0;
        for (loop_index, &end) in loop_ends.iter().enumerate() {
            for i in start..end {
                let off = vertices[i] - flat[i];
                let distance = off.length() / radius;
                if distance > PLANARITY_TOLERANCE {
                    return Err(PolygonError::NotPlanar {
                        loop_index,
                        vertex_index: i - start,
                        distance,
                    });
                }
            }
            start = end;
        }

        let inverse = 1.0 / radius;
        let offsets: Vec<_> = flat.iter().map(|&v| (v - center) * inverse).collect();
        let doubled_area = edges(&offsets, &loop_ends)
            .map(|(a, b)| a.cross(b).dot(normal))
            .sum();
        let centroid = centroid(&offsets, &loop_ends, normal);
        let radius = radius * extent;
        let plane_axes = normal.orthonormal_basis();
        let plane_offsets = offsets
            .iter()
            .map(|&v| [plane_axes.0.dot(v), plane_axes.1.dot(v)])
            .collect();
        let center_in_space = origin + center * extent;
        Ok(Self {
            center: center_in_space,
            radius,
            inverse_radius: 1.0 / radius,
            offsets,
            loop_ends,
            normal,
            doubled_area,
            centroid,
            plane_axes,
            plane_offsets,
            plane_tolerance: plane_tolerance::<f64>(center_in_space, radius),
            sides,
        })
    }

    /// The same light in another number type.
    ///
    /// # Errors
    /// If size or position overflow or vanish in it.
    pub fn cast<S: Scalar>(&self) -> Result<PolygonLight<S>, PolygonError> {
        let scalar = S::from_f64;
        let vector = |v: Vec3<f64>| Vec3::new(scalar(v.x), scalar(v.y), scalar(v.z));
        let cast = PolygonLight {
            center: vector(self.center),
            radius: scalar(self.radius),
            inverse_radius: scalar(self.inverse_radius),
            offsets: self.offsets.iter().map(|&v| vector(v)).collect(),
            loop_ends: self.loop_ends.clone(),
            normal: vector(self.normal),
            doubled_area: scalar(self.doubled_area),
            centroid: vector(self.centroid),
            plane_axes: (vector(self.plane_axes.0), vector(self.plane_axes.1)),
            plane_offsets: self.plane_offsets.iter().map(|v| v.map(scalar)).collect(),
            plane_tolerance: scalar(plane_tolerance::<S>(self.center, self.radius)),
            sides: self.sides,
        };
        let numbers = [
            cast.center.x,
            cast.center.y,
            cast.center.z,
            cast.radius,
            cast.inverse_radius,
        ];
        let fits = numbers.iter().all(|x| x.to_f64().is_finite())
            && cast.radius.to_f64() > 1e-35
            && cast.inverse_radius.to_f64() > 1e-35;
        if fits {
            Ok(cast)
        } else {
            Err(PolygonError::OutOfRange {
                radius: self.radius,
            })
        }
    }
}

impl<S: Scalar> PolygonLight<S> {
    /// Area in squared units of the vertices.
    pub fn area(&self) -> S {
        self.doubled_area * S::from_f64(0.5) * self.radius * self.radius
    }

    /// Unit normal, towards the emitting side.
    pub fn normal(&self) -> Vec3<S> {
        self.normal
    }

    /// Centroid of the area.
    pub fn centroid(&self) -> Vec3<S> {
        self.centroid * self.radius + self.center
    }

    /// Centre and radius of a circumscribed circle, at most 1 % larger than the smallest.
    pub fn circumscribed_circle(&self) -> (Vec3<S>, S) {
        (self.center, self.radius)
    }

    /// Whether both have the same vertices in their planes, to the last bit, in radii along their axes.
    pub fn has_outline_of(&self, other: &Self) -> bool {
        self.plane_offsets == other.plane_offsets && self.loop_ends == other.loop_ends
    }

    /// Number of vertices of all loops.
    pub fn vertex_count(&self) -> usize {
        self.offsets.len()
    }

    /// Number of loops.
    pub fn loop_count(&self) -> usize {
        self.loop_ends.len()
    }

    /// Which sides emit.
    pub fn sides(&self) -> Sides {
        self.sides
    }

    /// Vertices of all loops as they are stored: relative to the centre of the circumscribed circle,
    /// in units of its radius.
    pub fn offsets(&self) -> &[Vec3<S>] {
        &self.offsets
    }

    /// Twice the area, in squared radii.
    pub fn doubled_unit_area(&self) -> S {
        self.doubled_area
    }

    /// Centroid of the area relative to the circle's centre, in radii.
    pub fn centroid_offset(&self) -> Vec3<S> {
        self.centroid
    }

    /// Two unit vectors in the plane, right-handed with the normal.
    pub fn plane_axes(&self) -> (Vec3<S>, Vec3<S>) {
        self.plane_axes
    }

    /// In radii: points no farther from the plane may lie in it, but for rounding of positions.
    pub fn plane_tolerance(&self) -> S {
        self.plane_tolerance
    }

    /// The vertices of each loop.
    pub fn loops(&self) -> impl Iterator<Item = Vec<Vec3<S>>> + '_ {
        let mut start = 0;
        self.loop_ends.iter().map(move |&end| {
            let range = start..end;
            start = end;
            self.offsets[range]
                .iter()
                .map(|&v| v * self.radius + self.center)
                .collect()
        })
    }

    /// Which of [`PolygonLight::offsets`] each loop has.
    #[inline(always)]
    pub fn loop_ranges(&self) -> impl Iterator<Item = core::ops::Range<usize>> + '_ {
        let mut start = 0;
        self.loop_ends.iter().map(move |&end| {
            let range = start..end;
            start = end;
            range
        })
    }
}

/// What rounding coordinates to `S` may move a point near the light, in radii.
fn plane_tolerance<S: Scalar>(center: Vec3<f64>, radius: f64) -> f64 {
    let size = center.x.abs() + center.y.abs() + center.z.abs();
    4.0 * S::epsilon().to_f64() * (1.0 + size / radius)
}

fn validate(loops: &[&[[f64; 3]]]) -> Result<(), PolygonError> {
    if loops.is_empty() {
        return Err(PolygonError::NoLoop);
    }
    for (loop_index, vertices) in loops.iter().enumerate() {
        if vertices.len() < 3 {
            return Err(PolygonError::TooFewVertices {
                loop_index,
                count: vertices.len(),
            });
        }
        for (vertex_index, vertex) in vertices.iter().enumerate() {
            if !vertex.iter().all(|x| x.is_finite()) {
                return Err(PolygonError::NotFinite {
                    loop_index,
                    vertex_index,
                });
            }
        }
    }
    Ok(())
}

/// Every edge of every loop, the closing ones included.
fn edges<'a>(
    vertices: &'a [Vec3<f64>],
    loop_ends: &'a [usize],
) -> impl Iterator<Item = (Vec3<f64>, Vec3<f64>)> + 'a {
    let mut start = 0;
    loop_ends.iter().flat_map(move |&end| {
        let range = start..end;
        start = end;
        range.clone().map(move |i| {
            let next = if i + 1 == range.end {
                range.start
            } else {
                i + 1
            };
            (vertices[i], vertices[next])
        })
    })
}

/// Centroid of the signed area, on the polygon's plane.
fn centroid(vertices: &[Vec3<f64>], loop_ends: &[usize], normal: Vec3<f64>) -> Vec3<f64> {
    let apex = vertices[0];
    let (mut sum, mut weight) = (Vec3::default(), 0.0);
    for (a, b) in edges(vertices, loop_ends) {
        let area = (a - apex).cross(b - apex).dot(normal);
        sum += (a + b + apex) * (area / 3.0);
        weight += area;
    }
    sum * (1.0 / weight)
}

/// Centre and radius of a circle around coplanar points.
///
/// Ritter's two farthest points, then Badoiu and Clarkson's steps towards the farthest point
/// ("Smaller core-sets for balls", 2003), whose radius converges as 1/steps.
fn circumscribed_circle(points: &[Vec3<f64>]) -> (Vec3<f64>, f64) {
    let farthest =
        |from: Vec3<f64>| {
            points.iter().map(|&p| (p, (p - from).dot(p - from))).fold(
                (points[0], -1.0),
                |best, p| if p.1 > best.1 { p } else { best },
            )
        };
    let (a, _) = farthest(points[0]);
    let (b, _) = farthest(a);
    let mut best = (a + b) * 0.5;
    let mut best_radius = farthest(best).1;
    let mut center = best;
    for step in 0..100 {
        let (far, squared) = farthest(center);
        if squared < best_radius {
            (best, best_radius) = (center, squared);
        }
        center += (far - center) * (1.0 / f64::from(step + 2));
    }
    (best, libm::sqrt(best_radius))
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    fn square(z: f64) -> Vec<[f64; 3]> {
        [
            [-1.0, -1.0, z],
            [1.0, -1.0, z],
            [1.0, 1.0, z],
            [-1.0, 1.0, z],
        ]
        .to_vec()
    }

    #[test]
    fn square_with_hole() {
        let hole: Vec<_> = square(2.0)
            .iter()
            .rev()
            .map(|v| [v[0] * 0.5, v[1] * 0.5, v[2]])
            .collect();
        let light = PolygonLight::new(&[square(2.0), hole], Sides::Front).unwrap();
        assert!((light.area() - 3.0).abs() < 1e-14);
        assert!((light.normal().z - 1.0).abs() < 1e-15);
        let c = light.centroid();
        assert!(c.x.abs() + c.y.abs() + (c.z - 2.0).abs() < 1e-14);
        let (center, radius) = light.circumscribed_circle();
        assert!((radius - core::f64::consts::SQRT_2).abs() < 1e-12);
        assert!((center.z - 2.0).abs() < 1e-14);
        assert_eq!((light.vertex_count(), light.loop_count()), (8, 2));
        let corner = light.loops().next().unwrap()[2];
        assert!((corner - Vec3::new(1.0, 1.0, 2.0)).length() < 1e-14);
    }

    #[test]
    fn circle_is_nearly_the_smallest() {
        let triangle = vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [2.0, 3.4641016, 0.0]];
        let light = PolygonLight::new(&[triangle], Sides::Front).unwrap();
        let smallest = 4.0 / libm::sqrt(3.0);
        let ratio = light.circumscribed_circle().1 / smallest;
        assert!((1.0 - 1e-9..1.01).contains(&ratio), "{ratio}");
    }

    #[test]
    fn faults_are_named() {
        let no_loops: [Vec<[f64; 3]>; 0] = [];
        let fault = |loops: &[Vec<[f64; 3]>]| PolygonLight::new(loops, Sides::Front).unwrap_err();
        assert_eq!(fault(&no_loops), PolygonError::NoLoop);
        let two = square(0.0)[..2].to_vec();
        assert_eq!(
            fault(&[square(0.0), two]),
            PolygonError::TooFewVertices {
                loop_index: 1,
                count: 2
            }
        );
        let mut nan = square(0.0);
        nan[3][1] = f64::NAN;
        assert_eq!(
            fault(&[nan]),
            PolygonError::NotFinite {
                loop_index: 0,
                vertex_index: 3
            }
        );
        let line = vec![[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]];
        assert_eq!(fault(&[line]), PolygonError::NoArea);
        assert_eq!(fault(&[vec![[5.0; 3]; 4]]), PolygonError::NoArea);
        let mut bent = square(0.0);
        bent[2][2] = 0.3;
        assert!(matches!(fault(&[bent]), PolygonError::NotPlanar { .. }));
        let huge: Vec<_> = square(1.0).iter().map(|v| v.map(|x| x * 1e60)).collect();
        let light = PolygonLight::new(&[huge], Sides::Front).unwrap();
        assert!(matches!(
            light.cast::<f32>(),
            Err(PolygonError::OutOfRange { .. })
        ));
    }
}
