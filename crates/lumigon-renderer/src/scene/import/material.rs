//! Materials and their textures, converted when a drawn primitive first asks for them.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};
use gltf::json::{
    self,
    extensions::texture::TextureTransform as JsonTransform,
    material::AlphaMode as JsonAlphaMode,
    texture::{Info, MagFilter, MinFilter, WrappingMode},
    validation::Checked,
};
use serde_json::{Map, Value};

use super::{
    image::Images,
    source::Source,
    value::{check_finite, index, number, numbers, object},
    warning::Warnings,
};
use crate::scene::{
    AlphaMode, Filter, Limits, LoadWatch, Material, Sampler, Texture, TextureRef, TextureTransform,
    Wrap, error::Fault,
};

/// The materials and textures converted so far.
pub(super) struct Materials<'a> {
    pub(super) materials: Vec<Material>,
    pub(super) textures: Vec<Texture>,
    /// By the document's index; `None` is glTF's default material.
    material_of: HashMap<Option<usize>, usize>,
    /// By the document's index and whether it is read as sRGB.
    texture_of: HashMap<(usize, bool), usize>,
    images: Images<'a>,
}

/// What conversion needs beside the materials themselves.
pub(super) struct Context<'a, 'b> {
    pub(super) root: &'a json::Root,
    pub(super) source: &'b mut Source<'a>,
    pub(super) warnings: &'b mut Warnings,
}

/// A reference to a texture, whichever of glTF's three kinds it was.
pub(super) struct Reference {
    texture: usize,
    texcoord: u32,
    transform: TextureTransform,
    place: String,
}

impl<'a> Materials<'a> {
    pub(super) fn new(limits: &Limits, watch: LoadWatch<'a>) -> Self {
        Self {
            materials: Vec::new(),
            textures: Vec::new(),
            material_of: HashMap::new(),
            texture_of: HashMap::new(),
            images: Images::new(limits, watch),
        }
    }

    /// A material that is not the document's.
    pub(super) fn push(&mut self, material: Material) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// The scene's index of the document's material. `user` is the place that asks.
    pub(super) fn get(
        &mut self,
        context: &mut Context<'_, '_>,
        index: Option<usize>,
        user: &str,
    ) -> Result<usize, Fault> {
        if let Some(&done) = self.material_of.get(&index) {
            return Ok(done);
        }
        let material = match index {
            None => Material {
                name: "default".to_owned(),
                ..Material::default()
            },
            Some(index) => {
                let material = context.root.materials.get(index).ok_or_else(|| {
                    let what = format!("there is no materials[{index}]");
                    Fault::new(user, what, "use an index that exists")
                })?;
                self.convert(context, material, index)?
            }
        };
        let done = self.push(material);
        self.material_of.insert(index, done);
        Ok(done)
    }

    fn convert(
        &mut self,
        context: &mut Context<'_, '_>,
        material: &json::Material,
        index: usize,
    ) -> Result<Material, Fault> {
        let place = format!("materials[{index}]");
        let pbr = &material.pbr_metallic_roughness;
        let extensions = material.extensions.as_ref();
        let strength = extensions
            .and_then(|extensions| extensions.emissive_strength.as_ref())
            .map_or(1.0, |strength| strength.emissive_strength.0);
        let alpha_mode = match material.alpha_mode {
            Checked::Valid(JsonAlphaMode::Opaque) => AlphaMode::Opaque,
            Checked::Valid(JsonAlphaMode::Mask) => AlphaMode::Mask {
                cutoff: material.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0),
            },
            Checked::Valid(JsonAlphaMode::Blend) => {
                context.warnings.add("alphaMode BLEND is drawn opaque");
                AlphaMode::Blend
            }
            Checked::Invalid => {
                return Err(Fault::new(
                    place + ".alphaMode",
                    "this is not one of glTF's alpha modes",
                    "use OPAQUE, MASK or BLEND",
                ));
            }
        };

        let mut converted = Material {
            name: material.name.clone().unwrap_or_default(),
            base_color: Vec4::from(pbr.base_color_factor.0),
            metallic: pbr.metallic_factor.0,
            perceptual_roughness: pbr.roughness_factor.0,
            emissive: Vec3::from(material.emissive_factor.0) * strength,
            alpha_mode,
            double_sided: material.double_sided,
            unlit: extensions.is_some_and(|extensions| extensions.unlit.is_some()),
            source: Some(index),
            ..Material::default()
        };
        let info = |info: &Option<Info>, name: &str| -> Result<Option<Reference>, Fault> {
            let place = format!("{place}.{name}");
            info.as_ref()
                .map(|info| Reference::new(info, place))
                .transpose()
        };
        let srgb = [
            (
                info(
                    &pbr.base_color_texture,
                    "pbrMetallicRoughness.baseColorTexture",
                )?,
                &mut converted.base_color_texture,
            ),
            (
                info(&material.emissive_texture, "emissiveTexture")?,
                &mut converted.emissive_texture,
            ),
        ];
        for (reference, slot) in srgb {
            *slot = self.texture(context, reference, true)?;
        }
        let reference = info(
            &pbr.metallic_roughness_texture,
            "pbrMetallicRoughness.metallicRoughnessTexture",
        )?;
        converted.metallic_roughness_texture = self.texture(context, reference, false)?;
        if let Some(normal) = &material.normal_texture {
            converted.normal_scale = normal.scale;
            let others = normal.extensions.as_ref().map(|e| &e.others);
            let place = format!("{place}.normalTexture");
            let reference =
                Reference::untyped(normal.index.value(), normal.tex_coord, others, place)?;
            converted.normal_texture = self.texture(context, Some(reference), false)?;
        }
        if let Some(occlusion) = &material.occlusion_texture {
            converted.occlusion_strength = occlusion.strength.0;
            let others = occlusion.extensions.as_ref().map(|e| &e.others);
            let place = format!("{place}.occlusionTexture");
            let reference =
                Reference::untyped(occlusion.index.value(), occlusion.tex_coord, others, place)?;
            converted.occlusion_texture = self.texture(context, Some(reference), false)?;
        }

        if let Some(extensions) = extensions {
            self.layers(context, &extensions.others, &place, &mut converted)?;
        }

        let [x, y, z] = converted.emissive.to_array();
        let [r, g, b, a] = converted.base_color.to_array();
        let factors = [
            x,
            y,
            z,
            r,
            g,
            b,
            a,
            converted.metallic,
            converted.perceptual_roughness,
            converted.normal_scale,
        ];
        check_finite(&factors, || place.clone())?;
        if converted.emissive.min_element() < 0.0 {
            context
                .warnings
                .add(format!("{place}: negative emission is taken as none"));
            converted.emissive = converted.emissive.max(Vec3::ZERO);
        }
        converted.base_color = converted.base_color.clamp(Vec4::ZERO, Vec4::ONE);
        converted.metallic = converted.metallic.clamp(0.0, 1.0);
        converted.perceptual_roughness = converted.perceptual_roughness.clamp(0.0, 1.0);
        Ok(converted)
    }

    /// The reference into the scene's textures, or `None` where the texture cannot be shown.
    pub(super) fn texture(
        &mut self,
        context: &mut Context<'_, '_>,
        reference: Option<Reference>,
        srgb: bool,
    ) -> Result<Option<TextureRef>, Fault> {
        let Some(reference) = reference else {
            return Ok(None);
        };
        if reference.texcoord > 1 {
            let set = reference.texcoord;
            context.warnings.add(format!(
                "textures on TEXCOORD_{set} are not shown: only sets 0 and 1 are read"
            ));
            return Ok(None);
        }
        let key = (reference.texture, srgb);
        let texture = match self.texture_of.get(&key) {
            Some(&done) => done,
            None => {
                let Some(texture) = self.load(context, &reference, srgb)? else {
                    return Ok(None);
                };
                self.textures.push(texture);
                self.texture_of.insert(key, self.textures.len() - 1);
                self.textures.len() - 1
            }
        };
        Ok(Some(TextureRef {
            texture,
            texcoord: reference.texcoord as usize,
            transform: reference.transform,
        }))
    }

    fn load(
        &mut self,
        context: &mut Context<'_, '_>,
        reference: &Reference,
        srgb: bool,
    ) -> Result<Option<Texture>, Fault> {
        let root = context.root;
        let index = reference.texture;
        let texture = root.textures.get(index).ok_or_else(|| {
            let what = format!("there is no textures[{index}]");
            Fault::new(&reference.place, what, "use an index that exists")
        })?;
        let place = format!("textures[{index}]");
        // The crate's stand-in for an image that only an extension supplies.
        if texture.source.value() == u32::MAX as usize {
            context.warnings.add(format!(
                "{place} has no image that can be read and is not shown"
            ));
            return Ok(None);
        }
        let sampler = match texture.sampler {
            None => Sampler::default(),
            Some(sampler) => {
                let index = sampler.value();
                let sampler = root.samplers.get(index).ok_or_else(|| {
                    let what = format!("there is no samplers[{index}]");
                    Fault::new(&place, what, "use an index that exists")
                })?;
                convert_sampler(sampler, index)?
            }
        };
        let source = texture.source.value();
        let image = self.images.get(root, context.source, source, &place)?;
        let name = texture.name.as_ref().or(root.images[source].name.as_ref());
        let name = name.cloned().unwrap_or_default();
        let texture = Texture::new(name, image.size, image.texels, srgb, sampler);
        Ok(Some(texture.with_source(index)))
    }
}

impl Reference {
    fn new(info: &Info, place: String) -> Result<Self, Fault> {
        let transform = info
            .extensions
            .as_ref()
            .and_then(|e| e.texture_transform.as_ref());
        let default = JsonTransform::default();
        let found = transform.unwrap_or(&default);
        let ([x, y], [sx, sy]) = (found.offset.0, found.scale.0);
        check_finite(&[x, y, sx, sy, found.rotation.0], || place.clone())?;
        Ok(Self {
            texture: info.index.value(),
            texcoord: found.tex_coord.unwrap_or(info.tex_coord),
            transform: TextureTransform::new(Vec2::new(x, y), found.rotation.0, Vec2::new(sx, sy)),
            place,
        })
    }

    /// For the textures of extensions that the `gltf` crate has no types for.
    pub(super) fn from_value(value: &Value, place: String) -> Result<Self, Fault> {
        let properties = object(value, &place)?;
        let texture = index(properties, "index", &place)?
            .ok_or_else(|| Fault::new(&place, "it has no index", "name a texture"))?;
        let texcoord = index(properties, "texCoord", &place)?.unwrap_or(0);
        let extensions = match properties.get("extensions") {
            Some(value) => Some(object(value, &format!("{place}.extensions"))?),
            None => None,
        };
        let texcoord = u32::try_from(texcoord).unwrap_or(u32::MAX);
        Self::untyped(texture, texcoord, extensions, place)
    }

    /// For normal and occlusion textures, whose transform the `gltf` crate leaves untyped.
    fn untyped(
        texture: usize,
        texcoord: u32,
        extensions: Option<&Map<String, Value>>,
        place: String,
    ) -> Result<Self, Fault> {
        let mut reference = Self {
            texture,
            texcoord,
            transform: TextureTransform::default(),
            place,
        };
        if let Some(value) = extensions.and_then(|e| e.get("KHR_texture_transform")) {
            let place = format!("{}.extensions.KHR_texture_transform", reference.place);
            let properties = object(value, &place)?;
            reference.transform = TextureTransform::new(
                Vec2::from(numbers(properties, "offset", [0.0, 0.0], &place)?),
                number(properties, "rotation", 0.0, &place)?,
                Vec2::from(numbers(properties, "scale", [1.0, 1.0], &place)?),
            );
            if let Some(set) = index(properties, "texCoord", &place)? {
                reference.texcoord = u32::try_from(set).unwrap_or(u32::MAX);
            }
        }
        Ok(reference)
    }
}

fn convert_sampler(sampler: &json::texture::Sampler, index: usize) -> Result<Sampler, Fault> {
    let invalid = |property: &str| {
        Fault::new(
            format!("samplers[{index}].{property}"),
            "this is not one of glTF's values",
            "use one that the specification lists",
        )
    };
    let wrap = |mode: Checked<WrappingMode>, property: &str| match mode {
        Checked::Valid(WrappingMode::Repeat) => Ok(Wrap::Repeat),
        Checked::Valid(WrappingMode::MirroredRepeat) => Ok(Wrap::MirroredRepeat),
        Checked::Valid(WrappingMode::ClampToEdge) => Ok(Wrap::ClampToEdge),
        Checked::Invalid => Err(invalid(property)),
    };
    let filter = match (sampler.mag_filter, sampler.min_filter) {
        (Some(Checked::Invalid), _) => return Err(invalid("magFilter")),
        (_, Some(Checked::Invalid)) => return Err(invalid("minFilter")),
        (Some(Checked::Valid(MagFilter::Nearest)), _)
        | (None, Some(Checked::Valid(MinFilter::Nearest))) => Filter::Nearest,
        _ => Filter::Linear,
    };
    Ok(Sampler {
        wrap_s: wrap(sampler.wrap_s, "wrapS")?,
        wrap_t: wrap(sampler.wrap_t, "wrapT")?,
        filter,
    })
}
