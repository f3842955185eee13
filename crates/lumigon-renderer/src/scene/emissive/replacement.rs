//! Another picture on lights.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};

use super::{EmissivePolygon, take_pyramids};
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
            warnings.extend(emitted.warnings);
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
        let emits = |mesh: &&Arc<Mesh>| self.materials[mesh.material].is_emissive();
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
            let mut mesh = Mesh::clone(&scene.meshes[index]);
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
        let mesh = found.map_or(&*scene.meshes[index], |(_, mesh)| mesh);
        let material = &self.materials[mesh.material];
        super::of_mesh(mesh, index, material, &self.textures, limits)
    }

    fn store(self, scene: &mut Scene) {
        scene.materials = self.materials;
        scene.textures = self.textures;
        for (index, mesh) in self.meshes {
            scene.meshes[index] = Arc::new(mesh);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::emissive::Emitter;
    use crate::scene::{Material, Texture};

    /// Squares of side 2 in planes z = 0, 1, ...; those of one material share it.
    fn scene(names: &[(&str, usize)], materials: Vec<Material>) -> Scene {
        let mut scene = Scene {
            materials,
            ..Scene::default()
        };
        for (z, &(name, material)) in names.iter().enumerate() {
            let corners = [(0., 0.), (2., 0.), (2., 2.), (0., 2.)];
            let mesh = Mesh {
                name: name.to_owned(),
                material,
                positions: corners.map(|(x, y)| Vec3::new(x, y, z as f32)).to_vec(),
                normals: vec![Vec3::Z; 4],
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..Mesh::default()
            };
            let positions: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
            let emitter = Emitter {
                mesh: &mesh,
                index: z,
                positions: &positions,
                noise: 0.0,
                material: &scene.materials[material],
                textures: &[],
            };
            if emitter.material.is_emissive() {
                scene.polygon_lights.extend(emitter.polygons(64).polygons);
            }
            scene.meshes.push(Arc::new(mesh));
        }
        scene
    }

    fn emissive(strength: f32) -> Material {
        Material {
            emissive: Vec3::splat(strength),
            ..Material::default()
        }
    }

    fn frame(size: [u32; 2], color: impl Fn(u32) -> [f32; 3]) -> ImageFile {
        let texels: Vec<_> = (0..size[0] * size[1]).map(color).collect();
        ImageFile::from_linear("frame", size, &texels).unwrap()
    }

    #[test]
    fn untextured_light_shows_an_image_upright() {
        let mut scene = scene(&[("wall/screen[1]", 0), ("lamp", 0)], vec![emissive(3.0)]);
        let lamp = scene.polygon_lights[1].clone();
        let image = frame([4, 2], |i| [i as f32, 1.0, 0.0]);
        let limits = Limits::default();
        assert_eq!(scene.replace_light_image("screen", &image, &limits), Ok(1));
        assert_eq!(scene.polygon_lights[1], lamp);
        let light = &scene.polygon_lights[0];
        // The mean of the texels: clamped, the borders' halves show them alone.
        assert!((light.radiance - Vec3::new(10.5, 3.0, 0.0)).length() < 1e-5);
        let shown = light.image.unwrap();
        assert_eq!((shown.size, shown.strength), ([4, 2], Vec3::splat(3.0)));
        let cells = shown.cells(&scene.textures, shown.size);
        let expected: Vec<_> = (0..8).map(|i| [i as f32, 1.0, 0.0]).collect();
        assert_eq!(cells, expected);
        // Its upper left corner is seen there from its front.
        assert!(DVec3::from(shown.corner).distance(DVec3::Y * 2.0) < 1e-6);
        // Rays see it, and see the lamp as it was.
        let seen = |mesh: usize, scene: &Scene| {
            let place = Vec2::new(0.01, 0.98);
            scene.surface(mesh, 1, place, Vec3::NEG_Z).emissive
        };
        assert!((seen(0, &scene) - Vec3::new(0.0, 3.0, 0.0)).length() < 0.2);
        assert_eq!(seen(1, &scene), Vec3::splat(3.0));
    }

    #[test]
    fn frames_follow_each_other_in_one_texture() {
        let mut scene = scene(&[("a", 0), ("b", 0)], vec![emissive(1.0)]);
        let limits = Limits::default();
        for (name, expected) in [("a", 1), ("b", 2)] {
            for number in 0..5 {
                let image = frame([8, 8], |i| [(i * number) as f32; 3]);
                let count = scene.replace_light_image(name, &image, &limits).unwrap();
                // The first frame is black, and what is black is no light.
                assert_eq!(count, usize::from(number > 0));
                assert_eq!(scene.textures.len(), expected);
                let lights = scene.polygon_lights.iter();
                let of_name: Vec<_> = lights.filter(|light| light.name == name).collect();
                assert_eq!(of_name.len(), count);
                for light in of_name {
                    let mean = 31.5 * number as f32;
                    assert!((light.radiance.x - mean).abs() < 1e-3 * mean);
                }
            }
        }
        // One colour needs no picture.
        let image = frame([2, 2], |_| [0.5; 3]);
        assert_eq!(scene.replace_light_image("a", &image, &limits), Ok(1));
        let light = &scene.polygon_lights[0];
        assert_eq!((light.image, light.radiance), (None, Vec3::splat(0.5)));
        assert_eq!((light.mesh, scene.polygon_lights[1].mesh), (0, 1));
    }

    #[test]
    fn textured_lights_keep_their_place_and_wrapping() {
        let material = Material {
            emissive_texture: Some(TextureRef::default()),
            ..emissive(2.0)
        };
        let mut scene = scene(&[], vec![material]);
        let sampler = Sampler {
            wrap_s: Wrap::MirroredRepeat,
            ..Sampler::default()
        };
        let texels = vec![[255; 4]];
        scene.textures = Texture::from_rgba8("", [1, 1], texels, true, sampler)
            .into_iter()
            .collect();
        let uv = [(0., 1.), (4., 1.), (4., 0.), (0., 0.)];
        scene.meshes = vec![Arc::new(Mesh {
            name: "screen".to_owned(),
            positions: [(0., 0.), (2., 0.), (2., 1.), (0., 1.)]
                .map(|(x, y)| Vec3::new(x, y, 0.0))
                .to_vec(),
            texcoords: [uv.map(|(u, v)| Vec2::new(u, v)).to_vec(), Vec::new()],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        })];
        let image = frame([2, 1], |i| [i as f32; 3]);
        let limits = Limits::default();
        assert_eq!(scene.replace_light_image("screen", &image, &limits), Ok(1));
        assert_eq!(scene.textures.len(), 1);
        assert_eq!(scene.textures[0].sampler, sampler);
        let shown = scene.polygon_lights[0].image.unwrap();
        let cells = shown.cells(&scene.textures, shown.size);
        let found: Vec<f32> = cells.iter().map(|cell| cell[0]).collect();
        assert_eq!(found, [0., 1., 1., 0., 0., 1., 1., 0.]);
    }

    #[test]
    fn what_does_not_fit_changes_nothing() {
        let dark = Material::default();
        let mut scene = scene(
            &[("sign", 0), ("a \"sign\"", 0), ("wall", 1)],
            vec![emissive(1.0), dark],
        );
        let before = scene.clone();
        let image = frame([64, 64], |i| [i as f32; 3]);
        let error = scene
            .replace_light_image("wall", &image, &Limits::default())
            .unwrap_err();
        let message = error.to_string();
        assert!(
            message.contains(r#""sign""#) && message.contains("frame"),
            "{message}"
        );
        let limits = Limits {
            light_image_bytes: 1000,
            ..Limits::default()
        };
        let error = scene
            .replace_light_image("sign", &image, &limits)
            .unwrap_err();
        let message = error.to_string();
        for part in [
            "light \"sign\"",
            "87376 bytes",
            "1000 of 1000",
            "raise the limit",
        ] {
            assert!(message.contains(part), "{message}");
        }
        assert_eq!(scene, before);
        // Smaller pictures fit.
        let limits = Limits {
            light_image_side: 5,
            ..limits
        };
        assert_eq!(scene.replace_light_image("sign", &image, &limits), Ok(1));
        assert_eq!(scene.polygon_lights[0].image.unwrap().size, [4, 4]);
        let mut empty = Scene::default();
        let error = empty.replace_light_image("", &image, &limits).unwrap_err();
        assert!(error.to_string().contains("no mesh of the scene emits"));
    }
}
