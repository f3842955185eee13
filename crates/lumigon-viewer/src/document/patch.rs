//! A change of a document: values for some of its parts.

use std::collections::BTreeMap;
use std::sync::Arc;

use lumigon_renderer::{EmissivePolygon, Material, Mesh, Scene};

use super::{Light, PictureFile};

/// What a light of the document is in the scene.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Entry {
    /// As the file has it, a polygon of that mesh.
    OfFile { mesh: usize },
    /// On a mesh and a material of its own.
    Own { mesh: usize, light: Arc<Light> },
    /// Not there, or not yet.
    Removed,
}

/// The polygons of one mesh.
#[derive(Clone, Debug)]
pub(super) struct Polygons {
    pub(super) list: Arc<[EmissivePolygon]>,
    /// They are what loading the saved mesh makes; otherwise their pictures are yet to be finished.
    pub(super) finished: bool,
}

/// New values, by index; `None` for what is not there, which is the last of its kind.
#[derive(Clone, Debug)]
pub(super) struct Patch<S> {
    pub(super) meshes: BTreeMap<usize, Option<Arc<Mesh>>>,
    pub(super) materials: BTreeMap<usize, Option<Arc<Material>>>,
    pub(super) textures: BTreeMap<usize, Option<Arc<PictureFile>>>,
    pub(super) polygons: BTreeMap<usize, Polygons>,
    pub(super) entries: BTreeMap<u32, Entry>,
    pub(super) settings: Option<S>,
}

impl<S> Default for Patch<S> {
    fn default() -> Self {
        Self {
            meshes: BTreeMap::new(),
            materials: BTreeMap::new(),
            textures: BTreeMap::new(),
            polygons: BTreeMap::new(),
            entries: BTreeMap::new(),
            settings: None,
        }
    }
}

impl<S: Clone> Patch<S> {
    /// Takes what a later patch says instead.
    pub(super) fn then(&mut self, later: &Self) {
        fn extend<K: Ord + Copy, V: Clone>(map: &mut BTreeMap<K, V>, later: &BTreeMap<K, V>) {
            map.extend(later.iter().map(|(&k, v)| (k, v.clone())));
        }
        extend(&mut self.meshes, &later.meshes);
        extend(&mut self.materials, &later.materials);
        extend(&mut self.textures, &later.textures);
        extend(&mut self.polygons, &later.polygons);
        extend(&mut self.entries, &later.entries);
        if let Some(settings) = &later.settings {
            self.settings = Some(settings.clone());
        }
    }

    /// All of it but the polygons, in a scene.
    pub(super) fn change_parts(&self, scene: &mut Scene) {
        put(&mut scene.meshes, &self.meshes, Arc::clone);
        put(&mut scene.materials, &self.materials, |m| {
            Material::clone(m)
        });
        put(&mut scene.textures, &self.textures, |file| file.texture());
    }

    /// The polygons, in a scene whose polygons are in the order of their meshes.
    pub(super) fn change_polygons(&self, scene: &mut Scene) {
        for (&mesh, polygons) in &self.polygons {
            put_polygons(scene, mesh, &polygons.list);
        }
    }

    pub(super) fn changes_scene(&self) -> bool {
        !(self.meshes.is_empty()
            && self.materials.is_empty()
            && self.textures.is_empty()
            && self.polygons.is_empty())
    }

    /// About how much memory it holds.
    pub(super) fn bytes(&self) -> usize {
        let mesh = |mesh: &Option<Arc<Mesh>>| {
            mesh.as_ref().map_or(0, |mesh| {
                let vertex = size_of::<glam::Vec3>() * 2;
                mesh.positions.len() * vertex
                    + mesh.tangents.len() * size_of::<glam::Vec4>()
                    + mesh.colors.len() * size_of::<glam::Vec4>()
                    + (mesh.texcoords[0].len() + mesh.texcoords[1].len()) * size_of::<glam::Vec2>()
                    + mesh.triangles.len() * size_of::<[u32; 3]>()
            })
        };
        let polygon = |polygon: &EmissivePolygon| {
            size_of::<EmissivePolygon>()
                + polygon.triangles.len() * size_of::<u32>()
                + polygon.vertex_count() * size_of::<[f64; 3]>()
        };
        let polygons = self.polygons.values().flat_map(|p| p.list.iter());
        self.meshes.values().map(mesh).sum::<usize>()
            + polygons.map(polygon).sum::<usize>()
            + self.materials.len() * size_of::<Material>()
            + size_of::<S>()
    }
}

/// Values at their indices; the list ends where there is none.
fn put<T, V>(list: &mut Vec<T>, values: &BTreeMap<usize, Option<V>>, make: impl Fn(&V) -> T) {
    for (&index, value) in values {
        match value {
            Some(value) if index < list.len() => list[index] = make(value),
            Some(value) => list.push(make(value)),
            None => list.truncate(index),
        }
    }
}

/// Where the polygons of a mesh are among the scene's, in the order of their meshes.
pub(super) fn polygon_range(scene: &Scene, mesh: usize) -> std::ops::Range<usize> {
    let lights = &scene.polygon_lights;
    let start = lights.partition_point(|light| light.mesh < mesh);
    let count = lights[start..].partition_point(|light| light.mesh == mesh);
    start..start + count
}

fn put_polygons(scene: &mut Scene, mesh: usize, list: &[EmissivePolygon]) {
    let range = polygon_range(scene, mesh);
    if range.len() == list.len() {
        scene.polygon_lights[range].clone_from_slice(list);
    } else {
        scene.polygon_lights.splice(range, list.iter().cloned());
    }
}
