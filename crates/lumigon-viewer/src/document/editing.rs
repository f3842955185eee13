//! Edits of the lights and settings of a document.

use std::sync::Arc;

use glam::DMat3;
use lumigon_renderer::{EmissivePolygon, Mesh};

use super::patch::{Entry, Patch, Polygons, polygon_range};
use super::{Document, EditError, Light, LightId, PictureImage, check, faces, images};

impl<S: Clone + PartialEq> Document<S> {
    /// Changes the settings: a step "settings", or part of the gesture that is going on.
    pub fn set_settings(&mut self, settings: S) {
        if settings != self.settings {
            let patch = Patch {
                settings: Some(settings),
                ..Patch::default()
            };
            let scene = Arc::clone(&self.scene);
            self.take("settings", &patch, scene);
        }
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
        let mut scene = self.own_scene();
        patch.change_parts(&mut scene);
        patch.change_polygons(&mut scene);
        self.take("remove light", &patch, Arc::new(scene));
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
        let is_slow = images::is_slow(&made_of);
        let moved = is_slow
            .then(|| self.moved(id, &light, (mesh, &made)))
            .flatten();
        patch.meshes.insert(mesh, Some(Arc::new(made)));
        patch.materials.insert(material, Some(Arc::new(made_of)));

        let mut scene = self.own_scene();
        patch.change_parts(&mut scene);
        let (list, finished) = moved
            .or_else(|| {
                let coarse = is_slow.then(|| images::coarse(&scene, mesh, &light));
                coarse.flatten().map(|coarse| (coarse, false))
            })
            .unwrap_or_else(|| (scene.lights_of_mesh(mesh, &self.limits).0, true));
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
        self.take(name, &patch, Arc::new(scene));
        Ok(())
    }

    /// The polygons of a light that is only to be moved, turned or coloured, and whether they are finished.
    fn moved(
        &self,
        id: LightId,
        light: &Light,
        (mesh, made): (usize, &Mesh),
    ) -> Option<(Vec<EmissivePolygon>, bool)> {
        let before = self.light(id)?;
        let (Entry::OfFile { mesh: old } | Entry::Own { mesh: old, .. }) = self.entries[id.index()]
        else {
            return None;
        };
        let polygons = &self.scene.polygon_lights[self.polygons_of(id)];
        let meshes = [&*self.scene.meshes[old], made];
        let moved = images::moved([before, light], meshes, polygons, mesh)?;
        let known = self.polygons.get(&old);
        Some((moved, known.is_none_or(|polygons| polygons.finished)))
    }
}
