//! The fuzz target `eval` on seeded mutations.

#[path = "../../../fuzz/properties/eval.rs"]
mod property;
#[path = "../../../fuzz/smoke/mod.rs"]
mod smoke;

#[test]
fn mutated_lines_never_panic_hang_or_take_memory() {
    smoke::Smoke {
        name: "eval",
        seeds: &["fuzz/seeds/eval"],
        dictionary: "fuzz/dictionaries/eval.dict",
        inputs: 400_000,
    }
    .run(property::eval);
}
