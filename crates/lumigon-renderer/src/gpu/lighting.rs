//! A scene's lights on the device.

use std::collections::{BTreeMap, HashMap};
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
use super::storage::{Records, StagedRecords};
use super::texels::is_same_texture;
use crate::bounce::LightTargets;
use crate::prepared_lights::{Prepared, PreparedLights};
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
    clusters: Records<ClusterRecord>,
    punctual: Records<PunctualRecord>,
    fields: FieldCache,
    /// Where rays to the polygons go, made when it is asked for.
    targets: OnceLock<TargetList>,
    pub(super) warnings: Vec<String>,
    /// Of each warning the light's index in the scene.
    warned: Vec<usize>,
    /// What the lights were made of.
    origins: Vec<EmissivePolygon>,
    textures: Vec<Texture>,
}

/// Lights that are to replace those there are.
pub(super) struct StagedLights {
    prepared: Option<PreparedLights>,
    /// Buffers of them, where the old ones have no room.
    grown: Option<LightBuffers>,
    clusters: Option<StagedRecords<ClusterRecord>>,
    punctual: StagedRecords<PunctualRecord>,
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
            warned,
        } = sorted(PreparedLights::new(polygons, textures));
        let buffers = LightBuffers::new(device, queue, &lights)?;
        let tables = Tables::new(device, queue, TableFormat::F32);
        let layout = lumigon_wgpu::bind_group_layout(device, wgpu::ShaderStages::COMPUTE);
        let records = punctual.iter().map(PunctualRecord::from).collect();
        Ok(Self {
            bind_group: lumigon_wgpu::bind_group(device, &layout, &buffers, &tables),
            polygons: buffers,
            replaced: BTreeMap::new(),
            conventional: OnceLock::new(),
            tables,
            layout,
            clusters: Records::new(gpu, "light clusters", clusters(&lights))?,
            punctual: Records::new(gpu, "lights without extent", records)?,
            fields: FieldCache::new(&lights),
            targets: OnceLock::new(),
            lights,
            sources,
            warnings,
            warned,
            origins: polygons.to_vec(),
            textures: textures.to_vec(),
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
            clusters: self.clusters.buffer(),
            punctual: self.punctual.buffer(),
            polygons: &self.lights,
            punctual_count: self.punctual.len() as u32,
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
        self.clusters
            .change(gpu, cluster, |record| record.power = power);
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

    /// Prepares other lights, as far as they are others, and makes room for them.
    pub(super) fn stage(
        &self,
        gpu: &Gpu,
        polygons: &[EmissivePolygon],
        textures: &[Texture],
        punctual: &[PunctualLight],
    ) -> Result<StagedLights, GpuError> {
        let records = punctual.iter().map(PunctualRecord::from).collect();
        let punctual = self.punctual.stage(gpu, records)?;
        let known = self.known(polygons, textures);
        let in_place = known.iter().enumerate().all(|(i, old)| *old == Some(i));
        if in_place && known.len() == self.origins.len() && self.replaced.is_empty() {
            return Ok(StagedLights {
                prepared: None,
                grown: None,
                clusters: None,
                punctual,
            });
        }
        let mut places = vec![None; self.origins.len()];
        for (place, &source) in self.sources.iter().enumerate() {
            places[source] = Some(place);
        }
        let of_known = |index: usize| -> Option<Prepared> {
            let old = known[index]?;
            let light = places[old].map(|place| self.lights[place].clone());
            let warning = self.warned.binary_search(&old).ok();
            Some((light, warning.map(|i| self.warnings[i].clone())))
        };
        let prepared = sorted(PreparedLights::with_known(polygons, textures, of_known));
        let (device, queue) = (gpu.device(), gpu.queue());
        let lights = &prepared.lights;
        let grown = if self.polygons.holds(device, lights)? {
            None
        } else {
            Some(LightBuffers::new(device, queue, lights)?)
        };
        let clusters = self.clusters.stage(gpu, clusters(lights))?;
        Ok(StagedLights {
            grown,
            clusters: Some(clusters),
            prepared: Some(prepared),
            punctual,
        })
    }

    /// Takes what was staged, which is made of these.
    pub(super) fn commit(
        &mut self,
        gpu: &Gpu,
        staged: StagedLights,
        polygons: &[EmissivePolygon],
        textures: &[Texture],
    ) -> Result<(), GpuError> {
        self.punctual.commit(gpu, staged.punctual);
        self.textures = textures.to_vec();
        if let Some(clusters) = staged.clusters {
            self.clusters.commit(gpu, clusters);
        }
        let Some(PreparedLights {
            lights,
            sources,
            warnings,
            warned,
        }) = staged.prepared
        else {
            return Ok(());
        };
        let (device, queue) = (gpu.device(), gpu.queue());
        let has_new_buffers = match staged.grown {
            Some(buffers) => {
                self.polygons = buffers;
                true
            }
            None => self.polygons.write(device, queue, &lights)?,
        };
        if has_new_buffers {
            self.bind_group =
                lumigon_wgpu::bind_group(device, &self.layout, &self.polygons, &self.tables);
        }
        self.fields = FieldCache::new(&lights);
        self.targets = OnceLock::new();
        self.lights = lights;
        self.sources = sources;
        self.replaced.clear();
        self.conventional = OnceLock::new();
        self.warnings = warnings;
        self.warned = warned;
        self.origins.truncate(polygons.len());
        for (old, new) in self.origins.iter_mut().zip(polygons) {
            if !is_same_light(old, new) {
                old.clone_from(new);
            }
        }
        self.origins
            .extend_from_slice(&polygons[self.origins.len()..]);
        Ok(())
    }

    /// Which of the lights that were prepared each of these is, if any.
    fn known(&self, polygons: &[EmissivePolygon], textures: &[Texture]) -> Vec<Option<usize>> {
        let shows_same = |light: &EmissivePolygon| {
            let image = light.image.as_ref();
            let placed = image.iter().flat_map(|image| {
                let mask = image.mask.map(|mask| mask.placed);
                [image.emission, mask].into_iter().flatten()
            });
            let mut textures_of =
                placed.map(|p| (self.textures.get(p.texture), textures.get(p.texture)));
            textures_of.all(|pair| matches!(pair, (Some(a), Some(b)) if is_same_texture(a, b)))
        };
        let is_same = |old: &EmissivePolygon, new: &EmissivePolygon| {
            is_same_light(old, new) && shows_same(new)
        };
        let old = &self.origins;
        let mut known: Vec<Option<usize>> = polygons
            .iter()
            .enumerate()
            .map(|(i, new)| old.get(i).is_some_and(|old| is_same(old, new)).then_some(i))
            .collect();
        if known.iter().all(Option::is_some) {
            return known;
        }
        // Others went or came before them.
        let corner = |light: &EmissivePolygon| {
            let first = light.loops.first().and_then(|outer| outer.first());
            first.map(|corner| corner.map(f64::to_bits))
        };
        let mut by_corner: HashMap<_, Vec<usize>> = HashMap::new();
        for (i, light) in old.iter().enumerate() {
            by_corner.entry(corner(light)).or_default().push(i);
        }
        for (known, new) in known.iter_mut().zip(polygons) {
            if known.is_none()
                && let Some(places) = by_corner.get(&corner(new))
            {
                *known = places.iter().copied().find(|&i| is_same(&old[i], new));
            }
        }
        known
    }
}

/// Whether lights are prepared alike, as long as their textures are the same.
fn is_same_light(a: &EmissivePolygon, b: &EmissivePolygon) -> bool {
    a.loops == b.loops
        && a.radiance == b.radiance
        && a.image == b.image
        && a.two_sided == b.two_sided
        && a.name == b.name
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

/// The same lights, neighbours in clusters.
fn sorted(prepared: PreparedLights) -> PreparedLights {
    let order = order_by_place(&prepared.lights);
    let pairs = prepared.lights.into_iter().zip(prepared.sources);
    let mut left: Vec<_> = pairs.map(Some).collect();
    let (lights, sources) = order.iter().filter_map(|&i| left[i].take()).unzip();
    PreparedLights {
        lights,
        sources,
        ..prepared
    }
}
