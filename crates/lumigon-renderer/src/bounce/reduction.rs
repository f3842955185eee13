//! From texels to as few lights as wanted.
//!
//! A tree grows from its root by the leaf whose light is worst represented, until there are as many
//! leaves as lights are wanted. Surfaces that are flat and widely seen are roots of their own, split in
//! their plane; all others share one, split by position and normal. Nodes are split in the middle of
//! what they cover, never where texels happen to lie: as the camera moves, lights stay.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use glam::DVec3;

use super::Facets;
use super::cells::Cell;
use super::clusters::Cluster;
use super::footprint::{Convex, PlaneFrame};

/// Share of the whole light below which no leaf is split: it is rounding.
const LEAST_ERROR: f64 = 1e-6;

/// Where lights are merged and not counted: how far, on average, radiance may be from its mean.
const ALIKE: f64 = 0.05;

/// Fewest texels that make a facet a root.
const LEAST_TEXELS: usize = 8;

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
        self.radiance * (self.area() * PI)
    }

    /// The light that is its footprint.
    pub(super) fn patch(&self) -> Patch {
        let corners = self.footprint.corners().iter();
        let corners = corners.map(|&p| self.frame.raised(p).to_array());
        Patch {
            loops: vec![corners.collect()],
            area: self.area(),
            normal: self.normal,
            target: self.position,
            flux: self.flux(),
        }
    }
}

/// A light to be.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Counter-clockwise about the side that emits; what clipping leaves may run to and fro on itself.
    pub(super) loops: Vec<Vec<[f64; 3]>>,
    /// Area of the surfaces that it stands for.
    pub(super) area: f64,
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
    /// How much a light's size counts although it is evenly bright: for points, and for rays that see
    /// one point of it.
    pub(super) extent_weight: f64,
}

/// What nodes of the tree need to know to judge themselves.
#[derive(Clone, Copy)]
pub(super) struct Judge {
    pub(super) scene_diagonal: f64,
    pub(super) extent_weight: f64,
}

impl Judge {
    /// What is wrong with a light for being so large.
    pub(super) fn extent_error(&self, extent: f64, light: f64) -> f64 {
        if self.scene_diagonal > 0.0 {
            self.extent_weight * light * extent / self.scene_diagonal
        } else {
            0.0
        }
    }
}

/// Lights with the flux of the samples, as many as wanted or fewer.
pub(super) fn reduced(samples: &[Sample], facets: &Facets, reduction: Reduction) -> Vec<Patch> {
    let judge = Judge {
        scene_diagonal: facets.scene_diagonal,
        extent_weight: reduction.extent_weight,
    };
    let count = reduction.count.unwrap_or(usize::MAX);
    let mut roots = Vec::new();
    let mut rest: Vec<u32> = (0..samples.len() as u32).collect();
    if reduction.merges {
        let most = (count / 2).max(1);
        let (flat, others) = by_facet(samples, most);
        roots.extend(
            flat.into_iter().map(|(facet, list)| {
                Node::Cell(Cell::new(samples, &list, facets.get(facet), judge))
            }),
        );
        rest = others;
    }
    rest.retain(|&i| samples[i as usize].flux().max_element() > 0.0);
    let mut patches = Vec::new();
    if reduction.count.is_none() {
        patches.extend(rest.iter().map(|&i| samples[i as usize].patch()));
    } else if !rest.is_empty() {
        roots.push(Node::Cluster(Cluster::new(samples, rest, facets, judge)));
    }
    roots.retain(|root| root.light() > 0.0);
    let all: f64 = roots.iter().map(Node::light).sum();
    let mut tree: BinaryHeap<Node<'_>> = roots.into();
    let mut leaves = Vec::new();
    while let Some(worst) = tree.pop() {
        let is_alike = reduction.count.is_none() && worst.error() <= ALIKE * worst.light();
        if is_alike || worst.error() <= LEAST_ERROR * all || leaves.len() + tree.len() + 2 > count {
            leaves.push(worst);
            continue;
        }
        match worst.split(samples, judge) {
            Ok(halves) => tree.extend(halves.into_iter().filter(|half| half.light() > 0.0)),
            Err(whole) => leaves.push(whole),
        }
    }
    patches.extend(leaves.iter().map(|leaf| leaf.patch(samples)));
    keep_flux(samples, &mut patches);
    patches
}

/// Scales all lights alike, so that together they emit what the samples do. What texels on outlines
/// have too much or too little is spread over all.
fn keep_flux(samples: &[Sample], patches: &mut [Patch]) {
    let gathered: DVec3 = samples.iter().map(Sample::flux).sum();
    let emitted: DVec3 = patches.iter().map(|patch| patch.flux).sum();
    let scale = gathered / emitted;
    let scale = DVec3::select(scale.is_finite_mask(), scale, DVec3::ONE);
    for patch in patches {
        patch.flux *= scale;
    }
}

/// The samples of each facet that is widely seen, and all others.
///
/// Facets have two sides: a list has samples of one. The brightest come first, `most` at most.
fn by_facet(samples: &[Sample], most: usize) -> (Vec<(u32, Vec<u32>)>, Vec<u32>) {
    let mut order: Vec<u32> = (0..samples.len() as u32).collect();
    let side = |i: u32| {
        let sample = &samples[i as usize];
        (
            sample.facet,
            sample.normal.dot(sample.frame.normal()) >= 0.0,
        )
    };
    order.sort_by_key(|&i| side(i));
    let mut rest = Vec::new();
    let mut lists = Vec::new();
    for list in order.chunk_by(|&a, &b| side(a) == side(b)) {
        match side(list[0]).0 {
            Some(facet) if list.len() >= LEAST_TEXELS => {
                let flux: DVec3 = list.iter().map(|&i| samples[i as usize].flux()).sum();
                lists.push((flux.element_sum(), facet, list.to_vec()));
            }
            _ => rest.extend_from_slice(list),
        }
    }
    lists.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, _, list) in lists.drain(most.min(lists.len())..) {
        rest.extend(list);
    }
    rest.sort_unstable();
    let lists = lists.into_iter().map(|(_, facet, list)| (facet, list));
    (lists.collect(), rest)
}

/// A leaf of the tree.
enum Node<'a> {
    Cell(Cell<'a>),
    Cluster(Cluster),
}

impl<'a> Node<'a> {
    /// Radiance times area that is in the wrong place.
    fn error(&self) -> f64 {
        match self {
            Self::Cell(cell) => cell.error(),
            Self::Cluster(cluster) => cluster.error(),
        }
    }

    /// Radiance times area, over all channels.
    fn light(&self) -> f64 {
        match self {
            Self::Cell(cell) => cell.light(),
            Self::Cluster(cluster) => cluster.light(),
        }
    }

    fn split(self, samples: &[Sample], judge: Judge) -> Result<[Self; 2], Self> {
        match self {
            Self::Cell(cell) => match cell.split(judge) {
                Some(halves) => Ok(halves.map(Self::Cell)),
                None => Err(Self::Cell(cell)),
            },
            Self::Cluster(cluster) => match cluster.split(samples, judge) {
                Some(halves) => Ok(halves.map(Self::Cluster)),
                None => Err(Self::Cluster(cluster)),
            },
        }
    }

    fn patch(&self, samples: &[Sample]) -> Patch {
        match self {
            Self::Cell(cell) => cell.patch(),
            Self::Cluster(cluster) => cluster.patch(samples),
        }
    }
}

impl Ord for Node<'_> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error().total_cmp(&other.error())
    }
}

impl PartialOrd for Node<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Node<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Node<'_> {}
