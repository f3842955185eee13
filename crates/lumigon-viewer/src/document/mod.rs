//! What is open in the viewer: a scene whose lights can be held, and how it came to be so.

mod check;
mod editing;
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
mod undoing;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use lumigon_renderer::{Limits, Scene};

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
    /// The scene before that, and what changed since: once nobody else looks at it, it becomes the
    /// next one, and thousands of lights need not be copied for the sake of one.
    last_scene: Option<(Arc<Scene>, Patch<S>)>,
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
            last_scene: None,
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

    /// Whether the scene is as it was when it was last saved, or opened. Settings do not count.
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
}

#[cfg(test)]
mod properties;
#[cfg(test)]
mod tests;
