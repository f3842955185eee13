//! Every dependency on every platform has a licence that `deny.toml` allows and comes from where
//! it allows: what `cargo deny check licenses sources` does, for those who do not have it.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::process::Command;

use serde::Deserialize;
use spdx::{Expression, Licensee, ParseMode};

/// The parts of deny.toml that this test knows.
#[derive(Deserialize)]
struct Deny {
    licenses: Licenses,
}

#[derive(Deserialize)]
struct Licenses {
    allow: Vec<String>,
    exceptions: Vec<Exception>,
}

#[derive(Deserialize)]
struct Exception {
    #[serde(rename = "crate")]
    name: String,
    allow: Vec<String>,
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    version: String,
    license: Option<String>,
    source: Option<String>,
}

fn repository() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn deny() -> Deny {
    let path = repository().join("deny.toml");
    toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn packages() -> Vec<Package> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--locked",
            "--all-features",
            "--format-version=1",
        ])
        .current_dir(repository())
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "cargo metadata: {message}");
    let metadata: Metadata = serde_json::from_slice(&output.stdout).unwrap();
    metadata.packages
}

/// Why `expression` is not allowed, if it is not.
fn refusal(expression: &str, allowed: &[Licensee]) -> Option<String> {
    // Old manifests write `MIT/Apache-2.0`.
    match Expression::parse_mode(expression, ParseMode::LAX) {
        Ok(parsed) => {
            let satisfied = |requirement: &spdx::LicenseReq| {
                allowed.iter().any(|licence| licence.satisfies(requirement))
            };
            (!parsed.evaluate(satisfied)).then(|| format!("{expression} is not allowed"))
        }
        Err(error) => Some(format!("{expression} is no SPDX expression: {error}")),
    }
}

fn licensees(names: &[String]) -> Vec<Licensee> {
    let parse = |name: &String| Licensee::parse(name).unwrap_or_else(|e| panic!("{name}: {e}"));
    names.iter().map(parse).collect()
}

#[test]
fn licences_and_sources_are_allowed() {
    let Licenses { allow, exceptions } = deny().licenses;
    let allowed = licensees(&allow);
    let exceptions: HashMap<String, Vec<Licensee>> = exceptions
        .into_iter()
        .map(|exception| (exception.name, licensees(&exception.allow)))
        .collect();
    let packages = packages();

    let mut refused = Vec::new();
    for package in &packages {
        let mut allowed = allowed.clone();
        allowed.extend(exceptions.get(&package.name).into_iter().flatten().cloned());
        let fault = match &package.license {
            Some(expression) => refusal(expression, &allowed),
            None => Some("it names no licence".to_owned()),
        };
        let foreign = package
            .source
            .as_ref()
            .filter(|&source| source != "registry+https://github.com/rust-lang/crates.io-index")
            .map(|source| format!("it comes from {source}"));
        for fault in fault.into_iter().chain(foreign) {
            refused.push(format!("{} {}: {fault}", package.name, package.version));
        }
    }
    assert!(refused.is_empty(), "{}", refused.join("\n"));

    // Permissions that nobody needs are taken back.
    let names: HashSet<&str> = packages.iter().map(|p| p.name.as_str()).collect();
    for name in exceptions.keys() {
        assert!(
            names.contains(name.as_str()),
            "no dependency is {name} any more"
        );
    }
}

#[test]
fn what_is_not_allowed_is_refused() {
    let allowed = licensees(&["MIT".to_owned(), "Apache-2.0".to_owned()]);
    for (expression, is_allowed) in [
        ("MIT", true),
        ("MIT/Apache-2.0", true),
        ("GPL-3.0-only OR MIT", true),
        ("Apache-2.0 AND MIT", true),
        ("Apache-2.0 WITH LLVM-exception OR MIT", true),
        ("GPL-3.0-only", false),
        ("MIT AND GPL-3.0-only", false),
        ("LGPL-2.1-or-later", false),
        ("", false),
        ("Proprietary", false),
    ] {
        let refusal = refusal(expression, &allowed);
        assert_eq!(refusal.is_none(), is_allowed, "{expression}: {refusal:?}");
    }
}
