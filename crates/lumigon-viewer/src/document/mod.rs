//! What is open in the viewer: a scene whose lights can be held, and how it came to be so.

mod check;
mod error;
mod faces;
pub mod flux;
mod history;
mod images;
mod letter;
mod light;
pub mod outline;
mod patch;
mod picture;
mod presets;
mod reading;
mod surface;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use glam::DMat3;
use lumigon_renderer::{EmissivePolygon, Limits, Mesh, Scene};

pub use check::{OutlineFault, check};
pub use error::EditError;
pub use images::{FinishedImages, ImageJob};
pub use light::{Light, LightId, plane_frame};
pub use picture::{LightPicture, PictureFile, PictureFit, PictureImage};
pub use presets::{Preset, PresetError};

use history::{History, Step};
use patch::{Entry, Patch, Polygons, polygon_range};

/// A scene, its lights, settings that are undone along with them, and the history of all that.
///
/// A light that is edited, or made here, has a mesh and a material of its own at the end of the scene's;
/// the polygons that light the scene are made from that mesh as loading a saved one makes them.
/// Meshes, materials and textures keep their indices through all edits, and what is not edited stays the
/// same, down to its `Arc`.
#[derive(Debug)]
pub struct Document<S = ()> {
    scene: Arc<Scene>,
    /// Meshes whose polygons are not the file's: those polygons.
    polygons: BTreeMap<usize, Polygons>,
    /// The file's lights as they were read; each when it is first asked for.
    of_file: Vec<OnceLock<Box<Light>>>,
    /// By [`LightId`]; first the file's.
    entries: Vec<Entry>,
    /// Files of the scene's last textures.
    files: Vec<Arc<PictureFile>>,
    settings: S,
    limits: Limits,
    history: History<S>,
    gesture: Option<Step<S>>,
    /// The number of the state: equal for equal states along the history.
    state: u64,
    last_state: u64,
    saved: Option<u64>,
    version: u64,
}

impl<S: Clone + PartialEq + Default> Document<S> {
    /// Opens a scene with default settings and limits, as saved.
    #[must_use]
    pub fn new(scene: Scene) -> Self {
        Self::with_settings(scene, S::default(), Limits::default())
    }
}

impl<S: Clone + PartialEq> Document<S> {
    /// Opens a scene, as saved. `limits` are for the pictures of lights.
    #[must_use]
    pub fn with_settings(mut scene: Scene, settings: S, limits: Limits) -> Self {
        // As loading leaves them.
        if !scene.polygon_lights.is_sorted_by_key(|light| light.mesh) {
            scene.polygon_lights.sort_by_key(|light| light.mesh);
        }
        let entries: Vec<Entry> = scene
            .polygon_lights
            .iter()
            .map(|light| Entry::OfFile { mesh: light.mesh })
            .collect();
        Self {
            of_file: entries.iter().map(|_| OnceLock::new()).collect(),
            entries,
            scene: Arc::new(scene),
            polygons: BTreeMap::new(),
            files: Vec::new(),
            settings,
            limits,
            history: History::new(),
            gesture: None,
            state: 0,
            last_state: 0,
            saved: Some(0),
            version: 0,
        }
    }

    /// The scene as it is now.
    #[must_use]
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// All lights: first the file's, then those made here, oldest first. Those of the file are read when
    /// they are first asked for.
    pub fn lights(&self) -> impl Iterator<Item = (LightId, &Light)> {
        self.ids().filter_map(|id| Some((id, self.light(id)?)))
    }

    /// Which lights there are, in the order of [`Document::lights`].
    pub fn ids(&self) -> impl Iterator<Item = LightId> {
        let entries = (0_u32..).zip(&self.entries);
        entries
            .filter(|(_, entry)| **entry != Entry::Removed)
            .map(|(id, _)| LightId(id))
    }

    /// A light; `None` where it is removed.
    #[must_use]
    pub fn light(&self, id: LightId) -> Option<&Light> {
        match self.entries.get(id.index())? {
            Entry::Removed => None,
            Entry::Own { light, .. } => Some(light),
            Entry::OfFile { mesh } => Some(self.of_file[id.index()].get_or_init(|| {
                let index = self.polygon_of(id, *mesh);
                Box::new(reading::read(
                    &self.scene,
                    &self.scene.polygon_lights[index],
                ))
            })),
        }
    }

    /// Which light's face a triangle of the scene is.
    #[must_use]
    pub fn light_at(&self, mesh: usize, triangle: u32) -> Option<LightId> {
        let mut left = polygon_range(&self.scene, mesh);
        for (id, entry) in (0_u32..).zip(&self.entries) {
            match entry {
                Entry::Own { mesh: own, .. } if *own == mesh => return Some(LightId(id)),
                Entry::OfFile { mesh: of_file } if *of_file == mesh => {
                    let light = &self.scene.polygon_lights[left.next()?];
                    if light.triangles.contains(&triangle) {
                        return Some(LightId(id));
                    }
                }
                _ => {}
            }
        }
        None
    }

    /// Indices into [`Scene::polygon_lights`] of a light's polygons: one, unless its outline has several
    /// outer loops, or it is dark.
    #[must_use]
    pub fn polygons_of(&self, id: LightId) -> std::ops::Range<usize> {
        match self.entries.get(id.index()) {
            Some(Entry::OfFile { mesh }) => {
                let index = self.polygon_of(id, *mesh);
                index..index + 1
            }
            Some(Entry::Own { mesh, .. }) => polygon_range(&self.scene, *mesh),
            _ => 0..0,
        }
    }

    /// The mesh and the material that a light has to itself: where it was edited or made here.
    #[must_use]
    pub fn own_mesh(&self, id: LightId) -> Option<usize> {
        match self.entries.get(id.index())? {
            Entry::Own { mesh, .. } => Some(*mesh),
            _ => None,
        }
    }

    /// The image files that were put on lights, each with its index in [`Scene::textures`].
    pub fn picture_files(&self) -> impl Iterator<Item = (usize, &Arc<PictureFile>)> {
        let first = self.scene.textures.len() - self.files.len();
        (first..).zip(&self.files)
    }

    /// The polygon of a light of the file that has not been edited.
    fn polygon_of(&self, id: LightId, mesh: usize) -> usize {
        // The file's lights are in the order of their meshes.
        let before = self.entries[..id.index()].iter().rev();
        let rank = before
            // Those that were edited are walked over.
            .take_while(|entry| !matches!(entry, Entry::OfFile { mesh: m } if *m != mesh))
            .filter(|entry| matches!(entry, Entry::OfFile { .. }))
            .count();
        polygon_range(&self.scene, mesh).start + rank
    }

    /// The settings as they are now.
    #[must_use]
    pub fn settings(&self) -> &S {
        &self.settings
    }

    /// Changes the settings: a step "settings", or part of the gesture that is going on.
    pub fn set_settings(&mut self, settings: S) {
        if settings != self.settings {
            let patch = Patch {
                settings: Some(settings),
                ..Patch::default()
            };
            let scene = Arc::clone(&self.scene);
            self.take("settings", patch, scene);
        }
    }

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

    /// Whether all is as it was when it was last saved, or opened.
    #[must_use]
    pub fn is_saved(&self) -> bool {
        self.saved == Some(self.state)
    }

    /// What is there now has been saved.
    pub fn mark_saved(&mut self) {
        self.saved = Some(self.state);
    }

    /// What is there now has not been saved, such as work that was recovered.
    pub fn mark_unsaved(&mut self) {
        self.saved = None;
    }

    /// A number that changes with everything that can be seen.
    #[must_use]
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Makes a light what is given. A light of the file gets a mesh and a material of its own. Its
    /// picture is coarse until [`Document::finish_images`].
    ///
    /// # Errors
    /// Where it is no light: the document stays as it is.
    pub fn set_light(&mut self, id: LightId, light: Light) -> Result<(), EditError> {
        let before = self.light(id).ok_or(EditError::NoSuchLight)?;
        if *before == light {
            return Ok(());
        }
        self.validate(&light, Some(before))?;
        let mut patch = Patch::default();
        let (mesh, material) = match self.entries[id.index()] {
            Entry::Own { mesh, .. } => (mesh, self.scene.meshes[mesh].material),
            Entry::OfFile { mesh } => {
                self.take_from_mesh(id, mesh, &mut patch);
                (self.scene.meshes.len(), self.scene.materials.len())
            }
            Entry::Removed => return Err(EditError::NoSuchLight),
        };
        self.place(id, light, [mesh, material], patch, "edit light")
    }

    /// Adds a light.
    ///
    /// # Errors
    /// Where it is no light: the document stays as it is.
    pub fn add_light(&mut self, light: Light) -> Result<LightId, EditError> {
        self.add(light, "add light")
    }

    /// Adds a light like one that is there, in the same place.
    ///
    /// # Errors
    /// Where there is no such light.
    pub fn duplicate(&mut self, id: LightId) -> Result<LightId, EditError> {
        let light = self.light(id).ok_or(EditError::NoSuchLight)?.clone();
        self.add(light, "duplicate light")
    }

    fn add(&mut self, light: Light, name: &str) -> Result<LightId, EditError> {
        self.validate(&light, None)?;
        let id = LightId(u32::try_from(self.entries.len()).map_err(|_| EditError::TooMany)?);
        let place = [self.scene.meshes.len(), self.scene.materials.len()];
        self.entries.push(Entry::Removed);
        let placed = self.place(id, light, place, Patch::default(), name);
        if placed.is_err() {
            self.entries.pop();
        }
        placed.map(|()| id)
    }

    /// Removes a light and its faces; nothing where it is removed already.
    pub fn remove_light(&mut self, id: LightId) {
        let mut patch = Patch::default();
        match self.entries.get(id.index()) {
            Some(&Entry::OfFile { mesh }) => self.take_from_mesh(id, mesh, &mut patch),
            Some(&Entry::Own { mesh, .. }) => {
                let nothing = faces::nothing(&self.scene.meshes[mesh]);
                patch.meshes.insert(mesh, Some(nothing));
                let none = Polygons {
                    list: Arc::new([]),
                    finished: true,
                };
                patch.polygons.insert(mesh, none);
            }
            _ => return,
        }
        patch.entries.insert(id.0, Entry::Removed);
        let mut scene = Scene::clone(&self.scene);
        patch.change_parts(&mut scene);
        patch.change_polygons(&mut scene);
        self.take("remove light", patch, Arc::new(scene));
    }

    /// Takes the faces of a light of the file out of its mesh.
    fn take_from_mesh(&self, id: LightId, mesh: usize, patch: &mut Patch<S>) {
        let index = self.polygon_of(id, mesh);
        let range = polygon_range(&self.scene, mesh);
        let before = &self.scene.meshes[mesh];
        let mut stays = vec![true; before.triangles.len()];
        for &t in &self.scene.polygon_lights[index].triangles {
            stays[t as usize] = false;
        }
        let mut next = 0_u32;
        let renamed: Vec<u32> = stays
            .iter()
            .map(|&stays| {
                let name = next;
                next += u32::from(stays);
                name
            })
            .collect();
        let others = range.filter(|&i| i != index).map(|i| {
            let mut light = self.scene.polygon_lights[i].clone();
            light.triangles.retain(|&t| stays[t as usize]);
            for t in &mut light.triangles {
                *t = renamed[*t as usize];
            }
            light
        });
        let list: Arc<[EmissivePolygon]> = others.collect();
        let finished = self
            .polygons
            .get(&mesh)
            .is_none_or(|polygons| polygons.finished);
        patch.polygons.insert(mesh, Polygons { list, finished });
        let after = if next == 0 {
            faces::nothing(before)
        } else {
            let mut after = Mesh::clone(before);
            let mut stays = stays.iter();
            after.triangles.retain(|_| stays.next() == Some(&true));
            Arc::new(after)
        };
        patch.meshes.insert(mesh, Some(after));
    }

    /// Whether something is a light that can take the place of `before`.
    fn validate(&self, light: &Light, before: Option<&Light>) -> Result<(), EditError> {
        let m = light.world_from_plane.matrix3;
        let off = m.transpose() * m - DMat3::IDENTITY;
        let is_rigid = off.to_cols_array().iter().all(|x| x.abs() <= 1e-6) && m.determinant() > 0.0;
        if !is_rigid || !light.world_from_plane.translation.is_finite() {
            return Err(EditError::Frame);
        }
        if !light.radiance.is_finite() || light.radiance.min_element() < 0.0 {
            return Err(EditError::Radiance);
        }
        if let Some(picture) = &light.picture {
            let own = self.scene.textures.len() - self.files.len();
            let is_there = match picture.image {
                PictureImage::Scene(texture) => texture < own,
                PictureImage::File(_) => true,
            };
            if !is_there || !picture.texture_from_plane.is_finite() {
                return Err(EditError::Picture);
            }
        }
        if let Some(fixed) = &light.surface.fixed {
            if !fixed.fits(&light.loops) {
                return Err(EditError::Fixed(fixed.reason));
            }
        } else if before.is_none_or(|before| before.loops != light.loops)
            && let Err(fault) = check(&light.loops)
        {
            // Outlines of files may have faults that rounding made: what is no worse passes.
            let was_faulty = |before: &Light| check(&before.loops).is_err();
            if fault.is_hard() || !before.is_some_and(was_faulty) {
                return Err(EditError::Outline(fault));
            }
        }
        let in_range = |p: &glam::DVec2| light.to_world(*p).as_vec3().is_finite();
        if light.loops.iter().flatten().all(in_range) {
            Ok(())
        } else {
            Err(EditError::Frame)
        }
    }

    /// Puts a light on a mesh and a material of its own.
    fn place(
        &mut self,
        id: LightId,
        light: Light,
        [mesh, material]: [usize; 2],
        mut patch: Patch<S>,
        name: &str,
    ) -> Result<(), EditError> {
        let texture = light.picture.as_ref().map(|picture| match &picture.image {
            PictureImage::Scene(texture) => *texture,
            PictureImage::File(file) => {
                let known = self.picture_files().find(|(_, known)| *known == file);
                known.map_or_else(
                    || {
                        let new = self.scene.textures.len();
                        patch.textures.insert(new, Some(Arc::clone(file)));
                        new
                    },
                    |(texture, _)| texture,
                )
            }
        });
        let (made, made_of) = faces::faces(&light, material, texture);
        patch.meshes.insert(mesh, Some(Arc::new(made)));
        patch.materials.insert(material, Some(Arc::new(made_of)));

        let mut scene = Scene::clone(&self.scene);
        patch.change_parts(&mut scene);
        let quick = images::is_slow(&scene, mesh)
            .then(|| images::coarse(&scene, mesh, &light))
            .flatten();
        let finished = quick.is_none();
        let list = quick.unwrap_or_else(|| scene.lights_of_mesh(mesh, &self.limits).0);
        let shines = light.radiance.max_element() > 0.0;
        if list.is_empty() && shines && scene.meshes[mesh].triangles.is_empty() {
            return Err(EditError::Vanishes);
        }
        let polygons = Polygons {
            list: list.into(),
            finished,
        };
        patch.polygons.insert(mesh, polygons);
        patch.change_polygons(&mut scene);
        let light = Arc::new(light);
        patch.entries.insert(id.0, Entry::Own { mesh, light });
        self.take(name, patch, Arc::new(scene));
        Ok(())
    }

    /// Makes a change whose scene is known, and records it.
    fn take(&mut self, name: &str, patch: Patch<S>, scene: Arc<Scene>) {
        let before = self.present(&patch);
        self.store(&patch, scene);
        let from = self.state;
        self.last_state += 1;
        self.state = self.last_state;
        if let Some(step) = &mut self.gesture {
            step.add(before, &patch, self.state);
        } else {
            let mut step = Step::new(name, from);
            step.add(before, &patch, self.state);
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
            let mut scene = Scene::clone(&self.scene);
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
        self.scene = scene;
        self.version += 1;
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
        if step.to != step.from {
            self.apply(&step.before);
            self.state = step.from;
        }
    }
}

#[cfg(test)]
mod properties;
#[cfg(test)]
mod tests;
