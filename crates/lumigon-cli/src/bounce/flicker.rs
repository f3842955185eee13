//! How bounce light changes from frame to frame.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use lumigon_renderer::{BounceCenters, BounceSettings, CpuRenderer, Pixels, RenderSettings, Scene};
use serde::Serialize;

use super::errors::StudyScene;
use super::variant::{POINT_CAMERA, POLYGON_CAMERA, POLYGON_SCENE, Variant};
use super::{Study, rendered};
use crate::Failure;
use crate::bounce_light::Blocking;
use crate::gpu::Backend;
use crate::progress::Progress;

/// Diagonals of the scene that are one step a frame: 1 cm in a room of 5 m.
const STEP: f32 = 1.0 / 750.0;

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Moving {
    /// The camera, and the cube maps with it; the picture is taken from where the camera was, so that
    /// each pixel shows one point.
    Camera,
    /// A light.
    Light,
}

/// Changes of bounce light at fixed points, relative to the mean bounce light.
#[derive(Clone, Debug, Serialize)]
pub(super) struct FlickerRow {
    pub(super) scene: String,
    pub(super) moving: Moving,
    /// What was lit how.
    pub(super) title: String,
    /// Virtual lights at most; none for the path tracer.
    pub(super) virtual_lights: Option<u32>,
    /// Largest change of a pixel from one frame to the next.
    pub(super) largest: Option<f64>,
    /// What 99.9 % of all changes stay below.
    pub(super) percentile_999: Option<f64>,
    /// The same, of a pixel's distance from the mean of the frames before and after: none where all
    /// changes are even. The path tracer's is not measured.
    pub(super) uneven: Option<f64>,
    pub(super) uneven_percentile_999: Option<f64>,
}

impl Study<'_> {
    /// Measures frames of one scene.
    pub(super) fn flicker(&self, scene: &StudyScene) -> Result<Vec<FlickerRow>, Failure> {
        let count = self.command.sweep().count;
        let few = (count / 4).max(1);
        let of_camera = [
            (POLYGON_CAMERA, few),
            (POLYGON_CAMERA, count),
            (POINT_CAMERA, few),
            (POINT_CAMERA, count),
            (POLYGON_SCENE, count),
        ];
        let of_light = [
            (POLYGON_CAMERA, few),
            (POLYGON_CAMERA, count),
            (POINT_CAMERA, count),
            (POLYGON_SCENE, count),
        ];
        let mut rows = Vec::new();
        let progress = Progress::new("measuring flicker");
        let total = (of_camera.len() + of_light.len()) as u64;
        for (variant, count) in of_camera {
            progress.set(rows.len() as u64, total);
            let frames = self.camera_frames(scene, &variant, count)?;
            rows.push(row(scene, Moving::Camera, &variant, count, &frames));
        }
        let Some(light) = scene
            .scene
            .polygon_lights
            .iter()
            .position(|light| light.image.is_none())
        else {
            return Ok(rows);
        };
        let lamps = self.lamps(scene, light)?;
        for (variant, count) in of_light {
            progress.set(rows.len() as u64, total);
            let mut frames = self.light_frames(scene, light, &variant, count)?;
            frames.iter_mut().for_each(|frame| blacken(frame, &lamps));
            rows.push(row(scene, Moving::Light, &variant, count, &frames));
        }
        rows.push(self.truth_row(scene, light, &lamps)?);
        Ok(rows)
    }

    /// Pixels in which a light is seen in any frame: where it moves, they do not show one point.
    fn lamps(&self, scene: &StudyScene, light: usize) -> Result<Vec<bool>, Failure> {
        let settings = RenderSettings {
            direct: true,
            ..self.render_settings()
        };
        let mut lamps = Vec::new();
        for frame in 0..self.command.frames() {
            let moved = moved(&scene.scene, light, frame as f32);
            let renderer = CpuRenderer::new(&moved);
            let picture = rendered(renderer.render(&scene.camera, &settings, self.watch()))?;
            lamps.resize(picture.emitted.len(), false);
            for (lamp, emitted) in lamps.iter_mut().zip(&picture.emitted) {
                *lamp |= *emitted != [0.0; 3];
            }
        }
        Ok(lamps)
    }

    /// One picture a frame, all from where the camera was, lit from where it has come to.
    fn camera_frames(
        &self,
        scene: &StudyScene,
        variant: &Variant,
        count: u32,
    ) -> Result<Vec<Pixels>, Failure> {
        let backend = rendered(Backend::new(self.command.backend, &scene.scene))?;
        let from_camera = &scene.camera.world_from_camera;
        // To the right and a little ahead.
        let along = from_camera.transform_vector3(Vec3::new(0.8, 0.0, -0.6));
        let step = along.normalize_or_zero() * step(&scene.scene);
        let mut frames = Vec::new();
        for frame in 0..self.command.frames() {
            let place = Vec3::from(from_camera.translation) + step * frame as f32;
            let mut settings = variant.settings(count, self.command.sweep().size);
            if !variant.in_scene() {
                settings.centers = BounceCenters::Points(vec![place.to_array()]);
            }
            let mut camera = scene.camera.clone();
            camera.world_from_camera.translation = place.into();
            let lights = backend.virtual_lights(&camera, &settings, self.watch());
            let lights = rendered(lights)?;
            let picture = backend.render_with_bounce(
                &scene.camera,
                &self.render_settings(),
                &lights,
                self.watch(),
            );
            frames.push(rendered(picture)?.diffuse);
        }
        Ok(frames)
    }

    /// One picture a frame of a light on its way.
    fn light_frames(
        &self,
        scene: &StudyScene,
        light: usize,
        variant: &Variant,
        count: u32,
    ) -> Result<Vec<Pixels>, Failure> {
        let mut settings = variant.settings(count, self.command.sweep().size);
        (0..self.command.frames())
            .map(|frame| {
                let moved = moved(&scene.scene, light, frame as f32);
                let (picture, centers) = self.picture(&moved, scene, &settings)?;
                // What has been placed once stays.
                settings.centers = BounceCenters::Points(centers);
                Ok(picture)
            })
            .collect()
    }

    fn picture(
        &self,
        moved: &Scene,
        scene: &StudyScene,
        settings: &BounceSettings,
    ) -> Result<(Pixels, Vec<[f32; 3]>), Failure> {
        let backend = rendered(Backend::new(self.command.backend, moved))?;
        let (camera, watch) = (&scene.camera, self.watch());
        let lights = rendered(backend.virtual_lights(camera, settings, watch))?;
        let picture = backend.render_with_bounce(camera, &self.render_settings(), &lights, watch);
        Ok((rendered(picture)?.diffuse, lights.centers().to_vec()))
    }

    /// The path tracer's mean change a frame: over all frames, so that its noise is divided by them.
    fn truth_row(
        &self,
        scene: &StudyScene,
        light: usize,
        lamps: &[bool],
    ) -> Result<FlickerRow, Failure> {
        let steps = self.command.frames().saturating_sub(1).max(1) as f32;
        let truth = |frame: f32| {
            let moved = moved(&scene.scene, light, frame);
            let backend = rendered(Backend::new(self.command.backend, &moved))?;
            let truth = self.truth(&backend, &scene.camera, Blocking::Nothing)?;
            let mut pixels = truth.pixels;
            blacken(&mut pixels, lamps);
            Ok::<_, Failure>(pixels)
        };
        let (first, last) = (truth(0.0)?, truth(steps)?);
        let changes = first
            .iter()
            .zip(&last)
            .map(|(a, b)| change(a, b) / f64::from(steps));
        let [largest, percentile_999] = summary(changes.collect(), mean(&first));
        Ok(FlickerRow {
            scene: scene.name.clone(),
            moving: Moving::Light,
            title: "path traced, mean of all frames".to_owned(),
            virtual_lights: None,
            largest,
            percentile_999,
            uneven: None,
            uneven_percentile_999: None,
        })
    }
}

fn blacken(frame: &mut Pixels, lamps: &[bool]) {
    for (pixel, _) in frame.iter_mut().zip(lamps).filter(|(_, lamp)| **lamp) {
        *pixel = [0.0; 3];
    }
}

fn step(scene: &Scene) -> f32 {
    let (low, high) = scene.bounds().unwrap_or_default();
    2.0 * (high * 0.5).distance(low * 0.5) * STEP
}

/// The scene with one of its lights, and its faces, some steps along its plane.
fn moved(scene: &Scene, light: usize, steps: f32) -> Scene {
    let mut scene = scene.clone();
    let length = step(&scene) * steps;
    let polygon = &mut scene.polygon_lights[light];
    let normal = DVec3::from(polygon.area_vector()).normalize_or(DVec3::Y);
    let along = DVec3::new(1.0, 0.1, 0.3);
    let along = (along - normal * normal.dot(along)).normalize_or(DVec3::X);
    let offset = along * f64::from(length);
    for vertex in polygon.loops.iter_mut().flatten() {
        *vertex = (DVec3::from(*vertex) + offset).to_array();
    }
    let mesh = Arc::make_mut(&mut scene.meshes[polygon.mesh]);
    let corners = polygon
        .triangles
        .iter()
        .flat_map(|&t| mesh.triangles[t as usize]);
    let mut corners: Vec<u32> = corners.collect();
    corners.sort_unstable();
    corners.dedup();
    for corner in corners {
        mesh.positions[corner as usize] += offset.as_vec3();
    }
    scene
}

fn row(
    scene: &StudyScene,
    moving: Moving,
    variant: &Variant,
    count: u32,
    frames: &[Pixels],
) -> FlickerRow {
    let mean = frames.first().map_or(0.0, |first| mean(first));
    let pairs = frames.windows(2);
    let changes = pairs.flat_map(|pair| pair[0].iter().zip(&pair[1]).map(|(a, b)| change(a, b)));
    let [largest, percentile_999] = summary(changes.collect(), mean);
    let uneven = frames.windows(3).flat_map(|three| {
        let (before, here, after) = (&three[0], &three[1], &three[2]);
        here.iter().enumerate().map(|(pixel, here)| {
            let middle = [0, 1, 2].map(|c| 0.5 * (before[pixel][c] + after[pixel][c]));
            change(here, &middle)
        })
    });
    let [uneven, uneven_percentile_999] = summary(uneven.collect(), mean);
    FlickerRow {
        scene: scene.name.clone(),
        moving,
        title: variant.title.to_owned(),
        virtual_lights: Some(count),
        largest,
        percentile_999,
        uneven,
        uneven_percentile_999,
    }
}

/// The largest over the channels.
fn change(a: &[f32; 3], b: &[f32; 3]) -> f64 {
    let channels = a.iter().zip(b);
    f64::from(channels.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max))
}

fn mean(pixels: &[[f32; 3]]) -> f64 {
    let sum: f64 = pixels.iter().flatten().copied().map(f64::from).sum();
    sum / (3 * pixels.len()).max(1) as f64
}

/// The largest, and what 99.9 % stay below, over the mean; none where that is 0.
fn summary(mut changes: Vec<f64>, mean: f64) -> [Option<f64>; 2] {
    changes.sort_by(f64::total_cmp);
    let last = changes.len().saturating_sub(1);
    [last, last * 999 / 1000].map(|place| {
        let change = changes.get(place).filter(|_| mean > 0.0)?;
        Some(change / mean)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounce::many_lights::room;
    use lumigon_renderer::CpuRenderer;

    #[test]
    fn even_changes_are_no_flicker() {
        let scene = StudyScene {
            name: "x".to_owned(),
            scene: Scene::default(),
            camera: lumigon_renderer::Camera::framing(&Scene::default()),
        };
        let frames: Vec<Pixels> = [1.0, 1.5, 2.0].map(|v| vec![[v; 3]; 4]).to_vec();
        let found = row(&scene, Moving::Camera, &POLYGON_CAMERA, 1, &frames);
        assert_eq!(
            (found.largest, found.percentile_999),
            (Some(0.5), Some(0.5))
        );
        assert_eq!(found.uneven, Some(0.0));
        let frames: Vec<Pixels> = [1.0, 1.0, 3.0].map(|v| vec![[v; 3]; 4]).to_vec();
        assert_eq!(
            row(&scene, Moving::Camera, &POLYGON_CAMERA, 1, &frames).uneven,
            Some(1.0)
        );
        let black = vec![vec![[0.0; 3]; 4]; 3];
        assert_eq!(
            row(&scene, Moving::Camera, &POLYGON_CAMERA, 1, &black).largest,
            None
        );
    }

    #[test]
    fn a_light_moves_with_its_faces() {
        let still = room(3);
        let scene = moved(&still, 1, 10.0);
        let length = step(&still) * 10.0;
        let (before, after) = (&still.polygon_lights[1], &scene.polygon_lights[1]);
        let offset = DVec3::from(after.loops[0][0]) - DVec3::from(before.loops[0][0]);
        assert!((offset.length() - f64::from(length)).abs() < 1e-6 && offset.y.abs() < 1e-9);
        let mesh = |scene: &Scene| scene.meshes[before.mesh].positions[0];
        assert!((mesh(&scene) - mesh(&still) - offset.as_vec3()).length() < 1e-5);
        assert_eq!(scene.polygon_lights[0], still.polygon_lights[0]);
        assert!(CpuRenderer::new(&scene).warnings().is_empty());
    }
}
