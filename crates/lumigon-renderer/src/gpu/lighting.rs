//! A scene's lights on the device.

use std::collections::BTreeMap;
use std::mem::offset_of;
use std::sync::OnceLock;

use lumigon::{ImageMethod, SpecularMethod};
use lumigon_wgpu::{
    CLUSTER_LIGHTS, ClusterRecord, ImageColors, Light, LightBuffers, ReplaceImageError,
    TableFormat, Tables, clusters, light_power, order_by_place,
};

use super::device::Gpu;
use super::distance_fields::FieldCache;
use super::error::GpuError;
use super::light_set::{LightSet, PunctualRecord};
use super::parts::Part;
use super::rays::TargetList;
use crate::bounce::LightTargets;
use crate::prepared_lights::PreparedLights;
use crate::render::{RenderError, RenderSettings};
use crate::scene::{EmissivePolygon, PunctualLight, Texture};

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
    clusters: wgpu::Buffer,
    punctual: wgpu::Buffer,
    punctual_count: u32,
    fields: FieldCache,
    /// Where rays to the polygons go, made when it is asked for.
    targets: OnceLock<TargetList>,
    pub(super) warnings: Vec<String>,
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
            targets: OnceLock::new(),
            lights,
            sources,
            warnings,
        })
    }

    /// All of the lights, for a picture: with the distance fields and the levels of the conventional
    /// lookup that it needs, if any.
    pub(super) fn set(
        &self,
        gpu: &Gpu,
        settings: &RenderSettings,
    ) -> Result<LightSet<'_>, RenderError> {
        Ok(LightSet {
            bind_group: self.bind_group_for(gpu, settings)?,
            clusters: &self.clusters,
            punctual: &self.punctual,
            polygons: &self.lights,
            punctual_count: self.punctual_count,
            has_images: self.has_images(),
            with_emission: true,
            only: None,
            traced: None,
        })
    }

    /// Where rays to the polygons go.
    pub(super) fn targets(&self, gpu: &Gpu) -> Result<&TargetList, GpuError> {
        if let Some(targets) = self.targets.get() {
            return Ok(targets);
        }
        let targets = TargetList::new(gpu, &LightTargets::spread(&self.lights))?;
        Ok(self.targets.get_or_init(|| targets))
    }

    fn bind_group_for(
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

    /// Whether any light has an image.
    fn has_images(&self) -> bool {
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

    /// The polygons, sorted by place.
    pub(super) fn polygons(&self) -> &[Light] {
        &self.lights
    }

    /// One light: polygons are counted first, in the scene's order, then those without extent.
    pub(super) fn part_of(&self, light: usize) -> Part {
        let count = self.lights.len();
        let mut places: Vec<usize> = (0..count).collect();
        places.sort_by_key(|&place| self.sources[place]);
        let one = |place: usize| place as u32..place as u32 + 1;
        match places.get(light) {
            Some(&place) => Part {
                polygons: one(place),
                punctual: 0..0,
            },
            None => Part {
                polygons: 0..0,
                punctual: one(light - count),
            },
        }
    }

    /// A list of lights, polygons counted first and as they are sorted here, in the order that
    /// [`Lighting::part_of`] counts them in.
    pub(super) fn in_order_of_the_scene<T>(&self, list: Vec<(usize, T)>) -> Vec<(usize, T)> {
        let mut sorted = self.sources.clone();
        sorted.sort_unstable();
        let rank = |place: usize| match self.sources.get(place) {
            // Each source is there once.
            Some(source) => sorted.partition_point(|other| other < source),
            None => place,
        };
        let mut list: Vec<_> = list
            .into_iter()
            .map(|(place, item)| (rank(place), item))
            .collect();
        list.sort_by_key(|&(light, _)| light);
        list
    }

    /// The tables that all lights share.
    pub(super) fn tables(&self) -> &Tables {
        &self.tables
    }

    /// Replaces the polygons.
    pub(super) fn set_polygons(
        &mut self,
        gpu: &Gpu,
        polygons: &[EmissivePolygon],
        textures: &[Texture],
    ) -> Result<(), GpuError> {
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
        if bytes.len() as u64 > self.clusters.size() {
            self.clusters = gpu.storage("light clusters", &records)?;
        } else {
            queue.write_buffer(&self.clusters, 0, bytes);
        }
        self.fields = FieldCache::new(&lights);
        self.targets = OnceLock::new();
        self.lights = lights;
        self.sources = sources;
        self.replaced.clear();
        self.conventional = OnceLock::new();
        self.warnings = warnings;
        Ok(())
    }
}

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
