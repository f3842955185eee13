//! The flat parts of a scene's surfaces.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::footprint::{PlaneFrame, bounds};
use crate::scene::{FlatFace, Mesh, Scene, flat_faces};

/// A connected part of a surface that lies in one plane.
#[derive(Debug)]
pub(super) struct Facet {
    /// Its x axis runs along the outline's longest edge.
    pub(super) frame: PlaneFrame,
    /// Loops of the outline, counter-clockwise, and of its holes, clockwise.
    pub(super) loops: Vec<Vec<DVec2>>,
    /// Corners of the outline's box.
    pub(super) bounds: [DVec2; 2],
}

/// All facets of a scene.
#[derive(Debug, Default)]
pub(crate) struct Facets {
    list: Vec<Arc<Facet>>,
    /// Each mesh, and how many facets and triangles come before its own.
    meshes: Vec<(Arc<Mesh>, usize, usize)>,
    /// For each triangle of the scene, counted over its meshes, the facet that it is part of.
    of_triangle: Vec<u32>,
    /// Length of the diagonal of the box around all triangles.
    pub(super) scene_diagonal: f64,
    /// Corners of that box.
    pub(super) scene_bounds: [DVec3; 2],
    /// Where cube maps see much of the scene, once they have been sought: first the one that sees most.
    pub(super) places: OnceLock<Vec<Vec3>>,
}

/// A triangle without a facet.
const NONE: u32 = u32::MAX;

impl Facets {
    pub(crate) fn new(scene: &Scene) -> Self {
        Self::edited(scene, &Self::default())
    }

    /// Of a scene after edits: meshes that are what and where they were keep theirs.
    pub(crate) fn edited(scene: &Scene, earlier: &Self) -> Self {
        let of_mesh: Vec<Option<Vec<FlatFace>>> = scene
            .meshes
            .par_iter()
            .enumerate()
            .map(|(i, mesh)| earlier.place(i, mesh).is_none().then(|| flat_faces(mesh)))
            .collect();
        let (low, high) = scene.bounds().unwrap_or_default();
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let mut this = Self {
            scene_diagonal: (high - low).length(),
            scene_bounds: [low, high],
            ..Self::default()
        };
        for (i, (mesh, faces)) in scene.meshes.iter().zip(of_mesh).enumerate() {
            let (first_facet, first) = (this.list.len(), this.of_triangle.len());
            this.meshes.push((Arc::clone(mesh), first_facet, first));
            if let Some((facets, triangles)) = earlier.place(i, mesh) {
                this.list.extend_from_slice(&earlier.list[facets.clone()]);
                let renamed = |&facet: &u32| match facet {
                    NONE => NONE,
                    facet => facet - facets.start as u32 + first_facet as u32,
                };
                let of_triangle = earlier.of_triangle[triangles].iter().map(renamed);
                this.of_triangle.extend(of_triangle);
                continue;
            }
            this.of_triangle.resize(first + mesh.triangles.len(), NONE);
            for face in faces.unwrap_or_default() {
                for &triangle in &face.triangles {
                    this.of_triangle[first + triangle as usize] = this.list.len() as u32;
                }
                this.list.push(Arc::new(Facet::new(&face)));
            }
        }
        this
    }

    /// The facets and the triangles of a mesh, if it is the one that was there.
    fn place(&self, index: usize, mesh: &Arc<Mesh>) -> Option<(Range<usize>, Range<usize>)> {
        let (same, first_facet, first) = self.meshes.get(index)?;
        let (list, triangles) = (self.list.len(), self.of_triangle.len());
        let next = self.meshes.get(index + 1);
        let (last_facet, last) =
            next.map_or((list, triangles), |&(_, facet, first)| (facet, first));
        Arc::ptr_eq(same, mesh).then_some((*first_facet..last_facet, *first..last))
    }

    /// The index of the facet that a triangle is part of.
    pub(super) fn of(&self, triangle: u32) -> Option<u32> {
        let facet = *self.of_triangle.get(triangle as usize)?;
        (facet != NONE).then_some(facet)
    }

    pub(super) fn get(&self, facet: u32) -> &Facet {
        &self.list[facet as usize]
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }
}

impl Facet {
    fn new(face: &FlatFace) -> Self {
        let normal = DVec3::from(face.normal);
        let points = |vertices: &[[f64; 3]]| -> Vec<DVec3> {
            vertices.iter().map(|&v| DVec3::from(v)).collect()
        };
        let outer = face.loops.first().map_or(Vec::new(), |outer| points(outer));
        let following = outer.iter().cycle().skip(1);
        let longest = outer
            .iter()
            .zip(following)
            .map(|(&a, &b)| b - a)
            .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
            .unwrap_or_default();
        let origin = outer.first().copied().unwrap_or_default();
        let frame = PlaneFrame::along(origin, normal, longest);
        let flat = |vertices: &Vec<[f64; 3]>| {
            let vertices = points(vertices);
            vertices.into_iter().map(|v| frame.flat(v)).collect()
        };
        let loops: Vec<Vec<DVec2>> = face.loops.iter().map(flat).collect();
        Self {
            frame,
            bounds: bounds(loops.iter().flatten()),
            loops,
        }
    }
}
