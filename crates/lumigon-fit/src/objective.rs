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
    /// Appends the residuals of a sum of lobes; always the same number of them, all finite.
    fn evaluate(&self, lobes: &[Ltc], residuals: &mut Vec<f64>);

    /// Sets what follows from the lobes' shapes and amplitudes: their second amplitudes.
    fn complete(&self, lobes: &mut [Ltc]);
}
