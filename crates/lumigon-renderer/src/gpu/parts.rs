//! Lights in parts that one dispatch each adds.

use std::ops::Range;

use lumigon_wgpu::{CLUSTER_LIGHTS, Light};

/// Some of the lights of a [`LightSet`](super::light_set::LightSet).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Part {
    /// Polygons; they start with a cluster where lights that add little are left out.
    pub(super) polygons: Range<u32>,
    /// Lights without extent.
    pub(super) punctual: Range<u32>,
}

/// What a pixel does with a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// How often it goes through the light's edges.
    pub(super) walks: u64,
    /// How often it averages the light's image,
    pub(super) means: u64,
    /// by so many taps along either axis.
    pub(super) taps: u32,
    /// Rays to a polygon.
    pub(super) rays: u64,
    /// Rounds of each of these, and of the one to a light without extent; 0 without rays.
    pub(super) rounds_a_ray: u64,
    /// Whether lights that add little are left out.
    pub(super) culls_lights: bool,
}

/// Edges that one tap of an image costs as much as, about.
const EDGES_A_TAP: u64 = 4;

/// The same for a light without extent.
pub(super) const EDGES_A_POINT: u64 = 2;

/// Edges of all polygons, as many again as they have loops, and what `taps` by `taps` taps of
/// images cost, in edges.
pub(super) fn edges(polygons: &[Light], taps: u32) -> u64 {
    let taps = u64::from(taps.max(1)).pow(2);
    let edges =
        |light: &Light| records(light) + u64::from(light.image.is_some()) * taps * EDGES_A_TAP;
    polygons.iter().map(edges).sum()
}

/// All of the lights; the loops of each part end after `most_rounds` together, as far as whole
/// clusters allow. Traced lights that are not culled need not be whole clusters.
pub(super) fn parts(
    polygons: &[Light],
    punctual: u32,
    effort: Effort,
    most_rounds: u64,
) -> Vec<Part> {
    let Effort {
        walks,
        means,
        rays,
        rounds_a_ray,
        ..
    } = effort;
    let taps = u64::from(effort.taps);
    let is_traced = rounds_a_ray > 0;
    let of_rays = if is_traced {
        // One to find the light.
        1 + rays * (1 + rounds_a_ray)
    } else {
        0
    };
    let rounds: Vec<u64> = polygons
        .iter()
        .map(|light| {
            // A round for each record and walk, one to begin each walk, and two to find the light.
            let plain = records(light) * walks + walks + 2;
            // The light vector or the projection's axis once more, rows and taps.
            let of_image = records(light) * walks + means * (taps * taps + 2 * taps + 2);
            plain + of_rays + if light.image.is_some() { of_image } else { 0 }
        })
        .collect();
    let neighbours = if is_traced && !effort.culls_lights {
        1
    } else {
        CLUSTER_LIGHTS
    };
    parts_of(&rounds, neighbours, punctual, 1 + rounds_a_ray, most_rounds)
}

/// Vertex records of a light.
fn records(light: &Light) -> u64 {
    (light.polygon.vertex_count() + light.polygon.loop_count()) as u64
}

/// `rounds` are those of each polygon. Lights without extent come first, `rounds_a_point` each, then
/// polygons, so many `neighbours` always together; one empty part where there is no light.
fn parts_of(
    rounds: &[u64],
    neighbours: usize,
    punctual: u32,
    rounds_a_point: u64,
    most_rounds: u64,
) -> Vec<Part> {
    let at_once = u32::try_from(most_rounds / rounds_a_point).unwrap_or(u32::MAX);
    let at_once = at_once.max(1);
    let mut parts: Vec<_> = (0..punctual)
        .step_by(at_once as usize)
        .map(|start| Part {
            polygons: 0..0,
            punctual: start..punctual.min(start.saturating_add(at_once)),
        })
        .collect();
    let mut part = parts.pop().unwrap_or_default();
    let mut sum = part.punctual.len() as u64 * rounds_a_point;
    for cluster in rounds.chunks(neighbours) {
        let own: u64 = cluster.iter().sum();
        if sum > 0 && sum.saturating_add(own) > most_rounds {
            let place = part.polygons.end;
            let next = Part {
                polygons: place..place,
                punctual: punctual..punctual,
            };
            parts.push(std::mem::replace(&mut part, next));
            sum = 0;
        }
        sum += own;
        part.polygons.end += cluster.len() as u32;
    }
    parts.push(part);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_all_lights_in_clusters() {
        // Quads walked twice, and among them a polygon of 1,000 vertices.
        let mut rounds = vec![14; 10_000];
        rounds[77] += 2_000;
        for most in [1, 1_000, 60_000, u64::MAX] {
            let parts = parts_of(&rounds, CLUSTER_LIGHTS, 0, 1, most);
            let last = parts.len() - 1;
            assert_eq!(
                (parts[0].polygons.start, parts[last].polygons.end),
                (0, 10_000)
            );
            for pair in parts.windows(2) {
                assert_eq!(pair[0].polygons.end, pair[1].polygons.start);
                assert!(pair[1].polygons.start % CLUSTER_LIGHTS as u32 == 0);
            }
            if most == u64::MAX {
                assert_eq!(parts.len(), 1);
            } else {
                let least = 10_000_u64 * 14 / most.max(32 * 14);
                assert!(
                    (least..=2 * least + 2).contains(&(parts.len() as u64)),
                    "{}",
                    parts.len()
                );
            }
        }
        assert_eq!(
            parts_of(&[], CLUSTER_LIGHTS, 0, 1, 60_000),
            vec![Part::default()]
        );
    }

    #[test]
    fn lights_without_extent_have_parts_of_their_own() {
        let part = |polygons, punctual| Part { polygons, punctual };
        assert_eq!(
            parts_of(&[9], CLUSTER_LIGHTS, 3, 1, 100),
            [part(0..1, 0..3)]
        );
        assert_eq!(
            parts_of(&[9; 40], CLUSTER_LIGHTS, 250, 1, 100),
            [
                part(0..0, 0..100),
                part(0..0, 100..200),
                part(0..0, 200..250),
                part(0..32, 250..250),
                part(32..40, 250..250)
            ]
        );
        assert_eq!(
            parts_of(&[], CLUSTER_LIGHTS, 200, 1, 100),
            [part(0..0, 0..100), part(0..0, 100..200)]
        );
        assert_eq!(
            parts_of(&[], CLUSTER_LIGHTS, u32::MAX, 1, u64::MAX).len(),
            1
        );
    }

    #[test]
    fn rays_leave_fewer_lights_to_a_part() {
        let part = |polygons, punctual| Part { polygons, punctual };
        assert_eq!(
            parts_of(&[90, 20, 50, 40], 1, 3, 50, 100),
            [
                part(0..0, 0..2),
                part(0..0, 2..3),
                part(0..1, 3..3),
                part(1..3, 3..3),
                part(3..4, 3..3)
            ]
        );
        assert_eq!(
            parts_of(&[90, 20], 1, 2, 1000, 100),
            [
                part(0..0, 0..1),
                part(0..0, 1..2),
                part(0..1, 2..2),
                part(1..2, 2..2)
            ]
        );
    }
}
