//! Compilers that tests run; one that is missing fails the test and says how to get it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs a tool that must succeed without a warning; its output.
pub(crate) fn run(command: &mut Command, mend: &str) -> String {
    let Output {
        status,
        stdout,
        stderr,
    } = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?}: {error}: {mend}"));
    let stdout = String::from_utf8_lossy(&stdout).into_owned();
    let stderr = String::from_utf8_lossy(&stderr);
    assert!(status.success(), "{command:?}\n{stdout}\n{stderr}");
    assert!(!stderr.contains("error"), "{command:?}\n{stderr}");
    stdout
}

/// The reference compiler of GLSL; it reads HLSL too.
pub(crate) fn glslang(arguments: &[&str], file: &Path) {
    let mut command = Command::new("glslangValidator");
    command.args(arguments).arg(file);
    let output = run(
        &mut command,
        "install Debian's glslang-tools, or run ./check",
    );
    assert!(!output.contains("WARNING"), "{output}");
}

/// A tool of Debian's spirv-tools; what it prints.
pub(crate) fn spirv_tool(name: &str, arguments: &[&str]) -> String {
    let mut command = Command::new(name);
    command.args(arguments);
    run(&mut command, "install Debian's spirv-tools, or run ./check")
}

/// Slang, which reads HLSL: a fragment shader to SPIR-V.
pub(crate) fn slangc(file: &Path, output: &str) {
    let mut command = Command::new(python_tool("slangc"));
    // Unoptimised: the optimiser is not in the package.
    command
        .args(["-lang", "hlsl", "-profile", "sm_6_0", "-stage", "fragment"])
        .args(["-entry", "main", "-target", "spirv", "-O0", "-o", output])
        // Registers are Direct3D's, not Vulkan's.
        .args(["-warnings-disable", "39001,39029"])
        .arg(file);
    run(&mut command, "run ./check, which installs it");
}

/// What `slangc` calls itself, which it prints where errors go.
pub(crate) fn slangc_version() -> String {
    let output = Command::new(python_tool("slangc"))
        .arg("-v")
        .output()
        .unwrap();
    let printed = [output.stdout, output.stderr].concat();
    String::from_utf8_lossy(&printed).trim().to_owned()
}

/// A program in the environment that `check` makes.
pub(crate) fn python_tool(name: &str) -> PathBuf {
    let tool = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../target/check/python/bin")
        .join(name);
    assert!(
        tool.exists(),
        "{} is missing: run ./check, which installs it",
        tool.display()
    );
    tool
}
