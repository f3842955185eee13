use crate::{fit::Lobes, kind::BrdfKind, limit::Limit, settings::Settings};

/// The nodes of a table: where each lies, and what lies beside it.
pub(crate) struct Grid {
    brdf: BrdfKind,
    lobes: u32,
    sizes: Vec<usize>,
}

impl Grid {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            brdf: settings.brdf,
            lobes: settings.lobes,
            sizes: settings.brdf.sizes(settings.size),
        }
    }

    pub(crate) fn count(&self) -> usize {
        self.sizes.iter().product()
    }

    /// Position along each axis.
    pub(crate) fn position(&self, mut index: usize) -> Vec<usize> {
        self.sizes
            .iter()
            .map(|&size| {
                let at = index % size;
                index /= size;
                at
            })
            .collect()
    }

    pub(crate) fn index(&self, position: &[usize]) -> Option<usize> {
        let (mut index, mut stride) = (0, 1);
        for (axis, &size) in self.sizes.iter().enumerate() {
            let &at = position.get(axis)?;
            if at >= size {
                return None;
            }
            index += at * stride;
            stride *= size;
        }
        Some(index)
    }

    /// Coordinates in `[0,1]`.
    pub(crate) fn place(&self, index: usize) -> Vec<f64> {
        self.position(index)
            .iter()
            .zip(&self.sizes)
            .map(|(&at, &size)| at as f64 / (size - 1) as f64)
            .collect()
    }

    /// All nodes as lines that go out from one of them, the seed: first along the first axis, then
    /// along every other from all nodes that have been reached, the view axis last. A line is two
    /// ways, up and down the axis, and both begin with the node that has been reached.
    pub(crate) fn lines_from_seed(&self) -> Vec<Vec<[Vec<usize>; 2]>> {
        let view = self.brdf.view_axis();
        let mut order: Vec<usize> = (0..self.sizes.len()).filter(|&axis| axis != view).collect();
        order.push(view);
        // Broad lobes, where every coordinate matters; two of them share their work best where
        // one does worst, at grazing views.
        let fifths = |axis: usize| match (axis == view, self.lobes) {
            (false, _) => 3,
            (true, 1) => 2,
            (true, _) => 4,
        };
        let seed: Vec<usize> = (0..self.sizes.len())
            .map(|axis| self.sizes[axis] * fifths(axis) / 5)
            .collect();
        let mut reached = vec![self.index(&seed).unwrap_or(0)];
        order
            .into_iter()
            .map(|axis| {
                let stride: usize = self.sizes[..axis].iter().product();
                let (size, at) = (self.sizes[axis], seed[axis]);
                let lines: Vec<[Vec<usize>; 2]> = reached
                    .iter()
                    .map(|&start| {
                        let first = start - at * stride;
                        let up = (at..size).map(|i| first + i * stride).collect();
                        let down = (0..=at).rev().map(|i| first + i * stride).collect();
                        [up, down]
                    })
                    .collect();
                reached = lines
                    .iter()
                    .flat_map(|[up, down]| up.iter().chain(&down[1..]).copied())
                    .collect();
                lines
            })
            .collect()
    }

    /// For a node at the end of an axis: the two nodes before it, nearest first, whose line goes
    /// on to it.
    pub(crate) fn beyond<'a>(
        &self,
        index: usize,
        all: &'a [Lobes],
    ) -> impl Iterator<Item = [&'a Lobes; 2]> + use<'a> {
        let view = self.brdf.view_axis();
        let stride: usize = self.sizes[..view].iter().product();
        let at = self.position(index)[view];
        (at + 1 == self.sizes[view] && at > 1)
            .then(|| [&all[index - stride], &all[index - 2 * stride]])
            .into_iter()
    }

    /// The node itself and those beside it along every axis.
    pub(crate) fn around(&self, index: usize) -> Vec<usize> {
        let position = self.position(index);
        let mut near = vec![index];
        let mut stride = 1;
        for (&at, &size) in position.iter().zip(&self.sizes) {
            if at > 0 {
                near.push(index - stride);
            }
            if at + 1 < size {
                near.push(index + stride);
            }
            stride *= size;
        }
        near
    }

    /// What lies before and behind the node along each axis. Where an axis ends in a mirror, that
    /// is the mirrored node from within.
    pub(crate) fn neighbours(
        &self,
        index: usize,
        all: &[Lobes],
        limit: &Limit,
    ) -> Vec<[Option<Lobes>; 2]> {
        let position = self.position(index);
        let mut stride = 1;
        let mut pairs = Vec::new();
        for (axis, (&at, &size)) in position.iter().zip(&self.sizes).enumerate() {
            let low = (at > 0).then(|| all[index - stride].clone());
            let high = (at + 1 < size).then(|| all[index + stride].clone());
            let low = low.or_else(|| {
                let within = high.as_ref()?.iter();
                if axis == self.brdf.view_axis() {
                    Some(within.map(|c| c.seen_from_behind(limit)).collect())
                } else if axis == 3 {
                    Some(within.map(|c| c.mirrored([1.0, -1.0])).collect())
                } else {
                    None
                }
            });
            let high = high.or_else(|| {
                let within = low.as_ref()?.iter();
                (axis == 3).then(|| within.map(|c| c.mirrored([-1.0, 1.0])).collect())
            });
            pairs.push([low, high]);
            stride *= size;
        }
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_indices_and_lines() {
        let grid = Grid::new(&Settings {
            brdf: BrdfKind::GgxAnisotropic,
            size: 6,
            ..Settings::default()
        });
        assert_eq!(grid.count(), 3 * 6 * 6 * 3);
        for index in [0, 5, 17, 100, grid.count() - 1] {
            assert_eq!(grid.index(&grid.position(index)), Some(index));
        }
        assert_eq!(grid.index(&[3, 0, 0, 0]), None);
        let stages = grid.lines_from_seed();
        let mut seen = vec![stages[0][0][0][0]];
        for lines in stages {
            for [up, down] in lines {
                // Both ways begin with a node of the stage before.
                assert!(seen.contains(&up[0]) && up[0] == down[0]);
                seen.extend(up[1..].iter().chain(&down[1..]));
            }
        }
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..grid.count()));
        assert_eq!(grid.around(0).len(), 5);
    }
}
