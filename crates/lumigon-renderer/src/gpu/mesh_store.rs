//! A scene's meshes on the device: all in shared buffers, each in a place of its own.

use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;

use super::device::Gpu;
use super::error::GpuError;
use super::pool::Pool;
use super::record::{MeshRecord, NONE, TriangleRecord};
use super::scene_buffers::{DRAWN, Drawn};
use super::storage::{Records, StagedRecords};
use crate::scene::{Material, Mesh, Scene};

/// The meshes and where they are.
pub(super) struct MeshStore {
    placed: Vec<PlacedMesh>,
    triangles: Pool<TriangleRecord>,
    positions: Pool<[f32; 4]>,
    numbers: Pool<f32>,
    records: Records<MeshRecord>,
}

/// A mesh and its places, in items.
#[derive(Clone)]
struct PlacedMesh {
    mesh: Arc<Mesh>,
    drawn: Drawn,
    triangles: Range<u32>,
    vertices: Range<u32>,
    numbers: Range<u32>,
    bounds: Option<(Vec3, Vec3)>,
}

/// Meshes that are to replace those of a store. What changed is on the device already, beside the others.
pub(super) struct StagedMeshes {
    placed: Vec<PlacedMesh>,
    /// Those of them that have places of their own.
    new: Vec<usize>,
    grown: [Option<wgpu::Buffer>; 3],
    records: StagedRecords<MeshRecord>,
}

/// How a scene's triangles are gone through.
pub(super) struct Arrangement {
    /// Triangles by how they are drawn, as [`DRAWN`]; in the order of the meshes, so that of those at one
    /// depth the same is seen wherever they are.
    pub(super) draws: [Vec<Range<u32>>; 3],
    pub(super) order: TriangleOrder,
    pub(super) bounds: Option<(Vec3, Vec3)>,
}

/// Which triangle of the scene, counted over its meshes, each triangle on the device is.
#[derive(Default)]
pub(super) struct TriangleOrder {
    runs: Vec<Run>,
}

/// Successive triangles, on the device and in the scene.
#[derive(Clone, Copy)]
pub(super) struct Run {
    pub(super) on_device: u32,
    pub(super) of_scene: u32,
    pub(super) count: u32,
}

impl TriangleOrder {
    /// The triangle of the scene; `on_device` is one.
    pub(super) fn of_scene(&self, on_device: u32) -> u32 {
        let after = self.runs.partition_point(|run| run.on_device <= on_device);
        let run = after.checked_sub(1).map(|i| self.runs[i]);
        run.map_or(on_device, |run| run.of_scene + (on_device - run.on_device))
    }

    /// All triangles, ascending on the device.
    pub(super) fn runs(&self) -> &[Run] {
        &self.runs
    }
}

impl MeshStore {
    /// Brings a scene's meshes to the device, where lists have at most `limit` bytes.
    pub(super) fn new(gpu: &Gpu, scene: &Scene, limit: u64) -> Result<Self, GpuError> {
        let count = |of: fn(&Mesh) -> usize| scene.meshes.iter().map(|m| of(m) as u64).sum();
        // Three vertices a triangle have to be counted in 32 bits.
        let triangle_limit =
            limit.min(u64::from(u32::MAX / 3) * size_of::<TriangleRecord>() as u64);
        let triangles = count(|m| m.triangles.len());
        let numbers = count(|m| m.positions.len() * Attributes::new(m).stride as usize);
        // Before anything is copied.
        let mut store = Self {
            placed: Vec::new(),
            triangles: Pool::new(gpu, "triangles", triangles, triangle_limit)?,
            positions: Pool::new(gpu, "vertices", count(|m| m.positions.len()), limit)?,
            numbers: Pool::new(gpu, "vertex attributes", numbers, limit)?,
            records: Records::new(gpu, "meshes", Vec::new())?,
        };
        let mut placed: Vec<_> = scene
            .meshes
            .iter()
            .map(|mesh| PlacedMesh {
                bounds: mesh.bounds(),
                ..PlacedMesh::unplaced(mesh, &scene.materials)
            })
            .collect();
        let too_much = || GpuError::Refused {
            what: "a scene's meshes",
            reason: "there is no place for them".to_owned(),
        };
        let (mut positions, mut numbers) = (Vec::new(), Vec::new());
        for mesh in &mut placed {
            mesh.place_vertices(&mut store).ok_or_else(too_much)?;
            positions.extend(mesh.mesh.positions.iter().map(|p| p.extend(0.0).to_array()));
            mesh.append_numbers(&mut numbers);
        }
        let mut triangles = Vec::new();
        // Neighbours on the device are drawn at once.
        for drawn in DRAWN {
            let all = placed.iter_mut().enumerate();
            for (index, mesh) in all.filter(|(_, mesh)| mesh.drawn == drawn) {
                mesh.place_triangles(&mut store).ok_or_else(too_much)?;
                triangles.extend(mesh.triangle_records(index));
            }
        }
        let all = 0..0;
        Pool::write(gpu, store.triangles.buffer(), &all, &triangles);
        Pool::write(gpu, store.positions.buffer(), &all, &positions);
        Pool::write(gpu, store.numbers.buffer(), &all, &numbers);
        let records = placed.iter().map(PlacedMesh::record).collect();
        store.records = Records::new(gpu, "meshes", records)?;
        store.placed = placed;
        Ok(store)
    }

    /// The buffers of the shaders' `triangles`, `positions`, `meshes` and `attributes`.
    pub(super) fn buffers(&self) -> [&wgpu::Buffer; 4] {
        [
            self.triangles.buffer(),
            self.positions.buffer(),
            self.records.buffer(),
            self.numbers.buffer(),
        ]
    }

    /// Brings what is new in another scene to the device, and leaves what is there. `None` where there is
    /// no room for both.
    pub(super) fn stage(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
    ) -> Result<Option<StagedMeshes>, GpuError> {
        let mut placed = Vec::with_capacity(scene.meshes.len());
        let mut new = Vec::new();
        for (index, mesh) in scene.meshes.iter().enumerate() {
            let mut next = PlacedMesh::unplaced(mesh, &scene.materials);
            match self.placed.get(index) {
                Some(old) if Arc::ptr_eq(&old.mesh, mesh) => {
                    placed.push(PlacedMesh {
                        drawn: next.drawn,
                        ..old.clone()
                    });
                    continue;
                }
                _ => next.bounds = mesh.bounds(),
            }
            let has_room = next
                .place_vertices(self)
                .and_then(|()| next.place_triangles(self));
            placed.push(next);
            new.push(index);
            if has_room.is_none() {
                self.free(&placed, &new);
                return Ok(None);
            }
        }
        let records = placed.iter().map(PlacedMesh::record).collect();
        let records = match self.records.stage(gpu, records) {
            Ok(records) => records,
            Err(fault) => {
                self.free(&placed, &new);
                return Err(fault);
            }
        };
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let grown = [
            self.triangles.grown(gpu, &mut encoder),
            self.positions.grown(gpu, &mut encoder),
            self.numbers.grown(gpu, &mut encoder),
        ];
        if grown.iter().any(Option::is_some) {
            // What is written from now on comes after the copies.
            gpu.queue().submit([encoder.finish()]);
        }
        let old = [
            self.triangles.buffer(),
            self.positions.buffer(),
            self.numbers.buffer(),
        ];
        let [triangles, positions, numbers] =
            [0, 1, 2].map(|i| grown[i].as_ref().unwrap_or(old[i]));
        for &index in &new {
            let mesh = &placed[index];
            let records: Vec<_> = mesh.triangle_records(index).collect();
            Pool::write(gpu, triangles, &mesh.triangles, &records);
            let points = mesh.mesh.positions.iter().map(|p| p.extend(0.0).to_array());
            Pool::write(gpu, positions, &mesh.vertices, &points.collect::<Vec<_>>());
            let mut list = Vec::new();
            mesh.append_numbers(&mut list);
            Pool::write(gpu, numbers, &mesh.numbers, &list);
        }
        Ok(Some(StagedMeshes {
            placed,
            new,
            grown,
            records,
        }))
    }

    /// Gives back the places of the `new` ones.
    fn free(&mut self, placed: &[PlacedMesh], new: &[usize]) {
        for &index in new {
            let mesh = placed[index].clone();
            self.triangles.free(mesh.triangles);
            self.positions.free(mesh.vertices);
            self.numbers.free(mesh.numbers);
        }
    }

    /// Forgets what was staged.
    pub(super) fn withdraw(&mut self, staged: &StagedMeshes) {
        self.free(&staged.placed, &staged.new);
    }

    /// Takes what was staged.
    pub(super) fn commit(&mut self, gpu: &Gpu, staged: StagedMeshes) {
        let old = std::mem::replace(&mut self.placed, staged.placed);
        let is_new =
            |index: &usize| *index >= self.placed.len() || staged.new.binary_search(index).is_ok();
        let gone: Vec<_> = (0..old.len()).filter(is_new).collect();
        self.free(&old, &gone);
        let [triangles, positions, numbers] = staged.grown;
        self.triangles.take(triangles);
        self.positions.take(positions);
        self.numbers.take(numbers);
        self.records.commit(gpu, staged.records);
    }

    pub(super) fn arrangement(&self) -> Arrangement {
        let mut draws: [Vec<Range<u32>>; 3] = Default::default();
        let mut runs = Vec::with_capacity(self.placed.len());
        let mut of_scene = 0;
        for mesh in &self.placed {
            let place = mesh.triangles.clone();
            if place.is_empty() {
                continue;
            }
            runs.push(Run {
                on_device: place.start,
                of_scene,
                count: place.len() as u32,
            });
            of_scene += place.len() as u32;
            let draws = &mut draws[mesh.drawn as usize];
            match draws.last_mut() {
                Some(last) if last.end == place.start => last.end = place.end,
                _ => draws.push(place),
            }
        }
        runs.sort_unstable_by_key(|run| run.on_device);
        let bounds = self
            .placed
            .iter()
            .filter_map(|mesh| mesh.bounds)
            .reduce(|(low, high), (l, h)| (low.min(l), high.max(h)));
        Arrangement {
            draws,
            order: TriangleOrder { runs },
            bounds,
        }
    }
}

impl PlacedMesh {
    fn unplaced(mesh: &Arc<Mesh>, materials: &[Material]) -> Self {
        Self {
            mesh: Arc::clone(mesh),
            drawn: Drawn::of(&materials[mesh.material]),
            triangles: 0..0,
            vertices: 0..0,
            numbers: 0..0,
            bounds: None,
        }
    }

    fn place_vertices(&mut self, store: &mut MeshStore) -> Option<()> {
        let stride = Attributes::new(&self.mesh).stride as usize;
        let vertices = self.mesh.positions.len();
        self.vertices = store.positions.place(vertices)?;
        self.numbers = store.numbers.place(vertices * stride)?;
        Some(())
    }

    fn place_triangles(&mut self, store: &mut MeshStore) -> Option<()> {
        self.triangles = store.triangles.place(self.mesh.triangles.len())?;
        Some(())
    }

    fn triangle_records(&self, index: usize) -> impl Iterator<Item = TriangleRecord> + '_ {
        let first = self.vertices.start;
        let triangles = self.mesh.triangles.iter();
        triangles.map(move |corners| TriangleRecord {
            corners: corners.map(|i| first + i),
            mesh: index as u32,
        })
    }

    fn record(&self) -> MeshRecord {
        let attributes = Attributes::new(&self.mesh);
        MeshRecord {
            material: self.mesh.material as u32,
            first_vertex: self.vertices.start,
            first_number: self.numbers.start,
            stride: attributes.stride,
            normal: attributes.normal,
            tangent: attributes.tangent,
            color: attributes.color,
            texcoord: attributes.texcoord,
        }
    }

    fn append_numbers(&self, to: &mut Vec<f32>) {
        let mesh = &self.mesh;
        let attributes = Attributes::new(mesh);
        for i in 0..mesh.positions.len() {
            if attributes.normal != NONE {
                to.extend(mesh.normals[i].to_array());
            }
            if attributes.tangent != NONE {
                to.extend(mesh.tangents[i].to_array());
            }
            if attributes.color != NONE {
                to.extend(mesh.colors[i].to_array());
            }
            for (texcoords, offset) in mesh.texcoords.iter().zip(attributes.texcoord) {
                if offset != NONE {
                    to.extend(texcoords[i].to_array());
                }
            }
        }
    }
}

/// Where a mesh's vertices have which attribute, in numbers.
struct Attributes {
    normal: u32,
    tangent: u32,
    color: u32,
    texcoord: [u32; 2],
    stride: u32,
}

impl Attributes {
    fn new(mesh: &Mesh) -> Self {
        let mut stride = 0;
        let mut place = |length: usize, numbers: u32| {
            // One for each vertex, or none.
            if length == 0 || length < mesh.positions.len() {
                return NONE;
            }
            stride += numbers;
            stride - numbers
        };
        Self {
            normal: place(mesh.normals.len(), 3),
            tangent: place(mesh.tangents.len(), 4),
            color: place(mesh.colors.len(), 4),
            texcoord: [
                place(mesh.texcoords[0].len(), 2),
                place(mesh.texcoords[1].len(), 2),
            ],
            stride,
        }
    }
}

#[cfg(test)]
#[expect(
    clippy::single_range_in_vec_init,
    reason = "lists of ranges, some of one"
)]
mod tests {
    use super::*;
    use crate::gpu::GpuPreference;
    use crate::scene::AlphaMode;

    fn triangle(material: usize) -> Arc<Mesh> {
        Arc::new(Mesh {
            material,
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        })
    }

    fn scene() -> Scene {
        let masked = Material {
            alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
            ..Material::default()
        };
        let double_sided = Material {
            double_sided: true,
            ..Material::default()
        };
        Scene {
            meshes: [0, 1, 2, 1].map(triangle).to_vec(),
            materials: vec![masked, Material::default(), double_sided],
            ..Scene::default()
        }
    }

    #[test]
    fn triangles_are_sorted_by_how_they_are_drawn() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let store = MeshStore::new(&gpu, &scene(), u64::MAX).unwrap();
        let arrangement = store.arrangement();
        assert_eq!(arrangement.draws, [vec![0..2], vec![2..3], vec![3..4]]);
        let order = &arrangement.order;
        assert_eq!([0, 1, 2, 3].map(|i| order.of_scene(i)), [1, 3, 2, 0]);
        assert_eq!(
            arrangement.bounds,
            Some((Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)))
        );
        let last = &store.placed[3];
        let records: Vec<_> = last.triangle_records(3).collect();
        assert_eq!((records[0].corners, records[0].mesh), ([9, 10, 11], 3));
        assert_eq!(last.record().first_number, 27);
        let fault = MeshStore::new(&gpu, &scene(), 63).err();
        let is_told = matches!(
            fault,
            Some(GpuError::TooMuch {
                what: "triangles",
                count: 4,
                ..
            })
        );
        assert!(is_told, "{fault:?}");
    }

    #[test]
    fn meshes_that_change_get_places_of_their_own() {
        let gpu = Gpu::new(GpuPreference::Any).unwrap();
        let mut scene = scene();
        let mut store = MeshStore::new(&gpu, &scene, u64::MAX).unwrap();
        // Moved, and one more.
        scene.meshes[1] = triangle(1);
        scene.meshes.push(triangle(2));
        let staged = store.stage(&gpu, &scene).unwrap().unwrap();
        assert_eq!(staged.new, [1, 4]);
        // What is withdrawn leaves nothing.
        store.withdraw(&staged);
        assert_eq!(
            store.arrangement().draws,
            [vec![0..2], vec![2..3], vec![3..4]]
        );
        let staged = store.stage(&gpu, &scene).unwrap().unwrap();
        store.commit(&gpu, staged);
        let arrangement = store.arrangement();
        assert_eq!(
            arrangement.draws,
            [vec![4..5, 1..2], vec![2..3, 5..6], vec![3..4]]
        );
        let order = &arrangement.order;
        assert_eq!([1, 2, 3, 4, 5].map(|i| order.of_scene(i)), [3, 2, 0, 1, 4]);
        // The place that became free is used again; empty meshes take none.
        scene.meshes[3] = triangle(1);
        scene.meshes[4] = Arc::new(Mesh::default());
        let staged = store.stage(&gpu, &scene).unwrap().unwrap();
        store.commit(&gpu, staged);
        let draws = store.arrangement().draws;
        assert_eq!(draws, [vec![4..5, 0..1], vec![2..3], vec![3..4]]);
        // Fewer.
        scene.meshes.truncate(1);
        let staged = store.stage(&gpu, &scene).unwrap().unwrap();
        store.commit(&gpu, staged);
        assert_eq!(store.arrangement().draws, [vec![], vec![], vec![3..4]]);
        assert_eq!(store.triangles.place(3), Some(0..3));
    }
}
