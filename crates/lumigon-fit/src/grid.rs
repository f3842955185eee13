use crate::{fit::Lobes, kind::BrdfKind, limit::Limit, settings::Settings};

/// The nodes of a table: where each lies, and what lies beside it.
pub(crate) struct Grid {
    brdf: BrdfKind,
    sizes: Vec<usize>,
}

impl Grid {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            brdf: settings.brdf,
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

    /// All nodes as columns along the view axis, from normal to grazing view.
    pub(crate) fn columns(&self) -> Vec<Vec<usize>> {
        let view = self.brdf.view_axis();
        let stride: usize = self.sizes[..view].iter().product();
        (0..self.count())
            .filter(|index| (index / stride).is_multiple_of(self.sizes[view]))
            .map(|first| (0..self.sizes[view]).map(|i| first + i * stride).collect())
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
    fn positions_indices_and_columns() {
        let grid = Grid::new(&Settings {
            brdf: BrdfKind::GgxAnisotropic,
            size: 6,
            ..Settings::default()
        });
        assert_eq!(grid.count(), 6 * 3 * 6 * 3);
        for index in [0, 5, 17, 100, grid.count() - 1] {
            assert_eq!(grid.index(&grid.position(index)), Some(index));
        }
        assert_eq!(grid.index(&[0, 3, 0, 0]), None);
        let columns = grid.columns();
        assert_eq!(columns.len(), 6 * 3 * 3);
        let mut seen: Vec<usize> = columns.concat();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..grid.count()));
        let second = grid.position(columns[7][1]);
        assert_eq!(second[2], 1);
        assert_eq!(grid.around(0).len(), 5);
    }
}
