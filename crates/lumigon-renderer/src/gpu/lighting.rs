//! A scene's lights on the device.

use bytemuck::{Pod, Zeroable};
use lumigon_wgpu::{
    ClusterRecord, Light, LightBuffers, TableFormat, Tables, clusters, sort_by_place,
};

use super::device::Gpu;
use super::error::GpuError;
use crate::scene::{EmissivePolygon, PunctualKind, PunctualLight};
use crate::shading_light::prepared_lights;

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
    /// Edges of all polygons.
    pub(super) edges: u64,
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
        punctual: &[PunctualLight],
    ) -> Result<Self, GpuError> {
        let (device, queue) = (gpu.device(), gpu.queue());
        let (lights, warnings) = prepared(polygons);
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
            edges: edges(&lights),
            warnings,
        })
    }

    pub(super) fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Replaces the polygons. Returns whether bind groups of the clusters have to be made anew.
    pub(super) fn set_polygons(
        &mut self,
        gpu: &Gpu,
        polygons: &[EmissivePolygon],
    ) -> Result<bool, GpuError> {
        let (device, queue) = (gpu.device(), gpu.queue());
        let (lights, warnings) = prepared(polygons);
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
        self.edges = edges(&lights);
        self.warnings = warnings;
        Ok(grows)
    }
}

/// The lights that can be evaluated, neighbours in clusters, and why the others light nothing.
fn prepared(lights: &[EmissivePolygon]) -> (Vec<Light>, Vec<String>) {
    let (lights, warnings) = prepared_lights(lights);
    let mut lights: Vec<_> = lights
        .into_iter()
        .map(|light| Light {
            polygon: light.polygon,
            radiance: light.radiance,
        })
        .collect();
    sort_by_place(&mut lights);
    (lights, warnings)
}

fn edges(lights: &[Light]) -> u64 {
    let edges = |light: &Light| light.polygon.vertex_count() as u64;
    lights.iter().map(edges).sum()
}
