//! Rays through the scene's triangles.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;

use super::layer::{Layer, LayerMesh, There, TracedTriangle};
use crate::scene::{Mesh, Scene, SurfaceSample};

/// New meshes of more triangles have a hierarchy of their own, which stays while they do; that of all
/// smaller ones is built anew whenever one of them changes.
const SMALL: usize = 4096;

/// Every triangle of a scene in one hierarchy, or, after edits, in a few: the one of the scene before
/// them, without what is gone, and those of what is new.
pub(crate) struct Geometry {
    layers: Vec<PlacedLayer>,
    /// For each mesh of the scene how many triangles come before its own.
    first_triangles: Vec<u32>,
    /// Rays that start on a surface skip this distance, relative to the scene's size.
    pub(super) epsilon: f32,
}

/// Meshes that are no longer there.
const GONE: u32 = u32::MAX;

/// A hierarchy, and what has become of its meshes.
struct PlacedLayer {
    layer: Arc<Layer>,
    /// For each of its meshes, counted as when it was built, its index now, or [`GONE`]; none where
    /// nothing has changed.
    now: Option<Vec<u32>>,
    /// It has the small meshes that are new since the first one was built.
    is_small: bool,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy)]
pub(super) struct TriangleHit {
    pub(super) mesh: usize,
    pub(super) triangle: usize,
    of_scene: u32,
    barycentrics: Vec2,
    direction: Vec3,
    pub(super) distance: f32,
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
    epsilon(scene.bounds())
}

fn epsilon(bounds: Option<(Vec3, Vec3)>) -> f32 {
    let extent = bounds.map_or(0.0, |(low, high)| {
        (high - low)
            .length()
            .max(low.abs().max(high.abs()).max_element())
    });
    extent * 1e-5
}

impl Geometry {
    pub(crate) fn new(scene: &Scene) -> Self {
        Self::of_layers(scene, vec![PlacedLayer::new(scene, 0..scene.meshes.len())])
    }

    /// Of the same scene after edits: what has not changed keeps its hierarchy.
    pub(super) fn edited(&self, scene: &Scene) -> Self {
        let mut unclaimed = Unclaimed::new(scene);
        let mut layers = Vec::new();
        let (small, others): (Vec<_>, Vec<_>) = self.layers.iter().partition(|l| l.is_small);
        for placed in others {
            let placed = placed.renamed(unclaimed.claim(placed));
            if placed.bounds().next().is_some() {
                layers.push(placed);
            }
        }
        let is_large = |&mesh: &usize| scene.meshes[mesh].triangles.len() > SMALL;
        let (large, left): (Vec<_>, Vec<_>) = unclaimed.meshes().into_iter().partition(is_large);
        layers.extend(
            large
                .into_iter()
                .map(|mesh| PlacedLayer::new(scene, [mesh])),
        );
        if !left.is_empty() {
            // As it was, where it has all that is left and no more.
            let kept = small.first().and_then(|placed| {
                let now = unclaimed.claim(placed);
                let is_whole = !now.contains(&GONE) && now.len() == left.len();
                is_whole.then(|| placed.renamed(now))
            });
            layers.push(kept.unwrap_or_else(|| PlacedLayer {
                is_small: true,
                ..PlacedLayer::new(scene, left)
            }));
        }
        Self::of_layers(scene, layers)
    }

    fn of_layers(scene: &Scene, layers: Vec<PlacedLayer>) -> Self {
        let mut first_triangles = Vec::with_capacity(scene.meshes.len());
        let mut count = 0;
        for mesh in &scene.meshes {
            first_triangles.push(count);
            count += mesh.triangles.len() as u32;
        }
        let bounds = layers
            .iter()
            .flat_map(PlacedLayer::bounds)
            .reduce(|(low, high), (l, h)| (low.min(l), high.max(h)));
        Self {
            layers,
            first_triangles,
            epsilon: epsilon(bounds),
        }
    }

    /// Whether there is more than one hierarchy, or one with triangles that are gone.
    pub(super) fn is_layered(&self) -> bool {
        self.layers.len() > 1 || self.layers.iter().any(PlacedLayer::has_gone)
    }

    /// Where a ray first meets a triangle at least `nearest` away.
    pub(super) fn hit(
        &self,
        scene: &Scene,
        origin: Vec3,
        direction: Vec3,
        nearest: f32,
    ) -> Option<TriangleHit> {
        let mut ray = finite_ray(origin, direction, nearest, f32::INFINITY)?;
        let mut first: Option<(&PlacedLayer, &TracedTriangle)> = None;
        let of_scene = |placed: &PlacedLayer, triangle: &TracedTriangle| {
            self.first_triangles[placed.now(triangle.mesh) as usize] + triangle.index
        };
        for placed in &self.layers {
            let Some(hierarchy) = &placed.layer.hierarchy else {
                continue;
            };
            let mut hit = RayHit::none();
            let mut found = ray.tmax;
            hierarchy.ray_traverse(ray, &mut hit, |ray, slot| {
                let triangle = placed.layer.triangle(hierarchy, slot);
                let distance = placed.distance(scene, triangle, ray);
                // Where triangles meet, the scene's first one, in whatever hierarchies they are.
                let is_first = || {
                    first.is_none_or(|(other, earlier)| {
                        of_scene(placed, triangle) < of_scene(other, earlier)
                    })
                };
                if distance < found || distance == found && distance.is_finite() && is_first() {
                    found = distance;
                    first = Some((placed, triangle));
                }
                distance
            });
            ray.tmax = found;
        }
        let (placed, triangle) = first?;
        let mesh = placed.now(triangle.mesh);
        Some(TriangleHit {
            mesh: mesh as usize,
            triangle: triangle.index as usize,
            of_scene: of_scene(placed, triangle),
            barycentrics: barycentrics(&triangle.corners, &ray),
            direction,
            distance: ray.tmax,
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
        let Some(ray) = finite_ray(origin, direction, nearest, farthest) else {
            return false;
        };
        self.layers.iter().any(|placed| {
            placed.layer.hierarchy.as_ref().is_some_and(|hierarchy| {
                !hierarchy.ray_traverse_miss(ray, |ray, slot| {
                    placed.distance(scene, placed.layer.triangle(hierarchy, slot), ray)
                })
            })
        })
    }

    /// Whether anything lies between two points of surfaces.
    pub(super) fn between(&self, scene: &Scene, from: Vec3, to: Vec3) -> bool {
        let offset = to - from;
        let distance = offset.length();
        let farthest = distance - self.epsilon;
        self.occluded(scene, from, offset / distance, self.epsilon, farthest)
    }
}

impl PlacedLayer {
    /// Of some of a scene's meshes.
    fn new(scene: &Scene, meshes: impl IntoIterator<Item = usize>) -> Self {
        let meshes: Vec<usize> = meshes.into_iter().collect();
        let is_in_order = meshes.iter().enumerate().all(|(i, &mesh)| i == mesh);
        Self {
            layer: Arc::new(Layer::new(scene, &meshes)),
            now: (!is_in_order).then(|| meshes.iter().map(|&mesh| mesh as u32).collect()),
            is_small: false,
        }
    }

    /// The same hierarchy with its meshes elsewhere.
    fn renamed(&self, now: Vec<u32>) -> Self {
        let is_in_order = (0..).zip(&now).all(|(i, &mesh)| i == mesh);
        Self {
            layer: Arc::clone(&self.layer),
            now: (!is_in_order).then_some(now),
            is_small: self.is_small,
        }
    }

    /// The index, or [`GONE`], of a mesh of the layer.
    #[inline(always)]
    fn now(&self, mesh: u32) -> u32 {
        self.now.as_ref().map_or(mesh, |now| now[mesh as usize])
    }

    /// Whether triangles of it are no longer there.
    fn has_gone(&self) -> bool {
        let mut meshes = (0..).zip(&self.layer.meshes);
        meshes.any(|(i, mesh)| mesh.bounds.is_some() && self.now(i) == GONE)
    }

    /// Of each mesh with triangles that is there.
    fn bounds(&self) -> impl Iterator<Item = (Vec3, Vec3)> {
        let meshes = (0..).zip(&self.layer.meshes);
        let there = meshes.filter(|&(i, _)| self.now(i) != GONE);
        there.filter_map(|(_, mesh)| mesh.bounds)
    }

    /// Distance to a triangle, infinite where it is missed or not there.
    #[inline(always)]
    fn distance(&self, scene: &Scene, triangle: &TracedTriangle, ray: &Ray) -> f32 {
        let distance = triangle.corners.intersect(ray);
        if distance == f32::INFINITY {
            return distance;
        }
        let mesh = self.now(triangle.mesh);
        if mesh == GONE {
            return f32::INFINITY;
        }
        let is_there = match triangle.there {
            There::Always => true,
            There::FromItsFront => {
                let Triangle { v0, v1, v2 } = triangle.corners;
                (v1 - v0).cross(v2 - v0).dot(ray.direction) <= 0.0
            }
            There::WhereOpaque => {
                let opacity = scene.opacity(
                    mesh as usize,
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

/// The meshes of a scene that no layer has yet.
struct Unclaimed<'a> {
    scene: &'a Scene,
    /// Those with triangles.
    is_left: Vec<bool>,
    /// By where they are in memory; made when first a mesh is not where it was.
    places: Option<HashMap<*const Mesh, Vec<u32>>>,
}

impl<'a> Unclaimed<'a> {
    fn new(scene: &'a Scene) -> Self {
        let has_triangles = |mesh: &Arc<Mesh>| !mesh.triangles.is_empty();
        Self {
            scene,
            is_left: scene.meshes.iter().map(has_triangles).collect(),
            places: None,
        }
    }

    /// Where each mesh of a layer is now. The layer has them then.
    fn claim(&mut self, placed: &PlacedLayer) -> Vec<u32> {
        let mut now: Vec<u32> = (0..)
            .zip(&placed.layer.meshes)
            .map(|(i, mesh)| {
                let before = placed.now(i);
                let is_same = before != GONE && self.is_left(before, mesh);
                if is_same {
                    self.is_left[before as usize] = false;
                }
                if is_same { before } else { GONE }
            })
            .collect();
        for (now, mesh) in now.iter_mut().zip(&placed.layer.meshes) {
            if *now == GONE
                && let Some(found) = self.elsewhere(mesh)
            {
                *now = found;
                self.is_left[found as usize] = false;
            }
        }
        now
    }

    fn is_left(&self, index: u32, mesh: &LayerMesh) -> bool {
        let place = index as usize;
        self.is_left.get(place) == Some(&true)
            && Arc::ptr_eq(&self.scene.meshes[place], &mesh.mesh)
            && There::of(self.scene, place) == mesh.there
    }

    /// A mesh whose index has changed: others before it have come or gone.
    fn elsewhere(&mut self, mesh: &LayerMesh) -> Option<u32> {
        if mesh.mesh.triangles.is_empty() {
            return None;
        }
        let scene = self.scene;
        let places = self.places.get_or_insert_with(|| {
            let mut places: HashMap<_, Vec<u32>> = HashMap::new();
            for (i, mesh) in (0..).zip(&scene.meshes) {
                places.entry(Arc::as_ptr(mesh)).or_default().push(i);
            }
            places
        });
        let found = places.get(&Arc::as_ptr(&mesh.mesh))?.clone();
        found.into_iter().find(|&index| self.is_left(index, mesh))
    }

    fn meshes(&self) -> Vec<usize> {
        let left = self
            .is_left
            .iter()
            .enumerate()
            .filter(|(_, is_left)| **is_left);
        left.map(|(i, _)| i).collect()
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
