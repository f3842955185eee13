//! The document's images, each decoded once.

use std::collections::HashMap;

use gltf::json;

use super::source::Source;
use crate::scene::{
    Limits, LoadPhase, LoadWatch,
    error::Fault,
    image_file::{Budget, Decoded},
};

/// The images decoded so far.
pub(super) struct Images<'a> {
    done: HashMap<usize, Decoded>,
    budget: Budget,
    watch: LoadWatch<'a>,
}

impl<'a> Images<'a> {
    pub(super) fn new(limits: &Limits, watch: LoadWatch<'a>) -> Self {
        Self {
            done: HashMap::new(),
            budget: Budget::new(limits),
            watch,
        }
    }

    /// `images[index]`, decoded at most once. `user` is the place that asks.
    pub(super) fn get(
        &mut self,
        root: &json::Root,
        source: &mut Source<'_>,
        index: usize,
        user: &str,
    ) -> Result<Decoded, Fault> {
        if let Some(image) = self.done.get(&index) {
            return Ok(image.clone());
        }
        let image = root.images.get(index).ok_or_else(|| {
            let what = format!("there is no images[{index}]");
            Fault::new(user, what, "use an index that exists")
        })?;
        self.watch.begin(LoadPhase::Image {
            number: self.done.len() + 1,
            of: root.images.len(),
        })?;
        let place = format!("images[{index}]");
        let image = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                let bytes = source.uri(uri, &format!("{place}.uri"))?;
                self.budget.decode(&bytes, &place)?
            }
            (None, Some(view)) => {
                let view = source.view(view.value(), &place)?;
                self.budget.decode(view.bytes(), &place)?
            }
            (None, None) => {
                return Err(Fault::new(
                    place,
                    "it has neither a uri nor a bufferView",
                    "give it one of them",
                ));
            }
        };
        self.done.insert(index, image.clone());
        Ok(image)
    }
}
