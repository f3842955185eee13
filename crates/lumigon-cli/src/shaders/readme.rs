//! The README of an export.

use askama::Template;
use lumigon_shaders::{Library, Target};
use lumigon_table::Format;

use super::tables::{ExportedTable, formats};
use crate::Failure;

#[derive(Template)]
#[template(path = "shaders_readme.md")]
struct Readme<'a> {
    language: &'static str,
    library: &'static str,
    example: &'static str,
    host: &'static str,
    /// What prepares a light.
    host_call: &'static str,
    /// What is beside the example, and what it is.
    more_files: &'static [(&'static str, &'static str)],
    /// How a shader takes the library.
    inclusion: &'static str,
    /// What checks the export.
    compiler: &'static str,
    /// For the fence of the example.
    fence: &'static str,
    example_text: &'static str,
    /// What constants start with; empty where they have their own names.
    constant_prefix: String,
    /// Fields with other names here: structure, name, name here.
    renamed: Vec<(String, String, String)>,
    /// What else differs from WGSL.
    differences: &'static str,
    /// Of the tables' files in 16 bits.
    half_file: &'static str,
    /// Where a number is in them.
    half_layout: &'static str,
    /// How to load them.
    loading: &'static str,
    tables: Vec<TableRow<'a>>,
    contents: Vec<(&'static str, Vec<(String, String)>)>,
    version: &'static str,
}

struct TableRow<'a> {
    name: &'a str,
    sizes: String,
    channels: String,
    axes: &'a [String],
    /// Names of the functions that read it.
    lookup: &'static str,
    /// RGBA groups of a texel.
    groups: usize,
    /// Layers of a texture array.
    layers: usize,
    rmse: String,
    median: String,
    command: &'a str,
}

/// The text.
///
/// # Errors
/// Where the template fails, or the library cannot be translated.
pub(super) fn readme(
    target: Target,
    library: &Library,
    tables: &[ExportedTable],
) -> Result<String, Failure> {
    let (example, example_text) = target.example();
    let half = formats(target)[0];
    let readme = Readme {
        language: target.language(),
        library: target.file_name(),
        example,
        host: target.host_code().0,
        host_call: match target {
            Target::Wgsl | Target::GlslEs300 => "`prepareLight(loops, bothSides)`",
            _ => "`lumigon_host::prepare_light(loops, both_sides, records)`",
        },
        more_files: match target {
            Target::Spirv => &[
                (
                    "example.spv",
                    "`example.wgsl`, compiled, importing what it calls",
                ),
                (
                    "lumigon.wgsl",
                    "what `lumigon.spv` was compiled from, with all comments",
                ),
            ],
            _ => &[],
        },
        inclusion: inclusion(target),
        compiler: compiler(target),
        fence: match target {
            Target::Wgsl | Target::Spirv => "wgsl",
            Target::GlslEs300 | Target::Glsl450 => "glsl",
            Target::Hlsl => "hlsl",
            Target::Msl => "cpp",
        },
        example_text,
        constant_prefix: library.constant_prefix(target),
        renamed: library.renamed_fields(target)?,
        differences: differences(target),
        half_file: half.extension(),
        half_layout: match half {
            Format::F16 => {
                "texel by texel, so that a table of *g* groups is an RGBA16F texture *g* times as \
                 wide: group *k* of the texel in column *i*, row *j* is at (*g* *i* + *k*, *j*). The \
                 `.f32` files are the same in 32 bits, RGBA32F"
            }
            _ => {
                "a texture array, RGBA, 16 bits a number: column *i0*, row *i1* (row 0 comes first), \
                 layer *group* s2 s3 + *i3* s2 + *i2*. The `.f32` files hold 32 bits a number, texel by \
                 texel, all channels of a texel together"
            }
        },
        loading: loading(target),
        tables: tables.iter().map(row).collect(),
        contents: library.contents(),
        version: env!("CARGO_PKG_VERSION"),
    };
    Ok(library.prefixed(&readme.render()?))
}

fn row(table: &ExportedTable) -> TableRow<'_> {
    let sizes = table.image.sizes();
    let text: Vec<String> = sizes.iter().map(ToString::to_string).collect();
    let groups = table.image.channels().len() / 4;
    TableRow {
        name: table.name,
        sizes: text.join(" x "),
        channels: table.image.channels().join(", "),
        axes: &table.manifest.axes,
        lookup: match table.name {
            "ggx-32" => "`ltc_table_coordinates`, `table_cell`, `bilinear`, `ggx_lobes`",
            "ggx-2-32" => "the same, `ggx_two_lobes`",
            "ggx-anisotropic-16" => {
                "`anisotropic_place`, `anisotropic_table_corner` (16 of them), `anisotropic_lobe`"
            }
            _ => "as `ggx-32`, `normal_frame_lobes`",
        },
        groups,
        layers: groups * sizes.iter().skip(2).product::<usize>(),
        rmse: format!("{:.4}", table.manifest.errors.rmse),
        median: format!("{:.2} %", 100.0 * table.manifest.errors.median_relative),
        command: &table.manifest.command,
    }
}

fn inclusion(target: Target) -> &'static str {
    match target {
        Target::Wgsl => {
            "WGSL has no include: make the shader module from the text of `lumigon.wgsl` followed by \
             your own. Order does not matter in WGSL, and nothing is bound, so it goes before any \
             shader. All of it may stay: what a pipeline does not call costs it nothing."
        }
        Target::GlslEs300 => {
            "Put the text of `lumigon.glsl` behind `#version 300 es` and before your functions; WebGL \
             has no `#include`. It starts with `precision highp float` and `highp int`, which it \
             needs: repeat them for your own code only if you want less. In three.js it goes before \
             `main` of a `RawShaderMaterial`, or into a `ShaderMaterial` with \
             `glslVersion: THREE.GLSL3`, which brings its own `#version`. In a vertex and in a \
             fragment shader alike."
        }
        Target::Glsl450 => {
            "Include `lumigon.glsl` behind `#version 450` (with `GL_GOOGLE_include_directive`, as \
             glslang and shaderc have it), or paste it there. It needs no extension, and works in any \
             stage."
        }
        Target::Hlsl => {
            "`#include \"lumigon.hlsl\"`. With DXC, give `-HV 2018`: the text may select between \
             vectors with `?:`, which later versions of the language keep for scalars."
        }
        Target::Msl => "`#include \"lumigon.metal\"`. All of it is in the namespace `lumigon`.",
        Target::Spirv => {
            "`lumigon.spv` is a module without entry points that exports every function under its \
             name. A module that calls it declares the functions without bodies, decorated \
             `LinkageAttributes \"name\" Import`, with the same structures, member decorations \
             included, and is joined with it:\n\n\
             ```sh\n\
             spirv-link example.spv lumigon.spv -o linked.spv\n\
             spirv-opt -O --strip-debug linked.spv -o linked.opt.spv  # inlines, drops what is not called\n\
             ```\n\n\
             `example.spv` is such a module; `spirv-dis example.spv` shows its declarations."
        }
    }
}

fn compiler(target: Target) -> &'static str {
    match target {
        Target::Wgsl => "naga parses and validates the library and the example.",
        Target::GlslEs300 => {
            "glslang compiles the library with a call of every function, and the example. Mesa runs it \
             as `#version 300 es`, and the numbers equal those of the CPU."
        }
        Target::Glsl450 => {
            "glslang compiles the library with a call of every function, and the example, for OpenGL \
             and for Vulkan."
        }
        Target::Hlsl => {
            "Slang's HLSL front end (slangc 2026.14.1) and glslang's compile the library with a call \
             of every function, and the example, to SPIR-V. **DXC does not take part**: no package \
             registry that the checks can use has it for Linux."
        }
        Target::Msl => {
            "**Nothing compiles this target**: there is no compiler for Metal outside Apple's. The \
             text comes from naga's writer, which wgpu runs on Apple's devices; the example is \
             unchecked."
        }
        Target::Spirv => {
            "spirv-val accepts the library, the example, and what spirv-link makes of both; a test \
             links a client that calls every function."
        }
    }
}

fn differences(target: Target) -> &'static str {
    match target {
        Target::Wgsl => "",
        Target::Spirv => {
            "Structures have the layout of WGSL, stated by `Offset` decorations. Arguments and results \
             are values, never pointers."
        }
        Target::Hlsl => {
            "Arguments have a number behind their names. In a `StructuredBuffer`, `PolygonLight` is 64 bytes without \
             padding, as in the other languages."
        }
        Target::Msl => {
            "Arguments have a number behind their names. `PolygonLight` has `packed_float3` fields and is 64 bytes."
        }
        Target::GlslEs300 | Target::Glsl450 => "Arguments have a number behind their names.",
    }
}

fn loading(target: Target) -> &'static str {
    match target {
        Target::GlslEs300 => {
            "```js\n\
             import { prepareLight } from './prepare_light.js';\n\
             \n\
             // The table:\n\
             const file = await fetch('tables/ggx-32.f16');\n\
             const numbers = new Uint16Array(await file.arrayBuffer());\n\
             gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());\n\
             gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, 64, 32, 0, gl.RGBA, gl.HALF_FLOAT, numbers);\n\
             gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);\n\
             gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);\n\
             \n\
             // A square light that shines down, and the example's uniforms of it:\n\
             const square = [[-1, 2, -1], [1, 2, -1], [1, 2, 1], [-1, 2, 1]];\n\
             const light = prepareLight([square]);\n\
             const at = (name) => gl.getUniformLocation(program, name);\n\
             gl.uniform3fv(at('light.center'), light.center);\n\
             gl.uniform1f(at('light.inverse_radius'), light.inverse_radius);\n\
             gl.uniform3fv(at('light.normal'), light.normal);\n\
             gl.uniform1f(at('light.doubled_area'), light.doubled_area);\n\
             gl.uniform3fv(at('light.centroid_'), light.centroid);\n\
             gl.uniform1f(at('light.plane_tolerance'), light.plane_tolerance);\n\
             gl.uniform3fv(at('light.plane_axis'), light.plane_axis);\n\
             gl.uniform1ui(at('light.both_sides'), light.both_sides);\n\
             gl.uniform4fv(at('light_vertices'), light.records);\n\
             gl.uniform1i(at('record_count'), light.records.length / 4);\n\
             gl.uniform3f(at('radiance'), 10, 10, 10);\n\
             ```\n\n\
             `ggx-anisotropic-16` has four axes: its third and fourth are blocks of rows, row\n\
             (*i3* s2 + *i2*) s1 + *i1*, 24 x 2048 in all."
        }
        _ => {
            "A layer is 32 x 32 texels, or 8 x 16 for the anisotropic table, whose 384 layers are more\n\
             than WebGPU's 256: there, load the `.f32` file into a storage buffer instead."
        }
    }
}
