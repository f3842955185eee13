//! Lights in storage buffers.

use crate::image_buffers::{
    ImageBuffers, ImageLayout, ReplaceImageError, TooLargeImages, image_indices, largest_binding,
};
use crate::image_colors::ImageColors;
use crate::light::{Light, LightRecord, VertexRecord, vertex_records};

/// Lights that do not fit the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{lights} lights with {records} vertex records need a buffer of {needed} bytes, but the \
     device's hold {limit}: use fewer lights, or fewer vertices"
)]
pub struct TooManyLights {
    /// How many lights.
    pub lights: usize,
    /// How many vertex records they have.
    pub records: usize,
    /// Bytes of the greater buffer.
    pub needed: u64,
    /// Bytes that a storage buffer binding may have on this device.
    pub limit: u64,
}

/// What does not fit the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LightBuffersError {
    /// The lights.
    #[error(transparent)]
    Lights(#[from] TooManyLights),
    /// The images on them.
    #[error(transparent)]
    Images(#[from] TooLargeImages),
}

/// Lights on a device, replaced as often as they move: buffers grow when they must, and are
/// written in place otherwise.
#[derive(Debug)]
pub struct LightBuffers {
    lights: wgpu::Buffer,
    vertices: wgpu::Buffer,
    images: ImageBuffers,
    count: usize,
}

/// Bytes before the first [`LightRecord`]: their count, and what aligns the list.
const HEADER: usize = 16;

/// A buffer of no bytes cannot be bound.
const LEAST_RECORDS: usize = 1;

/// Bytes of the smallest buffers.
const LEAST_BYTES: u64 = 4096;

impl LightBuffers {
    /// Buffers of these lights.
    ///
    /// # Errors
    /// Where the device's storage buffers are too small.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        lights: &[Light],
    ) -> Result<Self, LightBuffersError> {
        let packed = Packed::new(device, lights)?;
        let mut buffers = Self::sized(device, &packed);
        buffers.fill(queue, packed, lights);
        Ok(buffers)
    }

    /// Buffers that hold as much and, but for images, up to twice that: lights are reshaped.
    fn sized(device: &wgpu::Device, packed: &Packed) -> Self {
        let limit = largest_binding(device);
        let spared = |needed: u64| needed.max(LEAST_BYTES).next_power_of_two().min(limit);
        Self {
            lights: storage_buffer(device, "lights", spared(packed.headed.len() as u64)),
            vertices: storage_buffer(device, "light vertices", spared(packed.vertex_bytes())),
            images: ImageBuffers::sized(device, &packed.images),
            count: 0,
        }
    }

    fn fill(&mut self, queue: &wgpu::Queue, packed: Packed, lights: &[Light]) {
        queue.write_buffer(&self.lights, 0, &packed.headed);
        queue.write_buffer(&self.vertices, 0, bytemuck::cast_slice(&packed.records));
        self.images.fill(queue, packed.images, lights);
        self.count = lights.len();
    }

    /// Whether other lights have room here: [`LightBuffers::write`] then changes nothing but what is in the
    /// buffers.
    ///
    /// # Errors
    /// Where the device's storage buffers are too small.
    pub fn holds(
        &self,
        device: &wgpu::Device,
        lights: &[Light],
    ) -> Result<bool, LightBuffersError> {
        Ok(self.has_room(&Packed::new(device, lights)?))
    }

    fn has_room(&self, packed: &Packed) -> bool {
        packed.headed.len() as u64 <= self.lights.size()
            && packed.vertex_bytes() <= self.vertices.size()
            && self.images.holds(&packed.images)
    }

    /// Replaces the lights; texels of images that are where they were are not written again. Returns whether the buffers had to grow, and bind groups of them have to
    /// be made anew.
    ///
    /// # Errors
    /// Where the device's storage buffers are too small; the lights stay as they were.
    pub fn write(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        lights: &[Light],
    ) -> Result<bool, LightBuffersError> {
        let packed = Packed::new(device, lights)?;
        let grows = !self.has_room(&packed);
        if grows {
            *self = Self::sized(device, &packed);
        }
        self.fill(queue, packed, lights);
        Ok(grows)
    }

    /// Shows other colours on a light that has an image: one for each of its texels, row by row. The
    /// device filters them; whatever is submitted afterwards sees them. Bind groups stay.
    ///
    /// Images with the conventional lookup's
    /// [levels](lumigon::LightImage::filter_gaussian_levels) are filtered by the processor instead,
    /// which takes a hundred times as long.
    ///
    /// # Errors
    /// Where the light has no image, or these are no colours for it; it then stays what it was.
    pub fn replace_image(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        light: usize,
        colors: ImageColors<'_>,
    ) -> Result<(), ReplaceImageError> {
        self.images.replace(device, queue, light, colors)
    }

    /// The images on the lights.
    #[must_use]
    pub fn images(&self) -> &ImageBuffers {
        &self.images
    }

    /// The buffer of the shaders' `lights`.
    #[must_use]
    pub fn lights(&self) -> &wgpu::Buffer {
        &self.lights
    }

    /// The buffer of the shaders' `light_vertices`.
    #[must_use]
    pub fn vertices(&self) -> &wgpu::Buffer {
        &self.vertices
    }

    /// Number of lights.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is no light.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }
}

/// What the buffers hold.
struct Packed {
    headed: Vec<u8>,
    records: Vec<VertexRecord>,
    images: ImageLayout,
}

impl Packed {
    fn new(device: &wgpu::Device, lights: &[Light]) -> Result<Self, LightBuffersError> {
        let count = |light: &Light| light.polygon.vertex_count() + light.polygon.loop_count();
        let records: usize = lights.iter().map(count).sum();
        let listed = HEADER + lights.len().max(LEAST_RECORDS) * size_of::<LightRecord>();
        let needed = listed.max(records * size_of::<VertexRecord>()) as u64;
        let limit = largest_binding(device);
        if needed > limit {
            return Err(LightBuffersError::Lights(TooManyLights {
                lights: lights.len(),
                records,
                needed,
                limit,
            }));
        }
        let images = ImageLayout::new(device, lights)?;
        let mut headed = vec![0; HEADER];
        headed[..4].copy_from_slice(&(lights.len() as u32).to_le_bytes());
        let mut all = Vec::with_capacity(records.max(LEAST_RECORDS));
        for (light, image) in lights.iter().zip(image_indices(lights)) {
            let first_record = all.len() as u32;
            all.extend(vertex_records(&light.polygon));
            headed.extend_from_slice(bytemuck::bytes_of(&LightRecord {
                polygon: (&light.polygon).into(),
                radiance: light.radiance,
                first_record,
                end_record: all.len() as u32,
                image,
                padding: [0; 2],
            }));
        }
        headed.resize(headed.len().max(listed), 0);
        all.resize(all.len().max(LEAST_RECORDS), [0.0; 4]);
        Ok(Self {
            headed,
            records: all,
            images,
        })
    }

    fn vertex_bytes(&self) -> u64 {
        size_of_val(&*self.records) as u64
    }
}

fn storage_buffer(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
