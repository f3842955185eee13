//! What was done, to be undone.

use std::collections::VecDeque;

use super::patch::Patch;

/// The most steps that are kept.
const MOST_STEPS: usize = 1000;
/// The most memory that steps hold, but for the last.
const MOST_BYTES: usize = 512 << 20;

/// A change and its name.
#[derive(Clone, Debug)]
pub(super) struct Step<S> {
    pub(super) name: String,
    pub(super) before: Patch<S>,
    pub(super) after: Patch<S>,
    /// The numbers of the states that it leads from and to.
    pub(super) from: u64,
    pub(super) to: u64,
}

impl<S: Clone> Step<S> {
    pub(super) fn new(name: &str, from: u64) -> Self {
        Self {
            name: name.to_owned(),
            before: Patch::default(),
            after: Patch::default(),
            from,
            to: from,
        }
    }

    /// Takes in one more change, which follows it.
    pub(super) fn add(&mut self, before: Patch<S>, after: &Patch<S>, to: u64) {
        // What was there first counts.
        let first = std::mem::replace(&mut self.before, before);
        self.before.then(&first);
        self.after.then(after);
        self.to = to;
    }

    fn bytes(&self) -> usize {
        self.before.bytes() + self.after.bytes()
    }
}

/// Steps that were done, and those that were undone.
#[derive(Debug)]
pub(super) struct History<S> {
    done: VecDeque<(Step<S>, usize)>,
    undone: Vec<Step<S>>,
    bytes: usize,
}

impl<S: Clone> History<S> {
    pub(super) fn new() -> Self {
        Self {
            done: VecDeque::new(),
            undone: Vec::new(),
            bytes: 0,
        }
    }

    /// A new step: what was undone cannot be done again.
    pub(super) fn push(&mut self, step: Step<S>) {
        self.undone.clear();
        self.store(step);
    }

    fn store(&mut self, step: Step<S>) {
        let bytes = step.bytes();
        self.bytes += bytes;
        self.done.push_back((step, bytes));
        while self.done.len() > MOST_STEPS || (self.bytes > MOST_BYTES && self.done.len() > 1) {
            if let Some((_, bytes)) = self.done.pop_front() {
                self.bytes -= bytes;
            }
        }
    }

    /// The step to undo; it can be done again then.
    pub(super) fn undo(&mut self) -> Option<&Step<S>> {
        let (step, bytes) = self.done.pop_back()?;
        self.bytes -= bytes;
        self.undone.push(step);
        self.undone.last()
    }

    /// The step to do again; it can be undone then.
    pub(super) fn redo(&mut self) -> Option<&Step<S>> {
        let step = self.undone.pop()?;
        self.store(step);
        self.done.back().map(|(step, _)| step)
    }

    pub(super) fn can_undo(&self) -> Option<&str> {
        self.done.back().map(|(step, _)| step.name.as_str())
    }

    pub(super) fn can_redo(&self) -> Option<&str> {
        self.undone.last().map(|step| step.name.as_str())
    }

    /// All patches, to finish what they hold.
    pub(super) fn patches(&mut self) -> impl Iterator<Item = &mut Patch<S>> {
        let done = self.done.iter_mut().map(|(step, _)| step);
        done.chain(&mut self.undone)
            .flat_map(|step| [&mut step.before, &mut step.after])
    }
}
