//! A scene's lights on the device.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use lumigon_wgpu::{
    CLUSTER_LIGHTS, ClusterRecord, Light, LightBuffers, TableFormat, Tables, clusters,
    sort_by_place,
};

use super::device::Gpu;
use super::error::GpuError;
use crate::prepared_lights::PreparedLights;
use crate::scene::{EmissivePolygon, PunctualKind, PunctualLight, Texture};

/// Polygon lights with their tables, and lights without extent.
pub(super) struct Lighting {
    polygons: LightBuffers,
    tables: Tables,
    layout: wgpu::BindGroupLayout,
    pub(super) bind_group: wgpu::BindGroup,
    /// Of [`ClusterRecord`]s.
    pub(super) clusters: wgpu::Buffer,
    pub(super) punctual: wgpu::Buffer,
    pub(super) punctual_count: u32,
    /// For each polygon, one past its last vertex record.
    record_ends: Vec<u32>,
    pub(super) warnings: Vec<String>,
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

impl Lighting {
    pub(super) fn new(
        gpu: &Gpu,
        polygons: &[EmissivePolygon],
        textures: &[Texture],
        punctual: &[PunctualLight],
    ) -> Result<Self, GpuError> {
        let (device, queue) = (gpu.device(), gpu.queue());
        let (lights, warnings) = prepared(polygons, textures);
        let buffers = LightBuffers::new(device, queue, &lights)?;
        let tables = Tables::new(device, queue, TableFormat::F32);
        let layout = lumigon_wgpu::bind_group_layout(device, wgpu::ShaderStages::COMPUTE);
        let records: Vec<_> = punctual.iter().map(PunctualRecord::from).collect();
        Ok(Self {
            bind_group: lumigon_wgpu::bind_group(device, &layout, &buffers, &tables),
            polygons: buffers,
            tables,
            layout,
            clusters: gpu.storage("light clusters", &clusters(&lights))?,
            punctual: gpu.storage("lights without extent", &records)?,
            punctual_count: records.len() as u32,
            record_ends: record_ends(&lights),
            warnings,
        })
    }

    /// Edges of all polygons, and as many again as they have loops.
    pub(super) fn edges(&self) -> u64 {
        self.record_ends.last().copied().unwrap_or(0).into()
    }

    /// Ranges of lights whose loops over edges, `walks` a light, end after `most_rounds` together.
    pub(super) fn parts(&self, walks: u64, most_rounds: u64) -> Vec<Range<u32>> {
        parts(&self.record_ends, walks, most_rounds)
    }

    pub(super) fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Replaces the polygons. Returns whether bind groups of the clusters have to be made anew.
    pub(super) fn set_polygons(
        &mut self,
        gpu: &Gpu,
        polygons: &[EmissivePolygon],
        textures: &[Texture],
    ) -> Result<bool, GpuError> {
        let (device, queue) = (gpu.device(), gpu.queue());
        let (lights, warnings) = prepared(polygons, textures);
        let records: Vec<ClusterRecord> = clusters(&lights);
        let bytes: &[u8] = bytemuck::cast_slice(&records);
        if self.polygons.write(device, queue, &lights)? {
            self.bind_group =
                lumigon_wgpu::bind_group(device, &self.layout, &self.polygons, &self.tables);
        }
        let grows = bytes.len() as u64 > self.clusters.size();
        if grows {
            self.clusters = gpu.storage("light clusters", &records)?;
        } else {
            queue.write_buffer(&self.clusters, 0, bytes);
        }
        self.record_ends = record_ends(&lights);
        self.warnings = warnings;
        Ok(grows)
    }
}

/// The lights that can be evaluated, neighbours in clusters, and why the others light nothing.
fn prepared(lights: &[EmissivePolygon], textures: &[Texture]) -> (Vec<Light>, Vec<String>) {
    let PreparedLights {
        mut lights,
        warnings,
        ..
    } = PreparedLights::new(lights, textures);
    sort_by_place(&mut lights);
    (lights, warnings)
}

/// Whole clusters, at least one a part; one empty part where there is no light.
fn parts(record_ends: &[u32], walks: u64, most_rounds: u64) -> Vec<Range<u32>> {
    let mut parts = vec![Range::default()];
    let (mut rounds, mut start) = (0_u64, 0);
    for cluster in record_ends.chunks(CLUSTER_LIGHTS) {
        let end = cluster[cluster.len() - 1];
        // A round for each record and walk, one to begin each walk, and two to find the light.
        let own = u64::from(end - start) * walks + cluster.len() as u64 * (walks + 2);
        start = end;
        let last = parts.len() - 1;
        let place = parts[last].end;
        if rounds > 0 && rounds.saturating_add(own) > most_rounds {
            parts.push(place..place);
            rounds = 0;
        }
        rounds += own;
        let last = parts.len() - 1;
        parts[last].end += cluster.len() as u32;
    }
    parts
}

/// One past the last vertex record of each.
fn record_ends(lights: &[Light]) -> Vec<u32> {
    let mut end = 0;
    let mut next = |light: &Light| {
        end += (light.polygon.vertex_count() + light.polygon.loop_count()) as u32;
        end
    };
    lights.iter().map(&mut next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_all_lights_in_clusters() {
        // Quads, and among them a polygon of 1,000 vertices.
        let ends: Vec<u32> = (0..10_000)
            .map(|i| 5 * (i + 1) + if i < 77 { 0 } else { 1000 })
            .collect();
        for most in [1, 1_000, 60_000, u64::MAX] {
            let parts = parts(&ends, 2, most);
            assert_eq!((parts[0].start, parts[parts.len() - 1].end), (0, 10_000));
            for pair in parts.windows(2) {
                assert_eq!(pair[0].end, pair[1].start);
                assert!(pair[1].start % CLUSTER_LIGHTS as u32 == 0);
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
        assert_eq!(parts(&[], 2, 60_000), vec![Range::default()]);
    }
}
