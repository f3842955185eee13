//! The bytes behind a document: its buffers, and files beside it.

use std::{
    borrow::Cow,
    fs,
    io::Read,
    path::{Component, Path, PathBuf},
    rc::Rc,
};

use base64::{
    Engine,
    alphabet::STANDARD,
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
};
use gltf::json;
use percent_encoding::percent_decode_str;

use crate::scene::{Limits, error::Fault};

/// Base64 as data URIs have it: padded or not.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Where a document's bytes come from. Buffers are read when first asked for, then kept.
pub(super) struct Source<'a> {
    root: &'a json::Root,
    binary: Option<&'a [u8]>,
    base_folder: Option<&'a Path>,
    /// How many more bytes may be read from files.
    bytes_left: u64,
    buffers: Vec<Option<Rc<Cow<'a, [u8]>>>>,
}

/// A part of a buffer.
#[derive(Clone)]
pub(super) struct View<'a> {
    buffer: Rc<Cow<'a, [u8]>>,
    start: usize,
    end: usize,
    pub(super) stride: Option<usize>,
}

impl View<'_> {
    pub(super) fn bytes(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }
}

impl<'a> Source<'a> {
    pub(super) fn new(
        root: &'a json::Root,
        binary: Option<&'a [u8]>,
        base_folder: Option<&'a Path>,
        limits: &Limits,
    ) -> Self {
        Self {
            root,
            binary,
            base_folder,
            bytes_left: limits.file_bytes,
            buffers: vec![None; root.buffers.len()],
        }
    }

    /// Of buffers that were read already.
    pub(super) fn kept(root: &'a json::Root, buffers: &'a [Option<Vec<u8>>]) -> Self {
        let borrowed = |buffer: &'a Option<Vec<u8>>| {
            let bytes = buffer.as_deref()?;
            Some(Rc::new(Cow::Borrowed(bytes)))
        };
        Self {
            root,
            binary: None,
            base_folder: None,
            bytes_left: 0,
            buffers: buffers.iter().map(borrowed).collect(),
        }
    }

    /// A buffer view, inside its buffer. `user` is the place that asks.
    pub(super) fn view(&mut self, index: usize, user: &str) -> Result<View<'a>, Fault> {
        let root = self.root;
        let view = root.buffer_views.get(index).ok_or_else(|| {
            let what = format!("there is no bufferViews[{index}]");
            Fault::new(user, what, "use an index that exists")
        })?;
        let place = format!("bufferViews[{index}]");
        let buffer = self.buffer(view.buffer.value(), &place)?;
        let offset = view.byte_offset.map_or(0, |offset| offset.0);
        let end = offset
            .checked_add(view.byte_length.0)
            .filter(|&end| end <= buffer.len() as u64)
            .ok_or_else(|| {
                let (length, buffer) = (view.byte_length.0, buffer.len());
                let what = format!("{length} bytes from {offset} pass its buffer's {buffer}");
                Fault::new(&place, what, "keep the view inside its buffer")
            })?;
        Ok(View {
            buffer,
            // Both are at most a slice's length.
            start: offset as usize,
            end: end as usize,
            // Some exporters write 0 for tightly packed.
            stride: view
                .byte_stride
                .map(|stride| stride.0)
                .filter(|&stride| stride > 0),
        })
    }

    /// A buffer, of just the bytes that the document announces.
    pub(super) fn buffer(&mut self, index: usize, user: &str) -> Result<Rc<Cow<'a, [u8]>>, Fault> {
        let root = self.root;
        let buffer = root.buffers.get(index).ok_or_else(|| {
            let what = format!("there is no buffers[{index}]");
            Fault::new(user, what, "use an index that exists")
        })?;
        if let Some(Some(bytes)) = self.buffers.get(index) {
            return Ok(Rc::clone(bytes));
        }
        let bytes = match &buffer.uri {
            Some(uri) => Cow::Owned(self.uri(uri, &format!("buffers[{index}].uri"))?),
            None => Cow::Borrowed(self.binary.filter(|_| index == 0).ok_or_else(|| {
                Fault::new(
                    format!("buffers[{index}]"),
                    "it has no uri, and there is no binary chunk for it",
                    "give it a uri, or make it buffers[0] of a .glb with a binary chunk",
                )
            })?),
        };
        let (announced, found) = (buffer.byte_length.0, bytes.len());
        // The binary chunk may end in padding beyond the buffer; less than the buffer is an error.
        if announced > found as u64 {
            return Err(Fault::new(
                format!("buffers[{index}]"),
                format!("{announced} bytes are announced, {found} are there"),
                "the data is cut short: export or copy it again",
            ));
        }
        let bytes = match bytes {
            Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[..announced as usize]),
            Cow::Owned(mut bytes) => {
                bytes.truncate(announced as usize);
                Cow::Owned(bytes)
            }
        };
        let bytes = Rc::new(bytes);
        self.buffers[index] = Some(Rc::clone(&bytes));
        Ok(bytes)
    }

    /// The bytes of a data URI or of a file in the scene's folder.
    pub(super) fn uri(&mut self, uri: &str, place: &str) -> Result<Vec<u8>, Fault> {
        if let Some(data) = strip_scheme(uri, "data") {
            return data_uri(data)
                .map_err(|what| Fault::new(place, what, "write a valid data URI"));
        }
        let path = self.local_path(uri, place)?;
        let bytes = read_file(&path, self.bytes_left)
            .map_err(|(what, mend)| Fault::new(place, format!("{}: {what}", shown(uri)), mend))?;
        self.bytes_left -= bytes.len() as u64;
        Ok(bytes)
    }

    /// The file that a relative URI names, which must lie in the scene's folder even after links
    /// are followed.
    fn local_path(&self, uri: &str, place: &str) -> Result<PathBuf, Fault> {
        let refuse = |what: &str| {
            Fault::new(
                place,
                format!("{} {what}", shown(uri)),
                "name a file inside the scene's folder, relative to it, or embed the data",
            )
        };
        if has_scheme(uri) {
            return Err(refuse("is remote or absolute"));
        }
        let decoded = percent_decode_str(uri)
            .decode_utf8()
            .map_err(|_| refuse("does not decode to UTF-8"))?;
        // Windows separators and drives are refused everywhere: a scene must not mean another file
        // on another machine.
        if decoded.is_empty() || decoded.contains(['\\', '\0']) || has_scheme(&decoded) {
            return Err(refuse("is not a relative path with forward slashes"));
        }
        let relative = Path::new(&*decoded);
        let inside = relative
            .components()
            .all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !inside {
            return Err(refuse("leaves the scene's folder"));
        }
        let folder = self
            .base_folder
            .ok_or_else(|| refuse("is a file, and this scene has no folder"))?;
        let unreadable = |error: std::io::Error| {
            Fault::new(
                place,
                format!("{}: {error}", shown(uri)),
                "put the file beside the scene",
            )
        };
        let folder = fs::canonicalize(folder).map_err(unreadable)?;
        let path = fs::canonicalize(folder.join(relative)).map_err(unreadable)?;
        if !path.starts_with(&folder) {
            return Err(refuse("is a link out of the scene's folder"));
        }
        Ok(path)
    }
}

/// The start of a URI, for messages: data and attacks can be long.
fn shown(uri: &str) -> String {
    let mut start: String = uri.chars().take(120).collect();
    if start.len() < uri.len() {
        start.push('…');
    }
    format!("{start:?}")
}

/// A scheme as RFC 3986 section 3.1 has it, which also covers a drive letter, or the double slash
/// of a network path.
fn has_scheme(uri: &str) -> bool {
    let scheme = uri.split_once(':').is_some_and(|(scheme, _)| {
        scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    });
    scheme || uri.starts_with("//")
}

fn strip_scheme<'a>(uri: &'a str, scheme: &str) -> Option<&'a str> {
    let (found, rest) = uri.split_once(':')?;
    found.eq_ignore_ascii_case(scheme).then_some(rest)
}

/// What follows `data:` in a data URI (RFC 2397).
fn data_uri(data: &str) -> Result<Vec<u8>, String> {
    let (kind, data) = data
        .split_once(',')
        .ok_or("this data URI has no comma before its data")?;
    if !kind.to_ascii_lowercase().ends_with(";base64") {
        return Ok(percent_decode_str(data).collect());
    }
    // Escapes are allowed in base64 too, and rare: without one there is nothing to copy.
    let plain: Cow<'_, [u8]> = percent_decode_str(data).into();
    BASE64
        .decode(&plain)
        .map_err(|error| format!("this data URI is not base64: {error}"))
}

/// A whole file of at most `limit` bytes, or what is wrong and its mend.
pub(in crate::scene) fn read_file(
    path: &Path,
    limit: u64,
) -> Result<Vec<u8>, (String, &'static str)> {
    let readable =
        |error: std::io::Error| (error.to_string(), "check the path and its permissions");
    let metadata = fs::metadata(path).map_err(readable)?;
    if !metadata.is_file() {
        // A pipe or a device could keep a reader waiting for ever.
        return Err(("it is not a regular file".to_owned(), "name a file"));
    }
    let too_large = || {
        let what = format!("it passes the limit of {limit} bytes for files that are left to read");
        (what, "make the scene smaller or raise the limit")
    };
    if metadata.len() > limit {
        return Err(too_large());
    }
    let file = fs::File::open(path).map_err(readable)?;
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    // The file may grow while it is read.
    file.take(limit.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(readable)?;
    if bytes.len() as u64 > limit {
        return Err(too_large());
    }
    Ok(bytes)
}
