//! Parts of a flat surface that emit as one polygon.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::facets::Facet;
use super::footprint::{Convex, bounds};
use super::reduction::{Judge, Patch, Sample};

/// Where texels cover less than this share of a cell, its outline is not what they see.
const LEAST_COVERAGE: f64 = 0.25;

/// Most halvings of a cell that leave all texels on one side.
const MOST_HALVINGS: u32 = 64;

/// A box of a facet's plane, and what texels see in it.
pub(super) struct Cell<'a> {
    facet: &'a Facet,
    /// Whether the texels see the facet's back.
    from_behind: bool,
    bounds: [DVec2; 2],
    /// The facet's outline within the box. Clipped loops run to and fro along its sides, where they
    /// cancel.
    loops: Vec<Vec<DVec2>>,
    fragments: Vec<Fragment>,
    /// Area that the fragments cover.
    covered: f64,
    /// Radiance times area.
    light: DVec3,
    error: f64,
}

/// Part of a texel's footprint.
#[derive(Clone, Copy)]
struct Fragment {
    part: Convex,
    area: f64,
    /// Area of the whole footprint.
    whole: f64,
    radiance: DVec3,
    weight: f64,
}

impl<'a> Cell<'a> {
    /// All that the samples of `list` see of a facet.
    pub(super) fn new(samples: &[Sample], list: &[u32], facet: &'a Facet, judge: Judge) -> Self {
        let fragment = |&i: &u32| {
            let sample = &samples[i as usize];
            Fragment {
                part: sample.footprint,
                area: sample.area(),
                whole: sample.area(),
                radiance: sample.radiance,
                weight: sample.weight,
            }
        };
        let normal = list.first().map(|&i| samples[i as usize].normal);
        let from_behind = normal.is_some_and(|normal| normal.dot(facet.frame.normal()) < 0.0);
        Self {
            facet,
            from_behind,
            bounds: facet.bounds,
            loops: facet.loops.clone(),
            fragments: list.iter().map(fragment).collect(),
            covered: 0.0,
            light: DVec3::ZERO,
            error: 0.0,
        }
        .judged(judge)
    }

    fn judged(mut self, judge: Judge) -> Self {
        self.covered = self.fragments.iter().map(|f| f.area).sum();
        self.light = self.fragments.iter().map(|f| f.radiance * f.area).sum();
        if self.covered <= 0.0 {
            return self;
        }
        let mean = self.light / self.covered;
        let apart = |f: &Fragment| (f.radiance - mean).abs().element_sum() * f.area;
        let deviation: f64 = self.fragments.iter().map(apart).sum();
        let missing = (self.area() - self.doubtful() - self.covered).max(0.0);
        let size = self.bounds[1] - self.bounds[0];
        self.error = deviation
            + mean.element_sum() * missing.min(self.covered)
            + judge.extent_error(size.length(), self.light());
        self
    }

    pub(super) fn error(&self) -> f64 {
        self.error
    }

    pub(super) fn light(&self) -> f64 {
        self.light.element_sum()
    }

    /// Area of the outline.
    fn area(&self) -> f64 {
        signed_area(&self.loops).max(0.0)
    }

    /// What may be missing of the covered area, or too much, because texels that the facet's outline
    /// cuts are on it or not as their centres are: half a texel along that outline. What splits cut is
    /// exact.
    fn doubtful(&self) -> f64 {
        let texel = self
            .fragments
            .iter()
            .map(|f| f.area)
            .fold(0.0, f64::max)
            .sqrt();
        let near = 1e-9 * (self.bounds[1] - self.bounds[0]).length();
        let is_cut = |a: DVec2, b: DVec2| {
            (0..2).any(|axis| {
                (0..2).any(|side| {
                    let line = self.bounds[side][axis];
                    line != self.facet.bounds[side][axis]
                        && (a[axis] - line).abs() <= near
                        && (b[axis] - line).abs() <= near
                })
            })
        };
        let of_loop = |vertices: &Vec<DVec2>| -> f64 {
            let following = vertices.iter().cycle().skip(1);
            let edges = vertices.iter().zip(following);
            let outer = edges.filter(|&(&a, &b)| !is_cut(a, b));
            outer.map(|(a, b)| a.distance(*b)).sum()
        };
        0.5 * texel * self.loops.iter().map(of_loop).sum::<f64>()
    }

    /// The area of the outline that emits, if its outline is what emits: all of it where nothing is
    /// surely missing. Texels on the outline then do not make cells flicker.
    fn lit_area(&self) -> Option<f64> {
        let area = self.area();
        let surely = area - self.doubtful();
        if area <= 0.0 || self.covered < LEAST_COVERAGE * surely {
            return None;
        }
        Some(if self.covered >= surely {
            area
        } else {
            area * self.covered / surely
        })
    }

    /// Two halves of the smallest box, of those that come of halving this one again and again, that
    /// holds all fragments; `None` where a texel sees as much, so that there is nothing more to know.
    pub(super) fn split(&self, judge: Judge) -> Option<[Self; 2]> {
        let texel = self.fragments.iter().map(|f| f.whole).fold(0.0, f64::max);
        if self.fragments.len() < 2 || self.covered <= texel {
            return None;
        }
        let corners = self.fragments.iter().flat_map(|f| f.part.corners());
        let [low, high] = bounds(corners);
        let mut bounds = self.bounds;
        for _ in 0..MOST_HALVINGS {
            let size = bounds[1] - bounds[0];
            let axis = usize::from(size.y > size.x);
            let middle = 0.5 * (bounds[0][axis] + bounds[1][axis]);
            if !(middle > bounds[0][axis] && middle < bounds[1][axis]) {
                return None;
            }
            if middle <= low[axis] {
                bounds[0][axis] = middle;
            } else if middle >= high[axis] {
                bounds[1][axis] = middle;
            } else {
                return Some(self.halves(bounds, axis, middle, judge));
            }
        }
        None
    }

    fn halves(&self, bounds: [DVec2; 2], axis: usize, middle: f64, judge: Judge) -> [Self; 2] {
        let half = |is_upper: bool| {
            let mut bounds = bounds;
            bounds[usize::from(!is_upper)][axis] = middle;
            let sign = if is_upper { 1.0 } else { -1.0 };
            let height = |p: DVec2| sign * (p[axis] - middle);
            let fragment = |f: &Fragment| {
                let part = f.part.clipped(height);
                let area = part.area() * f.weight;
                (area > 0.0).then_some(Fragment { part, area, ..*f })
            };
            let mut loops = self.loops.clone();
            // The box may have shrunk on the way here.
            for axis in 0..2 {
                let [low, high] = bounds.map(|corner| corner[axis]);
                for loop_ in &mut loops {
                    *loop_ = clipped(&clipped(loop_, |p| p[axis] - low), |p| high - p[axis]);
                }
            }
            loops.retain(|vertices| vertices.len() > 2);
            Self {
                facet: self.facet,
                from_behind: self.from_behind,
                bounds,
                loops,
                fragments: self.fragments.iter().filter_map(fragment).collect(),
                covered: 0.0,
                light: DVec3::ZERO,
                error: 0.0,
            }
            .judged(judge)
        };
        [half(false), half(true)]
    }

    pub(super) fn patch(&self) -> Patch {
        let frame = &self.facet.frame;
        let lit = self.lit_area();
        let mut loops: Vec<Vec<DVec2>> = match lit.is_some() {
            true => self.loops.iter().map(|l| simplified(l)).collect(),
            false => vec![self.rectangle()],
        };
        loops.retain(|vertices| vertices.len() > 2);
        let raised = |vertices: &Vec<DVec2>| {
            let mut vertices: Vec<_> = vertices
                .iter()
                .map(|&p| frame.raised(p).to_array())
                .collect();
            if self.from_behind {
                vertices.reverse();
            }
            vertices
        };
        let side = if self.from_behind { -1.0 } else { 1.0 };
        Patch {
            loops: loops.iter().map(raised).collect(),
            area: lit.unwrap_or(self.covered),
            normal: frame.normal() * side,
            target: frame.raised(self.middle()),
            flux: self.light * (PI * lit.map_or(1.0, |area| area / self.covered)),
        }
    }

    /// The centre of the light, or the middle of the part of a texel next to it.
    fn middle(&self) -> DVec2 {
        let weight = |f: &Fragment| f.radiance.element_sum() * f.area;
        let moment: DVec2 = self
            .fragments
            .iter()
            .map(|f| f.part.centroid() * weight(f))
            .sum();
        let center = moment / self.light();
        let distance = |f: &Fragment| f.part.centroid().distance_squared(center);
        let nearest = self
            .fragments
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let Some(nearest) = nearest else {
            return center;
        };
        if nearest.part.contains(center) {
            center
        } else {
            nearest.part.centroid()
        }
    }

    /// The rectangle that has the moments of the fragments.
    fn rectangle(&self) -> Vec<DVec2> {
        let places = self.fragments.iter().map(|f| (f.part.centroid(), f.area));
        moment_rectangle(places)
    }
}

/// The rectangle of the same moments as small areas at these places.
pub(super) fn moment_rectangle(places: impl Iterator<Item = (DVec2, f64)> + Clone) -> Vec<DVec2> {
    let whole: f64 = places.clone().map(|(_, area)| area).sum();
    let center: DVec2 = places.clone().map(|(p, area)| p * area).sum::<DVec2>() / whole;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (place, area) in places {
        let offset = place - center;
        // A square of this area has a twelfth of it as its own moment.
        xx += area * (offset.x * offset.x + area / 12.0);
        xy += area * offset.x * offset.y;
        yy += area * (offset.y * offset.y + area / 12.0);
    }
    let (xx, xy, yy) = (xx / whole, xy / whole, yy / whole);
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let x = DVec2::from_angle(angle);
    let y = x.perp();
    let deviation = |axis: DVec2| {
        let variance = axis.x * axis.x * xx + 2.0 * axis.x * axis.y * xy + axis.y * axis.y * yy;
        // A uniform distribution is sqrt(3) deviations wide to either side.
        axis * (3.0 * variance.max(0.0)).sqrt()
    };
    let (x, y) = (deviation(x), deviation(y));
    vec![
        center - x - y,
        center + x - y,
        center + x + y,
        center - x + y,
    ]
}

/// Area of the loops: holes count against it.
fn signed_area(loops: &[Vec<DVec2>]) -> f64 {
    let of_loop = |vertices: &Vec<DVec2>| -> f64 {
        let following = vertices.iter().cycle().skip(1);
        let edges = vertices.iter().zip(following);
        0.5 * edges.map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
    };
    loops.iter().map(of_loop).sum()
}

/// A loop where `height` is not negative, and along the line where it is 0 in place of the rest.
fn clipped(vertices: &[DVec2], height: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let following = vertices.iter().cycle().skip(1);
    let mut part = Vec::with_capacity(vertices.len() + 2);
    for (&from, &to) in vertices.iter().zip(following) {
        let (above, next) = (height(from), height(to));
        if above >= 0.0 {
            part.push(from);
        }
        if (above >= 0.0) != (next >= 0.0) {
            part.push(from.lerp(to, above / (above - next)));
        }
    }
    part
}

/// The same loop without vertices that others repeat or that lie between their neighbours.
fn simplified(vertices: &[DVec2]) -> Vec<DVec2> {
    let size = vertices
        .iter()
        .fold(0.0_f64, |m, v| m.max(v.abs().max_element()));
    let least = 1e-9 * size;
    let mut kept: Vec<DVec2> = Vec::with_capacity(vertices.len());
    for &v in vertices {
        if kept.last().is_none_or(|&last| last.distance(v) > least) {
            kept.push(v);
        }
    }
    while kept.len() > 1 && kept[0].distance(kept[kept.len() - 1]) <= least {
        kept.pop();
    }
    let count = kept.len();
    let turns = |i: usize| {
        let [before, here, after] = [i + count - 1, i, i + 1].map(|k| kept[k % count]);
        let (arriving, leaving) = (here - before, after - here);
        arriving.perp_dot(leaving).abs() > 1e-9 * arriving.length() * leaving.length()
            || arriving.dot(leaving) < 0.0
    };
    (0..count).filter(|&i| turns(i)).map(|i| kept[i]).collect()
}
