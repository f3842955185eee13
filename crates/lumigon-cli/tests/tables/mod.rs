//! Small fitted tables for tests.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use lumigon_fit::{Manifest, Settings, Table};
use sha2::{Digest, Sha256};

/// Fits a table and writes it into a folder, with few lights for the errors in its manifest, which
/// take far longer than the fit of a small table. The manifest's path.
pub(crate) fn write(settings: &Settings, folder: &Path) -> PathBuf {
    let table = lumigon_fit::fit(settings, &|_, _| (), &AtomicBool::new(false)).unwrap();
    let bytes: Vec<u8> = table
        .texels()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let name = settings.name();
    let digest = Sha256::digest(&bytes);
    let manifest = Manifest {
        file: format!("{name}.f32"),
        sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(),
        command: "a test".to_owned(),
        sizes: table.sizes(),
        channels: table.layout().channels(),
        axes: table
            .brdf()
            .axes()
            .iter()
            .map(|&axis| axis.to_owned())
            .collect(),
        texel_rule: "texel centres on the ends".to_owned(),
        frame: "shading space".to_owned(),
        normalisation: table.layout().normalisation().to_owned(),
        response: "the sum over the lobes".to_owned(),
        settings: settings.clone(),
        errors: table.errors([0.1, 1.0], 77, 128, 16),
        errors_smooth: table.errors([0.02, 0.1], 77, 4, 4),
    };
    fs::write(folder.join(&manifest.file), bytes).unwrap();
    let path = folder.join(format!("{name}.json"));
    fs::write(&path, serde_json::to_string_pretty(&manifest).unwrap()).unwrap();
    assert_eq!(Table::read(&path).unwrap(), table);
    path
}
