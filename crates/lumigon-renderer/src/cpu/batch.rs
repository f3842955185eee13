//! Numbers in the order SIMD lanes want them.

use fearless_simd::Simd;
use lumigon::{Lanes, Vec3};

/// Most lanes a processor has: lists are padded to a multiple, so that the last packet is full.
const PADDING: usize = 16;

/// `N` numbers of each of some hits: one list a number.
pub(super) struct Batch<const N: usize> {
    /// Which hit each entry is of.
    hits: Vec<u32>,
    lists: [Vec<f32>; N],
}

impl<const N: usize> Default for Batch<N> {
    fn default() -> Self {
        Self {
            hits: Vec::new(),
            lists: std::array::from_fn(|_| Vec::new()),
        }
    }
}

impl<const N: usize> Batch<N> {
    pub(super) fn push(&mut self, hit: u32, numbers: [f32; N]) {
        self.hits.push(hit);
        for (list, number) in self.lists.iter_mut().zip(numbers) {
            list.push(number);
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.hits.is_empty()
    }

    pub(super) fn hits(&self) -> &[u32] {
        &self.hits
    }

    /// Fills the last packet with repetitions of the last entry.
    pub(super) fn pad(&mut self) {
        let length = self.hits.len().next_multiple_of(PADDING);
        for list in &mut self.lists {
            if let Some(&last) = list.last() {
                list.resize(length, last);
            }
        }
    }

    /// Sums over lights for each entry, by channel, all dark. With room for whole packets.
    pub(super) fn dark(&self) -> [Vec<f32>; 3] {
        let length = self.hits.len().next_multiple_of(PADDING);
        std::array::from_fn(|_| vec![0.0; length])
    }

    /// Calls `each` with the first index of every packet.
    #[inline(always)]
    pub(super) fn for_each_packet<S: Simd>(&self, mut each: impl FnMut(usize)) {
        let mut start = 0;
        while start < self.hits.len() {
            each(start);
            start += Lanes::<S>::COUNT;
        }
    }

    #[inline(always)]
    pub(super) fn lanes<S: Simd>(&self, simd: S, list: usize, start: usize) -> Lanes<S> {
        Lanes::from_slice(simd, &self.lists[list][start..])
    }

    /// A vector whose coordinates are this list and the next two.
    #[inline(always)]
    pub(super) fn vectors<S: Simd>(&self, simd: S, list: usize, start: usize) -> Vec3<Lanes<S>> {
        Vec3::new(
            self.lanes(simd, list, start),
            self.lanes(simd, list + 1, start),
            self.lanes(simd, list + 2, start),
        )
    }
}
