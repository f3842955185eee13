//! Pictures of lights, finished beside the work that goes on.

use std::sync::Arc;

use glam::{DAffine2, DVec2, DVec3, Vec3};
use lumigon_renderer::{
    AlphaMask, AlphaMode, EmissiveImage, EmissivePolygon, Limits, Material, Mesh, PlacedTexture,
    Scene, TextureMap, TextureRef,
};

use super::faces::{affine, is_masked};
use super::patch::Patch;
use super::{Document, Light, Polygons};

/// Cells along a side of a picture that is not finished.
const COARSE_SIDE: f64 = 64.0;
/// Samples for the mean of one.
const COARSE_SAMPLES: f64 = 1024.0;
/// The least sine of the angle between a texture's axes on a light, to use them as the picture's.
const LEAST_SINE: f64 = 0.5;

/// Whether lights of a material take more time than their outlines do.
pub(super) fn is_slow(material: &Material) -> bool {
    material.is_emissive() && (material.emissive_texture.is_some() || is_masked(material))
}

/// The polygons of a light that was only moved, turned or coloured, from those it had: no image is read.
/// `own` is its mesh now, the one of index `mesh`. `None` where more has changed.
pub(super) fn moved(
    [before, after]: [&Light; 2],
    [old, own]: [&Mesh; 2],
    polygons: &[EmissivePolygon],
    mesh: usize,
) -> Option<Vec<EmissivePolygon>> {
    let is_same = before.loops == after.loops
        && before.picture == after.picture
        && before.surface == after.surface;
    // A polygon of the file is alone on its mesh now.
    let was_own = polygons.iter().all(|polygon| polygon.mesh == mesh);
    let keeps_triangles = if was_own {
        old.triangles == own.triangles
    } else {
        polygons.len() == 1
    };
    // What was dark may show anything.
    let was_lit = before.radiance.cmpgt(Vec3::ZERO) | after.radiance.cmple(Vec3::ZERO);
    let is_lit = !polygons.is_empty() && after.radiance.max_element() > 0.0 && was_lit.all();
    if !is_same || !keeps_triangles || !is_lit {
        return None;
    }
    let ratio = after.radiance / before.radiance;
    let brighter = Vec3::select(before.radiance.cmpgt(Vec3::ZERO), ratio, Vec3::ONE);
    let new_from_old = after.world_from_plane * before.world_from_plane.inverse();
    let move_point = |p: &mut [f64; 3]| *p = new_from_old.transform_point3((*p).into()).to_array();
    let turn = |v: &mut [f64; 3]| *v = new_from_old.transform_vector3((*v).into()).to_array();
    let move_map = |map: &mut TextureMap| {
        move_point(&mut map.point);
        map.gradients.iter_mut().for_each(turn);
    };
    let mut polygons = polygons.to_vec();
    for polygon in &mut polygons {
        if !was_own {
            polygon.triangles = (0..own.triangles.len() as u32).collect();
        }
        polygon.name.clone_from(&after.name);
        polygon.mesh = mesh;
        polygon.two_sided = after.two_sided;
        polygon.radiance *= brighter;
        polygon.loops.iter_mut().flatten().for_each(move_point);
        if let Some(image) = &mut polygon.image {
            image.strength = after.radiance;
            move_point(&mut image.corner);
            turn(&mut image.edge_u);
            turn(&mut image.edge_v);
            if let Some(placed) = &mut image.emission {
                move_map(&mut placed.map);
            }
            if let Some(mask) = &mut image.mask {
                move_map(&mut mask.placed.map);
            }
        }
    }
    Some(polygons)
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
        let [a, b, c] = mesh.corners(t as usize).map(Vec3::as_dvec3);
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
pub struct FinishedImages {
    scene: Arc<Scene>,
    finished: Vec<Finished>,
}

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
        let bytes = |lights: &[EmissivePolygon]| -> u64 {
            let images = lights.iter().filter_map(|light| light.image.as_ref());
            images.map(EmissiveImage::pyramid_bytes).sum()
        };
        let coarse: u64 = self.coarse.iter().map(|(_, lights)| bytes(lights)).sum();
        let others = bytes(&self.scene.polygon_lights).saturating_sub(coarse);
        let mut bytes_left = self.limits.light_image_bytes.saturating_sub(others);
        let finish = |(mesh, coarse)| {
            let (mut fine, _) = self.scene.lights_of_mesh(mesh, &self.limits);
            // Many large pictures are shown smaller rather than not at all.
            let mut side = self.limits.light_image_side;
            while bytes(&fine) > bytes_left && side > COARSE_SIDE as u32 {
                side /= 2;
                for image in fine.iter_mut().filter_map(|light| light.image.as_mut()) {
                    image.size = image.size.map(|cells| cells.min(side.max(1)));
                }
            }
            bytes_left = bytes_left.saturating_sub(bytes(&fine));
            Finished {
                mesh,
                coarse,
                fine: fine.into(),
            }
        };
        FinishedImages {
            finished: self.coarse.into_iter().map(finish).collect(),
            scene: self.scene,
        }
    }
}

impl FinishedImages {
    /// The scene that the work was given, with the pictures finished: for a renderer to filter them before
    /// the document shows them.
    #[must_use]
    pub fn scene(&self) -> Scene {
        let mut scene = Scene::clone(&self.scene);
        let is_other = |light: &EmissivePolygon| {
            let mut meshes = self.finished.iter().map(|finished| finished.mesh);
            !meshes.any(|mesh| mesh == light.mesh)
        };
        scene.polygon_lights.retain(is_other);
        let fine = self.finished.iter().flat_map(|finished| finished.fine.iter());
        scene.polygon_lights.extend(fine.cloned());
        scene.polygon_lights.sort_by_key(|light| light.mesh);
        scene
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
        let mut patch = Patch::default();
        for Finished { mesh, coarse, fine } in finished.finished {
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
            if let Some(polygons) = self.polygons.get_mut(&mesh)
                && renew(polygons)
            {
                patch.polygons.insert(mesh, polygons.clone());
            }
        }
        let is_current = patch.changes_scene();
        if is_current {
            let mut scene = self.own_scene();
            patch.change_polygons(&mut scene);
            self.show(Arc::new(scene), &patch);
        }
        is_current
    }
}
