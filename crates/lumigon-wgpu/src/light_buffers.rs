//! Lights in storage buffers.

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

/// Lights on a device, replaced as often as they move: buffers grow when they must, and are
/// written in place otherwise.
#[derive(Debug)]
pub struct LightBuffers {
    lights: wgpu::Buffer,
    vertices: wgpu::Buffer,
    count: usize,
}

/// Bytes before the first [`LightRecord`]: their count, and what aligns the list.
const HEADER: usize = 16;

/// A buffer of no bytes cannot be bound.
const LEAST_RECORDS: usize = 1;

impl LightBuffers {
    /// Buffers of these lights.
    ///
    /// # Errors
    /// Where the device's storage buffers are too small.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        lights: &[Light],
    ) -> Result<Self, TooManyLights> {
        let (headed, records) = packed(device, lights)?;
        let mut buffers = Self::sized(device, &headed, &records);
        buffers.fill(queue, &headed, &records, lights.len());
        Ok(buffers)
    }

    /// Buffers that hold as much.
    fn sized(device: &wgpu::Device, headed: &[u8], records: &[VertexRecord]) -> Self {
        Self {
            lights: storage_buffer(device, "lights", headed.len() as u64),
            vertices: storage_buffer(device, "light vertices", size_of_val(records) as u64),
            count: 0,
        }
    }

    fn fill(&mut self, queue: &wgpu::Queue, headed: &[u8], records: &[VertexRecord], count: usize) {
        queue.write_buffer(&self.lights, 0, headed);
        queue.write_buffer(&self.vertices, 0, bytemuck::cast_slice(records));
        self.count = count;
    }

    /// Replaces the lights. Returns whether the buffers had to grow, and bind groups of them have to
    /// be made anew.
    ///
    /// # Errors
    /// Where the device's storage buffers are too small; the lights stay as they were.
    pub fn write(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        lights: &[Light],
    ) -> Result<bool, TooManyLights> {
        let (headed, records) = packed(device, lights)?;
        let grows = headed.len() as u64 > self.lights.size()
            || size_of_val(&*records) as u64 > self.vertices.size();
        if grows {
            *self = Self::sized(device, &headed, &records);
        }
        self.fill(queue, &headed, &records, lights.len());
        Ok(grows)
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

/// The bytes of both buffers.
fn packed(
    device: &wgpu::Device,
    lights: &[Light],
) -> Result<(Vec<u8>, Vec<VertexRecord>), TooManyLights> {
    let count = |light: &Light| light.polygon.vertex_count() + light.polygon.loop_count();
    let records: usize = lights.iter().map(count).sum();
    let listed = HEADER + lights.len().max(LEAST_RECORDS) * size_of::<LightRecord>();
    let needed = listed.max(records * size_of::<VertexRecord>()) as u64;
    let limits = device.limits();
    let limit = limits
        .max_buffer_size
        .min(limits.max_storage_buffer_binding_size);
    if needed > limit {
        return Err(TooManyLights {
            lights: lights.len(),
            records,
            needed,
            limit,
        });
    }
    let mut headed = vec![0; HEADER];
    headed[..4].copy_from_slice(&(lights.len() as u32).to_le_bytes());
    let mut all = Vec::with_capacity(records.max(LEAST_RECORDS));
    for light in lights {
        let first_record = all.len() as u32;
        all.extend(vertex_records(&light.polygon));
        headed.extend_from_slice(bytemuck::bytes_of(&LightRecord {
            polygon: (&light.polygon).into(),
            radiance: light.radiance,
            first_record,
            end_record: all.len() as u32,
            padding: [0; 3],
        }));
    }
    headed.resize(headed.len().max(listed), 0);
    all.resize(all.len().max(LEAST_RECORDS), [0.0; 4]);
    Ok((headed, all))
}

fn storage_buffer(device: &wgpu::Device, label: &str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
