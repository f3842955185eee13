//! Which neighbouring triangles show one picture.
//!
//! The texture coordinates of a triangle are an affine map on its plane. Triangles of one plane show
//! one picture where one map serves all of them: theirs may differ by whole repeats of the texture.

use glam::{DVec2, DVec3};

use super::{Emitter, texture_map::TextureMap, weld::Welded};
use crate::scene::{AlphaMode, Filter, Texture, TextureRef, Wrap};

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
        for k in 0..2 {
            let Some(layer) = &self.layers[k] else {
                continue;
            };
            let within = |uv: &DVec2| (*uv * layer.size()).abs().max_element() <= FARTHEST;
            if !corners.uv[k].iter().all(within) {
                return None;
            }
            maps[k] = Some(TextureMap::of_triangle(corners.positions, corners.uv[k])?);
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
        DVec2::new(f64::from(self.texture.width), f64::from(self.texture.height))
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
        let placement = self.mapping.placement(self.welded, triangle);
        let (Some(fit), Some((placement, mut corners))) = (&mut self.fit, &placement_parts(placement))
        else {
            return false;
        };
        let _ = (fit, placement, &mut corners);
        false
    }
}
