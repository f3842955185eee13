//! How much of each light a hit sees.

use fearless_simd::Simd;
use glam::Vec3;
use lumigon::Lanes;

use super::geometry::Geometry;
use super::hits::Hits;
use crate::scene::Scene;

/// Most lanes a processor has.
const MOST_LANES: usize = 16;

/// For each hit and light the share of the light's targets that nothing hides.
pub(super) struct Visible {
    lights: usize,
    /// Hit after hit.
    shares: Vec<f32>,
}

impl Visible {
    /// One ray for each hit and target; of each of `lights` its targets and, where it emits from one
    /// side, its normal.
    ///
    /// Targets below a hit's horizon are not asked for: what is left of their lights above it counts
    /// as seen.
    pub(super) fn trace(
        geometry: &Geometry,
        scene: &Scene,
        hits: &Hits,
        lights: &[(&[Vec3], Option<Vec3>)],
        is_cancelled: &dyn Fn() -> bool,
    ) -> Self {
        let mut shares = Vec::with_capacity(hits.lobes().len() * lights.len());
        for lobes in hits.lobes() {
            if is_cancelled() {
                shares.resize(hits.lobes().len() * lights.len(), 0.0);
                break;
            }
            let normal = lobes.normal;
            for &(targets, side) in lights {
                let (mut asked, mut seen) = (0, 0);
                for &target in targets {
                    let offset = target - lobes.position;
                    let is_behind = side.is_some_and(|side| offset.dot(side) >= 0.0);
                    if is_behind || offset.dot(normal) <= 0.0 {
                        continue;
                    }
                    asked += 1;
                    seen += i32::from(!geometry.between(scene, lobes.position, target));
                }
                shares.push(if asked > 0 {
                    seen as f32 / asked as f32
                } else {
                    1.0
                });
            }
        }
        Self {
            lights: lights.len(),
            shares,
        }
    }

    /// Of one hit.
    pub(super) fn share(&self, hit: u32, light: usize) -> f32 {
        self.shares[hit as usize * self.lights + light]
    }

    /// Of the hits of one packet; lanes without a hit see nothing.
    #[inline(always)]
    pub(super) fn lanes<S: Simd, W>(
        &self,
        simd: S,
        entries: &[(u32, W)],
        start: usize,
        light: usize,
    ) -> Lanes<S> {
        let mut shares = [0.0; MOST_LANES];
        for (share, (hit, _)) in shares.iter_mut().zip(&entries[start..]) {
            *share = self.shares[*hit as usize * self.lights + light];
        }
        Lanes::from_slice(simd, &shares)
    }
}
