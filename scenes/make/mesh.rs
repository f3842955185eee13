//! Triangle meshes: flat polygons, quads, boxes and spheres.

use super::outline::Outline;
use earcut::Earcut;

/// Vertex attributes and triangles as glTF stores them; empty lists are attributes left out.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) texcoords: Vec<[f32; 2]>,
    pub(crate) tangents: Vec<[f32; 4]>,
    pub(crate) indices: Vec<u16>,
}

fn single<const N: usize>(values: [f64; N]) -> [f32; N] {
    values.map(|x| x as f32)
}

impl Mesh {
    /// A polygon in the xy plane whose front faces +z.
    pub(crate) fn polygon(outline: &Outline) -> Self {
        let points: Vec<[f64; 2]> = outline.loops.iter().flatten().copied().collect();
        let holes: Vec<u16> = outline
            .loops
            .iter()
            .scan(0, |start, points| {
                *start += points.len() as u16;
                Some(*start)
            })
            .take(outline.loops.len() - 1)
            .collect();
        let mut triangles: Vec<u16> = Vec::new();
        Earcut::new().earcut(points.iter().copied(), &holes, &mut triangles);
        for triangle in triangles.chunks_exact_mut(3) {
            let [a, b, c] = [0, 1, 2].map(|k| points[usize::from(triangle[k])]);
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            if area < 0.0 {
                triangle.swap(1, 2);
            }
        }
        Self {
            positions: points.iter().map(|&[x, y]| single([x, y, 0.0])).collect(),
            normals: vec![[0.0, 0.0, 1.0]; points.len()],
            indices: triangles,
            ..Self::default()
        }
    }

    /// The same with texture coordinates that show an image upright on a box: its lower left and upper
    /// right corner.
    pub(crate) fn polygon_with_picture(outline: &Outline, low: [f64; 2], high: [f64; 2]) -> Self {
        let mut mesh = Self::polygon(outline);
        let texcoords = outline.loops.iter().flatten().map(|&[x, y]| {
            single([
                (x - low[0]) / (high[0] - low[0]),
                (high[1] - y) / (high[1] - low[1]),
            ])
        });
        mesh.texcoords = texcoords.collect();
        mesh
    }

    /// A parallelogram from `corner` along the edges `u` and `v`; its front faces `u x v`.
    ///
    /// Texture coordinates run along `u` to the right and against `v` downwards, as images do.
    pub(crate) fn quad(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Self {
        let mut mesh = Self::default();
        mesh.push_quad(corner, u, v);
        mesh
    }

    /// The same with a tangent along `u`, for a normal map.
    pub(crate) fn quad_with_tangents(corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Self {
        let mut mesh = Self::quad(corner, u, v);
        let t = glam::DVec3::from(u).normalize();
        mesh.tangents = vec![single([t.x, t.y, t.z, 1.0]); 4];
        mesh
    }

    fn push_quad(&mut self, corner: [f64; 3], u: [f64; 3], v: [f64; 3]) {
        let [corner, u, v] = [corner, u, v].map(glam::DVec3::from);
        let first = self.positions.len() as u16;
        let normal = u.cross(v).normalize();
        for (s, t) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            self.positions
                .push(single((corner + u * s + v * t).to_array()));
            self.normals.push(single(normal.to_array()));
            self.texcoords.push(single([s, 1.0 - t]));
        }
        self.indices
            .extend([0, 1, 2, 0, 2, 3].map(|k: u16| first + k));
    }

    /// The six outer faces of a parallelepiped from `corner` along a right-handed triple of edges.
    pub(crate) fn cuboid(corner: [f64; 3], edges: [[f64; 3]; 3]) -> Self {
        let mut mesh = Self::default();
        let at = glam::DVec3::from(corner);
        for k in 0..3 {
            let [u, v, w] = [0, 1, 2].map(|j| edges[(k + j) % 3]);
            mesh.push_quad(corner, v, u);
            mesh.push_quad((at + glam::DVec3::from(w)).to_array(), u, v);
        }
        mesh
    }

    /// A box with edges along the axes from its lowest to its highest corner, without the face it stands on.
    pub(crate) fn standing(low: [f64; 3], high: [f64; 3]) -> Self {
        let [x, y, z] = [0, 1, 2].map(|k| high[k] - low[k]);
        let mut mesh = Self::cuboid(low, [[0.0, 0.0, z], [x, 0.0, 0.0], [0.0, y, 0.0]]);
        // The first face of a cuboid lies across from its last edge.
        mesh.positions.drain(..4);
        mesh.normals.drain(..4);
        mesh.texcoords.drain(..4);
        mesh.indices.drain(..6);
        mesh.indices.iter_mut().for_each(|index| *index -= 4);
        mesh
    }

    /// An upright wall along every edge of an outline that lies level: the outline's y runs towards -z, and the walls
    /// face away from what it holds, from height `low` to `high`.
    pub(crate) fn rim(outline: &Outline, low: f64, high: f64) -> Self {
        let mut mesh = Self::default();
        for points in &outline.loops {
            for (k, [x0, y0]) in points.iter().enumerate() {
                let [x1, y1] = points[(k + 1) % points.len()];
                mesh.push_quad(
                    [*x0, low, -y0],
                    [x1 - x0, 0.0, y0 - y1],
                    [0.0, high - low, 0.0],
                );
            }
        }
        mesh
    }

    /// A round disc of radius 1 in the xy plane whose front faces +z, with tangents around it.
    ///
    /// Texture coordinates run around it to the right and inwards downwards.
    pub(crate) fn brushed_disc(slices: u16) -> Self {
        const HUB: f64 = 0.02;
        let mut mesh = Self::default();
        for (v, radius) in [(0.0, 1.0), (1.0, HUB)] {
            for j in 0..=slices {
                let (sin, cos) =
                    libm::sincos(std::f64::consts::TAU * f64::from(j % slices) / f64::from(slices));
                mesh.positions
                    .push(single([radius * cos, radius * sin, 0.0]));
                mesh.normals.push([0.0, 0.0, 1.0]);
                // The bitangent points up the image, which is outwards: n x t points inwards.
                mesh.tangents.push(single([-sin, cos, 0.0, -1.0]));
                mesh.texcoords
                    .push(single([f64::from(j) / f64::from(slices), v]));
            }
        }
        for j in 0..slices {
            let (a, b) = (j, j + 1);
            let [c, d] = [a, b].map(|k| k + slices + 1);
            mesh.indices.extend([a, b, d, a, d, c]);
        }
        mesh
    }

    /// The same as [`Mesh::sphere`] with tangents along its parallels.
    pub(crate) fn sphere_with_tangents(slices: u16, stacks: u16) -> Self {
        let mut mesh = Self::sphere(slices, stacks);
        for _ in 0..=stacks {
            for j in 0..=slices {
                let (sin, cos) =
                    libm::sincos(std::f64::consts::TAU * f64::from(j % slices) / f64::from(slices));
                mesh.tangents.push(single([cos, 0.0, -sin, 1.0]));
            }
        }
        mesh
    }

    /// The unit sphere with smooth normals, its poles on the y axis.
    pub(crate) fn sphere(slices: u16, stacks: u16) -> Self {
        let mut mesh = Self::default();
        for i in 0..=stacks {
            let t = f64::from(i) / f64::from(stacks);
            let (sin_polar, cos_polar) = libm::sincos(std::f64::consts::PI * t);
            for j in 0..=slices {
                let s = f64::from(j) / f64::from(slices);
                // The seam's two columns carry equal bits.
                let (sin, cos) =
                    libm::sincos(std::f64::consts::TAU * f64::from(j % slices) / f64::from(slices));
                // The poles sit on the axis exactly.
                let radius = if i == 0 || i == stacks {
                    0.0
                } else {
                    sin_polar
                };
                let p = single([radius * sin, cos_polar, radius * cos]);
                mesh.positions.push(p);
                mesh.normals.push(p);
                mesh.texcoords.push(single([s, t]));
            }
        }
        let at = |i: u16, j: u16| i * (slices + 1) + j;
        for i in 0..stacks {
            for j in 0..slices {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                if i + 1 < stacks {
                    mesh.indices.extend([a, b, c]);
                }
                if i > 0 {
                    mesh.indices.extend([a, c, d]);
                }
            }
        }
        mesh
    }
}
