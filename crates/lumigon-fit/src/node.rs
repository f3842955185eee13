use std::sync::Arc;

use glam::DVec3;

use crate::{brdf::Brdf, kind::BrdfKind, limit::Limit, lobe::Lobe};

/// One problem to be fitted: a BRDF seen from one direction, with what its lobe sums up to.
#[derive(Clone)]
pub struct Node {
    /// The BRDF.
    pub brdf: Arc<dyn Brdf>,
    /// Unit view direction in shading space.
    pub view: DVec3,
    /// What the lobe tends to.
    pub limit: Limit,
    /// Directional albedo with F = 1, in `(0,1]`.
    pub albedo: f64,
    /// Directional albedo under the second weight.
    pub secondary_albedo: f64,
    /// Mean light direction of the lobe, unit length.
    pub mean_direction: DVec3,
}

impl Node {
    /// The node at a place of a table, and its lobe as `directions` weighted directions.
    pub fn new(kind: BrdfKind, place: &[f64], directions: u32) -> (Self, Lobe) {
        let (brdf, view) = kind.at(place);
        let lobe = Lobe::new(brdf.as_ref(), view, directions);
        let mut mean_direction = lobe.mean_direction();
        if kind.is_isotropic() {
            // Symmetric in y, up to the lattice.
            mean_direction = mean_direction.with_y(0.0).normalize_or(DVec3::Z);
        }
        let node = Self {
            limit: brdf.limit(view),
            brdf,
            view,
            albedo: lobe.albedo().max(1e-9),
            secondary_albedo: lobe.secondary_albedo(),
            mean_direction,
        };
        (node, lobe)
    }
}
