//! Rays through the scene's triangles, on the device.

use std::time::Duration;

use bytemuck::{Pod, Zeroable};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;

use super::device::Gpu;
use super::error::GpuError;
use super::mesh_store::TriangleOrder;
use super::record::NONE;
use crate::bounce::LightTargets;
use crate::cpu::ray_epsilon;
use crate::scene::Scene;

/// `RayNode` of `rays.wesl`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct RayNodeRecord {
    pub(super) low: [f32; 3],
    pub(super) skip: u32,
    pub(super) high: [f32; 3],
    pub(super) triangle: u32,
}

/// Rounds of the loop through the hierarchy that a ray is counted with, at most: a tenth of that is
/// usual among a million triangles.
const MOST_ROUNDS_A_RAY: u64 = 512;

/// Edges of a light that a ray costs as much as, at most.
const MOST_EDGES_A_RAY: u64 = 64;

/// The scene's triangles in a hierarchy.
pub(super) struct Rays {
    /// Of [`RayNodeRecord`]s.
    pub(super) nodes: wgpu::Buffer,
    count: u64,
    /// Rays that start or end on a surface leave out this distance from it.
    pub(super) epsilon: f32,
}

impl Rays {
    /// `order` is that of the triangles on the device.
    pub(super) fn new(gpu: &Gpu, scene: &Scene, order: &TriangleOrder) -> Result<Self, GpuError> {
        let nodes = nodes(scene, order);
        Ok(Self {
            nodes: gpu.storage("nodes of the hierarchy of triangles", &nodes)?,
            count: nodes.len() as u64,
            epsilon: ray_epsilon(scene),
        })
    }

    /// Rounds of loops that a ray takes, at most but for rays that graze very much.
    pub(super) fn rounds_a_ray(&self) -> u64 {
        self.count.min(MOST_ROUNDS_A_RAY)
    }

    /// What a ray costs, in edges of lights, about.
    pub(super) fn edges_a_ray(&self) -> u64 {
        self.count.min(MOST_EDGES_A_RAY)
    }
}

/// Where rays to polygons go, on the device.
pub(super) struct TargetList {
    pub(super) points: wgpu::Buffer,
    pub(super) per_light: u32,
}

impl TargetList {
    /// Of lights in the order in which they are given.
    pub(super) fn new(gpu: &Gpu, targets: &LightTargets) -> Result<Self, GpuError> {
        let points: Vec<_> = targets.points.iter().map(|p| p.extend(0.0)).collect();
        Ok(Self {
            points: gpu.storage("points of lights that rays go to", &points)?,
            per_light: targets.per_light as u32,
        })
    }
}

/// A light's rays.
#[derive(Clone, Copy)]
pub(super) struct TracedLights<'a> {
    pub(super) rays: &'a Rays,
    pub(super) targets: &'a TargetList,
}

/// The hierarchy, depth first: a node's first child follows it, and where its box is missed the ray goes
/// on at `skip`, so that no shader needs a stack.
fn nodes(scene: &Scene, order: &TriangleOrder) -> Vec<RayNodeRecord> {
    let of_scene: Vec<Triangle> = scene
        .meshes
        .iter()
        .flat_map(|mesh| (0..mesh.triangles.len()).map(|index| mesh.corners(index)))
        .map(|corners| {
            let [v0, v1, v2] = corners.map(Into::into);
            Triangle { v0, v1, v2 }
        })
        .collect();
    if of_scene.is_empty() {
        // A buffer has to have something: a box that nothing is in.
        return vec![RayNodeRecord {
            low: [1.0; 3],
            skip: 1,
            high: [-1.0; 3],
            triangle: NONE,
        }];
    }
    let mut triangles = Vec::with_capacity(of_scene.len());
    let mut on_device = Vec::with_capacity(of_scene.len());
    for run in order.runs() {
        let start = run.of_scene as usize;
        triangles.extend_from_slice(&of_scene[start..start + run.count as usize]);
        on_device.extend(run.on_device..run.on_device + run.count);
    }
    let parameters = BvhBuildParams {
        // A node is either a box or a triangle.
        max_prims_per_leaf: 1,
        ..BvhBuildParams::medium_build()
    };
    let hierarchy = build_bvh2_from_tris(&triangles, parameters, &mut Duration::default());
    depth_first(&hierarchy, &on_device)
}

/// `on_device` are the hierarchy's triangles.
fn depth_first(hierarchy: &Bvh2, on_device: &[u32]) -> Vec<RayNodeRecord> {
    enum Step {
        Enter(u32),
        /// All below this one of the list is in it.
        Leave(usize),
    }
    let mut list: Vec<RayNodeRecord> = Vec::with_capacity(hierarchy.nodes.len());
    let mut open = vec![Step::Enter(0)];
    while let Some(step) = open.pop() {
        let index = match step {
            Step::Leave(index) => {
                list[index].skip = list.len() as u32;
                continue;
            }
            Step::Enter(index) => index,
        };
        let node = &hierarchy.nodes[index as usize];
        let aabb = node.aabb();
        let record = RayNodeRecord {
            low: aabb.min.to_array(),
            skip: 0,
            high: aabb.max.to_array(),
            triangle: NONE,
        };
        if node.is_leaf() {
            let slots = node.first_index..node.first_index + node.prim_count;
            for slot in slots {
                list.push(RayNodeRecord {
                    skip: list.len() as u32 + 1,
                    triangle: on_device[hierarchy.primitive_indices[slot as usize] as usize],
                    ..record
                });
            }
        } else {
            open.push(Step::Leave(list.len()));
            open.push(Step::Enter(node.first_index + 1));
            open.push(Step::Enter(node.first_index));
            list.push(record);
        }
    }
    list
}
