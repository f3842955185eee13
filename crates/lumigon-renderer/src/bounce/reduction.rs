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
        let (flat, others) = by_facet(samples, count / 2);
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
            Some(halves) => tree.extend(halves.into_iter().filter(|half| half.light() > 0.0)),
            None => leaves.push(worst),
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

    fn split(&self, samples: &[Sample], judge: Judge) -> Option<[Self; 2]> {
        match self {
            Self::Cell(cell) => Some(cell.split(judge)?.map(Self::Cell)),
            Self::Cluster(cluster) => Some(cluster.split(samples, judge)?.map(Self::Cluster)),
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

#[cfg(test)]
mod tests {
    use super::super::CubeMap;
    use super::super::footprint::footprint;
    use super::*;
    use crate::scene::{Mesh, Scene};
    use glam::Vec3;
    use std::sync::Arc;

    /// A floor two metres wide at y = -1 with a square hole.
    fn floor() -> Scene {
        let at = |x: f32, z: f32| Vec3::new(x, -1.0, z);
        let ring = |r: f32| [at(-r, r), at(r, r), at(r, -r), at(-r, -r)];
        let positions = [ring(1.0), ring(0.5)].concat();
        let side = |i: u32| {
            let next = (i + 1) % 4;
            [[i, next, 4 + next], [i, 4 + next, 4 + i]]
        };
        Scene {
            meshes: vec![Arc::new(Mesh {
                normals: vec![Vec3::Y; 8],
                positions,
                triangles: (0..4).flat_map(side).collect(),
                ..Mesh::default()
            })],
            materials: vec![crate::scene::Material::default()],
            ..Scene::default()
        }
    }

    /// What texels of a cube map over the floor see of it, radiance growing with x.
    fn samples(facets: &Facets, eye: DVec3, slope: f64) -> Vec<Sample> {
        let map = CubeMap {
            center: eye.as_vec3().to_array(),
            face_size: 24,
            texels: Vec::new(),
        };
        let frame = facets.get(0).frame;
        (0..6 * 24 * 24)
            .filter_map(|index| {
                let corners = map.corners(index);
                let direction: DVec3 = corners.iter().sum::<DVec3>() * 0.25;
                let position = eye + direction * ((-1.0 - eye.y) / direction.y);
                let reach = position.x.abs().max(position.z.abs());
                if direction.y >= 0.0 || !(0.5..1.0).contains(&reach) {
                    return None;
                }
                Some(Sample {
                    facet: Some(0),
                    position,
                    normal: DVec3::Y,
                    radiance: DVec3::new(1.0, 0.5, 0.25) * (1.0 + slope * position.x),
                    weight: 1.0,
                    footprint: footprint(eye, &corners, 2.0 / 24.0, position, &frame),
                    frame,
                })
            })
            .collect()
    }

    fn flux(patches: &[Patch]) -> DVec3 {
        patches.iter().map(|patch| patch.flux).sum()
    }

    const WHOLE: Reduction = Reduction {
        merges: true,
        count: Some(64),
        extent_weight: 0.0,
    };

    #[test]
    fn an_even_surface_is_one_light_of_its_outline() {
        let facets = Facets::new(&floor());
        let samples = samples(&facets, DVec3::new(0.1, 0.0, 0.05), 0.0);
        let patches = reduced(&samples, &facets, WHOLE);
        assert_eq!(patches.len(), 1);
        let [patch] = patches.as_slice() else { return };
        assert_eq!(patch.loops.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4]);
        assert!((patch.area - 3.0).abs() < 1e-6, "{}", patch.area);
        assert!(patch.normal.distance(DVec3::Y) < 1e-6);
        // A point of the floor, not of its hole.
        let reach = patch.target.x.abs().max(patch.target.z.abs());
        assert!((0.45..1.05).contains(&reach), "{}", patch.target);
    }

    #[test]
    fn flux_is_kept_and_lights_are_counted() {
        let facets = Facets::new(&floor());
        let samples = samples(&facets, DVec3::new(0.1, 0.0, 0.05), 0.8);
        let seen: DVec3 = samples.iter().map(Sample::flux).sum();
        for merges in [true, false] {
            for count in [None, Some(1), Some(2), Some(7), Some(64), Some(100_000)] {
                for extent_weight in [0.0, 1.0] {
                    let reduction = Reduction {
                        merges,
                        count,
                        extent_weight,
                    };
                    let patches = reduced(&samples, &facets, reduction);
                    assert!((flux(&patches) / seen - 1.0).abs().max_element() < 1e-12);
                    let most = count.unwrap_or(2 * samples.len());
                    assert!((1..=most).contains(&patches.len()));
                    if (2..100).contains(&most) {
                        assert_eq!(patches.len(), most, "{reduction:?}");
                    }
                }
            }
        }
        let alike = Reduction {
            count: None,
            ..WHOLE
        };
        let alike = reduced(&samples, &facets, alike).len();
        assert!((2..2 * samples.len()).contains(&alike), "{alike}");
    }

    #[test]
    fn lights_do_not_follow_the_cube_map() {
        let facets = Facets::new(&floor());
        let of = |x: f64| {
            let samples = samples(&facets, DVec3::new(x, 0.0, 0.05), 0.8);
            let patches = reduced(&samples, &facets, WHOLE);
            let mut loops: Vec<_> = patches.into_iter().map(|patch| patch.loops).collect();
            loops.sort_by(|a, b| a.partial_cmp(b).unwrap());
            loops
        };
        let (first, second) = (of(0.1), of(0.13));
        let kept = second.iter().filter(|loops| first.contains(loops)).count();
        assert!(kept >= 40, "{kept} of {} stay", first.len());
    }

    #[test]
    fn what_is_no_facet_becomes_rectangles() {
        let facets = Facets::new(&floor());
        let mut samples = samples(&facets, DVec3::new(0.1, 0.0, 0.05), 0.0);
        for sample in &mut samples {
            sample.facet = None;
        }
        let one = Reduction {
            count: Some(1),
            ..WHOLE
        };
        let patches = reduced(&samples, &facets, one);
        let [patch] = patches.as_slice() else {
            panic!("{} lights", patches.len())
        };
        assert_eq!(patch.loops[0].len(), 4);
        // Its moments are the ring's: 2/12 times (16 - 1)/(4 - 1) of a unit square's.
        let width = DVec3::from(patch.loops[0][0]).distance(DVec3::from(patch.loops[0][1]));
        assert!(
            (width / (12.0 * 5.0 / 12.0_f64).sqrt() - 1.0).abs() < 0.03,
            "{width}"
        );
        // A surface point next to the middle.
        assert!(samples.iter().any(|sample| sample.position == patch.target));
        assert!(reduced(&[], &facets, WHOLE).is_empty());
    }
}
