//! `lumigon shaders export`: the library, the tables, and how to call them.

use std::fs;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use lumigon_shaders::{Library, Target};

use super::folder::ExportFolder;
use super::{readme, tables};
use crate::Failure;

/// Writes the shader library as functions to call, with its tables and a README
#[derive(Debug, Args)]
#[command(after_help = "\
Targets:
  wgsl        WebGPU
  glsl-es300  GLSL ES 3.00: WebGL 2 and OpenGL ES 3
  glsl450     GLSL 4.50: OpenGL and Vulkan
  hlsl        HLSL, shader model 6.0: Direct3D 12
  msl         Metal Shading Language 2.1
  spirv       SPIR-V 1.3, every function exported for spirv-link

Each holds the library in one file without entry points or bindings, an example that calls it, code
that prepares lights on the host (JavaScript for the web's targets, else C++), the fitted tables in
formats that the target's engines load, and a README.md with the call sequence.

A folder that holds anything is refused, unless --force: then files of the export replace those of
the same name, and others stay.

Examples:
  lumigon shaders export --target hlsl -o engine/shaders/lumigon
  lumigon shaders export --target glsl-es300 -o public/lumigon --force
  lumigon shaders export --target glsl450 --prefix lumigon_ -o engine/shaders/lumigon")]
pub(super) struct Export {
    /// Shading language
    #[arg(long, value_enum)]
    target: TargetName,
    /// Folder to write
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// What names of functions and structures start with, for engines that have such names already
    /// [default: nothing]
    #[arg(long, value_name = "PREFIX")]
    prefix: Option<String>,
    /// Write to a folder that holds files
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TargetName {
    Wgsl,
    #[value(name = "glsl-es300")]
    GlslEs300,
    Glsl450,
    Hlsl,
    Msl,
    Spirv,
}

impl From<TargetName> for Target {
    fn from(name: TargetName) -> Self {
        match name {
            TargetName::Wgsl => Self::Wgsl,
            TargetName::GlslEs300 => Self::GlslEs300,
            TargetName::Glsl450 => Self::Glsl450,
            TargetName::Hlsl => Self::Hlsl,
            TargetName::Msl => Self::Msl,
            TargetName::Spirv => Self::Spirv,
        }
    }
}

impl Export {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let target = Target::from(self.target);
        let library = match &self.prefix {
            Some(prefix) => Library::with_prefix(prefix)?,
            None => Library::new()?,
        };
        let folder = ExportFolder::create(&self.output, self.force)?;
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, bytes).map_err(|error| format!("{}: {error}", path.display()))
        };
        write(target.file_name(), &library.export(target)?)?;
        let (example, text) = target.example();
        let text = library.prefixed(text);
        write(example, text.as_bytes())?;
        let (host, code) = target.host_code();
        write(host, code.as_bytes())?;
        if target == Target::Spirv {
            write("example.spv", &library.export_client(&text)?)?;
            // Its comments say what the functions do.
            write(Target::Wgsl.file_name(), library.text().as_bytes())?;
        }
        let tables = tables::write(target, folder.path())?;
        let readme = readme::readme(target, &library, &tables)?;
        write("README.md", readme.as_bytes())?;
        for path in folder.commit()? {
            println!("{}", path.display());
        }
        Ok(())
    }
}
