//! Connected triangles in one plane.

use glam::DVec3;

use super::{
    junction::Edge,
    mapping::{Mapping, Placement, Region},
    weld::Welded,
};

/// How far a facet's triangles may tilt from its first, in radians.
const TILT: f64 = 1e-4;
/// How far its vertices may leave the plane of its first, as a fraction of its size.
const DEVIATION: f64 = 1e-5;
/// Where more triangles than this meet at one edge, facets do not grow across it: with no bound,
/// many pages on one spine would be compared each with each.
const MAX_MEETING: usize = 32;

/// Triangles of one plane, connected through their edges, all facing the same way.
pub(super) struct Facet {
    /// Indices of welded triangles.
    pub(super) triangles: Vec<u32>,
    /// A point of the plane: the area's centroid.
    pub(super) center: DVec3,
    /// The plane's unit normal: the mean over the area.
    pub(super) normal: DVec3,
    /// Diagonal of the bounding box.
    pub(super) extent: f64,
    /// Where the mesh's textures lie on it, if it has any and they lie alike on all its triangles.
    pub(super) placement: Option<Placement>,
}

/// Gathers all triangles into facets. Each grows from the largest triangle left and is measured
/// against that one's plane, so a curved mesh does not drift into one facet. With a mapping, the
/// triangles of a facet show one picture.
pub(super) fn facets(
    welded: &Welded,
    edges: &[Edge],
    noise: f64,
    mapping: Option<&Mapping<'_>>,
) -> Vec<Facet> {
    let count = welded.triangles.len();
    let area_vectors: Vec<DVec3> = (0..count as u32).map(|t| welded.area_vector(t)).collect();
    let mut seeds: Vec<u32> = (0..count as u32).collect();
    seeds.sort_by(|&a, &b| {
        let area = |t: u32| area_vectors[t as usize].length_squared();
        area(b).total_cmp(&area(a))
    });
    let neighbours = Neighbours::new(count, edges);

    let mut taken = vec![false; count];
    let mut facets = Vec::new();
    for seed in seeds {
        if std::mem::replace(&mut taken[seed as usize], true) {
            continue;
        }
        let plane = Plane::of(welded.corners(seed), noise);
        let mut bounds = Bounds::of(welded.corners(seed));
        let mut region = mapping.map(|mapping| Region::new(mapping, welded, seed));
        let mut triangles = vec![seed];
        let mut next = 0;
        while next < triangles.len() {
            for &candidate in neighbours.of(triangles[next]) {
                if taken[candidate as usize] {
                    continue;
                }
                let corners = welded.corners(candidate);
                let grown = bounds.with(corners);
                let fits = plane.holds(corners, grown.extent())
                    && region.as_mut().is_none_or(|region| region.takes(candidate));
                if fits {
                    taken[candidate as usize] = true;
                    triangles.push(candidate);
                    bounds = grown;
                }
            }
            next += 1;
        }
        facets.push(Facet::new(
            welded,
            &area_vectors,
            triangles,
            bounds.extent(),
            region.and_then(Region::placement),
        ));
    }
    facets
}

impl Facet {
    fn new(
        welded: &Welded,
        area_vectors: &[DVec3],
        triangles: Vec<u32>,
        extent: f64,
        placement: Option<Placement>,
    ) -> Self {
        let area_vector: DVec3 = triangles.iter().map(|&t| area_vectors[t as usize]).sum();
        let normal = area_vector.normalize();
        let first = welded.corners(triangles[0])[0];
        let (mut moment, mut area) = (DVec3::ZERO, 0.0);
        for &t in &triangles {
            let weight = area_vectors[t as usize].dot(normal);
            let [a, b, c] = welded.corners(t).map(|p| p - first);
            moment += (a + b + c) * (weight / 3.0);
            area += weight;
        }
        Self {
            center: first + moment / area,
            normal,
            extent,
            triangles,
            placement,
        }
    }
}

/// The plane of a facet's first triangle.
struct Plane {
    point: DVec3,
    normal: DVec3,
    noise: f64,
}

impl Plane {
    fn of([a, b, c]: [DVec3; 3], noise: f64) -> Self {
        Self {
            point: (a + b + c) / 3.0,
            normal: (b - a).cross(c - a).normalize(),
            noise,
        }
    }

    /// Whether a triangle lies in the plane and faces the same way, for a facet of that extent.
    fn holds(&self, corners: [DVec3; 3], extent: f64) -> bool {
        let reach = DEVIATION * extent + 4.0 * self.noise;
        let near = |p: DVec3| (p - self.point).dot(self.normal).abs() <= reach;
        if !corners.into_iter().all(near) {
            return false;
        }
        let [a, b, c] = corners;
        let doubled = (b - a).cross(c - a);
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        // Noise tilts a narrow triangle more than a wide one.
        let tilt = (TILT + 8.0 * self.noise * longest / doubled.length()).min(0.5);
        let normal = doubled.normalize();
        normal.dot(self.normal) > 0.0 && normal.cross(self.normal).length() <= tilt
    }
}

#[derive(Clone, Copy)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    fn of([a, b, c]: [DVec3; 3]) -> Self {
        Self {
            low: a.min(b).min(c),
            high: a.max(b).max(c),
        }
    }

    fn with(self, corners: [DVec3; 3]) -> Self {
        let other = Self::of(corners);
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn extent(self) -> f64 {
        (self.high - self.low).length()
    }
}

/// For each triangle, those that run along one of its edges the other way.
struct Neighbours {
    starts: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    fn new(count: usize, edges: &[Edge]) -> Self {
        let mut pairs: Vec<(u32, u32)> = Vec::with_capacity(edges.len());
        for run in edges.chunk_by(|a, b| a.ends() == b.ends()) {
            if run.len() > MAX_MEETING {
                continue;
            }
            for a in run {
                let opposite = run.iter().filter(|b| b.forward != a.forward);
                pairs.extend(opposite.map(|b| (a.triangle, b.triangle)));
            }
        }
        pairs.sort_unstable();
        let mut starts = vec![0; count + 1];
        for &(triangle, _) in &pairs {
            starts[triangle as usize + 1] += 1;
        }
        for i in 0..count {
            starts[i + 1] += starts[i];
        }
        let list = pairs.into_iter().map(|(_, neighbour)| neighbour).collect();
        Self { starts, list }
    }

    fn of(&self, triangle: u32) -> &[u32] {
        let t = triangle as usize;
        &self.list[self.starts[t] as usize..self.starts[t + 1] as usize]
    }
}
