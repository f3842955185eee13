//! A scene's lights on the device.

use std::collections::BTreeMap;
use std::mem::offset_of;
use std::ops::Range;
use std::sync::OnceLock;

use bytemuck::{Pod, Zeroable};
use lumigon::{ImageMethod, SpecularMethod};
use lumigon_wgpu::{
    CLUSTER_LIGHTS, ClusterRecord, ImageColors, Light, LightBuffers, ReplaceImageError,
    TableFormat, Tables, clusters, light_power, order_by_place,
};

use super::device::Gpu;
use super::distance_fields::FieldCache;
use super::error::GpuError;
use crate::prepared_lights::PreparedLights;
use crate::render::{RenderError, RenderSettings};
use crate::scene::{EmissivePolygon, PunctualKind, PunctualLight, Texture};

/// Polygon lights with their tables, and lights without extent.
pub(super) struct Lighting {
    polygons: LightBuffers,
    tables: Tables,
    layout: wgpu::BindGroupLayout,
    bind_group: wgpu::BindGroup,
    lights: Vec<Light>,
    /// Their indices in the scene.
    sources: Vec<usize>,
    /// Colours that images were replaced with, which `lights` does not know.
    replaced: BTreeMap<usize, Replaced>,
    /// The same lights with the levels of the conventional lookup, made when it is asked for.
    conventional: OnceLock<LightBuffers>,
    /// Of [`ClusterRecord`]s.
    pub(super) clusters: wgpu::Buffer,
    pub(super) punctual: wgpu::Buffer,
    pub(super) punctual_count: u32,
    fields: FieldCache,
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
        let PreparedLights {
            lights,
            sources,
            warnings,
        } = prepared(polygons, textures);
        let buffers = LightBuffers::new(device, queue, &lights)?;
        let tables = Tables::new(device, queue, TableFormat::F32);
        let layout = lumigon_wgpu::bind_group_layout(device, wgpu::ShaderStages::COMPUTE);
        let records: Vec<_> = punctual.iter().map(PunctualRecord::from).collect();
        Ok(Self {
            bind_group: lumigon_wgpu::bind_group(device, &layout, &buffers, &tables),
            polygons: buffers,
            replaced: BTreeMap::new(),
            conventional: OnceLock::new(),
            tables,
            layout,
            clusters: gpu.storage("light clusters", &clusters(&lights))?,
            punctual: gpu.storage("lights without extent", &records)?,
            punctual_count: records.len() as u32,
            fields: FieldCache::new(&lights),
            lights,
            sources,
            warnings,
        })
    }

    /// The bind group for a picture: with the distance fields and the levels of the conventional lookup
    /// that it needs, if any.
    pub(super) fn bind_group_for(
        &self,
        gpu: &Gpu,
        settings: &RenderSettings,
    ) -> Result<wgpu::BindGroup, RenderError> {
        let is_conventional = self.has_images() && settings.image_method == ImageMethod::Lookup;
        let lights = if is_conventional {
            gpu.guarded("light images", || self.conventional(gpu))?
        } else {
            &self.polygons
        };
        let (device, layout, tables) = (gpu.device(), &self.layout, &self.tables);
        let SpecularMethod::ReflectedDistanceField { field, .. } = settings.specular else {
            return Ok(if is_conventional {
                lumigon_wgpu::bind_group(device, layout, lights, tables)
            } else {
                self.bind_group.clone()
            });
        };
        let budget = settings.distance_field_budget;
        self.fields
            .get(gpu, &self.polygons, field, budget, |fields| {
                lumigon_wgpu::bind_group_with_fields(device, layout, lights, tables, fields)
            })
    }

    /// Edges of all polygons, as many again as they have loops, and what `taps` by `taps` taps of
    /// images cost, in edges.
    pub(super) fn edges(&self, taps: u32) -> u64 {
        let taps = u64::from(taps.max(1)).pow(2);
        let edges =
            |light: &Light| records(light) + u64::from(light.image.is_some()) * taps * EDGES_A_TAP;
        self.lights.iter().map(edges).sum()
    }

    /// Ranges of lights whose loops end after `most_rounds` together: `walks` over the edges of a
    /// light, and `means` of its image by `taps` by `taps` taps.
    pub(super) fn parts(
        &self,
        walks: u64,
        means: u64,
        taps: u32,
        most_rounds: u64,
    ) -> Vec<Range<u32>> {
        let taps = u64::from(taps);
        let rounds: Vec<u64> = self
            .lights
            .iter()
            .map(|light| {
                // A round for each record and walk, one to begin each walk, and two to find the light.
                let plain = records(light) * walks + walks + 2;
                // The light vector or the projection's axis once more, rows and taps.
                let of_image = records(light) * walks + means * (taps * taps + 2 * taps + 2);
                plain + if light.image.is_some() { of_image } else { 0 }
            })
            .collect();
        parts(&rounds, most_rounds)
    }

    /// Whether any light has an image.
    pub(super) fn has_images(&self) -> bool {
        !self.polygons.images().is_empty()
    }

    /// The lights with the levels of the conventional lookup.
    fn conventional(&self, gpu: &Gpu) -> Result<&LightBuffers, GpuError> {
        if let Some(buffers) = self.conventional.get() {
            return Ok(buffers);
        }
        let mut lights = self.lights.clone();
        for (i, light) in lights.iter_mut().enumerate() {
            if let Some(image) = &mut light.image {
                if let Some(colors) = self.replaced.get(&i) {
                    // They were good when they were replaced.
                    _ = image.replace(&colors.borrowed().to_linear());
                }
                image.filter_gaussian_levels();
            }
        }
        let buffers = LightBuffers::new(gpu.device(), gpu.queue(), &lights)?;
        Ok(self.conventional.get_or_init(|| buffers))
    }

    /// Shows other colours on light `light` of the scene.
    pub(super) fn replace_image(
        &mut self,
        gpu: &Gpu,
        light: usize,
        colors: ImageColors<'_>,
    ) -> Result<(), ReplaceImageError> {
        let place = self.sources.iter().position(|&source| source == light);
        let place = place.ok_or(ReplaceImageError::NoImage { light })?;
        let replaced = self
            .polygons
            .replace_image(gpu.device(), gpu.queue(), place, colors);
        replaced.map_err(|fault| match fault {
            ReplaceImageError::NoImage { .. } => ReplaceImageError::NoImage { light },
            other => other,
        })?;
        self.replaced.entry(place).or_default().store(colors);
        self.conventional = OnceLock::new();
        // What the cluster may add at most.
        let cluster = place / CLUSTER_LIGHTS;
        let first = cluster * CLUSTER_LIGHTS;
        let lights = self.lights.iter().enumerate();
        let power = lights
            .skip(first)
            .take(CLUSTER_LIGHTS)
            .map(|(i, light)| {
                let record = self.polygons.images().record(i);
                light_power(light, record.map_or([1.0; 3], |record| record.greatest))
            })
            .fold(0.0, f32::max)
            * 1.00001;
        let at = cluster * size_of::<ClusterRecord>() + offset_of!(ClusterRecord, power);
        gpu.queue()
            .write_buffer(&self.clusters, at as u64, bytemuck::bytes_of(&power));
        Ok(())
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
        let PreparedLights {
            lights,
            sources,
            warnings,
        } = prepared(polygons, textures);
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
        self.fields = FieldCache::new(&lights);
        self.lights = lights;
        self.sources = sources;
        self.replaced.clear();
        self.conventional = OnceLock::new();
        self.warnings = warnings;
        Ok(grows)
    }
}

/// Edges that one tap of an image costs as much as, about.
const EDGES_A_TAP: u64 = 4;

/// Colours of an image, kept.
enum Replaced {
    Srgb(Vec<[u8; 4]>),
    Linear(Vec<[f32; 3]>),
}

impl Default for Replaced {
    fn default() -> Self {
        Self::Srgb(Vec::new())
    }
}

impl Replaced {
    /// Keeps other ones; in the same memory, where they are of the same kind.
    fn store(&mut self, colors: ImageColors<'_>) {
        match (&mut *self, colors) {
            (Self::Srgb(kept), ImageColors::Srgb(colors)) => {
                kept.clear();
                kept.extend_from_slice(colors);
            }
            (Self::Linear(kept), ImageColors::Linear(colors)) => {
                kept.clear();
                kept.extend_from_slice(colors);
            }
            (_, ImageColors::Srgb(colors)) => *self = Self::Srgb(colors.to_vec()),
            (_, ImageColors::Linear(colors)) => *self = Self::Linear(colors.to_vec()),
        }
    }

    fn borrowed(&self) -> ImageColors<'_> {
        match self {
            Self::Srgb(colors) => ImageColors::Srgb(colors),
            Self::Linear(colors) => ImageColors::Linear(colors),
        }
    }
}

/// The lights that can be evaluated, neighbours in clusters, and why the others light nothing.
fn prepared(lights: &[EmissivePolygon], textures: &[Texture]) -> PreparedLights {
    let PreparedLights {
        lights,
        sources,
        warnings,
    } = PreparedLights::new(lights, textures);
    let order = order_by_place(&lights);
    let mut left: Vec<_> = lights.into_iter().zip(sources).map(Some).collect();
    let (lights, sources) = order.iter().filter_map(|&i| left[i].take()).unzip();
    PreparedLights {
        lights,
        sources,
        warnings,
    }
}

/// Vertex records of a light.
fn records(light: &Light) -> u64 {
    (light.polygon.vertex_count() + light.polygon.loop_count()) as u64
}

/// Whole clusters, at least one a part; one empty part where there is no light. `rounds` are those of
/// each light.
fn parts(rounds: &[u64], most_rounds: u64) -> Vec<Range<u32>> {
    let mut parts = vec![Range::default()];
    let mut sum = 0_u64;
    for cluster in rounds.chunks(CLUSTER_LIGHTS) {
        let own: u64 = cluster.iter().sum();
        let last = parts.len() - 1;
        let place = parts[last].end;
        if sum > 0 && sum.saturating_add(own) > most_rounds {
            parts.push(place..place);
            sum = 0;
        }
        sum += own;
        let last = parts.len() - 1;
        parts[last].end += cluster.len() as u32;
    }
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
            let parts = parts(&rounds, most);
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
        assert_eq!(parts(&[], 60_000), vec![Range::default()]);
    }
}
