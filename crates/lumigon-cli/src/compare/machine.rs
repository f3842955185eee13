//! The machine that was measured on.

use std::fs;

use serde::Serialize;

/// What decides how long a method takes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Machine {
    /// The processor's model name; none where the system does not tell.
    pub(crate) cpu: Option<String>,
    /// Threads that render.
    pub(crate) threads: usize,
    /// What rendered the methods; the references are the processor's.
    pub(crate) methods: String,
    /// The processor's architecture.
    pub(crate) architecture: &'static str,
    /// The operating system.
    pub(crate) system: &'static str,
}

impl Machine {
    /// This one; `methods` says what rendered them.
    pub(crate) fn this(methods: String) -> Self {
        let cpu = fs::read_to_string("/proc/cpuinfo")
            .ok()
            .and_then(|text| model_name(&text));
        Self {
            cpu,
            threads: rayon::current_num_threads(),
            methods,
            architecture: std::env::consts::ARCH,
            system: std::env::consts::OS,
        }
    }
}

/// The first processor's model name.
fn model_name(cpuinfo: &str) -> Option<String> {
    let (_, name) = cpuinfo
        .lines()
        .filter_map(|line| line.split_once(':'))
        .find(|(key, _)| key.trim() == "model name")?;
    let name = name.trim();
    (!name.is_empty()).then(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn model_name_is_the_first_processors() {
        let text = "processor\t: 0\nmodel name\t: Lamp 9000 @ 1 GHz\nmodel name\t: Other\n";
        assert_eq!(model_name(text).as_deref(), Some("Lamp 9000 @ 1 GHz"));
        assert_eq!(model_name("model name\t:\n"), None);
        assert_eq!(model_name(""), None);
    }
}
