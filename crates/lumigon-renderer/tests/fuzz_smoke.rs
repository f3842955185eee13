//! The fuzz target `gltf_import` on seeded mutations.

#[path = "../../../fuzz/properties/gltf_import.rs"]
mod property;
#[path = "../../../fuzz/smoke/mod.rs"]
mod smoke;

#[test]
fn mutated_files_never_panic_hang_or_take_memory() {
    smoke::Smoke {
        name: "gltf_import",
        seeds: &["fuzz/seeds/gltf_import", "scenes/check"],
        dictionary: "fuzz/dictionaries/gltf.dict",
        inputs: 20_000,
    }
    .run(property::gltf_import);
}
