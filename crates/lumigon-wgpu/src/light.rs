//! Lights as shaders read them.

use bytemuck::{Pod, Zeroable};
use lumigon::{LightImage, PolygonLight, Sides, Vec3};

/// A light: its polygon, its radiance, and what it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Prepared once; see [`lumigon::PolygonLight::cast`].
    pub polygon: PolygonLight<f32>,
    /// Linear RGB radiance.
    pub radiance: [f32; 3],
    /// Multiplies the radiance, place by place.
    pub image: Option<LightImage<f32>>,
}

/// The shaders' struct `PolygonLight`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PolygonRecord {
    /// World-space centre of the circumscribed circle.
    pub center: [f32; 3],
    /// One over the circle's radius.
    pub inverse_radius: f32,
    /// Unit normal towards the emitting side.
    pub normal: [f32; 3],
    /// Twice the area, in squared radii.
    pub doubled_area: f32,
    /// Centroid relative to the centre, in radii.
    pub centroid: [f32; 3],
    /// In radii: points no farther from the plane may lie in it.
    pub plane_tolerance: f32,
    /// Unit vector in the plane.
    pub plane_axis: [f32; 3],
    /// 0 where the front alone emits, 1 where both sides do.
    pub both_sides: u32,
}

impl From<&PolygonLight<f32>> for PolygonRecord {
    fn from(light: &PolygonLight<f32>) -> Self {
        let (center, radius) = light.circumscribed_circle();
        Self {
            center: center.into(),
            inverse_radius: 1.0 / radius,
            normal: light.normal().into(),
            doubled_area: light.doubled_unit_area(),
            centroid: light.centroid_offset().into(),
            plane_tolerance: light.plane_tolerance(),
            plane_axis: light.plane_axes().0.into(),
            both_sides: u32::from(light.sides() == Sides::Both),
        }
    }
}

/// The shaders' struct `Light`, field by field.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightRecord {
    /// The polygon.
    pub polygon: PolygonRecord,
    /// Linear RGB radiance.
    pub radiance: [f32; 3],
    /// Index of the light's first vertex record.
    pub first_record: u32,
    /// One past its last.
    pub end_record: u32,
    /// Index of the light's image record, or [`LightRecord::NO_IMAGE`].
    pub image: u32,
    /// What a struct of 16-byte alignment is padded with.
    pub padding: [u32; 2],
}

impl LightRecord {
    /// The image of a light without one.
    pub const NO_IMAGE: u32 = u32::MAX;
}

/// A vertex in radii from its light's centre; the fourth number is 1 where a loop starts there, 0
/// where an edge ends there.
pub type VertexRecord = [f32; 4];

/// The vertex records of a light: for each loop a move to its last vertex, then lines to all.
pub fn vertex_records(light: &PolygonLight<f32>) -> impl Iterator<Item = VertexRecord> + '_ {
    let record = |v: Vec3<f32>, start: f32| [v.x, v.y, v.z, start];
    light.loop_ranges().flat_map(move |range| {
        let vertices = &light.offsets()[range];
        let last = vertices.last().map(|&v| record(v, 1.0));
        last.into_iter()
            .chain(vertices.iter().map(move |&v| record(v, 0.0)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_loop_is_closed() {
        let square = |r: f64| vec![[-r, -r, 0.0], [r, -r, 0.0], [r, r, 0.0], [-r, r, 0.0]];
        let hole: Vec<_> = square(0.5).into_iter().rev().collect();
        let light = PolygonLight::new(&[square(1.0), hole], Sides::Both).unwrap();
        let light = light.cast().unwrap();
        let records: Vec<_> = vertex_records(&light).collect();
        let starts: Vec<_> = records.iter().map(|r| r[3]).collect();
        assert_eq!(starts, [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(records[0][..3], records[4][..3]);
        assert_eq!(records[5][..3], records[9][..3]);
        assert_eq!(PolygonRecord::from(&light).both_sides, 1);
    }
}
