//! Images of lights in storage buffers.

use bytemuck::{Pod, Zeroable};
use lumigon::{GAUSSIAN_LEVELS, LightImage, LightImageError};

use crate::image_colors::ImageColors;
use crate::image_filter::{FilterJob, ImageFilter};
use crate::light::{Light, LightRecord};

/// Images that do not fit the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{images} light images need a buffer of {needed} bytes, but the device's hold {limit}: use \
     smaller images, or fewer"
)]
pub struct TooLargeImages {
    /// How many images.
    pub images: usize,
    /// Bytes of all their levels.
    pub needed: u64,
    /// Bytes that a storage buffer binding may have on this device.
    pub limit: u64,
}

/// Why a light's image cannot be replaced.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ReplaceImageError {
    /// There is no such light, or it was given without an image.
    #[error("light {light} has no image to replace: give it one of the same size when it is made")]
    NoImage {
        /// Index of the light.
        light: usize,
    },
    /// The colours are too few, too many, or none.
    #[error(transparent)]
    Colors(#[from] LightImageError),
    /// The colours are more than one buffer holds.
    #[error(transparent)]
    TooLarge(#[from] TooLargeImages),
}

/// The shaders' struct `ShownImage`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ImageRecord {
    /// The image's frame: its corner, in radii from the light's centre.
    pub corner: [f32; 3],
    /// Index of its pyramid's first texel.
    pub first_texel: u32,
    /// From the corner to u = 1.
    pub edge_u: [f32; 3],
    /// 1 where the conventional lookup's levels are there, else 0.
    pub has_gaussian_levels: u32,
    /// From the corner to v = 1.
    pub edge_v: [f32; 3],
    /// What aligns the size.
    pub padding: u32,
    /// Texels across and down.
    pub size: [u32; 2],
    /// What aligns the colour.
    pub padding_after_size: [u32; 2],
    /// The greatest of its colours, channel by channel.
    pub greatest: [f32; 3],
    /// What aligns the levels.
    pub padding_after_greatest: u32,
    /// The conventional lookup's levels: texels across, texels down, index of the first.
    pub gaussian: [[u32; 4]; GAUSSIAN_LEVELS],
}

/// One image on the device.
#[derive(Debug)]
struct Placed {
    record: ImageRecord,
    first_source: u32,
    /// What its texels are, unless others have been shown since.
    shown: Option<LightImage<f32>>,
    /// Kept where it has the conventional lookup's levels, which the processor filters.
    kept: Option<LightImage<f32>>,
}

/// The images of a list of lights on a device.
#[derive(Debug)]
pub struct ImageBuffers {
    records: wgpu::Buffer,
    texels: wgpu::Buffer,
    sources: wgpu::Buffer,
    images: Vec<Placed>,
    /// The image of each light.
    of_lights: Vec<u32>,
    filter: Option<ImageFilter>,
}

/// Where everything lies in the buffers.
pub(crate) struct ImageLayout {
    records: Vec<ImageRecord>,
    first_sources: Vec<u32>,
    texels: u64,
    sources: u64,
}

/// A buffer of no bytes cannot be bound.
const LEAST_TEXELS: u64 = 1;

impl ImageLayout {
    pub(crate) fn new(device: &wgpu::Device, lights: &[Light]) -> Result<Self, TooLargeImages> {
        let mut layout = Self {
            records: Vec::new(),
            first_sources: Vec::new(),
            texels: 0,
            sources: 0,
        };
        for image in images(lights) {
            let frame = image.frame();
            let mut record = ImageRecord {
                corner: frame.corner.into(),
                first_texel: layout.texels as u32,
                edge_u: frame.edge_u.into(),
                edge_v: frame.edge_v.into(),
                size: image.size(),
                greatest: image.greatest(),
                ..ImageRecord::default()
            };
            layout.texels += image.pyramid().texels().len() as u64;
            if let Some(levels) = image.gaussian_levels() {
                record.has_gaussian_levels = 1;
                for (stored, level) in record.gaussian.iter_mut().zip(levels.levels()) {
                    let [width, height] = level.size;
                    *stored = [width, height, layout.texels as u32, 0];
                    layout.texels += level.texels.len() as u64;
                }
            }
            layout.records.push(record);
            let first_source = match image.coverage() {
                Some((_, sources)) => {
                    let first = layout.sources as u32;
                    layout.sources += sources.len() as u64;
                    first
                }
                None => FilterJob::EVERY_TEXEL_ITS_OWN,
            };
            layout.first_sources.push(first_source);
        }
        let limit = largest_binding(device);
        let needed = (layout.texels * size_of::<[f32; 4]>() as u64)
            .max((layout.records.len() * size_of::<ImageRecord>()) as u64);
        if needed > limit {
            return Err(TooLargeImages {
                images: layout.records.len(),
                needed,
                limit,
            });
        }
        Ok(layout)
    }

    fn bytes(&self) -> [u64; 3] {
        [
            self.records.len().max(1) as u64 * size_of::<ImageRecord>() as u64,
            self.texels.max(LEAST_TEXELS) * size_of::<[f32; 4]>() as u64,
            self.sources.max(LEAST_TEXELS) * size_of::<u32>() as u64,
        ]
    }
}

impl ImageBuffers {
    pub(crate) fn sized(device: &wgpu::Device, layout: &ImageLayout) -> Self {
        let buffer = |label, size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::STORAGE
                    | wgpu::BufferUsages::COPY_DST
                    | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        let [records, texels, sources] = layout.bytes();
        Self {
            records: buffer("light images", records),
            texels: buffer("light image texels", texels),
            sources: buffer("light image sources", sources),
            images: Vec::new(),
            of_lights: Vec::new(),
            filter: None,
        }
    }

    pub(crate) fn holds(&self, layout: &ImageLayout) -> bool {
        let buffers = [&self.records, &self.texels, &self.sources];
        let sizes = buffers.into_iter().zip(layout.bytes());
        sizes
            .into_iter()
            .all(|(buffer, size)| size <= buffer.size())
    }

    pub(crate) fn fill(&mut self, queue: &wgpu::Queue, layout: ImageLayout, lights: &[Light]) {
        if !layout.records.is_empty() {
            queue.write_buffer(&self.records, 0, bytemuck::cast_slice(&layout.records));
        }
        self.of_lights = image_indices(lights).collect();
        let old = std::mem::take(&mut self.images);
        let placed = layout.records.into_iter().zip(layout.first_sources);
        for (image, (record, first_source)) in images(lights).zip(placed) {
            if !is_there(&old, &record, first_source, image) {
                self.upload(queue, &record, image);
                if let Some((_, sources)) = image.coverage() {
                    let start = u64::from(first_source) * size_of::<u32>() as u64;
                    queue.write_buffer(&self.sources, start, bytemuck::cast_slice(sources));
                }
            }
            self.images.push(Placed {
                record,
                first_source,
                shown: Some(image.clone()),
                kept: image.gaussian_levels().map(|_| image.clone()),
            });
        }
    }

    /// Writes all levels of an image.
    fn upload(&self, queue: &wgpu::Queue, record: &ImageRecord, image: &LightImage<f32>) {
        let write = |first: u32, texels: &[[f32; 4]]| {
            let start = u64::from(first) * size_of::<[f32; 4]>() as u64;
            queue.write_buffer(&self.texels, start, bytemuck::cast_slice(texels));
        };
        write(record.first_texel, image.pyramid().texels());
        if let Some(levels) = image.gaussian_levels() {
            for (level, stored) in levels.levels().iter().zip(record.gaussian) {
                write(stored[2], &level.texels);
            }
        }
    }

    /// Shows other colours on a light; see
    /// [`LightBuffers::replace_image`](crate::LightBuffers::replace_image).
    pub(crate) fn replace(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        light: usize,
        colors: ImageColors<'_>,
    ) -> Result<(), ReplaceImageError> {
        let index = self.of_lights.get(light).copied();
        let index = index.unwrap_or(LightRecord::NO_IMAGE) as usize;
        let Some(image) = self.images.get_mut(index) else {
            return Err(ReplaceImageError::NoImage { light });
        };
        let greatest = colors.greatest(image.record.size)?;
        if let Some(mut kept) = image.kept.take() {
            let record = image.record;
            image.shown = None;
            let replaced = kept.replace(&colors.to_linear());
            self.upload(queue, &record, &kept);
            self.images[index].kept = Some(kept);
            replaced?;
        } else {
            let limit = largest_binding(device);
            let needed = colors.bytes().len() as u64;
            if needed > limit {
                return Err(ReplaceImageError::TooLarge(TooLargeImages {
                    images: 1,
                    needed,
                    limit,
                }));
            }
            let job = FilterJob {
                size: image.record.size,
                first_texel: image.record.first_texel,
                first_larger: 0,
                first_source: image.first_source,
                is_srgb: u32::from(colors.is_srgb()),
            };
            let filter = self
                .filter
                .get_or_insert_with(|| ImageFilter::new(device, queue));
            image.shown = None;
            filter.run(device, queue, [&self.texels, &self.sources], job, colors);
        }
        self.images[index].record.greatest = greatest;
        let at = index * size_of::<ImageRecord>() + std::mem::offset_of!(ImageRecord, greatest);
        queue.write_buffer(&self.records, at as u64, bytemuck::bytes_of(&greatest));
        Ok(())
    }

    /// The buffer of the shaders' `light_images`.
    #[must_use]
    pub fn records(&self) -> &wgpu::Buffer {
        &self.records
    }

    /// The buffer of the shaders' `light_image_texels`; it may be copied from.
    #[must_use]
    pub fn texels(&self) -> &wgpu::Buffer {
        &self.texels
    }

    /// How many images there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.images.len()
    }

    /// Whether no light has an image.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.images.is_empty()
    }

    /// The record of a light's image.
    #[must_use]
    pub fn record(&self, light: usize) -> Option<&ImageRecord> {
        let index = *self.of_lights.get(light)?;
        self.images.get(index as usize).map(|image| &image.record)
    }

    /// Bytes of all buffers.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.records.size() + self.texels.size() + self.sources.size()
    }
}

/// Whether an image's texels are among old ones already, at its place.
fn is_there(
    old: &[Placed],
    record: &ImageRecord,
    first_source: u32,
    image: &LightImage<f32>,
) -> bool {
    // Images follow each other.
    let place = old.binary_search_by_key(&record.first_texel, |old| old.record.first_texel);
    let Some(old) = place.ok().map(|place| &old[place]) else {
        return false;
    };
    let has_levels = old.record.has_gaussian_levels + record.has_gaussian_levels > 0;
    let shows = |shown: &LightImage<f32>| shown.shares_texels_with(image);
    !has_levels && old.first_source == first_source && old.shown.as_ref().is_some_and(shows)
}

/// The images of the lights that have one.
fn images(lights: &[Light]) -> impl Iterator<Item = &LightImage<f32>> {
    lights.iter().filter_map(|light| light.image.as_ref())
}

/// The index of each light's image, or [`LightRecord::NO_IMAGE`].
pub(crate) fn image_indices(lights: &[Light]) -> impl Iterator<Item = u32> + '_ {
    let mut next = 0;
    lights.iter().map(move |light| match light.image {
        Some(_) => {
            next += 1;
            next - 1
        }
        None => LightRecord::NO_IMAGE,
    })
}

/// Bytes that a storage buffer binding may have.
pub(crate) fn largest_binding(device: &wgpu::Device) -> u64 {
    let limits = device.limits();
    limits
        .max_buffer_size
        .min(limits.max_storage_buffer_binding_size)
}
