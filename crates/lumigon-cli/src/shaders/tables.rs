//! The shipped tables, in the formats of a target's engines.

use std::fs;
use std::path::Path;

use lumigon_fit::Manifest;
use lumigon_shaders::Target;
use lumigon_table::{Format, TableImage};

use crate::Failure;

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$((
            $name,
            include_bytes!(concat!("../../../../tables/", $name, ".f32")),
            include_bytes!(concat!("../../../../tables/", $name, ".json")),
        )),*]
    };
}

/// Names, numbers and manifests.
const SHIPPED: &[(&str, &[u8], &[u8])] = shipped![
    "ggx-32",
    "ggx-2-32",
    "ggx-anisotropic-16",
    "charlie-32",
    "eon-32",
];

/// A table of an export.
#[derive(Debug)]
pub(super) struct ExportedTable {
    /// The files' stem.
    pub(super) name: &'static str,
    pub(super) image: TableImage,
    pub(super) manifest: Manifest,
}

/// Formats besides raw f32.
pub(super) fn formats(target: Target) -> &'static [Format] {
    match target {
        Target::Hlsl => &[Format::Dds { half: true }],
        Target::GlslEs300 => &[Format::F16],
        Target::Wgsl | Target::Glsl450 | Target::Msl | Target::Spirv => {
            &[Format::Ktx2 { half: true }]
        }
    }
}

/// Writes every table into the folder `tables` of `folder`: raw f32 with its manifest, and the
/// target's own format in 16 bits.
///
/// # Errors
/// Where a file cannot be written.
pub(super) fn write(target: Target, folder: &Path) -> Result<Vec<ExportedTable>, Failure> {
    let folder = folder.join("tables");
    let failed = |error| format!("{}: {error}", folder.display());
    fs::create_dir(&folder).map_err(failed)?;
    let mut tables = Vec::with_capacity(SHIPPED.len());
    for (name, numbers, manifest) in SHIPPED {
        let manifest_path = folder.join(format!("{name}.json"));
        fs::write(folder.join(format!("{name}.f32")), numbers).map_err(failed)?;
        fs::write(&manifest_path, manifest).map_err(failed)?;
        let image = TableImage::read(&manifest_path)?;
        image.write(formats(target), &folder)?;
        tables.push(ExportedTable {
            name,
            image,
            manifest: Manifest::read(&manifest_path)?,
        });
    }
    Ok(tables)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_table_is_exported() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tables");
        let mut found: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .filter_map(|entry| {
                let name = entry.unwrap().file_name().into_string().unwrap();
                Some(name.strip_suffix(".f32")?.to_owned())
            })
            .collect();
        let mut exported: Vec<_> = SHIPPED
            .iter()
            .map(|(name, ..)| (*name).to_owned())
            .collect();
        found.sort();
        exported.sort();
        assert_eq!(exported, found);
    }
}
