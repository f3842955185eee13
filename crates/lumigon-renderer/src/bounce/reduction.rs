//! From texels to as few lights as wanted.

use glam::DVec3;

use super::Facets;
use super::footprint::{Convex, PlaneFrame};

/// What one texel sees.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    /// Index of the facet that it lies on, if any.
    pub(super) facet: Option<u32>,
    pub(super) position: DVec3,
    /// Unit normal towards the centre of its cube map.
    pub(super) normal: DVec3,
    /// Linear RGB radiance of its diffuse light.
    pub(super) radiance: DVec3,
    /// What other cube maps that see the place leave to this one, 0 to 1.
    pub(super) weight: f64,
    /// In the plane of `frame`.
    pub(super) footprint: Convex,
    pub(super) frame: PlaneFrame,
}

impl Sample {
    /// In square metres; its share, where other cube maps see the same.
    pub(super) fn area(&self) -> f64 {
        self.footprint.area() * self.weight
    }

    /// Linear RGB, in watts or lumens.
    pub(super) fn flux(&self) -> DVec3 {
        self.radiance * (self.area() * std::f64::consts::PI)
    }
}

/// A light to be.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Counter-clockwise about the side that emits; what clipping leaves may run to and fro on itself.
    pub(super) loops: Vec<Vec<[f64; 3]>>,
    /// Unit normal towards the side that emits.
    pub(super) normal: DVec3,
    /// A point of a surface that a cube map has seen, in the middle of it.
    pub(super) target: DVec3,
    /// Linear RGB.
    pub(super) flux: DVec3,
}

/// What to do with the texels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reduction {
    pub(super) merges: bool,
    /// At most as many lights.
    pub(super) count: Option<usize>,
    /// Whether a light's size counts although it is evenly bright: for points, and for rays that see
    /// one point of it.
    pub(super) extent_counts: bool,
}

/// Lights with the flux of the samples.
pub(super) fn reduced(samples: &[Sample], _facets: &Facets, _reduction: Reduction) -> Vec<Patch> {
    samples
        .iter()
        .map(|sample| {
            let corners = sample.footprint.corners().iter();
            let corners = corners.map(|&p| sample.frame.raised(p).to_array());
            Patch {
                loops: vec![corners.collect()],
                normal: sample.normal,
                target: sample.position,
                flux: sample.flux(),
            }
        })
        .collect()
}
