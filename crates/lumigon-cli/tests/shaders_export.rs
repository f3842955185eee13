//! `lumigon shaders export`, from the command line to compilers that take what it writes.

#[path = "shaders_export/caller.rs"]
mod caller;
#[path = "shaders_export/es300.rs"]
mod es300;
#[path = "shaders_export/host.rs"]
mod host;
#[path = "shaders_export/tool.rs"]
mod tool;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use caller::Language;
use tempfile::TempDir;
use tool::{glslang, slangc, spirv_tool};

const TARGETS: [&str; 6] = ["wgsl", "glsl-es300", "glsl450", "hlsl", "msl", "spirv"];

fn lumigon(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lumigon"))
        .args(["shaders", "export"])
        .args(arguments)
        .arg("-o")
        .arg(folder)
        .output()
        .unwrap()
}

/// The target's export, in a folder of its own.
fn export(target: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    let output = lumigon(&["--target", target], folder.path());
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    folder
}

fn read(folder: &TempDir, name: &str) -> String {
    let path = folder.path().join(name);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn write(folder: &TempDir, name: &str, text: &str) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    path
}

/// An example with the library's text where it is included.
fn joined(example: &str, library: &str) -> String {
    let line = "#include \"lumigon.glsl\"";
    assert!(example.contains(line));
    let without_extension =
        example.replace("#extension GL_GOOGLE_include_directive : require\n", "");
    without_extension.replace(line, library)
}

fn parse_wgsl(text: &str) {
    let module = naga::front::wgsl::parse_str(text)
        .unwrap_or_else(|fault| panic!("{}", fault.emit_to_string(text)));
    naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::empty(),
    )
    .validate(&module)
    .unwrap_or_else(|fault| panic!("{}", fault.emit_to_string(text)));
}

#[test]
fn every_export_is_complete() {
    for target in TARGETS {
        let folder = export(target);
        let readme = read(&folder, "README.md");
        let mut files = 0;
        for entry in fs::read_dir(folder.path()).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if name != "README.md" {
                assert!(readme.contains(&format!("`{name}")), "{target}: {name}");
                files += 1;
            }
            if name.starts_with("example") && !name.ends_with(".spv") {
                let example = read(&folder, &name);
                assert!(readme.contains(&example), "{target}: the example");
            }
        }
        assert!(files >= 3, "{target}");
        for table in [
            "ggx-32",
            "ggx-2-32",
            "ggx-anisotropic-16",
            "charlie-32",
            "eon-32",
        ] {
            let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tables");
            for suffix in ["f32", "json"] {
                let name = format!("{table}.{suffix}");
                let written = fs::read(folder.path().join("tables").join(&name)).unwrap();
                assert_eq!(written, fs::read(shipped.join(&name)).unwrap(), "{name}");
            }
            let half = match target {
                "hlsl" => "dds",
                "glsl-es300" => "f16",
                _ => "ktx2",
            };
            let half = folder.path().join(format!("tables/{table}.{half}"));
            assert!(half.metadata().unwrap().len() > 4096, "{}", half.display());
        }
    }
}

#[test]
fn files_that_are_there_are_not_replaced_unasked() {
    let folder = TempDir::new().unwrap();
    write(&folder, "lumigon.hlsl", "mine");
    write(&folder, "notes.txt", "mine");
    let output = lumigon(&["--target", "hlsl"], folder.path());
    assert_eq!(output.status.code(), Some(1));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("--force"), "{errors}");
    assert!(errors.contains(folder.path().to_str().unwrap()), "{errors}");
    assert_eq!(read(&folder, "lumigon.hlsl"), "mine");
    let output = lumigon(&["--target", "hlsl", "--force"], folder.path());
    assert!(output.status.success());
    assert!(read(&folder, "lumigon.hlsl").contains("irradiance"));
    assert_eq!(read(&folder, "notes.txt"), "mine");
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(printed.lines().all(|path| Path::new(path).is_file()));
    assert_eq!(
        lumigon(&["--target", "cg"], folder.path()).status.code(),
        Some(2)
    );
}

#[test]
fn wgsl_validates() {
    let folder = export("wgsl");
    let library = read(&folder, "lumigon.wgsl");
    parse_wgsl(&library);
    parse_wgsl(&format!("{library}\n{}", read(&folder, "example.wgsl")));
    parse_wgsl(&format!("{library}\n{}", caller::wgsl(&library)));
}

#[test]
fn glsl_es_compiles() {
    let folder = export("glsl-es300");
    let library = read(&folder, "lumigon.glsl");
    let caller = format!(
        "#version 300 es\n{library}\n{}",
        caller::c_like(&library, Language::Glsl)
    );
    for stage in ["vert", "frag"] {
        glslang(&["-S", stage], &write(&folder, "caller.glsl", &caller));
    }
    let example = joined(&read(&folder, "example.frag"), &library);
    glslang(&["-S", "frag"], &write(&folder, "joined.frag", &example));
}

#[test]
fn glsl_compiles() {
    let folder = export("glsl450");
    let library = read(&folder, "lumigon.glsl");
    let caller = format!(
        "#version 450\n{library}\n{}",
        caller::c_like(&library, Language::Glsl)
    );
    let output = folder.path().join("caller.spv");
    for stage in ["vert", "frag", "comp"] {
        let caller = write(&folder, "caller.glsl", &caller);
        glslang(&["-S", stage], &caller);
        let made = output.to_str().unwrap();
        glslang(&["-S", stage, "-V", "-o", made], &caller);
        spirv_tool("spirv-val", &["--target-env", "vulkan1.0", made]);
    }
    let example = joined(&read(&folder, "example.frag"), &library);
    glslang(&["-S", "frag"], &write(&folder, "joined.frag", &example));
    let include = format!("-I{}", folder.path().display());
    let made = output.to_str().unwrap();
    glslang(
        &["-V", &include, "-o", made],
        &folder.path().join("example.frag"),
    );
    spirv_tool("spirv-val", &["--target-env", "vulkan1.0", made]);
}

#[test]
fn hlsl_compiles() {
    let folder = export("hlsl");
    let library = read(&folder, "lumigon.hlsl");
    let caller = format!(
        "#include \"lumigon.hlsl\"\n{}",
        caller::c_like(&library, Language::Hlsl)
    );
    write(&folder, "caller.hlsl", &caller);
    let readme = read(&folder, "README.md");
    let version = tool::slangc_version();
    assert!(readme.contains(&format!("slangc {version}")), "{version}");
    let made = folder.path().join("made.spv");
    let made = made.to_str().unwrap();
    for name in ["caller.hlsl", "example.hlsl"] {
        let file = folder.path().join(name);
        slangc(&file, made);
        glslang(&["-D", "-V", "-S", "frag", "-e", "main", "-o", made], &file);
    }
}

#[test]
fn spirv_links() {
    let folder = export("spirv");
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    spirv_tool("spirv-val", &[&path("lumigon.spv")]);
    let library = lumigon_shaders::Library::new().unwrap();
    let client = library
        .export_client(&caller::wgsl(library.text()))
        .unwrap();
    fs::write(folder.path().join("caller.spv"), client).unwrap();
    for client in ["caller.spv", "example.spv"] {
        spirv_tool("spirv-val", &[&path(client)]);
        spirv_tool(
            "spirv-link",
            &[
                &path(client),
                &path("lumigon.spv"),
                "-o",
                &path("linked.spv"),
            ],
        );
        let linked = path("linked.spv");
        spirv_tool("spirv-val", &["--target-env", "vulkan1.1", &linked]);
        // As the README says.
        let optimised = path("linked.opt.spv");
        spirv_tool(
            "spirv-opt",
            &["-O", "--strip-debug", &linked, "-o", &optimised],
        );
        spirv_tool("spirv-val", &["--target-env", "vulkan1.1", &optimised]);
    }
}

/// The example calls what the library then has, so that compilers say whether both have the prefix.
#[test]
fn prefixed_exports_compile() {
    let prefixed = |target: &str| {
        let folder = TempDir::new().unwrap();
        let output = lumigon(&["--target", target, "--prefix", "our_"], folder.path());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{errors}");
        let readme = read(&folder, "README.md");
        assert!(readme.contains("`our_begin_irradiance`"), "{target}");
        assert!(!readme.contains("`begin_irradiance`"), "{target}");
        folder
    };
    let folder = prefixed("wgsl");
    let text = read(&folder, "lumigon.wgsl") + &read(&folder, "example.wgsl");
    parse_wgsl(&text);
    let folder = prefixed("glsl-es300");
    let example = joined(
        &read(&folder, "example.frag"),
        &read(&folder, "lumigon.glsl"),
    );
    glslang(&["-S", "frag"], &write(&folder, "joined.frag", &example));
    let folder = prefixed("glsl450");
    let example = joined(
        &read(&folder, "example.frag"),
        &read(&folder, "lumigon.glsl"),
    );
    glslang(&["-S", "frag"], &write(&folder, "joined.frag", &example));
    let folder = prefixed("hlsl");
    let made = folder.path().join("made.spv");
    slangc(&folder.path().join("example.hlsl"), made.to_str().unwrap());
    let folder = prefixed("spirv");
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let linked = path("linked.spv");
    spirv_tool(
        "spirv-link",
        &[&path("example.spv"), &path("lumigon.spv"), "-o", &linked],
    );
    spirv_tool("spirv-val", &["--target-env", "vulkan1.1", &linked]);
    let folder = prefixed("msl");
    assert!(read(&folder, "example.metal").contains("lumigon::our_begin_irradiance("));

    let folder = TempDir::new().unwrap();
    let output = lumigon(&["--target", "wgsl", "--prefix", "9"], folder.path());
    assert_eq!(output.status.code(), Some(1));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("\"9\""), "{errors}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn spirv_exports_every_function() {
    let folder = export("spirv");
    let library = folder.path().join("lumigon.spv");
    let text = spirv_tool("spirv-dis", &[library.to_str().unwrap()]);
    for name in lumigon_shaders::Library::new().unwrap().functions() {
        let decoration = format!("LinkageAttributes \"{name}\" Export");
        assert!(text.contains(&decoration), "{name}");
    }
}
