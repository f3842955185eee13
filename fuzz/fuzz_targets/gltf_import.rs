//! Coverage-guided fuzzing of the glTF import.
#![no_main]

#[path = "../properties/gltf_import.rs"]
mod property;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| property::gltf_import(bytes));
