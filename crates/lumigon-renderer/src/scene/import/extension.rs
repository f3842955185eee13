//! Which extensions are understood, and what else a file asks for.

use gltf::json;

use super::warning::Warnings;
use crate::scene::error::Fault;

/// Extensions that are done, or (the last two) that change nothing in the picture.
const SUPPORTED: [&str; 14] = [
    "EXT_lights_area",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_roughness",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Refuses what the file requires and this importer lacks, and reports what it merely uses.
pub(super) fn check(root: &json::Root, warnings: &mut Warnings) -> Result<(), Fault> {
    for (i, name) in root.extensions_required.iter().enumerate() {
        if !SUPPORTED.contains(&name.as_str()) {
            return Err(Fault::new(
                format!("extensionsRequired[{i}]"),
                format!("{name} is not supported"),
                "export the scene without it",
            ));
        }
    }
    for name in &root.extensions_used {
        if !SUPPORTED.contains(&name.as_str()) {
            warnings.add(format!("{name} is not supported and is ignored"));
        }
    }
    if !root.animations.is_empty() {
        warnings.add("animations are not played: the scene is drawn as it stands");
    }
    Ok(())
}
