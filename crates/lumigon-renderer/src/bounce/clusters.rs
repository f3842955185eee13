//! Parts of curved and scattered surfaces that emit as one rectangle.

use std::f64::consts::PI;

use glam::DVec3;

use super::Facets;
use super::cells::moment_rectangle;
use super::footprint::PlaneFrame;
use super::reduction::{Judge, Patch, Sample};

/// Most halvings of a cluster that leave all texels on one side.
const MOST_HALVINGS: u32 = 128;

/// A box of positions and of normals, and the texels in it.
pub(super) struct Cluster {
    list: Vec<u32>,
    /// Of positions, then of normals.
    bounds: [[f64; 2]; 6],
    /// Radiance times area.
    light: DVec3,
    error: f64,
    scene_diagonal: f64,
}

fn coordinates(sample: &Sample) -> [f64; 6] {
    let (p, n) = (sample.position, sample.normal);
    [p.x, p.y, p.z, n.x, n.y, n.z]
}

impl Cluster {
    pub(super) fn new(samples: &[Sample], list: Vec<u32>, facets: &Facets, judge: Judge) -> Self {
        let [low, high] = facets.scene_bounds;
        let mut bounds = [[-1.0, 1.0]; 6];
        for axis in 0..3 {
            bounds[axis] = [low[axis], high[axis]];
        }
        Self {
            list,
            bounds,
            light: DVec3::ZERO,
            error: 0.0,
            scene_diagonal: facets.scene_diagonal,
        }
        .judged(samples, judge)
    }

    fn judged(mut self, samples: &[Sample], judge: Judge) -> Self {
        let chosen = || self.list.iter().map(|&i| &samples[i as usize]);
        let area: f64 = chosen().map(Sample::area).sum();
        let facing: DVec3 = chosen().map(|s| s.normal * s.area()).sum();
        let light: DVec3 = chosen().map(|s| s.radiance * s.area()).sum();
        let mean = light / area;
        let apart = |s: &Sample| (s.radiance - mean).abs().element_sum() * s.area();
        let deviation: f64 = chosen().map(apart).sum();
        let [low, high] = extent(samples, &self.list);
        let length = (0..3)
            .map(|i| (high[i] - low[i]).powi(2))
            .sum::<f64>()
            .sqrt();
        let all = light.element_sum();
        self.light = light;
        self.error = deviation
            + all * (1.0 - facing.length() / area).max(0.0)
            + all * length / self.scene_diagonal.max(f64::MIN_POSITIVE)
            + judge.extent_error(length, all);
        if self.list.len() < 2 || !self.error.is_finite() {
            self.error = 0.0;
        }
        self
    }

    pub(super) fn error(&self) -> f64 {
        self.error
    }

    pub(super) fn light(&self) -> f64 {
        self.light.element_sum()
    }

    /// Two halves of the smallest box, of those that come of halving this one again and again, that
    /// holds all samples; `None` where they are all in one place.
    pub(super) fn split(&self, samples: &[Sample], judge: Judge) -> Option<[Self; 2]> {
        let [low, high] = extent(samples, &self.list);
        // Normals count by the half: two units from pole to pole are as much as the scene.
        let scale = |axis: usize| match axis {
            0..3 => 1.0 / self.scene_diagonal,
            _ => 0.5,
        };
        let size = |axis: usize| (high[axis] - low[axis]) * scale(axis);
        let axis = (0..6).max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
        let mut bounds = self.bounds;
        for _ in 0..MOST_HALVINGS {
            let [least, greatest] = bounds[axis];
            let middle = 0.5 * (least + greatest);
            if !(middle > least && middle < greatest) {
                return None;
            }
            if middle <= low[axis] {
                bounds[axis][0] = middle;
            } else if middle > high[axis] {
                bounds[axis][1] = middle;
            } else {
                let is_lower = |&i: &u32| coordinates(&samples[i as usize])[axis] < middle;
                let (lower, upper) = self.list.iter().partition(|&i| is_lower(i));
                let half = |list, is_upper: bool| {
                    let mut bounds = bounds;
                    bounds[axis][usize::from(!is_upper)] = middle;
                    Self {
                        list,
                        bounds,
                        light: DVec3::ZERO,
                        error: 0.0,
                        scene_diagonal: self.scene_diagonal,
                    }
                    .judged(samples, judge)
                };
                return Some([half(lower, false), half(upper, true)]);
            }
        }
        None
    }

    pub(super) fn patch(&self, samples: &[Sample]) -> Patch {
        if let &[only] = self.list.as_slice() {
            return samples[only as usize].patch();
        }
        let chosen = || self.list.iter().map(|&i| &samples[i as usize]);
        let area: f64 = chosen().map(Sample::area).sum();
        let facing: DVec3 = chosen().map(|s| s.normal * s.area()).sum();
        let normal = facing.normalize_or(samples[self.list[0] as usize].normal);
        let weight = |s: &Sample| s.flux().element_sum();
        let moment: DVec3 = chosen().map(|s| s.position * weight(s)).sum();
        let center = moment / chosen().map(weight).sum::<f64>();
        let frame = PlaneFrame::new(center, normal);
        let places = chosen().map(|s| (frame.flat(s.position), s.area()));
        let corners = moment_rectangle(places).into_iter();
        let distance = |s: &Sample| s.position.distance_squared(center);
        let nearest = chosen().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        Patch {
            loops: vec![corners.map(|p| frame.raised(p).to_array()).collect()],
            area,
            normal,
            target: nearest.map_or(center, |sample| sample.position),
            flux: self.light * PI,
        }
    }
}

/// The least and the greatest coordinates.
fn extent(samples: &[Sample], list: &[u32]) -> [[f64; 6]; 2] {
    let (mut low, mut high) = ([f64::INFINITY; 6], [f64::NEG_INFINITY; 6]);
    for &i in list {
        for (axis, x) in coordinates(&samples[i as usize]).into_iter().enumerate() {
            low[axis] = low[axis].min(x);
            high[axis] = high[axis].max(x);
        }
    }
    [low, high]
}
