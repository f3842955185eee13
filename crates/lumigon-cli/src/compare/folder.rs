//! The report's folder, there whole or not at all.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::error::CompareError;

/// The file that marks a folder as a report, and lists what belongs to it.
pub(super) const METRICS: &str = "metrics.json";

/// What [`METRICS`] says of its maker.
pub(super) const GENERATOR: &str = "lumigon compare";

/// A folder beside its destination, moved there when it is complete and removed otherwise.
#[derive(Debug)]
pub(super) struct ReportFolder {
    destination: PathBuf,
    folder: TempDir,
}

impl ReportFolder {
    /// Whether [`ReportFolder::create`] would find a place.
    ///
    /// # Errors
    /// Where `destination` holds anything but an earlier report, or has no parent.
    pub(super) fn check(destination: &Path) -> Result<(), CompareError> {
        refuse_foreign(&resolve(destination)?)
    }

    /// Makes the folder beside `destination`.
    ///
    /// # Errors
    /// Where `destination` holds anything but an earlier report, or cannot be written beside.
    pub(super) fn create(destination: &Path) -> Result<Self, CompareError> {
        let destination = resolve(destination)?;
        refuse_foreign(&destination)?;
        let parent = destination.parent().unwrap_or(Path::new("/"));
        let folder = tempfile::Builder::new()
            .prefix(".lumigon-compare-")
            .tempdir_in(parent)
            .map_err(|source| CompareError::io(parent, source))?;
        Ok(Self {
            destination,
            folder,
        })
    }

    /// Where to write.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Moves the folder to its destination, in place of an earlier report.
    ///
    /// # Errors
    /// Where the destination has become something else meanwhile, or cannot be replaced.
    pub(super) fn commit(self) -> Result<(), CompareError> {
        let destination = self.destination;
        let failed = |source| CompareError::io(&destination, source);
        // Someone may have put files there while the pictures were rendered.
        refuse_foreign(&destination)?;
        let aside = TempDir::with_prefix_in(
            ".lumigon-compare-",
            destination.parent().unwrap_or(Path::new("/")),
        )
        .map_err(failed)?;
        let earlier = aside.path().join("earlier");
        let replaces = destination.exists();
        if replaces {
            fs::rename(&destination, &earlier).map_err(failed)?;
        }
        if let Err(source) = fs::rename(self.folder.path(), &destination) {
            if replaces {
                fs::rename(&earlier, &destination).map_err(failed)?;
            }
            return Err(failed(source));
        }
        // It has moved: there is nothing left to remove under its old name.
        let _ = self.folder.keep();
        Ok(())
    }
}

/// The destination as an absolute path through folders that exist.
fn resolve(destination: &Path) -> Result<PathBuf, CompareError> {
    let failed = |source| CompareError::io(destination, source);
    if destination.exists() {
        return destination.canonicalize().map_err(failed);
    }
    let absolute = std::path::absolute(destination).map_err(failed)?;
    let parent = absolute.parent().unwrap_or(Path::new("/"));
    let parent = parent
        .canonicalize()
        .map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => CompareError::NoParent {
                path: destination.to_owned(),
                parent: parent.to_owned(),
            },
            _ => CompareError::io(parent, source),
        })?;
    match absolute.file_name() {
        Some(name) => Ok(parent.join(name)),
        None => Ok(parent),
    }
}

/// An error unless `destination` is missing, empty, or an earlier report and nothing else.
fn refuse_foreign(destination: &Path) -> Result<(), CompareError> {
    let refuse = |what: String| {
        Err(CompareError::Occupied {
            path: destination.to_owned(),
            what,
        })
    };
    match fs::symlink_metadata(destination) {
        Err(source) if source.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(CompareError::io(destination, source)),
        Ok(metadata) if !metadata.is_dir() => return refuse("is not a folder".to_owned()),
        Ok(_) => {}
    }
    let mut found = BTreeSet::new();
    list(destination, Path::new(""), &mut found)
        .map_err(|source| CompareError::io(destination, source))?;
    if found.is_empty() {
        return Ok(());
    }
    let Some(report) = listed(destination) else {
        return refuse("holds files, but no earlier report".to_owned());
    };
    match found.difference(&report).next() {
        Some(foreign) => refuse(format!("holds {foreign:?}, which is no part of its report")),
        None => Ok(()),
    }
}

/// Every file below a folder, relative to it, with forward slashes.
fn list(root: &Path, below: &Path, found: &mut BTreeSet<String>) -> io::Result<()> {
    for entry in fs::read_dir(root.join(below))? {
        let entry = entry?;
        let path = below.join(entry.file_name());
        // A file in the place of a folder is foreign; folders count by their files.
        if entry.file_type()?.is_dir() {
            list(root, &path, found)?;
        } else {
            let names = path.iter().map(|name| name.to_string_lossy());
            found.insert(names.collect::<Vec<_>>().join("/"));
        }
    }
    Ok(())
}

/// What an earlier report says are its files; none where there is no earlier report.
fn listed(destination: &Path) -> Option<BTreeSet<String>> {
    let text = fs::read(destination.join(METRICS)).ok()?;
    let metrics: serde_json::Value = serde_json::from_slice(&text).ok()?;
    if metrics.get("generator")?.as_str()? != GENERATOR {
        return None;
    }
    let files = metrics.get("files")?.as_array()?;
    files
        .iter()
        .map(|file| file.as_str().map(ToOwned::to_owned))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write_report(destination: &Path, text: &str) -> Result<(), CompareError> {
        let folder = ReportFolder::create(destination)?;
        let metrics = serde_json::json!({
            "generator": GENERATOR,
            "files": [METRICS, "pictures/text"],
        });
        fs::write(folder.path().join(METRICS), metrics.to_string()).unwrap();
        fs::create_dir(folder.path().join("pictures")).unwrap();
        fs::write(folder.path().join("pictures/text"), text).unwrap();
        folder.commit()
    }

    fn entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn new_empty_and_earlier_folders_are_filled() {
        let root = TempDir::new().unwrap();
        let destination = root.path().join("report");
        write_report(&destination, "new").unwrap();
        write_report(&destination, "again").unwrap();
        let text = fs::read_to_string(destination.join("pictures/text")).unwrap();
        assert_eq!(text, "again");
        let empty = root.path().join("empty");
        fs::create_dir(&empty).unwrap();
        write_report(&empty, "new").unwrap();
        assert_eq!(entries(root.path()), 2, "nothing is left beside them");
    }

    #[test]
    fn foreign_files_stay() {
        let root = TempDir::new().unwrap();
        let destination = root.path().join("report");
        fs::create_dir(&destination).unwrap();
        fs::write(destination.join("thesis.txt"), "years").unwrap();
        let error = write_report(&destination, "new").unwrap_err();
        assert!(error.to_string().contains("no earlier report"), "{error}");
        fs::write(destination.join(METRICS), "{}").unwrap();
        assert!(write_report(&destination, "new").is_err());

        let mixed = root.path().join("mixed");
        write_report(&mixed, "new").unwrap();
        fs::write(mixed.join("pictures/note.txt"), "mine").unwrap();
        let error = write_report(&mixed, "again").unwrap_err();
        assert!(error.to_string().contains("pictures/note.txt"), "{error}");

        let file = root.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(write_report(&file, "new").is_err());
        assert_eq!(entries(root.path()), 3, "nothing is left beside them");
    }

    #[test]
    fn files_that_arrive_meanwhile_stay() {
        let root = TempDir::new().unwrap();
        let destination = root.path().join("report");
        let folder = ReportFolder::create(&destination).unwrap();
        fs::create_dir(&destination).unwrap();
        fs::write(destination.join("thesis.txt"), "years").unwrap();
        assert!(folder.commit().is_err());
        assert!(destination.join("thesis.txt").exists());
        assert_eq!(entries(root.path()), 1, "nothing is left beside it");
    }

    #[test]
    fn missing_parent_is_named() {
        let root = TempDir::new().unwrap();
        let error = ReportFolder::create(&root.path().join("no/report")).unwrap_err();
        assert!(error.to_string().contains("no"), "{error}");
    }
}
