//! HLSL.

use naga::back::hlsl::{Options, PipelineOptions, ShaderModel, Writer};

use super::library::{heading, refused};
use super::{ExportError, Library, Target};

pub(super) fn write(library: &Library) -> Result<String, ExportError> {
    let refused = refused(Target::Hlsl);
    let module = library.with_prefixed_constants();
    let options = Options {
        shader_model: ShaderModel::V6_0,
        // The library's loops end.
        force_loop_bounding: false,
        ..Options::default()
    };
    let pipeline = PipelineOptions::default();
    let mut text = String::new();
    Writer::new(&mut text, &options, &pipeline)
        .write(&module, library.info(), None)
        .map_err(|fault| refused(&fault))?;
    let text = without_padding(&text);
    Ok(format!(
        "{}#ifndef LUMIGON_HLSL\n#define LUMIGON_HLSL\n\n{}\n\n#endif\n",
        heading(Target::Hlsl),
        library.with_comments(text.trim()).trim(),
    ))
}

/// Drops the fields that lay structures out as WGSL would: the library stores none, and in a
/// function they mean nothing.
fn without_padding(text: &str) -> String {
    let is_padding = |line: &str| {
        let name = line.strip_prefix("    int _").unwrap_or_default();
        line.ends_with(';') && (name.starts_with("pad") || name.starts_with("end_pad"))
    };
    let kept: Vec<&str> = text.lines().filter(|line| !is_padding(line)).collect();
    kept.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structures_have_no_padding() {
        let library = Library::new().unwrap();
        let text = write(&library).unwrap();
        assert!(!text.contains("_pad"), "{text}");
        assert!(text.contains("\n    float3 centroid_;\n"), "{text}");
    }
}
