//! Another picture on lights.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec3, Vec2, Vec3};

use super::{EmissivePolygon, Emitter, take_pyramids};
use crate::scene::{
    ImageFile, Limits, Mesh, Sampler, Scene, SceneError, TextureRef, Wrap, error::Fault,
};

impl Scene {
    /// Shows an image on the lights of that name in place of their emissive texture, and on the faces
    /// themselves; returns how many polygon lights there are of that name now.
    ///
    /// `name` is a light's, the node's or the mesh's: `sign` finds `sign`, `sign/letter`, `wall/sign`
    /// and `sign[1]`. The image takes the texture's place, transform and wrapping. Lights that had no
    /// texture show it along their first texture coordinates or, without any, upright and once on the
    /// bounding box of the mesh, as their largest light is seen from its front. The material's emissive
    /// factor and strength still multiply it. As often as there are frames: textures that nothing
    /// shows any more are overwritten.
    ///
    /// # Errors
    /// Where no emissive mesh has the name: the error lists those that there are. Where the pictures
    /// of all lights pass `limits`. The scene is then as it was.
    pub fn replace_light_image(
        &mut self,
        name: &str,
        image: &ImageFile,
        limits: &Limits,
    ) -> Result<usize, SceneError> {
        let in_image = |fault: Fault| fault.in_file(&image.name);
        let meshes = self.emissive_meshes(name).map_err(in_image)?;
        let mut changed = Changed::new(self, &meshes, image);
        let mut warnings = Vec::new();
        let mut polygons: Vec<EmissivePolygon> = Vec::new();
        for &index in &meshes {
            let emitted = changed.lights(self, index, limits);
            warnings.extend(emitted.warning);
            polygons.extend(emitted.polygons);
        }
        let mut bytes_left = limits.light_image_bytes;
        let is_other = |light: &&EmissivePolygon| !meshes.contains(&light.mesh);
        let others: Vec<_> = self
            .polygon_lights
            .iter()
            .filter(is_other)
            .cloned()
            .collect();
        take_pyramids(&others, limits, &mut bytes_left).map_err(in_image)?;
        take_pyramids(&polygons, limits, &mut bytes_left).map_err(in_image)?;

        let count = polygons.len();
        self.polygon_lights = others;
        self.polygon_lights.extend(polygons);
        // As if they had been there from the start.
        self.polygon_lights.sort_by_key(|light| light.mesh);
        for warning in warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        changed.store(self);
        Ok(count)
    }

    /// The meshes of that name whose material emits.
    fn emissive_meshes(&self, name: &str) -> Result<BTreeSet<usize>, Fault> {
        let emits = |mesh: &&Mesh| self.materials[mesh.material].is_emissive();
        let named = |mesh: &Mesh| {
            let parts = mesh.name.split('/');
            let without_index = |part: &str| part.split('[').next() == Some(name) || part == name;
            mesh.name == name || parts.into_iter().any(without_index)
        };
        let found = self.meshes.iter().enumerate();
        let found = found.filter(|(_, mesh)| emits(mesh) && named(mesh));
        let found: BTreeSet<usize> = found.map(|(index, _)| index).collect();
        if !found.is_empty() {
            return Ok(found);
        }
        let all: BTreeSet<&str> = self.meshes.iter().filter(emits).map(|m| &*m.name).collect();
        let (what, mend) = if all.is_empty() {
            let what = format!("there is no light {name:?}: no mesh of the scene emits");
            (what, "give a material an emissive factor".to_owned())
        } else {
            let shown: Vec<String> = all.iter().take(NAMES).map(|n| format!("{n:?}")).collect();
            let rest = match all.len().saturating_sub(NAMES) {
                0 => String::new(),
                rest => format!(" and {rest} more"),
            };
            let what = format!("there is no light {name:?}");
            (what, format!("use one of {}{rest}", shown.join(", ")))
        };
        Err(Fault::new("light", what, mend))
    }
}

/// Names that an error lists.
const NAMES: usize = 50;

/// The meshes, materials and textures that are to be, beside a scene that is not changed yet.
struct Changed {
    /// By the mesh's index; each with its own material.
    meshes: Vec<(usize, Mesh)>,
    materials: Vec<crate::scene::Material>,
    textures: Vec<crate::scene::Texture>,
}

impl Changed {
    fn new(scene: &Scene, meshes: &BTreeSet<usize>, image: &ImageFile) -> Self {
        let mut changed = Self {
            meshes: Vec::new(),
            materials: scene.materials.clone(),
            textures: scene.textures.clone(),
        };
        // Materials that other meshes show as well are copied, each once.
        let is_other = |index: &usize| !meshes.contains(index);
        let others = (0..scene.meshes.len()).filter(is_other);
        let others: BTreeSet<usize> = others.map(|index| scene.meshes[index].material).collect();
        let mut own = BTreeMap::new();
        let mut before = Vec::new();
        for &index in meshes {
            let mut mesh = scene.meshes[index].clone();
            let material = *own.entry(mesh.material).or_insert_with(|| {
                if others.contains(&mesh.material) {
                    changed
                        .materials
                        .push(changed.materials[mesh.material].clone());
                    changed.materials.len() - 1
                } else {
                    mesh.material
                }
            });
            mesh.material = material;
            let reference = changed.materials[material].emissive_texture.take();
            before.push(reference);
            changed.meshes.push((index, mesh));
        }
        // A material that several of the meshes share has given its texture to the first of them.
        let mut placed = BTreeMap::new();
        for ((_, mesh), reference) in changed.meshes.iter().zip(&before) {
            placed.entry(mesh.material).or_insert(*reference);
        }
        for (&material, &reference) in &placed {
            let users = changed.meshes.iter_mut();
            let users = users.filter(|(_, mesh)| mesh.material == material);
            let mut users: Vec<_> = users.collect();
            // A texture without coordinates shows one of its texels.
            let reference = reference.filter(|reference| {
                let texcoords = |mesh: &Mesh| mesh.texcoords[reference.texcoord].is_empty();
                !users.iter().all(|(_, mesh)| texcoords(mesh))
            });
            let sampler = match reference {
                Some(reference) => scene.textures[reference.texture].sampler,
                None => {
                    let mut clamped = true;
                    for (index, mesh) in &mut users {
                        clamped &= give_texcoords(scene, *index, mesh);
                    }
                    let wrap = if clamped {
                        Wrap::ClampToEdge
                    } else {
                        Wrap::Repeat
                    };
                    Sampler {
                        wrap_s: wrap,
                        wrap_t: wrap,
                        ..Sampler::default()
                    }
                }
            };
            let texture = image.texture(true, sampler);
            let old = reference.map(|reference| reference.texture);
            let unused = old.filter(|&old| !changed.materials.iter().any(|m| m.shows(old)));
            let slot = match unused {
                Some(slot) => {
                    changed.textures[slot] = texture;
                    slot
                }
                None => {
                    changed.textures.push(texture);
                    changed.textures.len() - 1
                }
            };
            changed.materials[material].emissive_texture = Some(TextureRef {
                texture: slot,
                ..reference.unwrap_or_default()
            });
        }
        changed
    }

    /// The lights of one of the meshes as it is to be.
    fn lights(&mut self, scene: &Scene, index: usize, limits: &Limits) -> super::Emitted {
        let found = self.meshes.iter().find(|(i, _)| *i == index);
        let mesh = found.map_or(&scene.meshes[index], |(_, mesh)| mesh);
        let positions: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
        let largest = mesh.positions.iter().map(|p| p.abs().max_element());
        let largest = f64::from(largest.fold(0.0, f32::max));
        Emitter {
            mesh,
            index,
            positions: &positions,
            // Each coordinate is off by half a unit in the last place.
            noise: largest * f64::from(f32::EPSILON),
            material: &self.materials[mesh.material],
            textures: &self.textures,
        }
        .polygons(limits.light_image_side)
    }

    fn store(self, scene: &mut Scene) {
        scene.materials = self.materials;
        scene.textures = self.textures;
        for (index, mesh) in self.meshes {
            scene.meshes[index] = mesh;
        }
    }
}

/// Gives a mesh without texture coordinates such that an image stands upright on its bounding box,
/// seen from the front of its largest light. False where the mesh has coordinates.
fn give_texcoords(scene: &Scene, index: usize, mesh: &mut Mesh) -> bool {
    if !mesh.texcoords[0].is_empty() {
        return false;
    }
    let lights = scene.polygon_lights.iter();
    let largest = lights
        .filter(|light| light.mesh == index)
        .max_by(|a, b| a.area().total_cmp(&b.area()));
    let normal = largest.map_or(Vec3::Z, |light| DVec3::from(light.area_vector()).as_vec3());
    let normal = normal.normalize_or(Vec3::Z);
    let up = if normal.y.abs() > 0.999 {
        // What a floor shows has its upper edge at the back.
        Vec3::NEG_Z
    } else {
        Vec3::Y
    };
    let up = (up - normal * up.dot(normal)).normalize();
    let right = up.cross(normal);
    let along = |p: &Vec3| Vec2::new(right.dot(*p), -up.dot(*p));
    let low = mesh
        .positions
        .iter()
        .map(along)
        .fold(Vec2::INFINITY, Vec2::min);
    let high = mesh
        .positions
        .iter()
        .map(along)
        .fold(Vec2::NEG_INFINITY, Vec2::max);
    let extent = (high - low).max(Vec2::splat(f32::MIN_POSITIVE));
    let texcoords = mesh.positions.iter().map(|p| (along(p) - low) / extent);
    mesh.texcoords[0] = texcoords.collect();
    true
}
