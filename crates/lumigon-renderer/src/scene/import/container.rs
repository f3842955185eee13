//! The binary glTF container.

use crate::scene::error::Fault;

/// The two chunks of a `.glb`, or the JSON of a `.gltf`.
#[derive(Debug)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

const JSON: [u8; 4] = *b"JSON";
const BINARY: [u8; 4] = *b"BIN\0";

/// Splits a `.glb` into its chunks; anything that does not start with its magic is taken as JSON.
pub(super) fn split(bytes: &[u8]) -> Result<Container<'_>, Fault> {
    if !bytes.starts_with(b"glTF") {
        // Some editors put a byte order mark before the JSON; glTF forbids it and it does no harm.
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return Ok(Container { json, binary: None });
    }
    let truncated = |place: &str, needed: u64, found: usize| {
        let what = format!("{needed} bytes are announced, {found} are there");
        Fault::new(
            place,
            what,
            "the file is cut short: export or copy it again",
        )
    };
    let header = bytes
        .get(..12)
        .ok_or_else(|| truncated("GLB header", 12, bytes.len()))?;
    let version = word(&header[4..]);
    if version != 2 {
        return Err(Fault::new(
            "GLB header",
            format!("container version {version} is not 2"),
            "convert the scene to glTF 2.0",
        ));
    }
    let length = word(&header[8..]);
    let body = bytes
        .get(12..length as usize)
        .ok_or_else(|| truncated("GLB header", u64::from(length), bytes.len()))?;

    let (kind, json, rest) = chunk(body)
        .map_err(|(needed, found)| truncated("GLB chunk 0", needed, found))?
        .ok_or_else(|| truncated("GLB chunk 0", 8, 0))?;
    if kind != JSON {
        return Err(Fault::new(
            "GLB chunk 0",
            format!(
                "its type is {:?}, not \"JSON\"",
                String::from_utf8_lossy(&kind)
            ),
            "put the JSON chunk first",
        ));
    }
    // Some exporters pad with zeros what glTF pads with spaces.
    let padding = json.iter().rev().take_while(|&&c| c == 0).count();
    let json = &json[..json.len() - padding];
    // Chunks of unknown types are to be ignored.
    let mut rest = rest;
    for index in 1_usize.. {
        let place = format!("GLB chunk {index}");
        match chunk(rest).map_err(|(needed, found)| truncated(&place, needed, found))? {
            Some((BINARY, binary, _)) => {
                let binary = Some(binary);
                return Ok(Container { json, binary });
            }
            Some((_, _, next)) => rest = next,
            None => break,
        }
    }
    Ok(Container { json, binary: None })
}

type Chunk<'a> = ([u8; 4], &'a [u8], &'a [u8]);

/// The next chunk's type and contents, and what follows it; `None` at the end.
/// The error is how many bytes were announced and how many there are.
fn chunk(bytes: &[u8]) -> Result<Option<Chunk<'_>>, (u64, usize)> {
    if bytes.is_empty() {
        return Ok(None);
    }
    let header = bytes.get(..8).ok_or((8, bytes.len()))?;
    let length = word(header);
    let kind = [header[4], header[5], header[6], header[7]];
    let contents = bytes[8..]
        .get(..length as usize)
        .ok_or((u64::from(length), bytes.len() - 8))?;
    Ok(Some((kind, contents, &bytes[8 + contents.len()..])))
}

fn word(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}
