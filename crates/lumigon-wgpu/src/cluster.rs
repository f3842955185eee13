//! Many lights in clusters, so that shaders can leave out whole ones.

use bytemuck::{Pod, Zeroable};

use crate::light::Light;

/// Lights of a cluster: as many as a word of the shaders' masks has bits.
pub const CLUSTER_LIGHTS: usize = 32;

/// Makes up for what rounding may have taken.
const ROUNDED: f32 = 1.00001;

/// A sphere around [`CLUSTER_LIGHTS`] lights, or fewer in the last one.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClusterRecord {
    /// World-space centre.
    pub center: [f32; 3],
    /// Radius that holds every light whole.
    pub radius: f32,
    /// Greatest [`light_power`] among the lights: no single one adds more than it allows.
    pub power: f32,
    /// What a struct of 16-byte alignment is padded with.
    pub padding: [u32; 3],
}

/// Sorts lights so that neighbours in space are neighbours in the list.
///
/// Along a Morton curve: Morton, "A Computer Oriented Geodetic Data Base", 1966.
pub fn sort_by_place(lights: &mut [Light]) {
    let key = place_key(lights);
    lights.sort_by_cached_key(key);
}

/// The indices of the lights in the order of [`sort_by_place`].
#[must_use]
pub fn order_by_place(lights: &[Light]) -> Vec<usize> {
    let key = place_key(lights);
    let mut order: Vec<usize> = (0..lights.len()).collect();
    order.sort_by_cached_key(|&i| key(&lights[i]));
    order
}

/// What orders lights by their place among these.
fn place_key(lights: &[Light]) -> impl Fn(&Light) -> u32 + use<> {
    let centers = lights.iter().map(center);
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for center in centers {
        for axis in 0..3 {
            low[axis] = low[axis].min(center[axis]);
            high[axis] = high[axis].max(center[axis]);
        }
    }
    // One scale for all axes: clusters are to be round.
    let extent = (0..3).fold(0.0_f32, |most, axis| most.max(high[axis] - low[axis]));
    let scale = if extent > 0.0 { 1023.0 / extent } else { 0.0 };
    move |light| {
        let center = center(light);
        (0..3).fold(0, |key, axis| {
            let cell = ((center[axis] - low[axis]) * scale) as u32;
            key | spread(cell) << axis
        })
    }
}

/// Area times the brightest channel of what a light emits anywhere, where the greatest colours of its
/// image are these: of [`ImageRecord::greatest`](crate::ImageRecord::greatest), 1 without one.
#[must_use]
pub fn light_power(light: &Light, greatest_colors: [f32; 3]) -> f32 {
    let channels = light.radiance.iter().zip(greatest_colors);
    let brightest = channels.fold(0.0_f32, |most, (radiance, color)| {
        most.max(radiance * color)
    });
    light.polygon.area() * brightest
}

/// The spheres around each [`CLUSTER_LIGHTS`] successive lights.
#[must_use]
pub fn clusters(lights: &[Light]) -> Vec<ClusterRecord> {
    lights.chunks(CLUSTER_LIGHTS).map(cluster).collect()
}

fn cluster(lights: &[Light]) -> ClusterRecord {
    let count = lights.len() as f32;
    let mut middle = [0.0; 3];
    for light in lights {
        for (to, from) in middle.iter_mut().zip(center(light)) {
            *to += from / count;
        }
    }
    let (mut radius, mut most_power) = (0.0_f32, 0.0_f32);
    for light in lights {
        let (_, own) = light.polygon.circumscribed_circle();
        let squared: f32 = center(light)
            .iter()
            .zip(middle)
            .map(|(a, b)| (a - b) * (a - b))
            .sum();
        radius = radius.max(squared.sqrt() + own);
        let greatest_colors = light
            .image
            .as_ref()
            .map_or([1.0; 3], lumigon::LightImage::greatest);
        most_power = most_power.max(light_power(light, greatest_colors));
    }
    ClusterRecord {
        center: middle,
        radius: radius * ROUNDED,
        power: most_power * ROUNDED,
        padding: [0; 3],
    }
}

fn center(light: &Light) -> [f32; 3] {
    light.polygon.circumscribed_circle().0.into()
}

/// Ten bits with two zeros before each.
fn spread(cell: u32) -> u32 {
    let mut bits = cell & 0x3ff;
    bits = (bits | bits << 16) & 0x0300_00ff;
    bits = (bits | bits << 8) & 0x0300_f00f;
    bits = (bits | bits << 4) & 0x030c_30c3;
    (bits | bits << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;
    use lumigon::{PolygonLight, Sides};

    fn light(x: f64, z: f64, size: f64) -> Light {
        let outline = [[x, 0.0, z], [x + size, 0.0, z], [x, size, z]];
        let polygon = PolygonLight::new(&[outline], Sides::Both).unwrap();
        Light {
            polygon: polygon.cast().unwrap(),
            radiance: [0.5, 2.0, 1.0],
            image: None,
        }
    }

    #[test]
    fn clusters_hold_their_lights_and_are_small() {
        let mut lights: Vec<_> = (0..4096)
            .map(|i| light(f64::from(i * 37 % 64), f64::from(i / 64), 0.1))
            .collect();
        sort_by_place(&mut lights);
        let clusters = clusters(&lights);
        assert_eq!(clusters.len(), 128);
        for (cluster, lights) in clusters.iter().zip(lights.chunks(CLUSTER_LIGHTS)) {
            for light in lights {
                for vertex in light.polygon.loops().flatten() {
                    let offset: [f32; 3] = vertex.into();
                    let squared: f32 = offset
                        .iter()
                        .zip(cluster.center)
                        .map(|(a, b)| (a - b) * (a - b))
                        .sum();
                    assert!(squared.sqrt() <= cluster.radius);
                }
            }
            // 32 lights a metre apart fit into 4 by 8.
            assert!(cluster.radius < 5.0, "{}", cluster.radius);
            assert!((cluster.power / (0.005 * 2.0) - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn one_place_and_none() {
        let mut lights: Vec<_> = (0..3).map(|_| light(1.0, 2.0, 1.0)).collect();
        sort_by_place(&mut lights);
        assert_eq!(clusters(&lights).len(), 1);
        sort_by_place(&mut []);
        assert!(clusters(&[]).is_empty());
    }
}
