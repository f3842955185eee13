//! GLSL and GLSL ES.

use naga::back::glsl::{Options, PipelineOptions, Version, Writer, WriterFlags};
use naga::proc::BoundsCheckPolicies;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{EntryPoint, Function, ShaderStage};

use super::library::{heading, refused};
use super::{ExportError, Library, Target};

/// The writer prints what an entry point needs, so there must be one: an empty one, which starts so.
const ENTRY_POINT: &str = "\nvoid main() {\n";

pub(super) fn write(library: &Library, target: Target) -> Result<String, ExportError> {
    let refused = refused(target);
    let mut module = library.with_prefixed_constants();
    module.entry_points.push(EntryPoint {
        name: "main".to_owned(),
        stage: ShaderStage::Fragment,
        early_depth_test: None,
        workgroup_size: [0; 3],
        workgroup_size_overrides: None,
        function: Function {
            name: Some("main".to_owned()),
            ..Function::default()
        },
        mesh_info: None,
        task_payload: None,
        incoming_ray_payload: None,
    });
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|fault| refused(&fault))?;
    let options = Options {
        version: match target {
            Target::GlslEs300 => Version::new_gles(300),
            _ => Version::Desktop(450),
        },
        writer_flags: WriterFlags::empty(),
        ..Options::default()
    };
    let pipeline = PipelineOptions {
        shader_stage: ShaderStage::Fragment,
        entry_point: "main".to_owned(),
        multiview: None,
    };
    let mut text = String::new();
    Writer::new(
        &mut text,
        &module,
        &info,
        &options,
        &pipeline,
        BoundsCheckPolicies::default(),
    )
    .map_err(|fault| refused(&fault))?
    .write()
    .map_err(|fault| refused(&fault))?;
    let functions = functions_in(&text).ok_or_else(|| refused(&"unknown layout"))?;
    let restored = library.with_comments(functions);
    let precision = match target {
        Target::GlslEs300 => "\nprecision highp float;\nprecision highp int;\n",
        _ => "",
    };
    Ok(format!(
        "{}// Needs `#version {}` or later as the shader's first line.\n\
         #ifndef LUMIGON_GLSL\n#define LUMIGON_GLSL\n{precision}\n{}\n#endif\n",
        heading(target),
        match target {
            Target::GlslEs300 => "300 es",
            _ => "450",
        },
        restored.trim(),
    ))
}

/// What is between the version and precision lines and the entry point; nothing where they are not
/// where they should be.
fn functions_in(text: &str) -> Option<&str> {
    let (body, entry) = text.rsplit_once(ENTRY_POINT)?;
    let is_empty = |line: &str| matches!(line.trim(), "" | "return;" | "}");
    if !entry.lines().all(is_empty) {
        return None;
    }
    let start = body.find("\nstruct ")?;
    let head = &body[..start];
    let is_header = |line: &str| {
        line.is_empty() || line.starts_with("#version ") || line.starts_with("precision highp ")
    };
    head.lines().all(is_header).then(|| &body[start..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_around_functions_goes() {
        let text = "#version 450 core\nstruct A {\n    int x;\n};\nint f() {\n}\n\n";
        let printed = format!("{text}{ENTRY_POINT}}}\n\n");
        let functions = functions_in(&printed).unwrap();
        assert_eq!(functions.trim(), "struct A {\n    int x;\n};\nint f() {\n}");
        assert_eq!(functions_in(text), None);
        let full = format!("{text}{ENTRY_POINT}    f();\n}}\n");
        assert_eq!(functions_in(&full), None);
        let extended = format!("#extension GL_EXT_x : require\n{printed}");
        assert_eq!(functions_in(&extended), None);
    }

    #[test]
    fn header_and_entry_point_are_gone() {
        let library = Library::new().unwrap();
        for target in [Target::GlslEs300, Target::Glsl450] {
            let text = write(&library, target).unwrap();
            assert!(!text.contains("main("), "{target:?}");
            assert!(!text.contains("\n#version"), "{target:?}");
            assert_eq!(text.matches("#endif").count(), 1);
        }
    }
}
