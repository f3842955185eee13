use std::rc::Rc;

use glam::DMat3;

use crate::{lobe::Lobe, ltc::Ltc, node::Node};

/// What a fit minimises.
pub trait Objective: Send + Sync {
    /// Gathers all that one node's residuals need; the result outlives the node's lobe.
    fn prepare(&self, node: &Node, lobe: &Lobe) -> Box<dyn Residuals>;
}

/// The residuals of one node; a fit minimises the sum of their squares.
///
/// Residuals must be a deterministic and, as far as can be, smooth function of the lobes: no fresh
/// random numbers from call to call.
pub trait Residuals: Send + Sync {
    /// What residuals need of a lobe's matrix alone, where that is the costly part: whoever calls
    /// [`Residuals::evaluate`] keeps it for as long as the matrix stays.
    fn of_matrix(&self, matrix: &DMat3) -> Vec<f64>;

    /// Appends the residuals of a sum of lobes; always the same number of them, all finite.
    /// `parts` are the lobes' [`Residuals::of_matrix`].
    fn evaluate(&self, lobes: &[Ltc], parts: &[Rc<Vec<f64>>], residuals: &mut Vec<f64>);

    /// Sets what follows from the lobes' shapes and amplitudes: their second amplitudes.
    fn complete(&self, lobes: &mut [Ltc], parts: &[Rc<Vec<f64>>]);
}

/// The last few matrices' parts: of the many sums of lobes that a fit tries, most differ in one.
#[derive(Default)]
pub(crate) struct Parts {
    recent: Vec<(DMat3, Rc<Vec<f64>>)>,
}

impl Parts {
    /// Enough for two lobes, the cosine and a trial.
    const CAPACITY: usize = 5;

    pub(crate) fn of(&mut self, residuals: &dyn Residuals, lobes: &[Ltc]) -> Vec<Rc<Vec<f64>>> {
        lobes
            .iter()
            .map(|lobe| {
                let matrix = lobe.shading_to_cosine;
                let known = self.recent.iter().position(|(known, _)| *known == matrix);
                let entry = match known {
                    Some(at) => self.recent.remove(at),
                    None => (matrix, Rc::new(residuals.of_matrix(&matrix))),
                };
                let part = Rc::clone(&entry.1);
                self.recent.insert(0, entry);
                self.recent.truncate(Self::CAPACITY);
                part
            })
            .collect()
    }
}
