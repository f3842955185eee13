//! The material extensions that change or add a lobe: `KHR_materials_specular`, `_ior`,
//! `_anisotropy`, `_sheen`, `_clearcoat`, and the draft `KHR_materials_diffuse_roughness`
//! (proposed in pull request 2481 of the glTF repository).

use glam::Vec3;
use serde_json::{Map, Value};

use super::{
    material::{Context, Materials, Reference},
    value::{number, numbers, object},
};
use crate::scene::{Material, TextureRef, error::Fault};

/// One extension's object in a material, or none.
struct Extension<'v> {
    properties: &'v Map<String, Value>,
    place: String,
}

impl<'v> Extension<'v> {
    fn new(
        extensions: &'v Map<String, Value>,
        name: &str,
        material: &str,
    ) -> Result<Option<Self>, Fault> {
        let Some(value) = extensions.get(name) else {
            return Ok(None);
        };
        let place = format!("{material}.extensions.{name}");
        let properties = object(value, &place)?;
        Ok(Some(Self { properties, place }))
    }

    fn number(&self, key: &str, default: f32) -> Result<f32, Fault> {
        number(self.properties, key, default, &self.place)
    }

    /// A factor that the extension bounds by 0 and 1.
    fn factor(&self, key: &str, default: f32) -> Result<f32, Fault> {
        Ok(self.number(key, default)?.clamp(0.0, 1.0))
    }

    fn color(&self, key: &str, default: [f32; 3]) -> Result<Vec3, Fault> {
        numbers(self.properties, key, default, &self.place).map(Vec3::from)
    }

    fn reference(&self, key: &str) -> Result<Option<Reference>, Fault> {
        self.properties
            .get(key)
            .map(|value| Reference::from_value(value, format!("{}.{key}", self.place)))
            .transpose()
    }

    /// A texture's scale, as a normal texture has it.
    fn scale(&self, key: &str) -> Result<f32, Fault> {
        match self.properties.get(key) {
            Some(value) => {
                let place = format!("{}.{key}", self.place);
                number(object(value, &place)?, "scale", 1.0, &place)
            }
            None => Ok(1.0),
        }
    }
}

impl Materials<'_> {
    /// Reads the layers that extensions give to a material into it. `place` is the material's.
    pub(super) fn layers(
        &mut self,
        context: &mut Context<'_, '_>,
        extensions: &Map<String, Value>,
        place: &str,
        material: &mut Material,
    ) -> Result<(), Fault> {
        let mut found = Vec::new();
        let mut extension = |name: &'static str| {
            let extension = Extension::new(extensions, name, place)?;
            found.extend(extension.as_ref().map(|_| name));
            Ok(extension)
        };
        let specular = extension("KHR_materials_specular")?;
        let ior = extension("KHR_materials_ior")?;
        let anisotropy = extension("KHR_materials_anisotropy")?;
        let diffuse_roughness = extension("KHR_materials_diffuse_roughness")?;
        let sheen = extension("KHR_materials_sheen")?;
        let clearcoat = extension("KHR_materials_clearcoat")?;

        let mut data = |extension: &Extension<'_>, key| {
            let reference = extension.reference(key)?;
            self.texture(context, reference, false)
        };
        if let Some(specular) = &specular {
            material.specular = specular.factor("specularFactor", 1.0)?;
            material.specular_texture = data(specular, "specularTexture")?;
            // Allowed to pass 1: what is reflected is bounded later.
            let color = specular.color("specularColorFactor", [1.0; 3])?;
            material.specular_color = color.max(Vec3::ZERO);
        }
        if let Some(anisotropy) = &anisotropy {
            material.anisotropy_strength = anisotropy.factor("anisotropyStrength", 0.0)?;
            material.anisotropy_rotation = anisotropy.number("anisotropyRotation", 0.0)?;
            material.anisotropy_texture = data(anisotropy, "anisotropyTexture")?;
        }
        if let Some(rough) = &diffuse_roughness {
            material.diffuse_roughness = rough.factor("diffuseRoughnessFactor", 0.0)?;
            material.diffuse_roughness_texture = data(rough, "diffuseRoughnessTexture")?;
        }
        if let Some(sheen) = &sheen {
            let color = sheen.color("sheenColorFactor", [0.0; 3])?;
            material.sheen_color = color.clamp(Vec3::ZERO, Vec3::ONE);
            material.sheen_perceptual_roughness = sheen.factor("sheenRoughnessFactor", 0.0)?;
            material.sheen_roughness_texture = data(sheen, "sheenRoughnessTexture")?;
        }
        if let Some(coat) = &clearcoat {
            material.clearcoat = coat.factor("clearcoatFactor", 0.0)?;
            material.clearcoat_texture = data(coat, "clearcoatTexture")?;
            material.clearcoat_perceptual_roughness =
                coat.factor("clearcoatRoughnessFactor", 0.0)?;
            material.clearcoat_roughness_texture = data(coat, "clearcoatRoughnessTexture")?;
            material.clearcoat_normal_texture = data(coat, "clearcoatNormalTexture")?;
            material.clearcoat_normal_scale = coat.scale("clearcoatNormalTexture")?;
        }
        for (extension, key, slot) in [
            (
                &specular,
                "specularColorTexture",
                &mut material.specular_color_texture,
            ),
            (
                &sheen,
                "sheenColorTexture",
                &mut material.sheen_color_texture,
            ),
        ] {
            if let Some(extension) = extension {
                *slot = self.color_texture(context, extension, key)?;
            }
        }
        if let Some(ior) = &ior {
            material.ior = ior.number("ior", 1.5)?;
            if material.ior < 1.0 && material.ior != 0.0 {
                context.warnings.add(format!(
                    "{}.ior: below 1 and not 0, is taken as 1",
                    ior.place
                ));
                material.ior = 1.0;
            }
        }
        if material.unlit && !found.is_empty() {
            context.warnings.add(format!(
                "{place} is unlit: its {} is ignored",
                found.join(", ")
            ));
        }
        Ok(())
    }

    fn color_texture(
        &mut self,
        context: &mut Context<'_, '_>,
        extension: &Extension<'_>,
        key: &str,
    ) -> Result<Option<TextureRef>, Fault> {
        let reference = extension.reference(key)?;
        self.texture(context, reference, true)
    }
}
