//! The camera in the user's hand.

use glam::{Affine3A, Mat3, Vec2, Vec3};
use lumigon_renderer::{Camera, Projection, Scene};

/// How far from straight up or down an orbit ends, in radians.
const POLE: f32 = 1e-3;

/// Radians that dragging over the height of the picture turns by.
const TURN: f32 = 3.0;

/// A camera that orbits a point, moves along its picture, and flies.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Navigation {
    camera: Camera,
    /// The point that orbits keep in the middle.
    target: Vec3,
    /// Radius of the scene, in metres, above 0.
    extent: f32,
}

impl Navigation {
    /// The scene's camera of that index, or one that sees all of the scene where it has none.
    pub(crate) fn new(scene: &Scene, index: usize) -> Self {
        let camera = scene.cameras.get(index).cloned();
        let camera = camera.unwrap_or_else(|| Camera::framing(scene));
        let (low, high) = scene.bounds().unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
        let radius = (high * 0.5 - low * 0.5).length();
        let extent = if radius.is_finite() && radius > 0.0 {
            radius
        } else {
            1.0
        };
        let mut this = Self {
            camera,
            target: low * 0.5 + high * 0.5,
            extent,
        };
        // Turning begins about what the camera looks at, as far away as the scene's middle.
        let ahead = (this.target - this.position()).dot(this.forward());
        let ahead = if ahead > 0.01 * extent { ahead } else { extent };
        this.target = this.position() + this.forward() * ahead;
        this
    }

    /// Where pictures are taken from.
    pub(crate) fn camera(&self) -> &Camera {
        &self.camera
    }

    fn position(&self) -> Vec3 {
        self.camera.world_from_camera.translation.into()
    }

    pub(crate) fn right(&self) -> Vec3 {
        self.camera.world_from_camera.matrix3.x_axis.into()
    }

    pub(crate) fn up(&self) -> Vec3 {
        self.camera.world_from_camera.matrix3.y_axis.into()
    }

    pub(crate) fn forward(&self) -> Vec3 {
        Vec3::from(-self.camera.world_from_camera.matrix3.z_axis).normalize_or(Vec3::NEG_Z)
    }

    /// Metres at the target for a picture's height.
    fn height_at_target(&self, aspect: f32) -> f32 {
        match self.camera.projection {
            Projection::Perspective {
                yfov,
                aspect: authored,
            } => {
                let half = (yfov * 0.5).tan() * authored.map_or(1.0, |a| (a / aspect).max(1.0));
                2.0 * half * self.position().distance(self.target)
            }
            Projection::Orthographic { xmag, ymag } => 2.0 * ymag.max(xmag / aspect),
        }
    }

    /// Takes a place and a direction, level; kept as it is where they are no numbers.
    fn place(&mut self, position: Vec3, forward: Vec3) {
        let right = forward.cross(Vec3::Y).normalize_or(self.right());
        let up = right.cross(forward);
        let axes = Mat3::from_cols(right, up, -forward);
        let affine = Affine3A::from_mat3_translation(axes, position);
        if affine.is_finite() {
            self.camera.world_from_camera = affine;
        }
    }

    /// The direction turned by a drag, in heights of the picture, up to the poles.
    fn turned(&self, by: Vec2) -> Vec3 {
        let forward = self.forward();
        let yaw = forward.x.atan2(-forward.z) + by.x * TURN;
        let limit = std::f32::consts::FRAC_PI_2 - POLE;
        let pitch = (forward.y.clamp(-1.0, 1.0).asin() - by.y * TURN).clamp(-limit, limit);
        Vec3::new(
            pitch.cos() * yaw.sin(),
            pitch.sin(),
            -pitch.cos() * yaw.cos(),
        )
    }

    /// Around the target, by a drag in heights of the picture, y down.
    pub(crate) fn orbit(&mut self, by: Vec2) {
        let distance = self.position().distance(self.target);
        let forward = self.turned(by);
        self.place(self.target - forward * distance, forward);
    }

    /// On the spot, by a drag in heights of the picture, y down.
    pub(crate) fn look(&mut self, by: Vec2) {
        let distance = self.position().distance(self.target);
        let position = self.position();
        let forward = self.turned(by);
        self.place(position, forward);
        self.target = position + forward * distance;
    }

    /// Along the picture, so that what is at the target stays under the pointer.
    pub(crate) fn pan(&mut self, by: Vec2, aspect: f32) {
        let metres = self.height_at_target(aspect);
        let offset = (self.up() * by.y - self.right() * by.x) * metres;
        self.shift(offset);
    }

    fn shift(&mut self, offset: Vec3) {
        if (self.position() + offset).is_finite() && (self.target + offset).is_finite() {
            self.camera.world_from_camera.translation += glam::Vec3A::from(offset);
            self.target += offset;
        }
    }

    /// Closer by that factor, towards a place of the picture, 0 to 1 each way, y down.
    pub(crate) fn zoom(&mut self, factor: f32, at: Vec2, aspect: f32) {
        if !(factor.is_finite() && factor > 0.0) {
            return;
        }
        let before = self.height_at_target(aspect);
        match &mut self.camera.projection {
            Projection::Perspective { .. } => {
                let distance = self.position().distance(self.target) / factor;
                let range = self.extent * 1e-5..self.extent * 1e4;
                if !range.contains(&distance) {
                    return;
                }
                let position = self.target - self.forward() * distance;
                self.camera.world_from_camera.translation = position.into();
            }
            Projection::Orthographic { xmag, ymag } => {
                let range = self.extent * 1e-5..self.extent * 1e4;
                if !range.contains(&(ymag.max(*xmag) / factor)) {
                    return;
                }
                *xmag /= factor;
                *ymag /= factor;
            }
        }
        // What is under the pointer stays there.
        let change = before - self.height_at_target(aspect);
        let place = Vec2::new((at.x - 0.5) * aspect, 0.5 - at.y) * change;
        self.shift(self.right() * place.x + self.up() * place.y);
    }

    /// Forward, right and up, in metres a second times the scene's size.
    pub(crate) fn fly(&mut self, direction: Vec3, seconds: f32, fast: bool) {
        let speed = self.extent * if fast { 2.0 } else { 0.5 };
        let along =
            self.right() * direction.x + Vec3::Y * direction.y + self.forward() * direction.z;
        self.shift(along * speed * seconds.min(0.1));
    }

    /// Shows all of a box from where it looks now.
    pub(crate) fn frame(&mut self, [low, high]: [Vec3; 2], aspect: f32) {
        let center = low * 0.5 + high * 0.5;
        let radius = (high * 0.5 - low * 0.5).length().max(self.extent * 1e-4);
        if !(center.is_finite() && radius.is_finite()) {
            return;
        }
        let forward = self.forward();
        let distance = match &mut self.camera.projection {
            Projection::Perspective {
                yfov,
                aspect: authored,
            } => {
                let half = (*yfov * 0.5).tan() * authored.map_or(1.0, |a| (a / aspect).max(1.0));
                let narrow = half * aspect.min(1.0);
                radius / narrow.atan().sin()
            }
            Projection::Orthographic { xmag, ymag } => {
                *ymag = radius * (1.0 / aspect).max(1.0);
                *xmag = *ymag * aspect;
                radius * 2.0
            }
        };
        self.target = center;
        self.camera.world_from_camera.translation = (center - forward * distance).into();
    }

    /// Where a point of the world is in the picture, 0 to 1 each way, y down, and how far ahead in
    /// metres; nothing for points that are not in front.
    pub(crate) fn project(&self, point: Vec3, aspect: f32) -> Option<(Vec2, f32)> {
        project(&self.camera, point, aspect)
    }
}

/// As [`Navigation::project`]: the inverse of [`Camera::ray`].
pub(crate) fn project(camera: &Camera, point: Vec3, aspect: f32) -> Option<(Vec2, f32)> {
    let local = camera.world_from_camera.inverse().transform_point3(point);
    let ndc = match camera.projection {
        Projection::Perspective {
            yfov,
            aspect: authored,
        } => {
            let half = (yfov * 0.5).tan() * authored.map_or(1.0, |a| (a / aspect).max(1.0));
            if local.z >= 0.0 {
                return None;
            }
            Vec2::new(local.x / aspect, local.y) / (-local.z * half)
        }
        Projection::Orthographic { xmag, ymag } => {
            let ymag = ymag.max(xmag / aspect);
            Vec2::new(local.x / (ymag * aspect), local.y / ymag)
        }
    };
    let place = Vec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
    place.is_finite().then_some((place, -local.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn gallery() -> Navigation {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/gallery.glb");
        Navigation::new(&Scene::load(path).unwrap(), 0)
    }

    fn cameras() -> [Navigation; 2] {
        let mut parallel = gallery();
        parallel.camera.projection = Projection::Orthographic {
            xmag: 3.0,
            ymag: 2.0,
        };
        [gallery(), parallel]
    }

    #[test]
    fn projection_undoes_rays() {
        for view in cameras() {
            for (x, y) in [(0.1, 0.2), (0.5, 0.5), (0.9, 0.7)] {
                let (origin, direction) = view.camera().ray(x, y, 1.6);
                let (place, _) = view.project(origin + direction * 3.0, 1.6).unwrap();
                assert!((place - Vec2::new(x, y)).length() < 1e-4, "{place}");
            }
        }
        let view = gallery();
        assert_eq!(view.project(view.position() - view.forward(), 1.0), None);
    }

    #[test]
    fn orbits_keep_the_target_and_its_distance() {
        let mut view = gallery();
        let distance = view.position().distance(view.target);
        for by in [(0.3, 0.1), (-2.0, 5.0), (0.1, -9.0)] {
            view.orbit(by.into());
            let (place, ahead) = view.project(view.target, 1.6).unwrap();
            assert!((place - 0.5).length() < 1e-3);
            assert!((ahead / distance - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn dragging_to_the_right_moves_the_scene_to_the_right() {
        let mut view = gallery();
        // A point on the near side of the target.
        let near = view.target - view.forward() * 0.2;
        view.orbit(Vec2::new(0.05, 0.0));
        assert!(view.project(near, 1.6).unwrap().0.x > 0.5);
        let mut view = gallery();
        let target = view.target;
        view.pan(Vec2::new(0.25, 0.1), 1.6);
        let (place, _) = view.project(target, 1.6).unwrap();
        assert!(
            (place - Vec2::new(0.5 + 0.25 / 1.6, 0.6)).length() < 1e-3,
            "{place}"
        );
    }

    #[test]
    fn zooming_keeps_what_is_under_the_pointer() {
        for mut view in cameras() {
            let at = Vec2::new(0.7, 0.4);
            let plane = view.target;
            let (origin, direction) = view.camera().ray(at.x, at.y, 1.6);
            let forward = view.forward();
            let along = (plane - origin).dot(forward) / direction.dot(forward);
            let point = origin + direction * along;
            view.zoom(1.5, at, 1.6);
            let (place, _) = view.project(point, 1.6).unwrap();
            assert!((place - at).length() < 2e-3, "{place}");
            for _ in 0..1000 {
                view.zoom(10.0, at, 1.6);
                view.zoom(f32::NAN, at, 1.6);
            }
            assert!(view.camera().world_from_camera.is_finite());
        }
    }

    #[test]
    fn a_framed_box_is_in_the_picture() {
        for mut view in cameras() {
            for aspect in [0.5, 2.0] {
                let (low, high) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 2.5, 5.0));
                view.frame([low, high], aspect);
                for corner in [low, high] {
                    let (place, _) = view.project(corner, aspect).unwrap();
                    assert!(place.min_element() >= 0.0 && place.max_element() <= 1.0);
                }
            }
        }
    }
}
