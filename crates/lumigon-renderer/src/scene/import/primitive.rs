//! Primitives to world-space triangles.

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3, Vec4};
use gltf::json::{
    self,
    mesh::{Mode, Primitive as JsonPrimitive, Semantic},
    validation::Checked,
};

use super::{
    accessor::Reader,
    material::{Context, Materials},
};
use crate::scene::{Mesh, MeshSource, error::Fault};

/// The largest world coordinate in metres. Six times the distance to the Sun, and yet the surface
/// areas that the rays' hierarchy adds up stay far below the end of f32.
const FARTHEST: f32 = 1e12;

/// A mesh in world space, and its positions before they were rounded to f32.
pub(super) struct Primitive {
    pub(super) mesh: Mesh,
    pub(super) positions: Vec<DVec3>,
    /// How far rounding in the file may have moved a position, in metres.
    pub(super) noise: f64,
}

/// All primitives of one mesh that draw triangles, placed by one node.
#[allow(
    clippy::too_many_arguments,
    reason = "one caller, each a different thing"
)]
pub(super) fn import(
    context: &mut Context<'_, '_>,
    materials: &mut Materials<'_>,
    mesh_index: usize,
    world_from_local: &DAffine3,
    node_index: usize,
    node_name: Option<&str>,
    bytes_left: &mut u64,
) -> Result<Vec<Primitive>, Fault> {
    let root = context.root;
    let mesh = root.meshes.get(mesh_index).ok_or_else(|| {
        let what = format!("there is no meshes[{mesh_index}]");
        let user = format!("nodes[{node_index}]");
        Fault::new(user, what, "use an index that exists")
    })?;
    let mut primitives = Vec::new();
    for (i, primitive) in mesh.primitives.iter().enumerate() {
        let place = format!("meshes[{mesh_index}].primitives[{i}]");
        let Some(local) = Local::read(context, primitive, &place, *bytes_left)? else {
            continue;
        };
        *bytes_left = bytes_left.checked_sub(local.bytes()).ok_or_else(|| {
            Fault::new(
                &place,
                format!("it passes the limit for meshes, of which {bytes_left} bytes are left"),
                "draw fewer triangles or instances, or raise the limit",
            )
        })?;
        let material = primitive.material.map(|material| material.value());
        let material = materials.get(context, material, &place)?;
        let names = [node_name, mesh.name.as_deref()].into_iter().flatten();
        let mut name = names.collect::<Vec<_>>().join("/");
        if name.is_empty() {
            name = format!("meshes[{mesh_index}]");
        }
        if mesh.primitives.len() > 1 {
            name = format!("{name}[{i}]");
        }
        let unshared = local.normals.is_none();
        let mut placed = local.place(name, material, world_from_local, &place)?;
        placed.mesh.source = Some(MeshSource::Primitive {
            node: node_index,
            mesh: mesh_index,
            primitive: i,
            mirrored: is_mirrored(world_from_local),
            unshared,
        });
        primitives.push(placed);
    }
    Ok(primitives)
}

/// A primitive in the space of its node, straight from the accessors.
struct Local {
    positions: Vec<[f32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    tangents: Option<Vec<[f32; 4]>>,
    texcoords: [Option<Vec<[f32; 2]>>; 2],
    colors: Option<Vec<[f32; 4]>>,
    triangles: Vec<[u32; 3]>,
}

impl Local {
    /// `None` where the primitive draws no triangles.
    fn read(
        context: &mut Context<'_, '_>,
        primitive: &JsonPrimitive,
        place: &str,
        limit: u64,
    ) -> Result<Option<Self>, Fault> {
        let Checked::Valid(mode) = primitive.mode else {
            return Err(Fault::new(
                format!("{place}.mode"),
                "this is not one of glTF's modes",
                "use an integer from 0 to 6",
            ));
        };
        if !matches!(
            mode,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            context.warnings.add("points and lines are not drawn");
            return Ok(None);
        }
        if primitive
            .targets
            .as_ref()
            .is_some_and(|targets| !targets.is_empty())
        {
            context.warnings.add("morph targets are not applied");
        }
        let accessor = |semantic: Semantic| {
            let attribute = primitive.attributes.get(&Checked::Valid(semantic));
            attribute.map(json::Index::value)
        };
        let Some(position) = accessor(Semantic::Positions) else {
            context
                .warnings
                .add("primitives without POSITION are not drawn");
            return Ok(None);
        };
        let mut reader = Reader {
            root: context.root,
            source: context.source,
            limit,
        };
        let user = |name: &str| format!("{place}.attributes.{name}");
        let positions = reader.floats::<3>(position, &user("POSITION"), false)?;
        let count = positions.len();
        let normals = accessor(Semantic::Normals)
            .map(|index| reader.attribute::<3>(index, &user("NORMAL"), count))
            .transpose()?;
        // Tangents mean nothing without the normals they stand on.
        let tangents = accessor(Semantic::Tangents)
            .filter(|_| normals.is_some())
            .map(|index| reader.attribute::<4>(index, &user("TANGENT"), count))
            .transpose()?;
        let mut texcoord = |set: u32| {
            let name = format!("TEXCOORD_{set}");
            accessor(Semantic::TexCoords(set))
                .map(|index| reader.attribute::<2>(index, &user(&name), count))
                .transpose()
        };
        let texcoords = [texcoord(0)?, texcoord(1)?];
        let colors = accessor(Semantic::Colors(0))
            .map(|index| reader.attribute::<4>(index, &user("COLOR_0"), count))
            .transpose()?;
        let indices = match primitive.indices {
            Some(index) => reader.indices(index.value(), &format!("{place}.indices"))?,
            None => (0..u32::try_from(count).unwrap_or(u32::MAX)).collect(),
        };
        if let Some(&index) = indices.iter().find(|&&index| index as usize >= count) {
            return Err(Fault::new(
                format!("{place}.indices"),
                format!("index {index} of {count} vertices"),
                "keep indices below the number of vertices",
            ));
        }
        let triangles = triangles(&indices, mode);
        Ok(Some(Self {
            positions,
            normals,
            tangents,
            texcoords,
            colors,
            triangles,
        }))
    }

    /// Bytes of the finished mesh and of the f64 positions that go with it for a while.
    fn bytes(&self) -> u64 {
        let triangles = self.triangles.len() as u64;
        let vertices = match self.normals {
            Some(_) => self.positions.len() as u64,
            None => 3 * triangles,
        };
        let texcoords = self.texcoords.iter().flatten().count() as u64;
        let vectors = u64::from(self.tangents.is_some()) + u64::from(self.colors.is_some());
        vertices * (24 + 24 + 8 * texcoords + 16 * vectors) + triangles * 12
    }

    fn place(
        mut self,
        name: String,
        material: usize,
        world_from_local: &DAffine3,
        place: &str,
    ) -> Result<Primitive, Fault> {
        if self.normals.is_none() {
            self.unshare();
        }
        let mirrored = is_mirrored(world_from_local);
        let positions: Vec<DVec3> = self
            .positions
            .iter()
            .map(|&p| world_from_local.transform_point3(DVec3::from(p.map(f64::from))))
            .collect();
        // Half a unit in the last place of the largest coordinate, as large as the world makes it.
        let matrix = &world_from_local.matrix3;
        let scale = matrix.x_axis.length() + matrix.y_axis.length() + matrix.z_axis.length();
        let largest = self
            .positions
            .as_flattened()
            .iter()
            .fold(0.0, |m: f32, x| m.max(x.abs()));
        let noise = f64::from(largest) * f64::from(f32::EPSILON) * 0.5 * scale;
        let rounded: Vec<Vec3> = positions.iter().map(|p| p.as_vec3()).collect();
        let within = |p: &Vec3| p.abs().max_element() <= FARTHEST;
        if let Some(vertex) = rounded.iter().position(|p| !(p.is_finite() && within(p))) {
            return Err(Fault::new(
                format!("{place}.attributes.POSITION"),
                format!(
                    "vertex {vertex} is at {} in the world, which is not finite or beyond {FARTHEST:e} m",
                    rounded[vertex]
                ),
                "use finite positions and transforms, in metres",
            ));
        }
        // Where a mirror turns triangles over, they are turned back.
        let mut triangles = self.triangles;
        if mirrored {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        triangles.retain(|t| has_area(t.map(|i| rounded[i as usize])));

        let normals = match &self.normals {
            Some(normals) => {
                placed_normals(normals, &rounded, &triangles, &world_from_local.matrix3)
            }
            None => flat_normals(&rounded, &triangles),
        };
        let finite = |v: &[f32]| v.iter().all(|x| x.is_finite());
        let tangents = self.tangents.map(|tangents| {
            let sign = if mirrored { -1.0 } else { 1.0 };
            let place = |&[x, y, z, w]: &[f32; 4]| {
                let tangent = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                let tangent = (world_from_local.matrix3 * tangent)
                    .normalize_or_zero()
                    .as_vec3();
                // Exporters write NaN where texture coordinates degenerate; 0 means no tangent.
                if finite(&[x, y, z, w]) {
                    tangent.extend(w * sign)
                } else {
                    Vec4::ZERO
                }
            };
            tangents.iter().map(place).collect()
        });
        let texcoords = self.texcoords.map(|set| {
            let place = |uv: &[f32; 2]| {
                if finite(uv) {
                    Vec2::from(*uv)
                } else {
                    Vec2::ZERO
                }
            };
            set.iter().flatten().map(place).collect()
        });
        let place_color = |c: &[f32; 4]| {
            let color = if finite(c) { Vec4::from(*c) } else { Vec4::ONE };
            color.clamp(Vec4::ZERO, Vec4::ONE)
        };
        let mesh = Mesh {
            name,
            material,
            positions: rounded,
            normals,
            tangents: tangents.unwrap_or_default(),
            texcoords,
            colors: self.colors.iter().flatten().map(place_color).collect(),
            triangles,
            source: None,
        };
        Ok(Primitive {
            mesh,
            positions,
            noise,
        })
    }

    /// Gives every triangle vertices of its own, so that it can have a flat normal.
    fn unshare(&mut self) {
        fn gather<T: Copy>(values: &mut Vec<T>, corners: &[u32]) {
            *values = corners.iter().map(|&i| values[i as usize]).collect();
        }
        let corners = self.triangles.as_flattened();
        gather(&mut self.positions, corners);
        self.texcoords
            .iter_mut()
            .flatten()
            .for_each(|set| gather(set, corners));
        self.colors
            .iter_mut()
            .for_each(|colors| gather(colors, corners));
        let count = self.triangles.len() as u32;
        self.triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    }
}

impl Reader<'_, '_> {
    /// An attribute that must have as many elements as there are positions.
    fn attribute<const N: usize>(
        &mut self,
        index: usize,
        user: &str,
        count: usize,
    ) -> Result<Vec<[f32; N]>, Fault> {
        // Colours come with or without alpha.
        let values = self.floats::<N>(index, user, user.ends_with("COLOR_0"))?;
        if values.len() == count {
            return Ok(values);
        }
        let what = format!("{} elements for {count} positions", values.len());
        Err(Fault::new(user, what, "give every vertex one element"))
    }
}

/// The triangles of a primitive as its file has them, the corners in the file's order and by its
/// indices; none where it draws no triangles.
pub(super) fn file_triangles(
    reader: &mut Reader<'_, '_>,
    mesh: usize,
    primitive: usize,
) -> Result<Vec<[u32; 3]>, Fault> {
    let place = format!("meshes[{mesh}].primitives[{primitive}]");
    let found = reader.root.meshes.get(mesh);
    let found = found.and_then(|mesh| mesh.primitives.get(primitive));
    let found = found.ok_or_else(|| {
        Fault::new(
            &place,
            "there is no such primitive",
            "use an index that exists",
        )
    })?;
    let Checked::Valid(mode) = found.mode else {
        return Ok(Vec::new());
    };
    let indices = match found.indices {
        Some(index) => reader.indices(index.value(), &format!("{place}.indices"))?,
        None => {
            let positions = found.attributes.get(&Checked::Valid(Semantic::Positions));
            let accessor = positions.and_then(|index| reader.root.accessors.get(index.value()));
            let count = accessor.map_or(0, |accessor| accessor.count.0);
            (0..u32::try_from(count).unwrap_or(u32::MAX)).collect()
        }
    };
    Ok(triangles(&indices, mode))
}

fn is_mirrored(world_from_local: &DAffine3) -> bool {
    world_from_local.matrix3.determinant() < 0.0
}

/// Triangles of a list, strip or fan, all with the winding of the first.
fn triangles(indices: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| {
                if i % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[0], w[2], w[1]]
                }
            })
            .collect(),
        Mode::TriangleFan => indices
            .get(1..)
            .unwrap_or_default()
            .windows(2)
            .map(|w| [w[0], w[1], indices[0]])
            .collect(),
        _ => indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]])
            .collect(),
    }
}

fn has_area([a, b, c]: [Vec3; 3]) -> bool {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a) != DVec3::ZERO
}

fn face_normal([a, b, c]: [Vec3; 3]) -> DVec3 {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    (b - a).cross(c - a)
}

fn flat_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::Y; positions.len()];
    for triangle in triangles {
        let normal = face_normal(triangle.map(|i| positions[i as usize])).normalize_or(DVec3::Y);
        triangle
            .iter()
            .for_each(|&i| normals[i as usize] = normal.as_vec3());
    }
    normals
}

/// Normals by the inverse transpose. Those without a direction (zero, or not finite) take that of
/// the faces around their vertex.
fn placed_normals(
    normals: &[[f32; 3]],
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    world_from_local: &DMat3,
) -> Vec<Vec3> {
    // The cofactor matrix is the inverse transpose times the determinant, and exists for flat
    // transforms too; the determinant's sign keeps normals on their side in a mirror.
    let DMat3 {
        x_axis: x,
        y_axis: y,
        z_axis: z,
    } = *world_from_local;
    let sign = if world_from_local.determinant() < 0.0 {
        -1.0
    } else {
        1.0
    };
    // Scaled first: the cofactors of a tiny or huge scale leave f64's range.
    let size = x.abs().max(y.abs()).max(z.abs()).max_element();
    let (x, y, z) = (x / size, y / size, z / size);
    let cofactor = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
    let place = |n: &[f32; 3]| {
        let normal = cofactor * DVec3::from(n.map(f64::from));
        normal.normalize_or_zero().as_vec3()
    };
    let mut placed: Vec<Vec3> = normals.iter().map(place).collect();
    if placed.contains(&Vec3::ZERO) {
        let mut around = vec![DVec3::ZERO; placed.len()];
        for triangle in triangles {
            let normal = face_normal(triangle.map(|i| positions[i as usize]));
            triangle.iter().for_each(|&i| around[i as usize] += normal);
        }
        for (normal, around) in placed.iter_mut().zip(around) {
            if *normal == Vec3::ZERO {
                *normal = around.normalize_or(DVec3::Y).as_vec3();
            }
        }
    }
    placed
}
