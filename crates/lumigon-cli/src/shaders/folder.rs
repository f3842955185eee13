//! An export's folder, written beside its destination and moved there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// Why an export has no folder.
#[derive(Debug, thiserror::Error)]
pub(super) enum FolderError {
    #[error(
        "{}: the folder holds files: name a new or an empty folder, or give --force to replace what has the same names",
        path.display()
    )]
    Occupied { path: PathBuf },
    #[error("{}: is not a folder: name a folder", path.display())]
    NotAFolder { path: PathBuf },
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
}

/// A folder beside its destination, gone unless it is committed.
#[derive(Debug)]
pub(super) struct ExportFolder {
    /// As the user named it.
    named: PathBuf,
    /// Absolute, through folders that exist.
    destination: PathBuf,
    force: bool,
    folder: TempDir,
}

impl ExportFolder {
    /// Makes the folder beside `destination`, whose parents are made where they are missing.
    ///
    /// # Errors
    /// Where the destination is no folder, or, without `force`, holds anything.
    pub(super) fn create(destination: &Path, force: bool) -> Result<Self, FolderError> {
        let failed = |source| io(destination, source);
        let absolute = match destination.canonicalize() {
            Ok(absolute) => absolute,
            Err(_) => {
                let absolute = std::path::absolute(destination).map_err(failed)?;
                let parent = absolute.parent().unwrap_or(Path::new("/"));
                fs::create_dir_all(parent).map_err(|source| io(parent, source))?;
                absolute
            }
        };
        refuse(destination, &absolute, force)?;
        let parent = absolute.parent().unwrap_or(&absolute);
        let folder = tempfile::Builder::new()
            .prefix(".lumigon-export-")
            .tempdir_in(parent)
            .map_err(|source| io(parent, source))?;
        Ok(Self {
            named: destination.to_owned(),
            destination: absolute,
            force,
            folder,
        })
    }

    /// Where to write.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Moves the folder to its destination, or its files where there is a folder already. The files'
    /// paths.
    ///
    /// # Errors
    /// Where the destination was filled meanwhile, or cannot be written.
    pub(super) fn commit(self) -> Result<Vec<PathBuf>, FolderError> {
        refuse(&self.named, &self.destination, self.force)?;
        let mut files = Vec::new();
        list(self.folder.path(), Path::new(""), &mut files)
            .map_err(|source| io(self.folder.path(), source))?;
        files.sort();
        let exists = self.destination.exists();
        // Read by others, unlike a temporary folder.
        #[cfg(unix)]
        if !exists {
            use std::os::unix::fs::PermissionsExt;
            let open = fs::Permissions::from_mode(0o755);
            fs::set_permissions(self.folder.path(), open)
                .map_err(|source| io(self.folder.path(), source))?;
        }
        if exists {
            for file in &files {
                let target = self.destination.join(file);
                let parent = target.parent().unwrap_or(&self.destination);
                fs::create_dir_all(parent)
                    .and_then(|()| fs::rename(self.folder.path().join(file), &target))
                    .map_err(|source| io(&self.named.join(file), source))?;
            }
        } else {
            fs::rename(self.folder.path(), &self.destination)
                .map_err(|source| io(&self.named, source))?;
            // It has moved: there is nothing left to remove under its old name.
            let _ = self.folder.keep();
        }
        Ok(files.iter().map(|file| self.named.join(file)).collect())
    }
}

fn io(path: &Path, source: io::Error) -> FolderError {
    FolderError::Io {
        path: path.to_owned(),
        source,
    }
}

/// An error unless the destination is missing or an empty folder, or `force` and a folder.
fn refuse(named: &Path, destination: &Path, force: bool) -> Result<(), FolderError> {
    let path = named.to_owned();
    match fs::metadata(destination) {
        Err(source) if source.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(source) => Err(io(named, source)),
        Ok(metadata) if !metadata.is_dir() => Err(FolderError::NotAFolder { path }),
        Ok(_) if force => Ok(()),
        Ok(_) => match fs::read_dir(destination).map(|mut entries| entries.next().is_none()) {
            Ok(true) => Ok(()),
            Ok(false) => Err(FolderError::Occupied { path }),
            Err(source) => Err(io(named, source)),
        },
    }
}

/// Every file below a folder, relative to it.
fn list(root: &Path, below: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(root.join(below))? {
        let entry = entry?;
        let path = below.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            list(root, &path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(destination: &Path, force: bool) -> Result<Vec<PathBuf>, FolderError> {
        let folder = ExportFolder::create(destination, force)?;
        fs::create_dir(folder.path().join("tables")).unwrap();
        fs::write(folder.path().join("a"), "new").unwrap();
        fs::write(folder.path().join("tables/b"), "new").unwrap();
        folder.commit()
    }

    #[test]
    fn new_and_empty_folders_are_filled() {
        let root = TempDir::new().unwrap();
        let deep = root.path().join("x/y/z");
        let files = write(&deep, false).unwrap();
        assert_eq!(files, [deep.join("a"), deep.join("tables/b")]);
        assert!(files.iter().all(|file| file.is_file()));
        let empty = root.path().join("empty");
        fs::create_dir(&empty).unwrap();
        write(&empty, false).unwrap();
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 2);
        assert_eq!(fs::read_dir(root.path().join("x/y")).unwrap().count(), 1);
    }

    #[test]
    fn what_is_there_stays() {
        let root = TempDir::new().unwrap();
        let folder = root.path().join("engine");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("thesis"), "years").unwrap();
        fs::write(folder.join("a"), "old").unwrap();
        let error = write(&folder, false).unwrap_err().to_string();
        assert!(error.contains("--force"), "{error}");
        assert_eq!(fs::read_to_string(folder.join("a")).unwrap(), "old");
        write(&folder, true).unwrap();
        assert_eq!(fs::read_to_string(folder.join("a")).unwrap(), "new");
        assert_eq!(fs::read_to_string(folder.join("thesis")).unwrap(), "years");
        let file = write(&folder.join("thesis"), true).unwrap_err().to_string();
        assert!(file.contains("is not a folder"), "{file}");
        assert!(write(&folder.join("thesis/below"), true).is_err());
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
    }
}
