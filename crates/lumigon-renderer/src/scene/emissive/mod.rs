//! Emissive faces to polygon lights.
//!
//! The triangles of one mesh are welded by position, split where a vertex of one lies on an edge of
//! another, gathered into flat facets that each show one picture, and each facet is replaced by its
//! outline and that picture.

mod facet;
mod flat_face;
mod image;
mod junction;
mod mapping;
mod outline;
mod replacement;
mod resample;
mod texture_map;
mod texture_mean;
mod weld;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Limits, Material, Mesh, Scene, Texture, error::Fault};
pub(crate) use flat_face::{FlatFace, flat_faces};
pub use image::{AlphaMask, EmissiveImage, PlacedTexture};
use mapping::Mapping;
pub use texture_map::TextureMap;
use texture_mean::TextureMean;

/// Pictures that one mesh may fall apart into. Beyond, its lights show their mean colours: they are
/// small already, or their texture is.
const MOST_PICTURES: usize = 4096;

/// A flat light: the outline of connected coplanar emissive triangles, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct EmissivePolygon {
    /// The name of the mesh.
    pub name: String,
    /// The outer loop, counter-clockwise seen from the emitting side, then the holes, clockwise.
    /// All vertices lie in one plane. Loops are simple but may touch each other at vertices.
    pub loops: Vec<Vec<[f64; 3]>>,
    /// Linear RGB radiance; with an emissive texture or an alpha mask, its mean over the polygon's
    /// area.
    pub radiance: Vec3,
    /// What it shows, where that is more than one colour.
    pub image: Option<EmissiveImage>,
    /// It emits from its back too.
    pub two_sided: bool,
    /// Index into [`super::Scene::meshes`] of the faces themselves.
    pub mesh: usize,
    /// Indices into [`Mesh::triangles`] of the faces themselves.
    pub triangles: Vec<u32>,
}

impl EmissivePolygon {
    /// The area vector: half the sum of the loops' cross products. Its direction is the side the
    /// polygon emits to, its length the area, holes taken off.
    #[must_use]
    pub fn area_vector(&self) -> [f64; 3] {
        area_vector(&self.loops).to_array()
    }

    /// The area in square metres, holes taken off.
    #[must_use]
    pub fn area(&self) -> f64 {
        DVec3::from(self.area_vector()).length()
    }

    /// The number of vertices of all loops.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.loops.iter().map(Vec::len).sum()
    }

    /// The number of holes.
    #[must_use]
    pub fn hole_count(&self) -> usize {
        self.loops.len().saturating_sub(1)
    }
}

/// Half the sum of the loops' cross products.
fn area_vector(loops: &[Vec<[f64; 3]>]) -> DVec3 {
    let origin = loops.first().and_then(|outer| outer.first());
    let origin = origin.map_or(DVec3::ZERO, |&p| DVec3::from(p));
    let mut sum = DVec3::ZERO;
    for vertices in loops {
        for (i, &a) in vertices.iter().enumerate() {
            let b = vertices[(i + 1) % vertices.len()];
            sum += (DVec3::from(a) - origin).cross(DVec3::from(b) - origin);
        }
    }
    sum * 0.5
}

/// An emissive mesh before its positions were rounded to f32.
pub(super) struct Emitter<'a> {
    pub(super) mesh: &'a Mesh,
    /// The mesh's index in the scene.
    pub(super) index: usize,
    /// World-space positions, one for each of the mesh's.
    pub(super) positions: &'a [DVec3],
    /// How far rounding in the file may have moved a position, in metres.
    pub(super) noise: f64,
    pub(super) material: &'a Material,
    pub(super) textures: &'a [Texture],
}

/// An emissive mesh's lights, and what is to be said about them.
pub(super) struct Emitted {
    pub(super) polygons: Vec<EmissivePolygon>,
    pub(super) warnings: Vec<String>,
}

impl Emitter<'_> {
    /// The polygons that stand for the mesh's faces, largest facet first, their pictures at most
    /// `longest_side` cells a side.
    ///
    /// Facets whose emissive texture is black or cut out are left out, as are triangles narrower than
    /// the noise. Triangles with the same three corners count once.
    pub(super) fn polygons(&self, longest_side: u32) -> Emitted {
        let welded = weld::weld(self.positions, &self.mesh.triangles, self.noise);
        let edges = junction::edges(&welded);
        let mapping = Mapping::new(self);
        let mut facets = facet::facets(&welded, &edges, self.noise, mapping.as_ref());
        let mut warnings = Vec::new();
        if mapping.is_some() && facets.len() > MOST_PICTURES {
            warnings.push(format!(
                "mesh \"{}\" shows its texture in {} flat pieces, more than {MOST_PICTURES}: its \
                 lights have their mean colours; use fewer faces, or texture coordinates that join",
                self.mesh.name,
                facets.len()
            ));
            facets = facet::facets(&welded, &edges, self.noise, None);
        }
        let boundaries = outline::boundaries(&edges, &facets, welded.triangles.len());
        let mean = TextureMean::new(self);
        let of_facet = |(facet, boundary): (&facet::Facet, &Vec<(u32, u32)>)| {
            let sources = |triangles: &[u32]| -> Vec<u32> {
                triangles.iter().flat_map(|&t| welded.sources(t)).collect()
            };
            let outlines = outline::outlines(&welded, boundary, facet, self.noise);
            let image = |outline: &outline::Outline| {
                EmissiveImage::new(self, facet, &outline.loops, longest_side)
            };
            let images: Vec<_> = outlines.iter().map(image).collect();
            let whole = match (images.as_slice(), outlines.as_slice()) {
                ([Some(image)], [outline]) => image.mean_of_all(self.textures, &outline.loops),
                _ => None,
            };
            let radiance = whole.unwrap_or_else(|| mean.radiance(&sources(&facet.triangles)));
            if radiance.max_element() <= 0.0 {
                return Vec::new();
            }
            let polygon = |(outline, image): (outline::Outline, _)| EmissivePolygon {
                name: self.mesh.name.clone(),
                image,
                loops: outline.loops,
                radiance,
                two_sided: self.material.double_sided,
                mesh: self.index,
                triangles: sources(&outline.triangles),
            };
            outlines
                .into_iter()
                .zip(images)
                .map(polygon)
                .collect::<Vec<_>>()
        };
        let pairs = facets.par_iter().zip(&boundaries);
        let polygons: Vec<EmissivePolygon> = pairs.flat_map_iter(of_facet).collect();
        let images = polygons.iter().filter_map(|polygon| polygon.image);
        let smaller = images.filter_map(|image| Some((image, image.shown_smaller(self.textures)?)));
        // One speaks for all of the mesh.
        if let Some((image, [columns, rows])) = smaller.into_iter().next() {
            let [width, height] = image.size;
            warnings.push(format!(
                "light \"{}\" shows {columns} × {rows} texels, its picture {width} × {height}: mirrors \
                 and smooth surfaces see less than there is; raise the limit of {longest_side} a side",
                self.mesh.name
            ));
        }
        Emitted { polygons, warnings }
    }
}

impl Scene {
    /// The lights that the faces of one mesh make, as loading makes them, and what is to be said about
    /// them; none where its material does not emit. [`Scene::polygon_lights`] is left as it is: put them
    /// there in the place of the mesh's others.
    ///
    /// # Panics
    /// Where there is no such mesh, or the mesh's indices are out of range.
    #[must_use]
    pub fn lights_of_mesh(
        &self,
        mesh: usize,
        limits: &Limits,
    ) -> (Vec<EmissivePolygon>, Vec<String>) {
        let index = mesh;
        let mesh = &self.meshes[index];
        let material = &self.materials[mesh.material];
        if !material.is_emissive() {
            return Default::default();
        }
        let emitted = of_mesh(mesh, index, material, &self.textures, limits);
        (emitted.polygons, emitted.warnings)
    }
}

/// The lights of a mesh whose positions are known in single precision only.
fn of_mesh(
    mesh: &Mesh,
    index: usize,
    material: &Material,
    textures: &[Texture],
    limits: &Limits,
) -> Emitted {
    let positions: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
    let largest = mesh.positions.iter().map(|p| p.abs().max_element());
    let largest = f64::from(largest.fold(0.0, f32::max));
    Emitter {
        mesh,
        index,
        positions: &positions,
        // Each coordinate is off by half a unit in the last place.
        noise: largest * f64::from(f32::EPSILON),
        material,
        textures,
    }
    .polygons(limits.light_image_side)
}

/// Takes the pyramids of lights' pictures from a budget, or says which does not fit.
pub(super) fn take_pyramids(
    polygons: &[EmissivePolygon],
    limits: &Limits,
    bytes_left: &mut u64,
) -> Result<(), Fault> {
    for polygon in polygons {
        let Some(image) = &polygon.image else {
            continue;
        };
        let needed = image.pyramid_bytes();
        *bytes_left = bytes_left.checked_sub(needed).ok_or_else(|| {
            let [width, height] = image.size;
            Fault::new(
                format!("light \"{}\"", polygon.name),
                format!(
                    "its picture of {width} × {height} texels needs {needed} bytes, {bytes_left} of \
                     {} for the pictures of lights are left",
                    limits.light_image_bytes
                ),
                "show smaller images on lights, or raise the limit (--image-budget)",
            )
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
