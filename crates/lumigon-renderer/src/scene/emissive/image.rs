//! What a polygon light shows.

use glam::{DVec2, DVec3, Vec3, Vec4, Vec4Swizzles};
use lumigon::ImagePyramid;
use rayon::prelude::*;

use super::{Emitter, TextureMap, facet::Facet, mapping::Placement, resample};
use crate::scene::{AlphaMode, Filter, Texture, Wrap};

/// Texels a piece of texture may have to be searched for a second colour.
const SEARCHED: f64 = 1_048_576.0;
/// Parts of a texel that do not count in that search.
const ROUNDING: f64 = 1e-3;
/// Cells of a picture with hard borders, in texels' stead: borders between nearest texels, or where
/// alpha cuts, are straight lines that a coarser picture would blur ...
const SHARPER: u32 = 4;
/// ... unless it has this many cells a side already.
const SHARP: u32 = 256;
/// The least sine of the angle between the texture's axes on the light, to use them as the picture's.
const LEAST_SINE: f64 = 0.5;
/// Parts of a texel that a texture's axes may leave the picture's over its width.
const ALIGNED: f64 = 1.0 / 16.0;

/// A texture where it lies on a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedTexture {
    /// Index into [`crate::Scene::textures`].
    pub texture: usize,
    /// Where it lies.
    pub map: TextureMap,
}

/// Where a light's faces are there: where `alpha` times the texture's is at least `cutoff`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AlphaMask {
    /// The base colour's texture.
    pub placed: PlacedTexture,
    /// The material's and the vertices' alpha.
    pub alpha: f32,
    /// glTF's `alphaCutoff`.
    pub cutoff: f32,
}

/// What a polygon light shows, and the parallelogram of the picture that stands for it: the bounding
/// box of the outline along the texture's axes, or, where those are too slanted or do not lie on the
/// light's plane alike, along the plane's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissiveImage {
    /// The emissive texture; `None` where it shows one colour on all the light or there is none.
    pub emission: Option<PlacedTexture>,
    /// What the alpha mask leaves; `None` where that is all.
    pub mask: Option<AlphaMask>,
    /// Linear RGB radiance that the texture is multiplied with.
    pub strength: Vec3,
    /// The picture's upper left corner, world space.
    pub corner: [f64; 3],
    /// From there along its rows to their end.
    pub edge_u: [f64; 3],
    /// From there down its columns to their end.
    pub edge_v: [f64; 3],
    /// Cells across and down, powers of two: at least the texels that the light shows, unless that
    /// passes [`crate::Limits::light_image_side`].
    pub size: [u32; 2],
}

impl EmissiveImage {
    /// The image of one outline of a facet; `None` where it shows one colour.
    pub(super) fn new(
        emitter: &Emitter<'_>,
        facet: &Facet,
        loops: &[Vec<[f64; 3]>],
        longest_side: u32,
    ) -> Option<Self> {
        let placement = facet.placement.as_ref()?;
        let points: Vec<DVec3> = loops.iter().flatten().map(|&p| DVec3::from(p)).collect();
        let (emission, mask, strength) = shown(emitter, placement, &points);
        let driver = emission.or(mask.map(|mask| mask.placed))?.map;
        let parallelogram = aligned(&driver, facet.normal, &points)
            .unwrap_or_else(|| upright(&driver, facet, &points));
        let [corner, edge_u, edge_v] = parallelogram.map(|v| v.to_array());
        let mut image = Self {
            emission,
            mask,
            strength,
            corner,
            edge_u,
            edge_v,
            size: [1; 2],
        };
        let has_size = [edge_u, edge_v].map(DVec3::from).iter().all(|edge| {
            let length = edge.length();
            length > 0.0 && length.is_finite()
        });
        image.size = image.best_size(emitter.textures, longest_side);
        has_size.then_some(image)
    }

    /// What the light shows at a point of its plane, the strength left out: linear RGB, bilinear or
    /// the nearest texel as the texture's sampler says, black where the mask cuts.
    #[must_use]
    pub fn color(&self, textures: &[Texture], position: [f64; 3]) -> [f32; 3] {
        self.at(textures, DVec3::from(position)).to_array()
    }

    fn at(&self, textures: &[Texture], position: DVec3) -> Vec3 {
        if let Some(mask) = &self.mask {
            let alpha = mask.alpha * mask.placed.sample(textures, position).w;
            if alpha < mask.cutoff {
                return Vec3::ZERO;
            }
        }
        match &self.emission {
            Some(placed) => placed.sample(textures, position).xyz(),
            None => Vec3::ONE,
        }
    }

    /// The picture in cells, row by row from the corner: what the light shows on average over each,
    /// the strength left out, linear RGB. `textures` are the scene's.
    ///
    /// Along the texture's own axes averages are exact, and where cells are texels they are the
    /// texels. Otherwise, and with a mask, they are the mean of 4 to 64 samples a cell.
    #[must_use]
    pub fn cells(&self, textures: &[Texture], size: [u32; 2]) -> Vec<[f32; 3]> {
        let (corner, edge_u, edge_v) = (
            DVec3::from(self.corner),
            DVec3::from(self.edge_u),
            DVec3::from(self.edge_v),
        );
        let [width, height] = size.map(|side| side.max(1));
        if let Some((texture, [low, high])) = self.along_texture(textures) {
            return resample::averages(texture, low, high, [width, height]);
        }
        let [across, down] = [(edge_u, width), (edge_v, height)].map(|(edge, count)| {
            let texels = self.texels_along(textures, edge) / f64::from(count);
            let least = if self.mask.is_some() { 4.0 } else { 2.0 };
            // The cast saturates.
            (2.0 * texels).ceil().clamp(least, 8.0) as u32
        });
        let mut cells = vec![[0.0; 3]; width as usize * height as usize];
        let rows = cells.par_chunks_mut(width as usize).enumerate();
        rows.for_each(|(y, row)| {
            for (x, cell) in row.iter_mut().enumerate() {
                let mut sum = Vec3::ZERO;
                for j in 0..down {
                    let v = y as f64 + (f64::from(j) + 0.5) / f64::from(down);
                    let start = corner + edge_v * (v / f64::from(height));
                    for i in 0..across {
                        let u = x as f64 + (f64::from(i) + 0.5) / f64::from(across);
                        sum += self.at(textures, start + edge_u * (u / f64::from(width)));
                    }
                }
                *cell = (sum / (across * down) as f32).to_array();
            }
        });
        cells
    }

    /// The texture and its coordinates at the first and the last corner, where the picture lies along
    /// it and nothing is cut out.
    fn along_texture<'a>(&self, textures: &'a [Texture]) -> Option<(&'a Texture, [[f64; 2]; 2])> {
        let (Some(placed), None) = (&self.emission, &self.mask) else {
            return None;
        };
        let texture = &textures[placed.texture];
        let [u, v] = [self.edge_u, self.edge_v].map(|edge| placed.map.change(DVec3::from(edge)));
        let slant = [
            u.y * f64::from(texture.height),
            v.x * f64::from(texture.width),
        ];
        let low = placed.map.at(DVec3::from(self.corner));
        let high = low + DVec2::new(u.x, v.y);
        let is_along = slant.iter().all(|x| x.abs() <= ALIGNED);
        is_along.then(|| (texture, [low.to_array(), high.to_array()]))
    }

    /// The mean radiance of an outline that fills the picture: exact, and quicker than along the cells
    /// that an outline cuts. `None` for other outlines.
    pub(super) fn mean_of_all(
        &self,
        textures: &[Texture],
        loops: &[Vec<[f64; 3]>],
    ) -> Option<Vec3> {
        let (texture, [low, high]) = self.along_texture(textures)?;
        let whole = DVec3::from(self.edge_u).cross(DVec3::from(self.edge_v));
        let area = super::area_vector(loops);
        let fills = (area.length() - whole.length()).abs() <= 1e-6 * whole.length();
        let mean = || resample::mean(texture, low, high);
        fills.then(|| (self.strength * mean()).min(Vec3::splat(f32::MAX)))
    }

    /// Bytes of the picture's prefiltered pyramid: four single-precision numbers a cell, on all levels.
    #[must_use]
    pub fn pyramid_bytes(&self) -> u64 {
        ImagePyramid::bytes(self.size)
    }

    /// How many texels the light shows, where its picture has fewer cells.
    pub(super) fn shown_smaller(&self, textures: &[Texture]) -> Option<[u64; 2]> {
        let texels = [self.edge_u, self.edge_v]
            .map(|edge| (self.texels_along(textures, DVec3::from(edge)) - ALIGNED).ceil() as u64);
        let is_smaller = (0..2).any(|k| texels[k] > u64::from(self.size[k]));
        is_smaller.then_some(texels)
    }

    fn best_size(&self, textures: &[Texture], longest_side: u32) -> [u32; 2] {
        let longest = 1 << longest_side.clamp(1, 1 << 14).ilog2();
        let nearest =
            |placed: &PlacedTexture| textures[placed.texture].sampler.filter == Filter::Nearest;
        let is_hard = self.mask.is_some() || self.emission.as_ref().is_some_and(nearest);
        [self.edge_u, self.edge_v].map(|edge| {
            let texels = self.texels_along(textures, DVec3::from(edge));
            // The cast saturates.
            let texels = (texels - ALIGNED).ceil().clamp(1.0, f64::from(longest)) as u32;
            let cells = texels.next_power_of_two();
            let sharper = if is_hard {
                (cells * SHARPER).min(cells.max(SHARP))
            } else {
                cells
            };
            sharper.min(longest)
        })
    }

    /// How many texels of a texture a vector passes: the most of the two textures.
    fn texels_along(&self, textures: &[Texture], vector: DVec3) -> f64 {
        let mask = self.mask.map(|mask| mask.placed);
        let placed = [self.emission, mask].into_iter().flatten();
        placed
            .map(|placed| {
                let texture = &textures[placed.texture];
                (placed.map.change(vector) * size_of(texture)).length()
            })
            .fold(0.0, f64::max)
    }
}

impl PlacedTexture {
    fn sample(&self, textures: &[Texture], position: DVec3) -> Vec4 {
        let texture = &textures[self.texture];
        let uv = self.map.at(position);
        // Whole repeats are taken off before precision is.
        let near = |x: f64, wrap| match wrap {
            Wrap::Repeat => x - x.floor(),
            Wrap::MirroredRepeat => x - 2.0 * (0.5 * x).floor(),
            Wrap::ClampToEdge => x,
        };
        let uv = DVec2::new(
            near(uv.x, texture.sampler.wrap_s),
            near(uv.y, texture.sampler.wrap_t),
        );
        texture.sample(uv.as_vec2())
    }

    /// The one texel value under all of these points, or `None` where there are several or too many
    /// texels to tell.
    fn constant<T: PartialEq>(
        &self,
        textures: &[Texture],
        points: &[DVec3],
        of: impl Fn(Vec4) -> T,
    ) -> Option<T> {
        let texture = &textures[self.texture];
        let (low, high) = self.bounds(points);
        if ((high - low) * size_of(texture)).max_element() <= ROUNDING {
            return points.first().map(|&p| of(self.sample(textures, p)));
        }
        // Bilinear weights reach the next texels' centres.
        let centre = match texture.sampler.filter {
            Filter::Linear => 0.5,
            Filter::Nearest => 0.0,
        };
        let span = |low: f64, high: f64, size: u32, wrap| {
            let texels = f64::from(size);
            let (low, high) = (low * texels - centre, high * texels - centre);
            let (low, high) = match texture.sampler.filter {
                Filter::Linear => ((low + ROUNDING).floor(), (high - ROUNDING).ceil()),
                Filter::Nearest => ((low + ROUNDING).floor(), (high - ROUNDING).floor()),
            };
            let high = high.max(low);
            let period = match wrap {
                Wrap::MirroredRepeat => 2.0 * texels,
                _ => texels,
            };
            match wrap {
                Wrap::ClampToEdge => (low.clamp(0.0, texels - 1.0), high.clamp(0.0, texels - 1.0)),
                _ => (low, high.min(low + period - 1.0)),
            }
        };
        let (left, right) = span(low.x, high.x, texture.width, texture.sampler.wrap_s);
        let (top, bottom) = span(low.y, high.y, texture.height, texture.sampler.wrap_t);
        let count = (right - left + 1.0) * (bottom - top + 1.0);
        // Nor where it is NaN.
        let is_small = count <= SEARCHED;
        if !is_small {
            return None;
        }
        let first = of(texture.wrapped_texel(left as i64, top as i64));
        let same = (top as i64..=bottom as i64).all(|y| {
            (left as i64..=right as i64).all(|x| of(texture.wrapped_texel(x, y)) == first)
        });
        same.then_some(first)
    }

    /// The smallest and largest texture coordinates of points.
    fn bounds(&self, points: &[DVec3]) -> (DVec2, DVec2) {
        bounds(points.iter().map(|&p| self.map.at(p)))
    }
}

/// What varies on a light, and its strength times what does not.
fn shown(
    emitter: &Emitter<'_>,
    placement: &Placement,
    points: &[DVec3],
) -> (Option<PlacedTexture>, Option<AlphaMask>, Vec3) {
    let (material, textures) = (emitter.material, emitter.textures);
    let placed = |k: usize, reference: &Option<crate::scene::TextureRef>| {
        let (map, reference) = (placement.maps[k]?, reference.as_ref()?);
        let texture = reference.texture;
        Some(PlacedTexture { texture, map })
    };
    let mut strength = material.emissive;
    let mut emission = placed(0, &material.emissive_texture);
    if emission.is_none()
        && let Some(reference) = &material.emissive_texture
    {
        // One colour everywhere.
        strength *= textures[reference.texture].texel(0, 0).xyz();
    }
    let color = emission.and_then(|placed| placed.constant(textures, points, Vec4Swizzles::xyz));
    if let Some(color) = color {
        (emission, strength) = (None, strength * color);
    }
    let AlphaMode::Mask { cutoff } = material.alpha_mode else {
        return (emission, None, strength);
    };
    let mask = placed(1, &material.base_color_texture).map(|placed| AlphaMask {
        placed,
        alpha: material.base_color.w * placement.alpha,
        cutoff,
    });
    // A mask that cuts all is a light without radiance, which is none.
    let mask = mask.filter(|mask| {
        let is_there = |texel: Vec4| mask.alpha * texel.w >= mask.cutoff;
        mask.placed.constant(textures, points, is_there) != Some(true)
    });
    (emission, mask, strength)
}

/// The bounding box of points along the texture's axes: its corner and edges. `None` where the axes
/// are too slanted.
fn aligned(map: &TextureMap, normal: DVec3, points: &[DVec3]) -> Option<[DVec3; 3]> {
    let [gu, gv] = map.gradients.map(DVec3::from);
    let determinant = normal.dot(gu.cross(gv));
    let spans = determinant.abs() >= LEAST_SINE * gu.length() * gv.length();
    if !spans || determinant == 0.0 {
        return None;
    }
    // Along them one coordinate grows by 1 and the other stays.
    let (along_u, along_v) = (
        gv.cross(normal) / determinant,
        normal.cross(gu) / determinant,
    );
    let (low, high) = bounds(points.iter().map(|&p| map.at(p)));
    let (point, from) = (DVec3::from(map.point), low - DVec2::from(map.uv));
    let frame = [
        point + along_u * from.x + along_v * from.y,
        along_u * (high.x - low.x),
        along_v * (high.y - low.y),
    ];
    frame.iter().all(|v| v.is_finite()).then_some(frame)
}

/// The bounding box of points along the plane's own axes, one of them along the texture's steepest.
fn upright(map: &TextureMap, facet: &Facet, points: &[DVec3]) -> [DVec3; 3] {
    let [gu, gv] = map.gradients.map(DVec3::from);
    let steepest = if gu.length() >= gv.length() { gu } else { gv };
    let across = steepest
        .try_normalize()
        .unwrap_or_else(|| facet.normal.any_orthonormal_vector());
    let down = facet.normal.cross(across);
    let (low, high) = bounds(points.iter().map(|&p| {
        let from = p - facet.center;
        DVec2::new(from.dot(across), from.dot(down))
    }));
    [
        facet.center + across * low.x + down * low.y,
        across * (high.x - low.x),
        down * (high.y - low.y),
    ]
}

fn bounds(points: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    })
}

fn size_of(texture: &Texture) -> DVec2 {
    DVec2::new(f64::from(texture.width), f64::from(texture.height))
}

#[cfg(test)]
mod tests;
