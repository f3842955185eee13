//! Numbers in the order SIMD lanes want them.

use fearless_simd::Simd;
use lumigon::{Lanes, Vec3};

/// Most lanes a processor has.
const PACKET: usize = 16;

/// Lobes of one kind: `N` numbers of each, and the weights `W` of what comes of them.
pub(super) struct Batch<const N: usize, W> {
    /// Which hit each entry is of, and its weights.
    entries: Vec<(u32, W)>,
    /// The numbers of as many entries as a packet has lanes, one list a number. Lanes that no entry
    /// has taken yet repeat their packet's first.
    packets: Vec<[[f32; PACKET]; N]>,
}

impl<const N: usize, W> Default for Batch<N, W> {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            packets: Vec::new(),
        }
    }
}

impl<const N: usize, W: Copy> Batch<N, W> {
    pub(super) fn push(&mut self, hit: u32, weights: W, numbers: [f32; N]) {
        let lane = self.entries.len() % PACKET;
        self.entries.push((hit, weights));
        match self.packets.last_mut() {
            Some(packet) if lane > 0 => {
                for (list, number) in packet.iter_mut().zip(numbers) {
                    list[lane] = number;
                }
            }
            _ => self.packets.push(numbers.map(|number| [number; PACKET])),
        }
    }

    /// Keeps the memory for what comes next.
    pub(super) fn clear(&mut self) {
        self.entries.clear();
        self.packets.clear();
    }

    pub(super) fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    pub(super) fn entries(&self) -> &[(u32, W)] {
        &self.entries
    }

    /// Those of one entry.
    pub(super) fn numbers(&self, entry: usize) -> [f32; N] {
        let packet = &self.packets[entry / PACKET];
        std::array::from_fn(|list| packet[list][entry % PACKET])
    }

    /// Sums over lights for each entry, by channel, all dark. With room for whole packets.
    pub(super) fn dark(&self) -> [Vec<f32>; 3] {
        let length = self.packets.len() * PACKET;
        std::array::from_fn(|_| vec![0.0; length])
    }

    /// Calls `each` with the first index of every packet.
    #[inline(always)]
    pub(super) fn for_each_packet<S: Simd>(&self, mut each: impl FnMut(usize)) {
        let mut start = 0;
        while start < self.entries.len() {
            each(start);
            start += Lanes::<S>::COUNT;
        }
    }

    #[inline(always)]
    pub(super) fn lanes<S: Simd>(&self, simd: S, list: usize, start: usize) -> Lanes<S> {
        Lanes::from_slice(simd, &self.packets[start / PACKET][list][start % PACKET..])
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
