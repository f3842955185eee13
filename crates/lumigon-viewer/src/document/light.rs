//! A light as one holds it: an outline in a plane.

use glam::{DAffine2, DAffine3, DMat2, DMat3, DQuat, DVec2, DVec3, Vec3};

use super::LightPicture;
use super::surface::Surface;

/// Which light of a document: stays the same through edits, undo and redo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct LightId(pub(super) u32);

impl LightId {
    /// Its place in the order of [`super::Document::lights`], gaps of removed lights included.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A flat light that can be moved, reshaped and coloured.
///
/// Radiance and nits are one number here: glTF's emissive factor times strength is in nits
/// (`KHR_materials_emissive_strength`), and scenes in W m⁻² sr⁻¹ are lit alike.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The name of its mesh.
    pub name: String,
    /// Rotation and translation: x and y span the plane, +z is the side it emits to. The origin is
    /// about the centroid.
    pub world_from_plane: DAffine3,
    /// Metres in the plane: outer loops counter-clockwise seen from +z, holes clockwise, the first an
    /// outer one. Loops may touch at vertices and do not cross.
    pub loops: Vec<Vec<DVec2>>,
    /// Linear RGB radiance, at least 0; with a picture, what multiplies it.
    pub radiance: Vec3,
    /// It emits to -z as well.
    pub two_sided: bool,
    /// What it shows, where that is more than one colour.
    pub picture: Option<LightPicture>,
    /// The rest of its material, and where its textures lie.
    pub(super) surface: Surface,
}

impl Light {
    /// A light on a black surface, one-sided, of radiance 1. [`super::check`] says whether the loops are
    /// an outline.
    #[must_use]
    pub fn new(name: &str, world_from_plane: DAffine3, loops: Vec<Vec<DVec2>>) -> Self {
        Self {
            name: name.to_owned(),
            world_from_plane,
            loops,
            radiance: Vec3::ONE,
            two_sided: false,
            picture: None,
            surface: Surface::black(name),
        }
    }

    /// Why its outline cannot be changed, where that is so: its faces carry what no other outline
    /// could. It can be moved, turned, scaled and coloured all the same.
    ///
    /// # Errors
    /// The reason, a clause.
    pub fn can_reshape(&self) -> Result<(), &'static str> {
        self.surface
            .fixed
            .as_ref()
            .map_or(Ok(()), |fixed| Err(fixed.reason))
    }

    /// The area in square metres, holes taken off; of one side.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.loops.iter().map(|points| signed_area(points)).sum()
    }

    /// The unit normal, world space, towards the side it emits to.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.world_from_plane.matrix3.z_axis
    }

    /// The centroid of its area, in its plane; the mean of the vertices where there is no area.
    #[must_use]
    pub fn centroid(&self) -> DVec2 {
        centroid(&self.loops)
    }

    /// A point of the plane in the world.
    #[must_use]
    pub fn to_world(&self, point: DVec2) -> DVec3 {
        self.world_from_plane.transform_point3(point.extend(0.0))
    }

    /// The point of the plane nearest to one of the world.
    #[must_use]
    pub fn to_plane(&self, point: DVec3) -> DVec2 {
        let from_origin = point - self.world_from_plane.translation;
        (self.world_from_plane.matrix3.transpose() * from_origin).truncate()
    }

    /// The smallest and largest coordinates of its vertices in the plane.
    #[must_use]
    pub fn bounds(&self) -> (DVec2, DVec2) {
        self.loops
            .iter()
            .flatten()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| {
                (low.min(p), high.max(p))
            })
    }

    /// Moved by a vector of the world.
    #[must_use]
    pub fn moved(&self, by: DVec3) -> Self {
        let mut light = self.clone();
        light.world_from_plane.translation += by;
        light
    }

    /// Turned about its origin, counter-clockwise seen against the world-space `axis`, by an angle in
    /// radians. Where the axis has no direction it stays.
    #[must_use]
    pub fn turned(&self, axis: DVec3, angle: f64) -> Self {
        let mut light = self.clone();
        if let Some(axis) = axis.try_normalize() {
            let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, angle));
            light.world_from_plane.matrix3 = orthonormal(turn * self.world_from_plane.matrix3);
        }
        light
    }

    /// Scaled about its origin along the plane's x and y, with all that lies on it. `None` unless both
    /// are positive and finite.
    #[must_use]
    pub fn scaled(&self, x: f64, y: f64) -> Option<Self> {
        let is_scale = |s: f64| s.is_finite() && s > 0.0;
        if !is_scale(x) || !is_scale(y) {
            return None;
        }
        let scale = DVec2::new(x, y);
        Some(self.changed(DAffine2::from_scale(scale)))
    }

    /// The same light with its origin at the centroid of its area.
    #[must_use]
    pub fn recentred(&self) -> Self {
        let center = self.centroid();
        if center == DVec2::ZERO {
            return self.clone();
        }
        let mut light = self.changed(DAffine2::from_translation(-center));
        light.world_from_plane.translation = self.to_world(center);
        light
    }

    /// The same light with its plane's x and y axes turned counter-clockwise by an angle in radians: it
    /// stays where it is in the world.
    #[must_use]
    pub fn with_axes_turned(&self, angle: f64) -> Self {
        let mut light = self.changed(DAffine2::from_angle(-angle));
        light.world_from_plane.matrix3 =
            orthonormal(self.world_from_plane.matrix3 * DMat3::from_rotation_z(angle));
        light
    }

    /// All that lies in the plane, changed by a map of it.
    fn changed(&self, new_from_old: DAffine2) -> Self {
        let mut light = self.clone();
        for point in light.loops.iter_mut().flatten() {
            *point = new_from_old.transform_point2(*point);
        }
        if let Some(picture) = &mut light.picture {
            picture.texture_from_plane *= new_from_old.inverse();
        }
        light.surface.change(new_from_old);
        light
    }
}

/// The rotation nearest to a matrix that is almost one, keeping z's direction.
pub(super) fn orthonormal(matrix: DMat3) -> DMat3 {
    let z = matrix.z_axis.normalize();
    let x = (matrix.x_axis - z * z.dot(matrix.x_axis)).normalize();
    DMat3::from_cols(x, z.cross(x), z)
}

/// The area of a loop: positive where it runs counter-clockwise.
pub(super) fn signed_area(points: &[DVec2]) -> f64 {
    let Some(&first) = points.first() else {
        return 0.0;
    };
    let edges = points.iter().zip(points.iter().cycle().skip(1));
    0.5 * edges
        .map(|(&a, &b)| (a - first).perp_dot(b - first))
        .sum::<f64>()
}

/// The centroid of the area of loops, holes taken off.
pub(super) fn centroid(loops: &[Vec<DVec2>]) -> DVec2 {
    let mut points = loops.iter().flatten();
    let Some(&first) = points.next() else {
        return DVec2::ZERO;
    };
    let (mut moment, mut doubled) = (DVec2::ZERO, 0.0);
    for points in loops {
        for (&a, &b) in points.iter().zip(points.iter().cycle().skip(1)) {
            let (a, b) = (a - first, b - first);
            let weight = a.perp_dot(b);
            moment += (a + b) * weight;
            doubled += weight;
        }
    }
    let center = first + moment / (3.0 * doubled);
    if center.is_finite() {
        return center;
    }
    let count = loops.iter().map(Vec::len).sum::<usize>() as f64;
    loops
        .iter()
        .flatten()
        .fold(DVec2::ZERO, |sum, &p| sum + p / count)
}

/// Rotation and translation onto a plane at `origin` that faces along `normal`, its y axis as near to up
/// as it gets: on floors and ceilings, away from the viewer who looks along -z.
///
/// A normal without direction faces along +z.
#[must_use]
pub fn plane_frame(origin: DVec3, normal: DVec3) -> DAffine3 {
    let z = normal.try_normalize().unwrap_or(DVec3::Z);
    let up = upward(z);
    DAffine3 {
        matrix3: DMat3::from_cols(up.cross(z), up, z),
        translation: origin,
    }
}

/// The unit vector of the plane of a unit normal that points up, or on horizontal planes away.
pub(super) fn upward(normal: DVec3) -> DVec3 {
    let up = if normal.y.abs() > 0.999 {
        DVec3::NEG_Z
    } else {
        DVec3::Y
    };
    (up - normal * normal.dot(up)).normalize()
}

/// How often to turn axes counter-clockwise by a quarter for their y to point up the most.
pub(super) fn quarters_upright(axes: DMat3) -> u32 {
    let up = upward(axes.z_axis.normalize());
    let turned = [axes.y_axis, -axes.x_axis, -axes.y_axis, axes.x_axis];
    (0_u32..)
        .zip(turned.map(|y| y.dot(up)))
        // The first of equals.
        .fold(
            (0, f64::MIN),
            |best, (k, y)| {
                if y > best.1 + 1e-9 { (k, y) } else { best }
            },
        )
        .0
}

/// A rotation of the plane by quarters, exact.
pub(super) fn quarter_turn(quarters: u32) -> DMat2 {
    let (x, y) = match quarters % 4 {
        0 => (DVec2::X, DVec2::Y),
        1 => (DVec2::Y, DVec2::NEG_X),
        2 => (DVec2::NEG_X, DVec2::NEG_Y),
        _ => (DVec2::NEG_Y, DVec2::X),
    };
    DMat2::from_cols(x, y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light() -> Light {
        let loops = vec![
            [(0., 0.), (4., 0.), (4., 2.), (0., 2.)]
                .map(DVec2::from)
                .to_vec(),
            [(1., 0.5), (1., 1.5), (2., 1.5), (2., 0.5)]
                .map(DVec2::from)
                .to_vec(),
        ];
        Light::new(
            "lamp",
            plane_frame(DVec3::new(1.0, 2.0, 3.0), DVec3::NEG_Y),
            loops,
        )
    }

    #[test]
    fn holes_count_in_area_and_centroid() {
        let light = light();
        assert_eq!(light.area(), 7.0);
        // The hole's centre is half a metre left of the whole's.
        let expected = DVec2::new((8.0 * 2.0 - 1.5) / 7.0, 1.0);
        assert!((light.centroid() - expected).length() < 1e-12);
    }

    #[test]
    fn recentring_moves_nothing() {
        let before = light();
        let after = before.recentred();
        assert!(after.centroid().length() < 1e-12);
        let turned = after.with_axes_turned(0.3);
        let points = |light: &Light| -> Vec<DVec3> {
            let points = light.loops.iter().flatten();
            points.map(|&p| light.to_world(p)).collect()
        };
        for other in [&after, &turned] {
            for (a, b) in points(&before).into_iter().zip(points(other)) {
                assert!(a.distance(b) < 1e-12);
            }
        }
        let point = DVec2::new(0.7, -1.3);
        assert!(turned.to_plane(turned.to_world(point)).distance(point) < 1e-12);
    }

    #[test]
    fn turns_keep_the_frame_rigid_and_scales_are_positive() {
        let mut light = light();
        for step in 0..10_000 {
            light = light.turned(DVec3::new(0.3, f64::from(step % 7), -1.0), 0.1);
        }
        let m = light.world_from_plane.matrix3;
        assert!(
            (m.transpose() * m - DMat3::IDENTITY)
                .to_cols_array()
                .iter()
                .all(|x| x.abs() < 1e-14)
        );
        assert!(m.determinant() > 0.0);
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(light.scaled(bad, 1.0).is_none() && light.scaled(1.0, bad).is_none());
        }
        assert_eq!(light.scaled(2.0, 0.5).unwrap().area(), 7.0);
    }

    #[test]
    fn upright_frames() {
        let wall = plane_frame(DVec3::ZERO, DVec3::X).matrix3;
        assert_eq!(wall.y_axis, DVec3::Y);
        assert_eq!(wall.x_axis, DVec3::NEG_Z);
        for quarters in 0..4 {
            let turn = DMat3::from_mat2(quarter_turn(quarters));
            // Turned back.
            assert_eq!((quarters_upright(wall * turn) + quarters) % 4, 0);
        }
    }
}
