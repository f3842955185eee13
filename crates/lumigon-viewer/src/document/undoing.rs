//! Steps of a document: made, gathered in gestures, taken back.

use std::sync::Arc;

use lumigon_renderer::Scene;

use super::history::Step;
use super::patch::{Entry, Patch, Polygons, polygon_range};
use super::{Document, Light};

impl<S: Clone + PartialEq> Document<S> {
    /// Begins a gesture: all edits until [`Document::end`] are one step of that name. One that is going
    /// on ends first.
    pub fn begin(&mut self, name: &str) {
        self.end();
        self.gesture = Some(Step::new(name, self.state));
    }

    /// Ends the gesture, if one is going on. One that left all as it was is no step.
    pub fn end(&mut self) {
        let Some(step) = self.gesture.take() else {
            return;
        };
        if self.is_nothing(&step) {
            self.revert(&step);
        } else {
            self.history.push(step);
        }
    }

    /// Ends the gesture, if one is going on, and takes back what it did.
    pub fn cancel(&mut self) {
        if let Some(step) = self.gesture.take() {
            self.revert(&step);
        }
    }

    /// Whether a gesture is going on.
    #[must_use]
    pub fn in_gesture(&self) -> bool {
        self.gesture.is_some()
    }

    /// Takes back the last step; returns its name. A gesture that is going on ends first.
    pub fn undo(&mut self) -> Option<String> {
        self.end();
        let step = self.history.undo()?;
        let (name, patch, state) = (step.name.clone(), step.before.clone(), step.from);
        self.apply(&patch);
        self.state = state;
        Some(name)
    }

    /// Does the last step that was undone again; returns its name.
    pub fn redo(&mut self) -> Option<String> {
        self.end();
        let step = self.history.redo()?;
        let (name, patch, state) = (step.name.clone(), step.after.clone(), step.to);
        self.apply(&patch);
        self.state = state;
        Some(name)
    }

    /// The name of the step that [`Document::undo`] would take back.
    #[must_use]
    pub fn can_undo(&self) -> Option<&str> {
        self.history.can_undo()
    }

    /// The name of the step that [`Document::redo`] would do again.
    #[must_use]
    pub fn can_redo(&self) -> Option<&str> {
        self.history.can_redo()
    }

    /// Makes a change whose scene is known, and records it.
    pub(super) fn take(&mut self, name: &str, patch: &Patch<S>, scene: Arc<Scene>) {
        let before = self.present(patch);
        self.store(patch, scene);
        let from = self.state;
        // Settings are not in what is saved.
        if patch.changes_scene() {
            self.last_state += 1;
            self.state = self.last_state;
        }
        if let Some(step) = &mut self.gesture {
            step.add(before, patch, self.state);
        } else {
            let mut step = Step::new(name, from);
            step.add(before, patch, self.state);
            self.history.push(step);
        }
    }

    /// What is there now of all that a patch changes.
    fn present(&self, patch: &Patch<S>) -> Patch<S> {
        let scene = &self.scene;
        let first_file = scene.textures.len() - self.files.len();
        let meshes = patch.meshes.keys();
        let materials = patch.materials.keys();
        let textures = patch.textures.keys();
        let polygons = patch.polygons.keys().map(|&mesh| {
            let of_file = || Polygons {
                list: scene.polygon_lights[polygon_range(scene, mesh)].into(),
                finished: true,
            };
            (
                mesh,
                self.polygons.get(&mesh).cloned().unwrap_or_else(of_file),
            )
        });
        let entries = patch.entries.keys();
        Patch {
            meshes: meshes.map(|&i| (i, scene.meshes.get(i).cloned())).collect(),
            materials: materials
                .map(|&i| (i, scene.materials.get(i).cloned().map(Arc::new)))
                .collect(),
            textures: textures
                .map(|&i| (i, self.files.get(i - first_file).cloned()))
                .collect(),
            polygons: polygons.collect(),
            entries: entries
                .map(|&id| (id, self.entries[id as usize].clone()))
                .collect(),
            settings: patch.settings.as_ref().map(|_| self.settings.clone()),
        }
    }

    fn apply(&mut self, patch: &Patch<S>) {
        let scene = if patch.changes_scene() {
            let mut scene = self.own_scene();
            patch.change_parts(&mut scene);
            patch.change_polygons(&mut scene);
            Arc::new(scene)
        } else {
            Arc::clone(&self.scene)
        };
        self.store(patch, scene);
    }

    /// Takes over a patch and the scene that it makes.
    fn store(&mut self, patch: &Patch<S>, scene: Arc<Scene>) {
        let first_file = self.scene.textures.len() - self.files.len();
        for (&index, file) in &patch.textures {
            match file {
                Some(file) => self.files.push(Arc::clone(file)),
                None => self.files.truncate(index - first_file),
            }
        }
        for (&mesh, polygons) in &patch.polygons {
            self.polygons.insert(mesh, polygons.clone());
        }
        for (&id, entry) in &patch.entries {
            self.entries[id as usize] = entry.clone();
        }
        if let Some(settings) = &patch.settings {
            self.settings = settings.clone();
        }
        self.show(scene, patch);
    }

    /// Takes over a scene that a patch made of the present one.
    pub(super) fn show(&mut self, scene: Arc<Scene>, patch: &Patch<S>) {
        if !Arc::ptr_eq(&self.scene, &scene) {
            let last = std::mem::replace(&mut self.scene, scene);
            self.last_scene = Some((last, patch.clone()));
        }
        self.version += 1;
    }

    /// The present scene, to be changed.
    pub(super) fn own_scene(&mut self) -> Scene {
        if let Some((last, patch)) = self.last_scene.take()
            && let Ok(mut scene) = Arc::try_unwrap(last)
        {
            patch.change_parts(&mut scene);
            patch.change_polygons(&mut scene);
            return scene;
        }
        Scene::clone(&self.scene)
    }

    /// Whether a gesture ended where it began.
    fn is_nothing(&self, step: &Step<S>) -> bool {
        let light = |patch: &Patch<S>, id: u32| -> Option<Light> {
            match patch.entries.get(&id)? {
                Entry::Own { light, .. } => Some(Light::clone(light)),
                Entry::OfFile { .. } => {
                    let read = self.of_file[id as usize].get()?;
                    Some(Light::clone(read))
                }
                Entry::Removed => None,
            }
        };
        let mut ids = step.after.entries.keys();
        step.before.settings == step.after.settings
            && ids.all(|&id| light(&step.before, id) == light(&step.after, id))
    }

    fn revert(&mut self, step: &Step<S>) {
        if step.to != step.from || step.before.settings.is_some() {
            self.apply(&step.before);
            self.state = step.from;
        }
    }
}
