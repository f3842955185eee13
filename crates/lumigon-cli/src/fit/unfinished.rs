//! An unfinished fit on disk.

use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

use lumigon_fit::{Checkpoint, Fit, FitError, Settings};
use serde::{Deserialize, Serialize};

/// Most bytes that a texel's coordinates take, as text, with room to spare.
const TEXEL_BYTES: u64 = 1024;

/// The file beside a table to be that holds what is done of its fit.
pub(super) struct Unfinished {
    path: PathBuf,
}

/// What the file holds.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    /// Version of lumigon: another one may fit otherwise.
    lumigon: String,
    checkpoint: Checkpoint,
}

/// What is wrong with the file, and the mend.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}; --fresh begins anew in its place", path.display())]
pub(super) struct UnusableError {
    path: PathBuf,
    problem: String,
}

/// The file could not be read, written or removed.
#[derive(Debug, thiserror::Error)]
#[error("{}: {source}", path.display())]
pub(super) struct FileError {
    path: PathBuf,
    source: io::Error,
}

impl Unfinished {
    /// The file for a table in this folder.
    pub(super) fn beside(folder: &Path, settings: &Settings) -> Self {
        Self {
            path: folder.join(format!("{}.unfinished.json", settings.name())),
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The fit to go on with; `None` where there is no file.
    pub(super) fn resume(&self, settings: &Settings) -> Result<Option<Fit>, UnusableError> {
        let unusable = |problem: String| UnusableError {
            path: self.path.clone(),
            problem,
        };
        let file = match File::open(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            file => file.map_err(|error| unusable(error.to_string()))?,
        };
        let length = file
            .metadata()
            .map_err(|error| unusable(error.to_string()))?
            .len();
        let texels: usize = settings.brdf.sizes(settings.size).iter().product();
        let most = (texels as u64 + 1) * TEXEL_BYTES;
        if length > most {
            let problem =
                format!("{length} bytes; an unfinished fit of this table has at most {most}");
            return Err(unusable(problem));
        }
        let contents: Contents = serde_json::from_reader(BufReader::new(file))
            .map_err(|error| unusable(format!("no unfinished fit: {error}")))?;
        let version = env!("CARGO_PKG_VERSION");
        if contents.lumigon != version {
            let problem = format!(
                "begun by lumigon {}, and this is {version}",
                contents.lumigon
            );
            return Err(unusable(problem));
        }
        match Fit::resume(settings, contents.checkpoint) {
            Ok(fit) => Ok(Some(fit)),
            Err(FitError::Settings(problem)) => Err(unusable(problem)),
            Err(error) => Err(unusable(error.to_string())),
        }
    }

    /// Writes what is done, whole: a fit in progress may be saved at any time.
    pub(super) fn save(&self, fit: &Fit) -> Result<(), FileError> {
        let contents = Contents {
            lumigon: env!("CARGO_PKG_VERSION").to_owned(),
            checkpoint: fit.checkpoint(),
        };
        self.write(&contents).map_err(|source| self.error(source))
    }

    fn write(&self, contents: &Contents) -> io::Result<()> {
        let folder = self.path.parent().unwrap_or(Path::new("."));
        let file = tempfile::NamedTempFile::new_in(folder)?;
        let mut writer = BufWriter::new(file);
        serde_json::to_writer(&mut writer, contents)?;
        writer.flush()?;
        let file = writer
            .into_inner()
            .map_err(io::IntoInnerError::into_error)?;
        // It is there for the day when the machine stops.
        file.as_file().sync_all()?;
        file.persist(&self.path)?;
        Ok(())
    }

    /// The table is there: nothing to go on with.
    pub(super) fn remove(&self) -> Result<(), FileError> {
        fs::remove_file(&self.path).map_err(|source| self.error(source))
    }

    fn error(&self, source: io::Error) -> FileError {
        FileError {
            path: self.path.clone(),
            source,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

    use lumigon_fit::BrdfKind;

    use super::*;

    fn settings() -> Settings {
        Settings {
            size: 3,
            directions: 200,
            samples: 12,
            ..Settings::of(BrdfKind::Eon, 1)
        }
    }

    /// Stopped again and again, each time after a few texels, and read back from disk each time.
    #[test]
    fn interrupted_fit_ends_at_the_same_table() {
        let settings = settings();
        let never = AtomicBool::new(false);
        let whole = Fit::new(&settings)
            .unwrap()
            .run(&|_, _| (), &never)
            .unwrap();
        let folder = tempfile::tempdir().unwrap();
        let unfinished = Unfinished::beside(folder.path(), &settings);
        assert!(unfinished.resume(&settings).unwrap().is_none());
        let mut fit = Fit::new(&settings).unwrap();
        let mut stops = 0;
        let table = loop {
            let (stop, texels) = (AtomicBool::new(false), AtomicUsize::new(0));
            let progress = |_, _| {
                if texels.fetch_add(1, Ordering::Relaxed) >= 5 {
                    stop.store(true, Ordering::Relaxed);
                }
            };
            match fit.run(&progress, &stop) {
                Ok(table) => break table,
                Err(FitError::Cancelled) => stops += 1,
                Err(error) => panic!("{error}"),
            }
            unfinished.save(&fit).unwrap();
            fit = unfinished.resume(&settings).unwrap().unwrap();
        };
        assert!(stops > 4, "{stops}");
        assert_eq!(table, whole);
        unfinished.remove().unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn unusable_files_are_named_with_the_mend() {
        let settings = settings();
        let folder = tempfile::tempdir().unwrap();
        let unfinished = Unfinished::beside(folder.path(), &settings);
        let message = |settings: &Settings| match unfinished.resume(settings) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("it was taken"),
        };
        unfinished.save(&Fit::new(&settings).unwrap()).unwrap();
        let good = fs::read_to_string(unfinished.path()).unwrap();
        let other = Settings {
            seed: 2,
            ..settings.clone()
        };
        let refused = message(&other);
        assert!(refused.contains("eon-3.unfinished.json") && refused.contains("--fresh"));
        assert!(refused.contains("other settings"), "{refused}");
        for (text, expected) in [
            (good[..good.len() / 2].to_owned(), "no unfinished fit"),
            (String::new(), "no unfinished fit"),
            (good.replace("\"pass\":0", "\"pass\":1"), "damaged"),
            (good.replace("\"pass\":0", "\"pass\":1000000"), "damaged"),
            (good.replace("[[],", "["), "damaged"),
            (
                good.replacen("[[],", "[[9221120237041090560],", 1),
                "damaged",
            ),
            (
                good.replace(env!("CARGO_PKG_VERSION"), "0.0.0"),
                "lumigon 0.0.0",
            ),
            (good + &" ".repeat(20_000), "at most"),
        ] {
            fs::write(unfinished.path(), text).unwrap();
            let refused = message(&settings);
            assert!(refused.contains(expected), "{refused}");
            assert!(refused.contains("--fresh"), "{refused}");
        }
    }
}
