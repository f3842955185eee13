//! Writing files, whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use tempfile::NamedTempFile;

/// A file of no lasting name in the folder of `path`, gone when dropped.
pub(crate) fn beside(path: &Path) -> io::Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    // A temporary file is private; a picture is not.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let made = builder.prefix(".lumigon-").tempfile_in(folder);
    made.map_err(without_name)
}

/// What the system says, without the name of a file that nobody asked for.
fn without_name(fault: io::Error) -> io::Error {
    let inner = fault.get_ref().and_then(|fault| fault.source());
    let inner = inner.and_then(|source| source.downcast_ref::<io::Error>());
    let code = inner.and_then(io::Error::raw_os_error);
    code.map_or(fault, io::Error::from_raw_os_error)
}

/// Writes a file whole or not at all: beside the target, then renamed. A reader sees the old file or the
/// new one.
///
/// # Errors
/// What `write` or the system says; nothing is left then.
pub fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> io::Result<()> {
    let file = beside(path)?;
    let mut buffer = BufWriter::new(file.as_file());
    write(&mut buffer)?;
    buffer.flush()?;
    drop(buffer);
    file.as_file().sync_all()?;
    file.persist(path).map(drop).map_err(|error| error.error)
}
