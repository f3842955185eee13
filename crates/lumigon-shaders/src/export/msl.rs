//! Metal Shading Language.

use naga::back::msl::{Options, PipelineOptions, Writer};

use super::library::{heading, refused};
use super::{ExportError, Library, Target};

/// The last line of the writer's own head, which stays outside the namespace.
const HEAD_END: &str = "using metal::uint;\n";

pub(super) fn write(library: &Library) -> Result<String, ExportError> {
    let refused = refused(Target::Msl);
    let module = library.with_prefixed_constants();
    let options = Options {
        lang_version: (2, 1),
        // The library's loops end.
        force_loop_bounding: false,
        ..Options::default()
    };
    let mut writer = Writer::new(String::new());
    writer
        .write(
            &module,
            library.info(),
            &options,
            &PipelineOptions::default(),
        )
        .map_err(|fault| refused(&fault))?;
    let text = writer.finish();
    let (head, functions) = text
        .split_once(HEAD_END)
        .ok_or_else(|| refused(&"unknown layout"))?;
    let head: Vec<&str> = head.lines().filter(|l| !l.starts_with("//")).collect();
    Ok(format!(
        "{}#pragma once\n\n{}\n{HEAD_END}\nnamespace lumigon {{\n\n{}\n\n}} // namespace lumigon\n",
        heading(Target::Msl),
        head.join("\n").trim(),
        library.with_comments(functions.trim()).trim(),
    ))
}
