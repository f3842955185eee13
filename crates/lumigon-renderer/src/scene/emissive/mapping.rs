//! Which neighbouring triangles show one picture.
//!
//! The texture coordinates of a triangle are an affine map on its plane. Triangles of one plane show
//! one picture where one map serves all of them: theirs may differ by whole repeats of the texture.

use glam::{DVec2, DVec3};

use super::{Emitter, texture_map::TextureMap, weld::Welded};
use crate::scene::{AlphaMode, Texture, TextureRef, Wrap};

/// How far a corner's texture coordinates may lie from the common map, in texels, beside what
/// rounding explains.
const TOLERANCE: f64 = 0.25;
/// Beyond this many texels from the origin, single precision cannot tell one from the next.
const FARTHEST: f64 = 4_194_304.0;

/// The textures that decide what an emissive mesh shows.
pub(super) struct Mapping<'a> {
    emitter: &'a Emitter<'a>,
    /// The emissive texture, and the base colour's where its alpha cuts faces out.
    layers: [Option<Layer<'a>>; 2],
    has_mask: bool,
}

struct Layer<'a> {
    reference: &'a TextureRef,
    texture: &'a Texture,
}

/// Where the textures lie on a facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    /// Those of [`Mapping::layers`]; `None` where there is no such texture.
    pub(super) maps: [Option<TextureMap>; 2],
    /// The alpha that its vertices multiply with.
    pub(super) alpha: f32,
}

impl<'a> Mapping<'a> {
    /// `None` where no texture matters.
    pub(super) fn new(emitter: &'a Emitter<'a>) -> Option<Self> {
        let material = emitter.material;
        let has_mask = matches!(material.alpha_mode, AlphaMode::Mask { .. });
        let layer = |reference: &'a Option<TextureRef>, matters: fn(&Texture) -> bool| {
            let reference = reference.as_ref()?;
            let texture = &emitter.textures[reference.texture];
            matters(texture).then_some(Layer { reference, texture })
        };
        let opacity = has_mask.then(|| layer(&material.base_color_texture, has_alphas));
        let layers = [
            layer(&material.emissive_texture, has_colors),
            opacity.flatten(),
        ];
        layers.iter().any(Option::is_some).then_some(Self {
            emitter,
            layers,
            has_mask,
        })
    }

    /// The maps of one triangle, and its corners; `None` where they cannot be told.
    fn placement(&self, welded: &Welded, triangle: u32) -> Option<(Placement, Corners)> {
        let mesh = self.emitter.mesh;
        let source = welded.sources(triangle).next()?;
        let indices = mesh.triangles[source as usize];
        let corners = Corners {
            positions: indices.map(|i| self.emitter.positions[i as usize]),
            uv: [0, 1].map(|k| {
                let layer = self.layers[k].as_ref();
                indices.map(|i| layer.map_or(DVec2::ZERO, |layer| layer.uv(self.emitter, i)))
            }),
        };
        let alphas = indices.map(|i| mesh.colors.get(i as usize).map_or(1.0, |c| c.w));
        if self.has_mask && alphas != [alphas[0]; 3] {
            return None;
        }
        let mut maps = [None; 2];
        for ((map, layer), uv) in maps.iter_mut().zip(&self.layers).zip(corners.uv) {
            let Some(layer) = layer else {
                continue;
            };
            let within = |uv: &DVec2| (*uv * layer.size()).abs().max_element() <= FARTHEST;
            if !uv.iter().all(within) {
                return None;
            }
            *map = Some(TextureMap::of_triangle(corners.positions, uv)?);
        }
        let placement = Placement {
            maps,
            alpha: alphas[0],
        };
        Some((placement, corners))
    }
}

impl Layer<'_> {
    fn size(&self) -> DVec2 {
        DVec2::new(
            f64::from(self.texture.width),
            f64::from(self.texture.height),
        )
    }

    /// As rays read them, in single precision.
    fn uv(&self, emitter: &Emitter<'_>, vertex: u32) -> DVec2 {
        let texcoords = &emitter.mesh.texcoords[self.reference.texcoord];
        let texcoord = texcoords.get(vertex as usize).copied().unwrap_or_default();
        self.reference.transform.apply(texcoord).as_dvec2()
    }

    /// The whole repeats nearest to a difference of texture coordinates.
    fn repeats(&self, difference: DVec2) -> DVec2 {
        let along = |difference: f64, wrap| match wrap {
            Wrap::Repeat => difference.round(),
            Wrap::MirroredRepeat => 2.0 * (difference * 0.5).round(),
            Wrap::ClampToEdge => 0.0,
        };
        let sampler = self.texture.sampler;
        DVec2::new(
            along(difference.x, sampler.wrap_s),
            along(difference.y, sampler.wrap_t),
        )
    }
}

struct Corners {
    positions: [DVec3; 3],
    uv: [[DVec2; 3]; 2],
}

/// The triangles of a facet that grows.
pub(super) struct Region<'a> {
    mapping: &'a Mapping<'a>,
    welded: &'a Welded,
    /// `None` where the first triangle's map cannot be told: then it is joined by its like.
    fit: Option<Fit>,
}

impl<'a> Region<'a> {
    pub(super) fn new(mapping: &'a Mapping<'a>, welded: &'a Welded, seed: u32) -> Self {
        let fit = mapping.placement(welded, seed).map(|(placement, corners)| {
            let mut fit = Fit::new(placement, &corners);
            fit.add(&corners.positions, &corners.uv);
            fit
        });
        Self {
            mapping,
            welded,
            fit,
        }
    }

    /// Takes in a triangle of the same plane, if it shows the same picture.
    pub(super) fn takes(&mut self, triangle: u32) -> bool {
        let found = self.mapping.placement(self.welded, triangle);
        let Some(fit) = &mut self.fit else {
            return found.is_none();
        };
        let Some((placement, mut corners)) = found else {
            return false;
        };
        if placement.alpha != fit.placement.alpha {
            return false;
        }
        for k in 0..2 {
            let (Some(layer), Some(map)) = (&self.mapping.layers[k], &fit.placement.maps[k]) else {
                continue;
            };
            let uv = &mut corners.uv[k];
            let shift = layer.repeats(uv[0] - map.at(corners.positions[0]));
            let noise = rounding(layer, map, uv, self.mapping.emitter.noise);
            for (uv, &position) in uv.iter_mut().zip(&corners.positions) {
                *uv -= shift;
                // Rounding tilts the map of a small region: the more, the farther one looks.
                let reach = 1.0 + (position - fit.origin).length() / fit.width;
                let error = (*uv - map.at(position)) * layer.size();
                if error.abs().max_element() > (TOLERANCE + noise * reach).min(1.0) {
                    return false;
                }
            }
        }
        fit.add(&corners.positions, &corners.uv);
        true
    }

    /// Where the textures lie on all the triangles taken.
    pub(super) fn placement(mut self) -> Option<Placement> {
        let fit = self.fit.as_mut()?;
        fit.solve();
        Some(fit.placement)
    }
}

/// Texels by which rounding may move a texture coordinate.
fn rounding(layer: &Layer<'_>, map: &TextureMap, uv: &[DVec2; 3], noise: f64) -> f64 {
    let largest = uv.map(|uv| (uv * layer.size()).abs().max_element());
    let largest = largest.into_iter().fold(0.0, f64::max);
    let steepest = map.gradients.map(|g| DVec3::from(g).length());
    let steepest = DVec2::from(steepest) * layer.size();
    4.0 * f64::from(f32::EPSILON) * largest + 2.0 * noise * steepest.max_element()
}

/// The affine maps with the least squared error at the corners of the triangles so far.
struct Fit {
    placement: Placement,
    /// The first triangle's centre, from which positions are measured.
    origin: DVec3,
    /// The first triangle's least height, later the region's.
    width: f64,
    /// Two unit vectors in the plane.
    axes: [DVec3; 2],
    /// Corners added, and how many make it worth to solve again.
    count: f64,
    next: f64,
    /// Sums over the corners of place, of its products, and of texture coordinates and their products
    /// with the place, for each layer measured from its first map's at the origin.
    place: DVec2,
    squares: [f64; 3],
    uv: [DVec2; 2],
    products: [[DVec2; 2]; 2],
    uv_at_origin: [DVec2; 2],
}

impl Fit {
    fn new(placement: Placement, corners: &Corners) -> Self {
        let [a, b, c] = corners.positions;
        let origin = (a + b + c) / 3.0;
        let normal = (b - a).cross(c - a);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        let along = (b - a).normalize();
        let map = |map: Option<TextureMap>| map.map_or(DVec2::ZERO, |map| map.at(origin));
        Self {
            placement,
            origin,
            width: normal.length() / longest,
            axes: [along, normal.normalize().cross(along)],
            count: 0.0,
            next: 6.0,
            place: DVec2::ZERO,
            squares: [0.0; 3],
            uv: [DVec2::ZERO; 2],
            products: [[DVec2::ZERO; 2]; 2],
            uv_at_origin: placement.maps.map(map),
        }
    }

    fn add(&mut self, positions: &[DVec3; 3], uv: &[[DVec2; 3]; 2]) {
        for (i, &position) in positions.iter().enumerate() {
            let from_origin = position - self.origin;
            let p = DVec2::from(self.axes.map(|axis| axis.dot(from_origin)));
            self.place += p;
            self.squares[0] += p.x * p.x;
            self.squares[1] += p.x * p.y;
            self.squares[2] += p.y * p.y;
            for (k, uv) in uv.iter().enumerate() {
                let difference = uv[i] - self.uv_at_origin[k];
                self.uv[k] += difference;
                self.products[k][0] += difference * p.x;
                self.products[k][1] += difference * p.y;
            }
        }
        self.count += 3.0;
        if self.count >= self.next {
            self.next = 2.0 * self.count;
            self.solve();
        }
    }

    /// One triangle's map is exact already.
    fn solve(&mut self) {
        if self.count <= 3.0 {
            return;
        }
        let mean = self.place / self.count;
        let [xx, xy, yy] = self.squares;
        let (xx, xy, yy) = (
            xx - self.place.x * mean.x,
            xy - self.place.x * mean.y,
            yy - self.place.y * mean.y,
        );
        let determinant = xx * yy - xy * xy;
        let has_width = determinant > 1e-12 * xx * yy;
        if !has_width {
            return;
        }
        self.width = self
            .width
            .max((determinant / (xx + yy) / self.count).sqrt());
        for k in 0..2 {
            let Some(map) = &mut self.placement.maps[k] else {
                continue;
            };
            let along_x = self.products[k][0] - self.uv[k] * mean.x;
            let along_y = self.products[k][1] - self.uv[k] * mean.y;
            let x = (along_x * yy - along_y * xy) / determinant;
            let y = (along_y * xx - along_x * xy) / determinant;
            let at_mean = self.uv_at_origin[k] + self.uv[k] / self.count;
            let [ax, ay] = self.axes;
            *map = TextureMap {
                point: (self.origin + ax * mean.x + ay * mean.y).to_array(),
                uv: at_mean.to_array(),
                gradients: [
                    (ax * x.x + ay * y.x).to_array(),
                    (ax * x.y + ay * y.y).to_array(),
                ],
            };
        }
    }
}

/// Whether a texture shows more than one colour.
fn has_colors(texture: &Texture) -> bool {
    differs(texture, glam::Vec4::truncate)
}

/// Whether a texture has more than one alpha.
fn has_alphas(texture: &Texture) -> bool {
    differs(texture, |texel| texel.w)
}

fn differs<T: PartialEq>(texture: &Texture, of: impl Fn(glam::Vec4) -> T) -> bool {
    let first = of(texture.texel(0, 0));
    (0..texture.height).any(|y| (0..texture.width).any(|x| of(texture.texel(x, y)) != first))
}
