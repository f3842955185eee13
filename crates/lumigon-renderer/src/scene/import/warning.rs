//! What a file asks for and does not get, each once.

use std::collections::HashSet;

#[derive(Debug, Default)]
pub(super) struct Warnings {
    seen: HashSet<String>,
    list: Vec<String>,
}

impl Warnings {
    /// Adds a warning unless it is there already.
    pub(super) fn add(&mut self, warning: impl Into<String>) {
        let warning = warning.into();
        if self.seen.insert(warning.clone()) {
            self.list.push(warning);
        }
    }

    pub(super) fn into_list(self) -> Vec<String> {
        self.list
    }
}
