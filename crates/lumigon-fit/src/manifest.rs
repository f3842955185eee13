use std::{
    io::Write,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::{
    errors::ErrorReport, fit::FitError, kind::BrdfKind, layout::Layout, settings::Settings,
    table::Table,
};

/// Seed of the lights that a manifest's errors are measured on.
const TEST_SEED: u64 = 0x7E57;

/// All that a reader of the raw file must know, and how to make it again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Raw file beside the manifest: little-endian f32, row by row.
    pub file: String,
    /// Its SHA-256 in hexadecimal.
    pub sha256: String,
    /// Command that makes the table again.
    pub command: String,
    /// Texels along each axis, the first the fastest.
    pub sizes: Vec<usize>,
    /// Numbers a texel, in order.
    pub channels: Vec<String>,
    /// Meaning of the axes.
    pub axes: Vec<String>,
    /// Where texels lie.
    pub texel_rule: String,
    /// Shading space and the unit space that matrices start from.
    pub frame: String,
    /// How numbers make the matrix.
    pub normalisation: String,
    /// How a response is computed.
    pub response: String,
    /// Settings of the fit.
    pub settings: Settings,
    /// Errors on lights it wasn't fitted to, perceptual roughness 0.1 to 1.
    pub errors: ErrorReport,
    /// The same at perceptual roughness 0.02 to 0.1, where lobes are narrow against the
    /// step between two view angles of the table.
    pub errors_smooth: ErrorReport,
}

impl Manifest {
    fn new(table: &Table, name: &str, bytes: &[u8], command: &str) -> Self {
        Self {
            file: format!("{name}.f32"),
            sha256: hash(bytes),
            command: command.into(),
            sizes: table.sizes(),
            channels: table.layout().channels(),
            axes: table.brdf().axes().iter().map(|&axis| axis.into()).collect(),
            texel_rule: "texel centres on the ends: u in [0,1] is texel position u * (size - 1) along each axis; linear between".into(),
            frame: frame(table.brdf()).into(),
            normalisation: table.layout().normalisation().into(),
            response: response(table.brdf()).into(),
            settings: table.settings.clone(),
            errors: table.errors([0.1, 1.0], TEST_SEED, 1024, 64),
            errors_smooth: table.errors([0.02, 0.1], TEST_SEED, 256, 64),
        }
    }

    pub(crate) fn write(table: &Table, folder: &Path, command: &str) -> Result<Self, FitError> {
        let name = table.settings.name();
        let bytes: Vec<u8> = table.texels.iter().flat_map(|x| x.to_le_bytes()).collect();
        let manifest = Self::new(table, &name, &bytes, command);
        write_whole(&folder.join(&manifest.file), &bytes)?;
        let path = folder.join(format!("{name}.json"));
        let mut json =
            serde_json::to_string_pretty(&manifest).map_err(|e| malformed(&path, e.to_string()))?;
        json.push('\n');
        write_whole(&path, json.as_bytes())?;
        Ok(manifest)
    }

    /// Reads a manifest.
    ///
    /// # Errors
    /// Where the file cannot be read or isn't a manifest.
    pub fn read(path: &Path) -> Result<Self, FitError> {
        let text = std::fs::read_to_string(path).map_err(|source| io(path, source))?;
        serde_json::from_str(&text)
            .map_err(|e| malformed(path, format!("not a table's manifest: {e}")))
    }

    /// Reads the raw file beside the manifest.
    pub(crate) fn table(&self, manifest: &Path) -> Result<Table, FitError> {
        self.settings
            .validate()
            .map_err(|problem| malformed(manifest, problem))?;
        let sizes = self.settings.brdf.sizes(self.settings.size);
        let channels = Layout::new(&self.settings).channels();
        if self.sizes != sizes || self.channels != channels {
            return Err(malformed(
                manifest,
                format!(
                    "sizes {:?} and channels {:?} are not those of its settings, {sizes:?} and {channels:?}",
                    self.sizes, self.channels
                ),
            ));
        }
        // The raw file lies beside its manifest: a path that leads elsewhere is refused.
        let file = Path::new(&self.file);
        if file.file_name() != Some(file.as_os_str()) {
            return Err(malformed(
                manifest,
                format!("file is {:?}, which is no plain file name", self.file),
            ));
        }
        let path = manifest.with_file_name(file);
        let expected = sizes.iter().product::<usize>() * channels.len() * 4;
        let found = std::fs::metadata(&path)
            .map_err(|source| io(&path, source))?
            .len();
        if found != expected as u64 {
            return Err(malformed(
                &path,
                format!("{found} bytes; a table of this size has {expected}"),
            ));
        }
        let bytes = std::fs::read(&path).map_err(|source| io(&path, source))?;
        if hash(&bytes) != self.sha256 {
            return Err(malformed(
                &path,
                format!(
                    "its SHA-256 isn't the manifest's; make it again: {}",
                    self.command
                ),
            ));
        }
        let texels: Vec<f32> = bytes
            .as_chunks::<4>()
            .0
            .iter()
            .map(|b| f32::from_le_bytes(*b))
            .collect();
        if let Some(bad) = texels.iter().position(|x| !x.is_finite()) {
            return Err(malformed(&path, format!("number {bad} isn't finite")));
        }
        Ok(Table {
            settings: self.settings.clone(),
            texels,
        })
    }
}

/// Shading space, and the unit space that a table's matrices start from.
fn frame(brdf: BrdfKind) -> &'static str {
    match brdf {
        BrdfKind::Ggx => {
            "shading space: z = normal, view = (sin theta_view, 0, cos theta_view). shading_to_unit turns the mirrored view into z, then divides x and y by alpha: rows (cos / alpha, 0, sin / alpha), (0, 1 / alpha, 0), (-sin, 0, cos) of theta_view"
        }
        BrdfKind::GgxAnisotropic => {
            "shading space: z = normal, x along the greater width alpha_x. shading_to_unit turns the mirrored view into z, about the axis at right angles to both, then divides x by alpha_x and y by alpha_y"
        }
        BrdfKind::Charlie | BrdfKind::Eon => {
            "shading space: z = normal, view = (sin theta_view, 0, cos theta_view). shading_to_unit = 1"
        }
    }
}

/// How a texel's lobes make a response.
fn response(brdf: BrdfKind) -> &'static str {
    match brdf {
        BrdfKind::Ggx | BrdfKind::GgxAnisotropic => {
            "form_factor = E / pi in [0,1] of shading_to_cosine * polygon, clipped by the true horizon and by z > 0 of cosine space. Summed over lobes: F = 1: amplitude * form_factor; weighted with (1 - h.v)^5: schlick * form_factor; Schlick's Fresnel: (f0 * (amplitude - schlick) + f90 * schlick) * form_factor"
        }
        BrdfKind::Charlie => {
            "form_factor = E / pi in [0,1] of shading_to_cosine * polygon, clipped by the true horizon and by z > 0 of cosine space. Summed over lobes: amplitude * form_factor. Lobe \"cosine\": shading_to_cosine = 1"
        }
        BrdfKind::Eon => {
            "form_factor = E / pi in [0,1] of shading_to_cosine * polygon, clipped by the true horizon and by z > 0 of cosine space. Summed over lobes: (rho * amplitude + rho_ms * multiple_scattering) * form_factor, rho_ms = rho^2 <E> / (1 - rho (1 - <E>)). Lobe \"cosine\": shading_to_cosine = 1"
        }
    }
}

fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect()
}

fn io(path: &Path, source: std::io::Error) -> FitError {
    FitError::Io {
        path: PathBuf::from(path),
        source,
    }
}

fn malformed(path: &Path, problem: String) -> FitError {
    FitError::Malformed {
        path: PathBuf::from(path),
        problem,
    }
}

/// Writes beside the target, then renames: a reader sees the old file or the new one.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), FitError> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(|e| io(path, e))?;
    file.write_all(bytes).map_err(|e| io(path, e))?;
    // A temporary file is private; a table is not.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let open = std::fs::Permissions::from_mode(0o644);
        file.as_file()
            .set_permissions(open)
            .map_err(|e| io(path, e))?;
    }
    file.persist(path).map_err(|e| io(path, e.error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;

    fn written() -> (tempfile::TempDir, PathBuf, Table) {
        let settings = Settings {
            size: 2,
            directions: 100,
            samples: 8,
            sweeps: 0,
            ..Settings::default()
        };
        let table = crate::fit(&settings, &|_, _| (), &AtomicBool::new(false)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        table.write(folder.path(), "a command").unwrap();
        let path = folder.path().join("ggx-2.json");
        (folder, path, table)
    }

    #[test]
    fn round_trip() {
        let (folder, path, table) = written();
        assert_eq!(Table::read(&path).unwrap(), table);
        assert_eq!(Manifest::read(&path).unwrap().command, "a command");
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            2,
            "no file left over"
        );
    }

    #[test]
    fn broken_files_are_named() {
        let (folder, path, _) = written();
        let raw = folder.path().join("ggx-2.f32");
        let mut bytes = std::fs::read(&raw).unwrap();
        bytes[5] ^= 1;
        std::fs::write(&raw, &bytes).unwrap();
        let message = Table::read(&path).unwrap_err().to_string();
        assert!(
            message.contains("ggx-2.f32") && message.contains("SHA-256"),
            "{message}"
        );
        std::fs::write(&raw, &bytes[..100]).unwrap();
        assert!(
            Table::read(&path)
                .unwrap_err()
                .to_string()
                .contains("100 bytes")
        );
        std::fs::write(&path, "{").unwrap();
        assert!(
            Table::read(&path)
                .unwrap_err()
                .to_string()
                .contains("ggx-2.json")
        );
        std::fs::remove_file(&path).unwrap();
        assert!(matches!(Table::read(&path), Err(FitError::Io { .. })));
    }

    #[test]
    fn manifest_cannot_lead_elsewhere() {
        let (_folder, path, _) = written();
        let mut manifest = Manifest::read(&path).unwrap();
        manifest.file = "../ggx-2.f32".into();
        std::fs::write(&path, serde_json::to_string(&manifest).unwrap()).unwrap();
        assert!(
            Table::read(&path)
                .unwrap_err()
                .to_string()
                .contains("plain file name")
        );
    }
}
