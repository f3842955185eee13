//! A polygon light as the path tracer sees it: a set of triangles to hit and to draw points from.

use glam::{DVec2, DVec3};

use crate::polygon::Polygon;
use crate::sampling::{Random, uniform_triangle};
use crate::texture::Texture;

/// A polygon that emits the same radiance in every direction of its lit side or sides, and everywhere unless a texture
/// says otherwise.
#[derive(Debug, Clone)]
pub struct Emitter {
    polygon: Polygon,
    radiance: [f64; 3],
    texture: Option<Texture>,
    centre: DVec3,
    /// Of a sphere about `centre` that holds the polygon.
    radius: f64,
    /// Summed areas up to and including each triangle.
    cumulative_areas: Vec<f64>,
}

/// A point of an emitter, seen from a shading point.
pub(crate) struct EmitterPoint {
    /// Unit, towards the emitter.
    pub(crate) direction: DVec3,
    pub(crate) distance: f64,
    /// Solid angle per area of the emitter there, r^-2 times its cosine: converts densities.
    pub(crate) solid_angle_per_area: f64,
}

impl Emitter {
    /// A light from a polygon and its RGB radiance in W m^-2 sr^-1 (or nits).
    ///
    /// Radiance that is negative or not finite counts as none.
    pub fn new(polygon: Polygon, radiance: [f64; 3]) -> Self {
        let centre = DVec3::from(polygon.centroid());
        let vertices = polygon.triangle_vertices().iter().flatten();
        let radius = vertices.fold(0.0, |m: f64, v| m.max(v.distance(centre)));
        let mut area = 0.0;
        let cumulative_areas = polygon
            .triangle_vertices()
            .iter()
            .map(|[a, b, c]| {
                area += 0.5 * (b - a).cross(c - a).length();
                area
            })
            .collect();
        Self {
            polygon,
            radiance: radiance.map(|x| if x.is_finite() { x.max(0.0) } else { 0.0 }),
            texture: None,
            centre,
            radius,
            cumulative_areas,
        }
    }

    /// The same with its radiance multiplied, point by point, by a texture in its plane.
    #[must_use]
    pub fn with_texture(self, texture: Texture) -> Self {
        Self {
            texture: Some(texture),
            ..self
        }
    }

    /// The outline.
    pub fn polygon(&self) -> &Polygon {
        &self.polygon
    }

    /// RGB radiance of the lit side, before any texture.
    pub fn radiance(&self) -> [f64; 3] {
        self.radiance
    }

    /// RGB radiance of a point of it.
    pub fn radiance_at(&self, position: [f64; 3]) -> [f64; 3] {
        match &self.texture {
            None => self.radiance,
            Some(texture) => {
                let color = texture.color(position);
                std::array::from_fn(|i| self.radiance[i] * color[i])
            }
        }
    }

    /// Total area as sampled.
    pub(crate) fn area(&self) -> f64 {
        self.cumulative_areas.last().copied().unwrap_or(0.0)
    }

    /// Rough irradiance at a point, for choosing lights; zero only if the light cannot reach a surface with this normal.
    pub(crate) fn importance(&self, point: DVec3, normal: DVec3) -> f64 {
        let offset = self.centre - point;
        if !self.lights(point) || normal.dot(offset) < -self.radius {
            return 0.0;
        }
        let gap = (offset.length() - self.radius).max(0.0);
        let area = self.area();
        self.radiance.iter().sum::<f64>() * area / (area + gap * gap)
    }

    /// Whether the point is on a lit side.
    ///
    /// A two-sided light is dark within 1e-5 of its radius (plus 1e-6 of the coordinates) of its plane: points of its
    /// own surface, whose side is a matter of rounding, would see it everywhere.
    fn lights(&self, point: DVec3) -> bool {
        let height = self.polygon.height(point);
        match self.polygon.is_two_sided() {
            true => height.abs() > 1e-5 * self.radius + 1e-6 * point.abs().max_element(),
            false => height > 0.0,
        }
    }

    /// A uniform point of the emitter's area; `None` if it shows its dark side or its edge.
    pub(crate) fn sample(&self, point: DVec3, random: &mut Random) -> Option<EmitterPoint> {
        let target = random.uniform() * self.area();
        let index = self
            .cumulative_areas
            .partition_point(|&area| area <= target);
        let [a, b, c] = *self.polygon.triangle_vertices().get(index)?;
        let DVec2 { x: u, y: v } = uniform_triangle(random.uniform2());
        let offset = a + (b - a) * u + (c - a) * v - point;
        let distance = offset.length();
        self.seen(&[a, b, c], offset / distance, distance)
    }

    /// Every point of the emitter along a ray with a unit direction, on a lit side.
    ///
    /// Triangles after Moeller and Trumbore 1997.
    pub(crate) fn hits(
        &self,
        origin: DVec3,
        direction: DVec3,
    ) -> impl Iterator<Item = EmitterPoint> + '_ {
        let offset = self.centre - origin;
        let along = offset.dot(direction);
        let misses = along < -self.radius
            || (offset - along * direction).length_squared()
                > self.radius * self.radius * (1.0 + 1e-9);
        let triangles = match misses || !self.lights(origin) {
            true => &[][..],
            false => self.polygon.triangle_vertices(),
        };
        triangles.iter().filter_map(move |triangle| {
            let [a, b, c] = *triangle;
            let (ab, ac, ao) = (b - a, c - a, origin - a);
            let p = direction.cross(ac);
            let determinant = ab.dot(p);
            if determinant == 0.0 {
                return None;
            }
            let q = ao.cross(ab);
            let (u, v) = (ao.dot(p) / determinant, direction.dot(q) / determinant);
            let distance = ac.dot(q) / determinant;
            // Half open, so that a ray through the edge between two triangles counts once.
            let inside = u >= 0.0 && v >= 0.0 && u + v < 1.0 && distance > 0.0;
            if inside {
                self.seen(triangle, direction, distance)
            } else {
                None
            }
        })
    }

    fn seen(
        &self,
        [a, b, c]: &[DVec3; 3],
        direction: DVec3,
        distance: f64,
    ) -> Option<EmitterPoint> {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let facing = -normal.dot(direction);
        let cosine = if self.polygon.is_two_sided() {
            facing.abs()
        } else {
            facing
        };
        (cosine > 0.0 && distance > 0.0).then_some(EmitterPoint {
            direction,
            distance,
            solid_angle_per_area: cosine / (distance * distance),
        })
    }
}
