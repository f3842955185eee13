//! Pictures of lights, finished beside the work that goes on.

use std::sync::Arc;

use glam::{DAffine2, DVec2, DVec3, Vec3};
use lumigon_renderer::{
    AlphaMask, AlphaMode, EmissiveImage, EmissivePolygon, Limits, Material, Mesh, PlacedTexture,
    Scene, TextureMap, TextureRef,
};

use super::faces::{affine, is_masked};
use super::patch::put_polygons;
use super::{Document, Light, Polygons};

/// Cells along a side of a picture that is not finished.
const COARSE_SIDE: f64 = 64.0;
/// Samples for the mean of one.
const COARSE_SAMPLES: f64 = 1024.0;
/// The least sine of the angle between a texture's axes on a light, to use them as the picture's.
const LEAST_SINE: f64 = 0.5;

/// Whether the lights of a mesh take more time than an outline does.
pub(super) fn is_slow(scene: &Scene, mesh: usize) -> bool {
    let material = &scene.materials[scene.meshes[mesh].material];
    material.is_emissive() && (material.emissive_texture.is_some() || is_masked(material))
}

/// The polygons of a light on its own mesh in a fraction of a millisecond: their pictures have few cells, and their
/// mean radiance is sampled. `None` where its textures do not lie on it in one piece.
pub(super) fn coarse(scene: &Scene, mesh: usize, light: &Light) -> Option<Vec<EmissivePolygon>> {
    let own = &scene.meshes[mesh];
    let material = &scene.materials[own.material];
    let placed = |reference: &TextureRef, texture_from_plane: DAffine2| PlacedTexture {
        texture: reference.texture,
        map: texture_map(light, texture_from_plane),
    };
    let emission = match (&material.emissive_texture, &light.picture) {
        (Some(reference), Some(picture)) => Some(placed(reference, picture.texture_from_plane)),
        (Some(_), None) => return None,
        (None, _) => None,
    };
    let mask = match (material.alpha_mode, &material.base_color_texture) {
        (AlphaMode::Mask { cutoff }, Some(reference)) => {
            let texcoord_from_plane = light.surface.texcoords_from_plane[reference.texcoord]?;
            Some(AlphaMask {
                placed: placed(
                    reference,
                    affine(&reference.transform) * texcoord_from_plane,
                ),
                alpha: material.base_color.w * light.surface.color.map_or(1.0, |color| color.w),
                cutoff,
            })
        }
        // All of it is there, or nothing: for the fine one to tell.
        (AlphaMode::Mask { .. }, None) => return None,
        _ => None,
    };

    // The outlines, as of a light of one colour.
    let plain = Scene {
        meshes: vec![Arc::new(Mesh {
            material: 0,
            texcoords: Default::default(),
            ..Mesh::clone(own)
        })],
        materials: vec![Material {
            emissive: light.radiance,
            double_sided: light.two_sided,
            ..Material::default()
        }],
        ..Scene::default()
    };
    let (mut polygons, _) = plain.lights_of_mesh(0, &Limits::default());
    for polygon in &mut polygons {
        polygon.mesh = mesh;
        let map = emission.or(mask.map(|mask| mask.placed))?.map;
        let [corner, edge_u, edge_v] = parallelogram(light, &map, polygon);
        let mut image = EmissiveImage {
            emission,
            mask,
            strength: light.radiance,
            corner: corner.to_array(),
            edge_u: edge_u.to_array(),
            edge_v: edge_v.to_array(),
            size: [1; 2],
        };
        image.size = [edge_u, edge_v].map(|edge| {
            let texels = |placed: PlacedTexture| {
                let texture = &scene.textures[placed.texture];
                let [u, v] = placed.map.gradients.map(|g| DVec3::from(g).dot(edge));
                (u * f64::from(texture.width)).hypot(v * f64::from(texture.height))
            };
            let placed = [emission, mask.map(|mask| mask.placed)];
            let most = placed.into_iter().flatten().map(texels).fold(1.0, f64::max);
            // The cast saturates.
            (most.min(COARSE_SIDE) as u32).next_power_of_two()
        });
        polygon.radiance = light.radiance * mean(scene, own, polygon, &image);
        polygon.image = Some(image);
    }
    polygons.retain(|polygon| polygon.radiance.max_element() > 0.0);
    Some(polygons)
}

/// Where a texture lies on a light, in the world.
fn texture_map(light: &Light, texture_from_plane: DAffine2) -> TextureMap {
    let frame = light.world_from_plane;
    let rows = texture_from_plane.matrix2.transpose();
    let gradient = |row: DVec2| (frame.matrix3 * row.extend(0.0)).to_array();
    TextureMap {
        point: frame.translation.to_array(),
        uv: texture_from_plane.translation.to_array(),
        gradients: [gradient(rows.x_axis), gradient(rows.y_axis)],
    }
}

/// The box around a polygon along the texture's axes or, where those are too slanted, the plane's: its
/// corner and its edges.
fn parallelogram(light: &Light, map: &TextureMap, polygon: &EmissivePolygon) -> [DVec3; 3] {
    let [gu, gv] = map.gradients.map(DVec3::from);
    let normal = light.normal();
    let determinant = normal.dot(gu.cross(gv));
    let spans = determinant.abs() >= LEAST_SINE * gu.length() * gv.length() && determinant != 0.0;
    let [along_u, along_v] = if spans {
        [
            gv.cross(normal) / determinant,
            normal.cross(gu) / determinant,
        ]
    } else {
        [
            light.world_from_plane.matrix3.x_axis,
            -light.world_from_plane.matrix3.y_axis,
        ]
    };
    let origin = DVec3::from(map.point);
    // The reciprocal basis in the plane.
    let doubled = along_u.cross(along_v).dot(normal);
    let coordinates = |p: &[f64; 3]| {
        let p = DVec3::from(*p) - origin;
        DVec2::new(
            p.cross(along_v).dot(normal) / doubled,
            along_u.cross(p).dot(normal) / doubled,
        )
    };
    let points = polygon.loops.iter().flatten().map(coordinates);
    let (low, high) = points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    [
        origin + along_u * low.x + along_v * low.y,
        along_u * (high.x - low.x),
        along_v * (high.y - low.y),
    ]
}

/// About the mean colour that a polygon shows.
fn mean(scene: &Scene, mesh: &Mesh, polygon: &EmissivePolygon, image: &EmissiveImage) -> Vec3 {
    let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
    let whole = polygon.area();
    for &t in &polygon.triangles {
        let [a, b, c] = mesh.corners(t as usize).map(|p| p.as_dvec3());
        let area = 0.5 * (b - a).cross(c - a).length();
        // Parts along each side, so that all triangles have samples as dense.
        let parts = (COARSE_SAMPLES * area / whole)
            .sqrt()
            .ceil()
            .clamp(1.0, 64.0);
        let count = parts as u32;
        let mut of_triangle = DVec3::ZERO;
        for i in 0..count {
            for j in 0..count {
                // A square folded into the triangle.
                let u = (f64::from(i) + 0.5) / parts;
                let v = (f64::from(j) + 0.5) / parts;
                let root = u.sqrt();
                let p = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
                let color = image.color(&scene.textures, p.to_array());
                of_triangle += Vec3::from(color).as_dvec3();
            }
        }
        sum += of_triangle * (area / (parts * parts));
        weight += area;
    }
    (sum / weight).as_vec3()
}

/// The work of finishing the pictures of lights that were changed, for another thread.
#[derive(Debug)]
pub struct ImageJob {
    scene: Arc<Scene>,
    limits: Limits,
    coarse: Vec<(usize, Arc<[EmissivePolygon]>)>,
}

/// What an [`ImageJob`] made.
#[derive(Debug)]
pub struct FinishedImages(Vec<Finished>);

#[derive(Debug)]
struct Finished {
    mesh: usize,
    coarse: Arc<[EmissivePolygon]>,
    fine: Arc<[EmissivePolygon]>,
}

impl ImageJob {
    /// Does the work: milliseconds and more for large images.
    #[must_use]
    pub fn run(self) -> FinishedImages {
        let finish = |(mesh, coarse)| Finished {
            mesh,
            coarse,
            fine: self.scene.lights_of_mesh(mesh, &self.limits).0.into(),
        };
        FinishedImages(self.coarse.into_iter().map(finish).collect())
    }
}

impl<S: Clone + PartialEq> Document<S> {
    /// The work that pictures of lights still need, for another thread; its result is for
    /// [`Document::apply_images`]. `None` where all are finished, and while a gesture goes on.
    #[must_use]
    pub fn finish_images(&self) -> Option<ImageJob> {
        let is_coarse = |(_, polygons): &(&usize, &Polygons)| !polygons.finished;
        let coarse = self.polygons.iter().filter(is_coarse);
        let coarse: Vec<_> = coarse
            .map(|(&mesh, polygons)| (mesh, Arc::clone(&polygons.list)))
            .collect();
        (self.gesture.is_none() && !coarse.is_empty()).then(|| ImageJob {
            scene: Arc::clone(&self.scene),
            limits: self.limits,
            coarse,
        })
    }

    /// Shows finished pictures where the lights are still those they were made for. Whether any were:
    /// no step, and nothing to save.
    pub fn apply_images(&mut self, finished: FinishedImages) -> bool {
        let mut scene = None;
        for Finished { mesh, coarse, fine } in finished.0 {
            let renew = |polygons: &mut Polygons| {
                let is_same = Arc::ptr_eq(&polygons.list, &coarse);
                if is_same {
                    polygons.list = Arc::clone(&fine);
                    polygons.finished = true;
                }
                is_same
            };
            // Steps that come back to it need no other work.
            let gesture = self.gesture.iter_mut();
            let patches = gesture.flat_map(|step| [&mut step.before, &mut step.after]);
            for patch in self.history.patches().chain(patches) {
                patch.polygons.get_mut(&mesh).map(renew);
            }
            if self.polygons.get_mut(&mesh).is_some_and(renew) {
                let scene = scene.get_or_insert_with(|| Scene::clone(&self.scene));
                put_polygons(scene, mesh, &fine);
            }
        }
        let is_current = scene.is_some();
        if let Some(scene) = scene {
            self.scene = Arc::new(scene);
            self.version += 1;
        }
        is_current
    }
}
