//! Lights that are added to the same sums, as dispatches take them.

use bytemuck::{Pod, Zeroable};
use lumigon_wgpu::{Light, LightBuffers, Tables, clusters, order_by_place};

use super::device::Gpu;
use super::error::GpuError;
use super::parts::{EDGES_A_POINT, Effort, Part, edges, parts};
use super::rays::{Rays, TargetList, TracedLights};
use super::shading::MOST_PARTS;
use crate::bounce::{LightTargets, VirtualLights, VirtualPoint};
use crate::scene::{PunctualKind, PunctualLight};

/// Some lights: the scene's, or virtual ones.
pub(super) struct LightSet<'a> {
    /// Of [`LightBuffers`] with their tables and images.
    pub(super) bind_group: wgpu::BindGroup,
    /// Of [`ClusterRecord`](lumigon_wgpu::ClusterRecord)s.
    pub(super) clusters: &'a wgpu::Buffer,
    /// Of [`PunctualRecord`]s.
    pub(super) punctual: &'a wgpu::Buffer,
    /// Neighbours in clusters.
    pub(super) polygons: &'a [Light],
    pub(super) punctual_count: u32,
    pub(super) has_images: bool,
    /// Whether what surfaces emit is added with them.
    pub(super) with_emission: bool,
    /// These of them alone, if any.
    pub(super) only: Option<Part>,
    /// Where surfaces block them.
    pub(super) traced: Option<TracedLights<'a>>,
}

impl LightSet<'_> {
    /// In parts whose loops end after `most_rounds` together, or after more, where these were more
    /// than [`MOST_PARTS`].
    pub(super) fn parts(&self, mut effort: Effort, mut most_rounds: u64) -> Vec<Part> {
        if let Some(only) = &self.only {
            return vec![only.clone()];
        }
        if let Some(TracedLights { rays, targets }) = self.traced {
            effort.rounds_a_ray = rays.rounds_a_ray();
            effort.rays = u64::from(targets.per_light);
        }
        loop {
            let parts = parts(self.polygons, self.punctual_count, effort, most_rounds);
            if parts.len() <= MOST_PARTS {
                return parts;
            }
            most_rounds = most_rounds.saturating_mul(2);
        }
    }

    /// Edges that a pixel goes through, about: of the polygons at most so many.
    pub(super) fn edges(&self, taps: u32, most_of_polygons: u64) -> u64 {
        let (polygons, punctual) = match &self.only {
            None => (self.polygons, self.punctual_count),
            Some(Part { polygons, punctual }) => {
                let range = polygons.start as usize..polygons.end as usize;
                let polygons = self.polygons.get(range).unwrap_or_default();
                (polygons, punctual.len() as u32)
            }
        };
        let of_polygons = edges(polygons, taps);
        let counting = of_polygons.min(most_of_polygons);
        let all = counting + u64::from(punctual) * EDGES_A_POINT;
        let Some(TracedLights { rays, targets }) = self.traced else {
            return all;
        };
        let to_polygons = polygons.len() as u64 * u64::from(targets.per_light);
        // As many of them as of the edges.
        let to_counting =
            u128::from(to_polygons) * u128::from(counting) / u128::from(of_polygons.max(1));
        all + (to_counting as u64 + u64::from(punctual)) * rays.edges_a_ray()
    }
}

/// `PunctualLight` of `punctual.wesl`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct PunctualRecord {
    pub(super) position: [f32; 3],
    pub(super) kind: u32,
    pub(super) direction: [f32; 3],
    pub(super) range: f32,
    pub(super) color: [f32; 3],
    pub(super) outer_cosine: f32,
    pub(super) cone_scale: f32,
    pub(super) padding: [u32; 3],
}

/// The shaders' kind of a virtual point.
const VIRTUAL: u32 = 3;

impl From<&PunctualLight> for PunctualRecord {
    fn from(light: &PunctualLight) -> Self {
        let (kind, outer_cosine, cone_scale) = match light.kind {
            PunctualKind::Directional => (0, 0.0, 0.0),
            PunctualKind::Point => (1, 0.0, 0.0),
            PunctualKind::Spot {
                inner_cone_angle,
                outer_cone_angle,
            } => {
                let (inner, outer) = (inner_cone_angle.cos(), outer_cone_angle.cos());
                (2, outer, 1.0 / (inner - outer).max(0.001))
            }
        };
        Self {
            position: light.position.into(),
            kind,
            direction: light.direction.into(),
            // 0 stands for none. Its square must not vanish.
            range: light.range.map_or(0.0, |range| range.max(1e-18)),
            color: light.color.into(),
            outer_cosine,
            cone_scale,
            padding: [0; 3],
        }
    }
}

impl From<&VirtualPoint> for PunctualRecord {
    fn from(point: &VirtualPoint) -> Self {
        Self {
            position: point.position.into(),
            kind: VIRTUAL,
            direction: point.normal.into(),
            range: point.least_distance,
            color: point.intensity.into(),
            outer_cosine: 0.0,
            cone_scale: 0.0,
            padding: [0; 3],
        }
    }
}

/// Virtual lights on the device, kept while pictures are lit by the same ones.
pub(super) struct VirtualLighting {
    bind_group: wgpu::BindGroup,
    clusters: wgpu::Buffer,
    punctual: wgpu::Buffer,
    /// Sorted by place.
    polygons: Vec<Light>,
    /// Of each of them the place among those that were given.
    order: Vec<usize>,
    points: Vec<VirtualPoint>,
    /// Where rays to them go, as it was given, and sorted like them.
    targets: Option<(LightTargets, TargetList)>,
}

impl VirtualLighting {
    /// `layout` is that of the lights' bind group.
    pub(super) fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        tables: &Tables,
        lights: &VirtualLights,
    ) -> Result<Self, GpuError> {
        let (device, queue) = (gpu.device(), gpu.queue());
        let order = order_by_place(&lights.polygons);
        let polygons: Vec<_> = order.iter().map(|&i| lights.polygons[i].clone()).collect();
        let buffers = LightBuffers::new(device, queue, &polygons)?;
        let records: Vec<_> = lights.points.iter().map(PunctualRecord::from).collect();
        let sorted = |targets: &LightTargets| {
            let of = |&light: &usize| {
                let start = light * targets.per_light;
                targets.points[start..start + targets.per_light].iter()
            };
            let sorted = LightTargets {
                per_light: targets.per_light,
                // Points are their own.
                points: order.iter().flat_map(of).copied().collect(),
            };
            Ok::<_, GpuError>((targets.clone(), TargetList::new(gpu, &sorted)?))
        };
        let targets = lights.targets.as_ref().map(sorted).transpose()?;
        Ok(Self {
            bind_group: lumigon_wgpu::bind_group(device, layout, &buffers, tables),
            clusters: gpu.storage("clusters of virtual lights", &clusters(&polygons))?,
            punctual: gpu.storage("virtual points", &records)?,
            polygons,
            order,
            points: lights.points.clone(),
            targets,
        })
    }

    /// Whether they are these: compared light by light, which costs far less than they do in a
    /// picture, and holds whoever made or copied them.
    pub(super) fn is(&self, lights: &VirtualLights) -> bool {
        let kept = self.order.iter().zip(&self.polygons);
        self.polygons.len() == lights.polygons.len()
            && self.points == lights.points
            && self.targets.as_ref().map(|(given, _)| given) == lights.targets.as_ref()
            && kept
                .into_iter()
                .all(|(&i, kept)| lights.polygons[i] == *kept)
    }

    /// Whether surfaces block them.
    pub(super) fn is_traced(&self) -> bool {
        self.targets.is_some()
    }

    /// With rays where surfaces block them.
    pub(super) fn set<'a>(&'a self, rays: Option<&'a Rays>) -> LightSet<'a> {
        LightSet {
            bind_group: self.bind_group.clone(),
            clusters: &self.clusters,
            punctual: &self.punctual,
            polygons: &self.polygons,
            punctual_count: self.points.len() as u32,
            has_images: false,
            with_emission: false,
            only: None,
            traced: rays.and_then(|rays| {
                let (_, targets) = self.targets.as_ref()?;
                Some(TracedLights { rays, targets })
            }),
        }
    }
}
