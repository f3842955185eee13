//! The report's folder, there whole or not at all.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// The file that marks a folder as a report, and lists what belongs to it.
pub(crate) const METRICS: &str = "metrics.json";

/// Why a report has no folder.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FolderError {
    /// The folder belongs to something else.
    #[error("{}: {what}; name a new or an empty folder, or an earlier report", path.display())]
    Occupied {
        /// The folder.
        path: PathBuf,
        /// What is there.
        what: String,
    },
    /// The folder has nowhere to be.
    #[error("{}: there is no folder {}; make it first", path.display(), parent.display())]
    NoParent {
        /// The folder.
        path: PathBuf,
        /// The folder it would be in.
        parent: PathBuf,
    },
    /// A folder could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl FolderError {
    fn io(path: &Path, source: io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }
}

/// A folder beside its destination, moved there when it is complete and removed otherwise.
#[derive(Debug)]
pub(crate) struct ReportFolder {
    destination: PathBuf,
    generator: &'static str,
    folder: TempDir,
}

impl ReportFolder {
    /// Whether [`ReportFolder::create`] would find a place. `generator` is what [`METRICS`] says of
    /// its maker: only its own earlier reports are replaced.
    ///
    /// # Errors
    /// Where `destination` holds anything but an earlier report, or has no parent.
    pub(crate) fn check(destination: &Path, generator: &str) -> Result<(), FolderError> {
        refuse_foreign(&resolve(destination)?, generator)
    }

    /// Makes the folder beside `destination`.
    ///
    /// # Errors
    /// Where `destination` holds anything but an earlier report, or cannot be written beside.
    pub(crate) fn create(destination: &Path, generator: &'static str) -> Result<Self, FolderError> {
        let destination = resolve(destination)?;
        refuse_foreign(&destination, generator)?;
        let parent = destination.parent().unwrap_or(Path::new("/"));
        let folder = tempfile::Builder::new()
            .prefix(".lumigon-report-")
            .tempdir_in(parent)
            .map_err(|source| FolderError::io(parent, source))?;
        Ok(Self {
            destination,
            generator,
            folder,
        })
    }

    /// Where to write.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Moves the folder to its destination, in place of an earlier report.
    ///
    /// # Errors
    /// Where the destination has become something else meanwhile, or cannot be replaced.
    pub(crate) fn commit(self) -> Result<(), FolderError> {
        let destination = self.destination;
        let failed = |source| FolderError::io(&destination, source);
        // Someone may have put files there while the pictures were rendered.
        refuse_foreign(&destination, self.generator)?;
        let aside = TempDir::with_prefix_in(
            ".lumigon-report-",
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
fn resolve(destination: &Path) -> Result<PathBuf, FolderError> {
    let failed = |source| FolderError::io(destination, source);
    if destination.exists() {
        return destination.canonicalize().map_err(failed);
    }
    let absolute = std::path::absolute(destination).map_err(failed)?;
    let parent = absolute.parent().unwrap_or(Path::new("/"));
    let parent = parent
        .canonicalize()
        .map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => FolderError::NoParent {
                path: destination.to_owned(),
                parent: parent.to_owned(),
            },
            _ => FolderError::io(parent, source),
        })?;
    match absolute.file_name() {
        Some(name) => Ok(parent.join(name)),
        None => Ok(parent),
    }
}

/// An error unless `destination` is missing, empty, or an earlier report and nothing else.
fn refuse_foreign(destination: &Path, generator: &str) -> Result<(), FolderError> {
    let refuse = |what: String| {
        Err(FolderError::Occupied {
            path: destination.to_owned(),
            what,
        })
    };
    match fs::symlink_metadata(destination) {
        Err(source) if source.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(FolderError::io(destination, source)),
        Ok(metadata) if !metadata.is_dir() => return refuse("is not a folder".to_owned()),
        Ok(_) => {}
    }
    let mut found = BTreeSet::new();
    list(destination, Path::new(""), &mut found)
        .map_err(|source| FolderError::io(destination, source))?;
    if found.is_empty() {
        return Ok(());
    }
    let Some(report) = listed(destination, generator) else {
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
fn listed(destination: &Path, generator: &str) -> Option<BTreeSet<String>> {
    let text = fs::read(destination.join(METRICS)).ok()?;
    let metrics: serde_json::Value = serde_json::from_slice(&text).ok()?;
    if metrics.get("generator")?.as_str()? != generator {
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

    const GENERATOR: &str = "a test";

    fn write_report(destination: &Path, text: &str) -> Result<(), FolderError> {
        let folder = ReportFolder::create(destination, GENERATOR)?;
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
        let folder = ReportFolder::create(&destination, GENERATOR).unwrap();
        fs::create_dir(&destination).unwrap();
        fs::write(destination.join("thesis.txt"), "years").unwrap();
        assert!(folder.commit().is_err());
        assert!(destination.join("thesis.txt").exists());
        assert_eq!(entries(root.path()), 1, "nothing is left beside it");
    }

    #[test]
    fn missing_parent_is_named() {
        let root = TempDir::new().unwrap();
        let error = ReportFolder::create(&root.path().join("no/report"), GENERATOR).unwrap_err();
        assert!(error.to_string().contains("no"), "{error}");
    }
}
