//! Another scene instead of one that is on the device.

use std::sync::{Arc, OnceLock};

use super::device::Gpu;
use super::error::GpuError;
use super::lighting::StagedLights;
use super::renderer::GpuRenderer;
use super::scene_buffers::{Features, SceneBuffers, StagedScene};
use super::visibility::Pipelines;
use crate::scene::Scene;

/// A scene that is to replace another one, as far as it is on the device.
struct Staged {
    next: Next,
    lights: StagedLights,
    /// For materials with what none had before.
    raster: Option<(Features, Pipelines)>,
}

enum Next {
    /// What is new, beside what is there.
    Beside(Box<StagedScene>),
    /// All of it.
    Whole(Box<SceneBuffers>),
}

impl Next {
    fn features(&self) -> Features {
        match self {
            Self::Beside(staged) => staged.features,
            Self::Whole(buffers) => buffers.features,
        }
    }
}

impl GpuRenderer {
    /// Shows another scene, and keeps what it shares with the last one: meshes that are the same in memory
    /// at the same index, textures that share texels, lights and their filtered pictures, pipelines. One
    /// light that moves costs little in the largest scene. Pictures that lights were given by
    /// [`GpuRenderer::replace_light_image`] give way to the scene's.
    ///
    /// # Errors
    /// Where the scene is larger than the device's memory or buffers, and where the device fails; the
    /// renderer then shows what it did, if the device is not lost.
    pub fn set_scene(&mut self, scene: &Scene) -> Result<(), GpuError> {
        let gpu = self.gpu.clone();
        check_not_lost(&gpu)?;
        let mut staged = None;
        let done = gpu.guarded("the scene", || {
            staged = Some(self.stage(&gpu, scene)?);
            Ok(())
        });
        match (done, staged) {
            (Ok(()), Some(staged)) => {
                gpu.guarded("the scene", || self.commit(&gpu, scene, staged))?;
            }
            (done, staged) => {
                if let Some(Staged {
                    next: Next::Beside(staged),
                    ..
                }) = &staged
                {
                    self.scene.withdraw(staged);
                }
                check_not_lost(&gpu)?;
                return done;
            }
        }
        check_not_lost(&gpu)
    }

    /// Brings what is new to the device. Leaves nothing where it fails.
    fn stage(&mut self, gpu: &Gpu, scene: &Scene) -> Result<Staged, GpuError> {
        let (polygons, punctual) = (&scene.polygon_lights, &scene.punctual_lights);
        let lights = self
            .lighting
            .stage(gpu, polygons, &scene.textures, punctual)?;
        let next = match self.scene.stage(gpu, scene)? {
            Some(staged) => Next::Beside(Box::new(staged)),
            None => {
                let mut buffers = SceneBuffers::new(gpu, &self.scene_layout, scene)?;
                buffers.features = self.scene.features.or(buffers.features);
                Next::Whole(Box::new(buffers))
            }
        };
        let features = next.features();
        let is_new = features != self.scene.features;
        Ok(Staged {
            raster: is_new.then(|| (features, self.visibility.pipelines_for(gpu, features))),
            next,
            lights,
        })
    }

    fn commit(&mut self, gpu: &Gpu, scene: &Scene, staged: Staged) -> Result<(), GpuError> {
        if let Some((features, pipelines)) = staged.raster {
            self.visibility.set(features, pipelines);
            self.shading.set_features(features);
            self.face_raster = OnceLock::new();
        }
        let is_whole = matches!(staged.next, Next::Whole(_));
        match staged.next {
            Next::Beside(staged) => self.scene.commit(gpu, &self.scene_layout, *staged),
            Next::Whole(buffers) => self.scene = *buffers,
        }
        let old = &self.shapes.meshes;
        let same = old.iter().zip(&scene.meshes);
        let has_same_meshes =
            old.len() == scene.meshes.len() && same.into_iter().all(|(a, b)| Arc::ptr_eq(a, b));
        if is_whole || !has_same_meshes {
            self.facets = OnceLock::new();
            self.rays = OnceLock::new();
            self.shapes.meshes.clone_from(&scene.meshes);
        }
        self.shapes
            .punctual_lights
            .clone_from(&scene.punctual_lights);
        self.textures.clone_from(&scene.textures);
        let (polygons, textures) = (&scene.polygon_lights, &scene.textures);
        self.lighting.commit(gpu, staged.lights, polygons, textures)
    }
}

fn check_not_lost(gpu: &Gpu) -> Result<(), GpuError> {
    match gpu.is_lost() {
        Some(reason) => Err(GpuError::Lost { reason }),
        None => Ok(()),
    }
}
