//! Coverage-guided fuzzing of the lines that `lumigon eval` answers.
#![no_main]

#[path = "../properties/eval.rs"]
mod property;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| property::eval(bytes));
