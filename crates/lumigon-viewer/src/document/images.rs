//! Pictures of lights, finished beside the work that goes on.

use std::sync::Arc;

use lumigon_renderer::{EmissivePolygon, Limits, Scene};

use super::faces::is_masked;
use super::patch::put_polygons;
use super::{Document, Polygons};

/// Whether the lights of a mesh take more time than an outline does.
pub(super) fn is_slow(scene: &Scene, mesh: usize) -> bool {
    let material = &scene.materials[scene.meshes[mesh].material];
    material.is_emissive() && (material.emissive_texture.is_some() || is_masked(material))
}

/// The work of finishing the pictures of lights that were changed in gestures, for another thread.
#[derive(Debug)]
pub struct ImageJob {
    scene: Arc<Scene>,
    limits: Limits,
    coarse: Vec<(usize, Arc<[EmissivePolygon]>)>,
}

/// What an [`ImageJob`] made.
#[derive(Debug)]
pub struct FinishedImages(Vec<Finished>);

#[derive(Debug)]
struct Finished {
    mesh: usize,
    coarse: Arc<[EmissivePolygon]>,
    fine: Arc<[EmissivePolygon]>,
}

impl ImageJob {
    /// Does the work: milliseconds and more for large images.
    #[must_use]
    pub fn run(self) -> FinishedImages {
        let finish = |(mesh, coarse)| Finished {
            mesh,
            coarse,
            fine: self.scene.lights_of_mesh(mesh, &self.limits).0.into(),
        };
        FinishedImages(self.coarse.into_iter().map(finish).collect())
    }
}

impl<S: Clone + PartialEq> Document<S> {
    /// The work that pictures of lights still need, for another thread; its result is for
    /// [`Document::apply_images`]. `None` where all are finished, and while a gesture goes on.
    #[must_use]
    pub fn finish_images(&self) -> Option<ImageJob> {
        let is_coarse = |(_, polygons): &(&usize, &Polygons)| !polygons.finished;
        let coarse = self.polygons.iter().filter(is_coarse);
        let coarse: Vec<_> = coarse
            .map(|(&mesh, polygons)| (mesh, Arc::clone(&polygons.list)))
            .collect();
        (self.gesture.is_none() && !coarse.is_empty()).then(|| ImageJob {
            scene: Arc::clone(&self.scene),
            limits: self.limits,
            coarse,
        })
    }

    /// Shows finished pictures where the lights are still those they were made for. Whether any were:
    /// no step, and nothing to save.
    pub fn apply_images(&mut self, finished: FinishedImages) -> bool {
        let mut scene = None;
        for Finished { mesh, coarse, fine } in finished.0 {
            let renew = |polygons: &mut Polygons| {
                let is_same = Arc::ptr_eq(&polygons.list, &coarse);
                if is_same {
                    polygons.list = Arc::clone(&fine);
                    polygons.finished = true;
                }
                is_same
            };
            // Steps that come back to it need no other work.
            let gesture = self.gesture.iter_mut();
            let patches = gesture.flat_map(|step| [&mut step.before, &mut step.after]);
            for patch in self.history.patches().chain(patches) {
                patch.polygons.get_mut(&mesh).map(renew);
            }
            if self.polygons.get_mut(&mesh).is_some_and(renew) {
                let scene = scene.get_or_insert_with(|| Scene::clone(&self.scene));
                put_polygons(scene, mesh, &fine);
            }
        }
        let is_current = scene.is_some();
        if let Some(scene) = scene {
            self.scene = Arc::new(scene);
            self.version += 1;
        }
        is_current
    }
}
