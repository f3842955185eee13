//! Rays through the scene's triangles.

use std::time::Duration;

use glam::{Vec2, Vec3};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;

use crate::scene::{AlphaMode, Scene, SurfaceSample};

/// Every triangle of a scene in one hierarchy.
pub(crate) struct Geometry {
    hierarchy: Option<CwBvh>,
    triangles: Vec<TracedTriangle>,
    /// Rays that start on a surface skip this distance, relative to the scene's size.
    pub(super) epsilon: f32,
}

/// A triangle with where it comes from.
struct TracedTriangle {
    corners: Triangle,
    mesh: u32,
    index: u32,
    there: There,
}

/// From where a triangle can be met.
#[derive(Clone, Copy)]
enum There {
    Always,
    /// Seen from where it runs counter-clockwise.
    FromItsFront,
    /// Where the alpha mask leaves it, and from its front where it is single-sided.
    WhereOpaque,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy)]
pub(super) struct TriangleHit {
    mesh: usize,
    triangle: usize,
    of_scene: u32,
    barycentrics: Vec2,
    direction: Vec3,
}

impl TriangleHit {
    /// Index of the triangle, counted over all meshes of the scene.
    pub(super) fn triangle_of_scene(&self) -> u32 {
        self.of_scene
    }

    /// The surface there.
    #[inline]
    pub(super) fn surface(&self, scene: &Scene) -> SurfaceSample {
        scene.surface(self.mesh, self.triangle, self.barycentrics, self.direction)
    }
}

/// The distance from surfaces that rays which start or end on them leave out: relative to the scene's
/// size, or to its distance from the origin, where coordinates are that coarse.
pub(crate) fn ray_epsilon(scene: &Scene) -> f32 {
    let extent = scene.bounds().map_or(0.0, |(low, high)| {
        (high - low)
            .length()
            .max(low.abs().max(high.abs()).max_element())
    });
    extent * 1e-5
}

impl Geometry {
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut triangles = Vec::new();
        for (mesh_index, mesh) in scene.meshes.iter().enumerate() {
            let material = &scene.materials[mesh.material];
            let there = match material.alpha_mode {
                AlphaMode::Mask { .. } => There::WhereOpaque,
                _ if material.double_sided => There::Always,
                _ => There::FromItsFront,
            };
            for index in 0..mesh.triangles.len() {
                let [v0, v1, v2] = mesh.corners(index).map(Into::into);
                triangles.push(TracedTriangle {
                    corners: Triangle { v0, v1, v2 },
                    mesh: mesh_index as u32,
                    index: index as u32,
                    there,
                });
            }
        }
        let hierarchy = (!triangles.is_empty()).then(|| {
            let corners: Vec<Triangle> = triangles.iter().map(|t| t.corners).collect();
            build_cwbvh_from_tris(
                &corners,
                BvhBuildParams::medium_build(),
                &mut Duration::default(),
            )
        });
        Self {
            hierarchy,
            triangles,
            epsilon: ray_epsilon(scene),
        }
    }

    /// Where a ray first meets a triangle at least `nearest` away.
    pub(super) fn hit(
        &self,
        scene: &Scene,
        origin: Vec3,
        direction: Vec3,
        nearest: f32,
    ) -> Option<TriangleHit> {
        let hierarchy = self.hierarchy.as_ref()?;
        let ray = finite_ray(origin, direction, nearest, f32::INFINITY)?;
        let mut hit = RayHit::none();
        let found = hierarchy.ray_traverse(ray, &mut hit, |ray, slot| {
            let triangle = self.triangle(hierarchy, slot);
            self.distance(scene, triangle, ray)
        });
        found.then(|| {
            let of_scene = hierarchy.primitive_indices[hit.primitive_id as usize];
            let triangle = &self.triangles[of_scene as usize];
            TriangleHit {
                mesh: triangle.mesh as usize,
                triangle: triangle.index as usize,
                of_scene,
                barycentrics: barycentrics(&triangle.corners, &ray),
                direction,
            }
        })
    }

    /// Whether anything lies between two distances along a ray.
    pub(crate) fn occluded(
        &self,
        scene: &Scene,
        origin: Vec3,
        direction: Vec3,
        nearest: f32,
        farthest: f32,
    ) -> bool {
        let Some(hierarchy) = &self.hierarchy else {
            return false;
        };
        let Some(ray) = finite_ray(origin, direction, nearest, farthest) else {
            return false;
        };
        !hierarchy.ray_traverse_miss(ray, |ray, slot| {
            let triangle = self.triangle(hierarchy, slot);
            self.distance(scene, triangle, ray)
        })
    }

    /// Whether anything lies between two points of surfaces.
    pub(super) fn between(&self, scene: &Scene, from: Vec3, to: Vec3) -> bool {
        let offset = to - from;
        let distance = offset.length();
        let farthest = distance - self.epsilon;
        self.occluded(scene, from, offset / distance, self.epsilon, farthest)
    }

    fn triangle(&self, hierarchy: &CwBvh, slot: usize) -> &TracedTriangle {
        &self.triangles[hierarchy.primitive_indices[slot] as usize]
    }

    /// Distance to the triangle, infinite where it is missed or not there.
    fn distance(&self, scene: &Scene, triangle: &TracedTriangle, ray: &Ray) -> f32 {
        let distance = triangle.corners.intersect(ray);
        if distance == f32::INFINITY {
            return distance;
        }
        let is_there = match triangle.there {
            There::Always => true,
            There::FromItsFront => {
                let Triangle { v0, v1, v2 } = triangle.corners;
                (v1 - v0).cross(v2 - v0).dot(ray.direction) <= 0.0
            }
            There::WhereOpaque => {
                let opacity = scene.opacity(
                    triangle.mesh as usize,
                    triangle.index as usize,
                    barycentrics(&triangle.corners, ray),
                    ray.direction.into(),
                );
                opacity >= 0.5
            }
        };
        if is_there { distance } else { f32::INFINITY }
    }
}

/// A ray of finite numbers, or none.
fn finite_ray(origin: Vec3, direction: Vec3, nearest: f32, farthest: f32) -> Option<Ray> {
    let usable = origin.is_finite() && direction.is_finite() && farthest > nearest;
    // The hierarchy loses rays along -0: of a sum with 0 no zero is negative.
    let direction = direction + Vec3::ZERO;
    usable.then(|| Ray::new(origin.into(), direction.into(), nearest, farthest))
}

/// Weights of the second and third corner where a ray meets a triangle's plane.
fn barycentrics(triangle: &Triangle, ray: &Ray) -> Vec2 {
    let (edge1, edge2) = (triangle.v1 - triangle.v0, triangle.v2 - triangle.v0);
    let p = ray.direction.cross(edge2);
    let determinant = edge1.dot(p);
    if determinant == 0.0 {
        return Vec2::splat(1.0 / 3.0);
    }
    let t = ray.origin - triangle.v0;
    let u = t.dot(p) / determinant;
    let v = ray.direction.dot(t.cross(edge1)) / determinant;
    Vec2::new(u, v).clamp(Vec2::ZERO, Vec2::ONE)
}
