//! HLSL.

use naga::back::hlsl::{Options, PipelineOptions, ShaderModel, Writer};

use super::library::{CONSTANT_PREFIX, heading, refused};
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
    Ok(format!(
        "{}#ifndef LUMIGON_HLSL\n#define LUMIGON_HLSL\n\n{}\n\n#endif\n",
        heading(Target::Hlsl),
        library.comments().restore(text.trim(), CONSTANT_PREFIX).trim(),
    ))
}
