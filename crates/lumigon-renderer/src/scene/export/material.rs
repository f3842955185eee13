//! Materials that the file does not have, or has otherwise.

use std::collections::HashMap;

use glam::Vec3;
use serde_json::{Map, Value, json};

use super::{
    SaveError,
    document::{Document, number, numbers},
    object,
    texture::Textures,
};
use crate::scene::{AlphaMode, Material, Scene, TextureRef, TextureTransform};

/// The materials of an edited scene, as far as they are in the document.
pub(super) struct Materials<'a> {
    original: &'a Scene,
    edited: &'a Scene,
    textures: Textures<'a>,
    done: HashMap<usize, Option<usize>>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(original: &'a Scene, edited: &'a Scene) -> Self {
        Self {
            original,
            edited,
            textures: Textures::new(original, edited),
            done: HashMap::new(),
        }
    }

    /// Whether a material of the file's scene is another now, or shows another texture.
    fn is_changed(&self, index: usize) -> bool {
        let (old, new) = (
            &self.original.materials[index],
            self.edited.materials.get(index),
        );
        new.is_none_or(|new| {
            let textures = 0..self.original.textures.len();
            let mut shown = textures.filter(|&texture| new.shows(texture));
            new != old || shown.any(|texture| self.textures.is_changed(texture))
        })
    }

    /// Whether faces of this material need another one in the file, as theirs is not in it.
    pub(super) fn is_replaced(&self, index: usize) -> bool {
        self.original
            .materials
            .get(index)
            .is_some_and(|old| old.source.is_none() && self.is_changed(index))
    }

    /// Patches the file's own materials that were changed in place.
    pub(super) fn patch_changed(&mut self, document: &mut Document<'_>) -> Result<(), SaveError> {
        for index in 0..self.original.materials.len() {
            let old = &self.original.materials[index];
            let Some(source) = old.source.filter(|_| self.is_changed(index)) else {
                continue;
            };
            let new = self.edited.materials.get(index);
            let new = new.ok_or_else(|| SaveError::scene(part(old), "it is gone"))?;
            let json = document.object("materials", source)?.clone();
            let json = self.patched(document, json, new, old)?;
            *document.object("materials", source)? = json;
        }
        Ok(())
    }

    /// The document's index of a material of the edited scene; `None` for glTF's default one.
    pub(super) fn index(
        &mut self,
        document: &mut Document<'_>,
        index: usize,
    ) -> Result<Option<usize>, SaveError> {
        if let Some(&done) = self.done.get(&index) {
            return Ok(done);
        }
        let (original, edited) = (self.original, self.edited);
        let material = edited.materials.get(index);
        let material = material
            .ok_or_else(|| SaveError::scene("the scene", format!("it has no material {index}")))?;
        let done = if index < original.materials.len() && material.source.is_some() {
            material.source
        } else if is_default(material) {
            None
        } else {
            // A changed copy: the file's material may have more than was understood.
            let of_file = edited.materials.iter().take(original.materials.len());
            let base = material.source.and_then(|source| {
                let base = of_file.clone().find(|base| base.source == Some(source))?;
                Some((base, document.object("materials", source).ok()?.clone()))
            });
            let plain = Material::default();
            let (base, json) = base.unwrap_or((&plain, Map::new()));
            let json = self.patched(document, json, material, base)?;
            Some(document.push("materials", Value::Object(json))?)
        };
        self.done.insert(index, done);
        Ok(done)
    }

    /// The JSON of `base`, changed to that of `material`.
    fn patched(
        &mut self,
        document: &mut Document<'_>,
        json: Map<String, Value>,
        material: &Material,
        base: &Material,
    ) -> Result<Map<String, Value>, SaveError> {
        let mut patch = Patch {
            document,
            textures: &mut self.textures,
            json,
            part: part(material),
        };
        patch.all(material, base)?;
        Ok(patch.json)
    }
}

fn part(material: &Material) -> String {
    format!("material \"{}\"", material.name)
}

/// Whether a primitive without a material looks the same.
fn is_default(material: &Material) -> bool {
    let default = Material {
        name: material.name.clone(),
        ..Material::default()
    };
    *material == default
}

const PBR: &[&str] = &["pbrMetallicRoughness"];
const SPECULAR: &[&str] = &["extensions", "KHR_materials_specular"];
const IOR: &[&str] = &["extensions", "KHR_materials_ior"];
const ANISOTROPY: &[&str] = &["extensions", "KHR_materials_anisotropy"];
const DIFFUSE: &[&str] = &["extensions", "KHR_materials_diffuse_roughness"];
const SHEEN: &[&str] = &["extensions", "KHR_materials_sheen"];
const COAT: &[&str] = &["extensions", "KHR_materials_clearcoat"];
const STRENGTH: &[&str] = &["extensions", "KHR_materials_emissive_strength"];
const UNLIT: &str = "KHR_materials_unlit";
const TRANSFORM: &str = "KHR_texture_transform";

/// One material's JSON under change.
struct Patch<'p, 'd, 'a> {
    document: &'p mut Document<'d>,
    textures: &'p mut Textures<'a>,
    json: Map<String, Value>,
    /// What stands for the material in errors.
    part: String,
}

impl Patch<'_, '_, '_> {
    fn all(&mut self, new: &Material, old: &Material) -> Result<(), SaveError> {
        if new.name != old.name {
            self.set(&[], "name", json!(new.name))?;
        }
        self.vector(
            PBR,
            "baseColorFactor",
            new.base_color.to_array(),
            old.base_color.to_array(),
        )?;
        self.vector(
            SPECULAR,
            "specularColorFactor",
            new.specular_color.to_array(),
            old.specular_color.to_array(),
        )?;
        self.vector(
            SHEEN,
            "sheenColorFactor",
            new.sheen_color.to_array(),
            old.sheen_color.to_array(),
        )?;
        for (path, key, new, old) in [
            (PBR, "metallicFactor", new.metallic, old.metallic),
            (
                PBR,
                "roughnessFactor",
                new.perceptual_roughness,
                old.perceptual_roughness,
            ),
            (SPECULAR, "specularFactor", new.specular, old.specular),
            (IOR, "ior", new.ior, old.ior),
            (
                ANISOTROPY,
                "anisotropyStrength",
                new.anisotropy_strength,
                old.anisotropy_strength,
            ),
            (
                ANISOTROPY,
                "anisotropyRotation",
                new.anisotropy_rotation,
                old.anisotropy_rotation,
            ),
            (
                DIFFUSE,
                "diffuseRoughnessFactor",
                new.diffuse_roughness,
                old.diffuse_roughness,
            ),
            (
                SHEEN,
                "sheenRoughnessFactor",
                new.sheen_perceptual_roughness,
                old.sheen_perceptual_roughness,
            ),
            (COAT, "clearcoatFactor", new.clearcoat, old.clearcoat),
            (
                COAT,
                "clearcoatRoughnessFactor",
                new.clearcoat_perceptual_roughness,
                old.clearcoat_perceptual_roughness,
            ),
        ] {
            if new != old {
                self.number(path, key, new)?;
            }
        }
        for (path, key, new, old) in [
            (
                PBR,
                "baseColorTexture",
                new.base_color_texture,
                old.base_color_texture,
            ),
            (
                PBR,
                "metallicRoughnessTexture",
                new.metallic_roughness_texture,
                old.metallic_roughness_texture,
            ),
            (
                SPECULAR,
                "specularTexture",
                new.specular_texture,
                old.specular_texture,
            ),
            (
                SPECULAR,
                "specularColorTexture",
                new.specular_color_texture,
                old.specular_color_texture,
            ),
            (
                ANISOTROPY,
                "anisotropyTexture",
                new.anisotropy_texture,
                old.anisotropy_texture,
            ),
            (
                DIFFUSE,
                "diffuseRoughnessTexture",
                new.diffuse_roughness_texture,
                old.diffuse_roughness_texture,
            ),
            (
                SHEEN,
                "sheenColorTexture",
                new.sheen_color_texture,
                old.sheen_color_texture,
            ),
            (
                SHEEN,
                "sheenRoughnessTexture",
                new.sheen_roughness_texture,
                old.sheen_roughness_texture,
            ),
            (
                COAT,
                "clearcoatTexture",
                new.clearcoat_texture,
                old.clearcoat_texture,
            ),
            (
                COAT,
                "clearcoatRoughnessTexture",
                new.clearcoat_roughness_texture,
                old.clearcoat_roughness_texture,
            ),
        ] {
            self.texture(path, key, new, old, false)?;
        }
        for (path, key, property, new, old) in [
            (
                &[][..],
                "normalTexture",
                "scale",
                (new.normal_texture, new.normal_scale),
                (old.normal_texture, old.normal_scale),
            ),
            (
                &[],
                "occlusionTexture",
                "strength",
                (new.occlusion_texture, new.occlusion_strength),
                (old.occlusion_texture, old.occlusion_strength),
            ),
            (
                COAT,
                "clearcoatNormalTexture",
                "scale",
                (new.clearcoat_normal_texture, new.clearcoat_normal_scale),
                (old.clearcoat_normal_texture, old.clearcoat_normal_scale),
            ),
        ] {
            self.texture(path, key, new.0, old.0, false)?;
            if new.0.is_some() && new.1 != old.1 {
                let path: Vec<&str> = path.iter().copied().chain([key]).collect();
                self.number(&path, property, new.1)?;
            }
        }
        let scale = self.texture(
            &[],
            "emissiveTexture",
            new.emissive_texture,
            old.emissive_texture,
            true,
        )?;
        if new.emissive != old.emissive || scale.is_some() {
            self.emission(new.emissive * scale.unwrap_or(1.0))?;
        }
        if new.alpha_mode != old.alpha_mode {
            self.json.remove("alphaCutoff");
            let mode = match new.alpha_mode {
                AlphaMode::Opaque => "OPAQUE",
                AlphaMode::Blend => "BLEND",
                AlphaMode::Mask { cutoff } => {
                    self.number(&[], "alphaCutoff", cutoff)?;
                    "MASK"
                }
            };
            self.set(&[], "alphaMode", json!(mode))?;
        }
        if new.double_sided != old.double_sided {
            self.set(&[], "doubleSided", json!(new.double_sided))?;
        }
        match (new.unlit, old.unlit) {
            (true, false) => self.set(&["extensions"], UNLIT, json!({})),
            (false, true) => self.remove_extension(UNLIT),
            _ => Ok(()),
        }
    }

    /// Radiance as a factor up to 1 and a strength.
    fn emission(&mut self, emissive: Vec3) -> Result<(), SaveError> {
        if !emissive.is_finite() || emissive.min_element() < 0.0 {
            let what = format!("its radiance {emissive} is negative or not finite");
            return Err(SaveError::scene(&self.part, what));
        }
        let strength = emissive.max_element();
        let factor = if strength > 1.0 {
            self.number(STRENGTH, "emissiveStrength", strength)?;
            (emissive / strength).min(Vec3::ONE)
        } else {
            self.remove_extension(STRENGTH[1])?;
            emissive
        };
        self.set(&[], "emissiveFactor", numbers(factor.to_array()))
    }

    /// Changes a texture where it is another. `scaled`: it may be darker than it is; returns by how
    /// much, `None` where nothing changed.
    fn texture(
        &mut self,
        path: &[&str],
        key: &str,
        new: Option<TextureRef>,
        old: Option<TextureRef>,
        scaled: bool,
    ) -> Result<Option<f32>, SaveError> {
        let is_changed = |new: TextureRef| self.textures.is_changed(new.texture);
        if new == old && !new.is_some_and(is_changed) {
            return Ok(None);
        }
        let Some(new) = new else {
            self.object(path)?.remove(key);
            return Ok(Some(1.0));
        };
        let transform = transform(&new.transform).ok_or_else(|| {
            let what = format!("its {key} is sheared, which glTF cannot say");
            SaveError::scene(&self.part, what)
        })?;
        let (index, scale) = self
            .textures
            .index(self.document, new.texture, scaled, &self.part)?;
        let path: Vec<&str> = path.iter().copied().chain([key]).collect();
        self.set(&path, "index", json!(index))?;
        let info = self.object(&path)?;
        info.remove("texCoord");
        if new.texcoord != 0 {
            info.insert("texCoord".to_owned(), json!(new.texcoord));
        }
        if let Some(extensions) = info.get_mut("extensions") {
            let extensions = object(Some(extensions), || key.to_owned())?;
            extensions.remove(TRANSFORM);
            if extensions.is_empty() {
                info.remove("extensions");
            }
        }
        if new.transform != TextureTransform::default() {
            let path: Vec<&str> = path.iter().copied().chain(["extensions"]).collect();
            self.set(&path, TRANSFORM, transform)?;
            self.document.uses(TRANSFORM)?;
        }
        Ok(Some(scale))
    }

    fn vector<const N: usize>(
        &mut self,
        path: &[&str],
        key: &str,
        new: [f32; N],
        old: [f32; N],
    ) -> Result<(), SaveError> {
        if new == old {
            return Ok(());
        }
        if !new.iter().all(|x| x.is_finite()) {
            return Err(SaveError::scene(&self.part, format!("{key} is not finite")));
        }
        self.set(path, key, numbers(new))
    }

    fn number(&mut self, path: &[&str], key: &str, value: f32) -> Result<(), SaveError> {
        if !value.is_finite() {
            return Err(SaveError::scene(&self.part, format!("{key} is not finite")));
        }
        self.set(path, key, number(value))
    }

    fn set(&mut self, path: &[&str], key: &str, value: Value) -> Result<(), SaveError> {
        match path {
            ["extensions"] => self.document.uses(key)?,
            ["extensions", name, ..] => self.document.uses(name)?,
            _ => {}
        }
        self.object(path)?.insert(key.to_owned(), value);
        Ok(())
    }

    fn remove_extension(&mut self, name: &str) -> Result<(), SaveError> {
        if self.json.contains_key("extensions") {
            let extensions = self.object(&["extensions"])?;
            extensions.remove(name);
            if extensions.is_empty() {
                self.json.remove("extensions");
            }
        }
        Ok(())
    }

    /// The object at the end of a path, made where it is missing.
    fn object(&mut self, path: &[&str]) -> Result<&mut Map<String, Value>, SaveError> {
        let mut at = &mut self.json;
        for key in path {
            let next = at.entry(*key).or_insert_with(|| json!({}));
            at = object(Some(next), || format!("{}: {key}", self.part))?;
        }
        Ok(at)
    }
}

/// `KHR_texture_transform` of a transform; `None` where it shears.
fn transform(transform: &TextureTransform) -> Option<Value> {
    let matrix = transform.texture_from_texcoord;
    let (x, y) = (matrix.x_axis.truncate(), matrix.y_axis.truncate());
    // One axis may be squeezed to nothing, and says nothing of the rotation then.
    let (sin, cos) = if x.length() > 0.0 {
        (-x.y / x.length(), x.x / x.length())
    } else if y.length() > 0.0 {
        (y.x / y.length(), y.y / y.length())
    } else {
        (0.0, 1.0)
    };
    let (along, across) = (y.x * sin + y.y * cos, y.x * cos - y.y * sin);
    if !matrix.is_finite() || across.abs() > 1e-5 * along.abs().max(x.length()) {
        return None;
    }
    Some(json!({
        "offset": numbers(matrix.z_axis.truncate().to_array()),
        "rotation": number(sin.atan2(cos)),
        "scale": numbers([x.length(), along]),
    }))
}
