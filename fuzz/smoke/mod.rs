//! Fuzzing on stable Rust: seeded mutations of a corpus, the same on every run.
//!
//! libFuzzer finds more, because it sees which branches an input reaches; this needs nothing
//! but `cargo test`.

mod mutation;
mod watchdog;

use std::alloc::System;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use cap::Cap;
use mutation::Mutator;
use watchdog::Watchdog;

/// Memory that no input may pass. An allocation beyond it aborts the test.
const MEMORY_LIMIT: usize = 1 << 30;

/// Memory that no input may add. What a thread pool or a table needs once is well below.
const MEMORY_PER_INPUT: usize = 128 << 20;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, MEMORY_LIMIT);

/// What to mutate, and how often.
pub(super) struct Smoke<'a> {
    /// The property's name, for messages and for the file of a failing input.
    pub(super) name: &'a str,
    /// Folders and files of seeds, relative to the repository.
    pub(super) seeds: &'a [&'a str],
    /// libFuzzer's dictionary, relative to the repository.
    pub(super) dictionary: &'a str,
    /// Mutated inputs.
    pub(super) inputs: u64,
}

impl Smoke<'_> {
    /// Tries the seeds themselves, then mutations of them.
    ///
    /// # Panics
    /// On the first input that panics, hangs or takes too much memory, having saved it.
    pub(super) fn run(&self, property: fn(&[u8])) {
        let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let seeds: Vec<Vec<u8>> = self
            .seeds
            .iter()
            .flat_map(|path| files(&repository.join(path)))
            .map(|path| fs::read(&path).expect("the seed can be read"))
            .collect();
        assert!(!seeds.is_empty(), "no seeds in {:?}", self.seeds);
        let dictionary = fs::read_to_string(repository.join(self.dictionary))
            .expect("the dictionary can be read");
        let mutator = Mutator::new(&seeds, mutation::tokens(&dictionary));

        let watchdog = Watchdog::start(self.name);
        for (i, seed) in seeds.iter().enumerate() {
            self.attempt(property, &watchdog, &format!("seed {i}"), seed);
        }
        for i in 0..self.inputs {
            let input = mutator.input(i);
            self.attempt(property, &watchdog, &format!("mutation {i}"), &input);
        }
    }

    fn attempt(&self, property: fn(&[u8]), watchdog: &Watchdog, label: &str, input: &[u8]) {
        let before = ALLOCATOR.allocated();
        let peak_before = ALLOCATOR.max_allocated();
        watchdog.enter(label, input);
        let outcome = catch_unwind(AssertUnwindSafe(|| property(input)));
        watchdog.leave();
        let peak = ALLOCATOR.max_allocated();
        let memory = if peak > peak_before { peak - before } else { 0 };
        if outcome.is_err() || memory > MEMORY_PER_INPUT {
            let path = save(self.name, input);
            panic!(
                "{}, {label}: {} (its {memory} bytes of memory may be {MEMORY_PER_INPUT}); saved as {}",
                self.name,
                if outcome.is_err() {
                    "panicked"
                } else {
                    "took too much memory"
                },
                path.display(),
            );
        }
    }
}

/// A file, or the files of a folder in the order of their names.
fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.expect("the folder can be read").path())
        .collect();
    files.sort();
    files
}

/// Saves a failing input where builds put their files.
fn save(name: &str, input: &[u8]) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-failure"));
    fs::write(&path, input).expect("the failing input can be saved");
    path
}
