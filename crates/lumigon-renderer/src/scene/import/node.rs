//! The node hierarchy to world space.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3};
use gltf::json::{self, camera::Type as CameraType, validation::Checked};

use super::{
    area_light,
    material::{Context, Materials},
    primitive::{self, Primitive},
    punctual_light,
    source::Source,
    warning::Warnings,
};
use crate::scene::{
    Camera, Limits, LoadPhase, LoadWatch, MeshSource, Projection, Scene,
    emissive::{Emitter, take_pyramids},
    error::Fault,
};

/// Draws the document's scene: its default one, else its first, else all nodes without a parent.
pub(super) fn import<'a>(
    root: &'a json::Root,
    mut source: Source<'a>,
    limits: &Limits,
    mut warnings: Warnings,
    watch: LoadWatch<'_>,
) -> Result<Scene, Fault> {
    let mut scene = Scene::default();
    let mut materials = Materials::new(limits, watch);
    let mut bytes_left = limits.mesh_bytes;
    let mut lights = LightBudget {
        limits,
        bytes_left: limits.light_image_bytes,
        watch,
    };
    let mut number = 0;
    let mut visited = vec![false; root.nodes.len()];
    let mut stack: Vec<Visit> = roots(root)?
        .into_iter()
        .rev()
        .map(|(node, user)| Visit {
            node,
            user,
            depth: 1,
            world_from_parent: DAffine3::IDENTITY,
        })
        .collect();

    while let Some(visit) = stack.pop() {
        let index = visit.node;
        let node = root.nodes.get(index).ok_or_else(|| {
            let what = format!("there is no nodes[{index}]");
            Fault::new(&visit.user, what, "use an index that exists")
        })?;
        let place = format!("nodes[{index}]");
        if std::mem::replace(&mut visited[index], true) {
            return Err(Fault::new(
                &visit.user,
                format!("{place} is reached twice: it has two parents or is its own ancestor"),
                "give every node one parent and no cycle",
            ));
        }
        if visit.depth > limits.node_depth {
            return Err(Fault::new(
                place,
                format!("nodes are nested deeper than {}", limits.node_depth),
                "flatten the hierarchy or raise the limit",
            ));
        }
        number += 1;
        watch.begin(LoadPhase::Node {
            number,
            of: root.nodes.len(),
        })?;
        let world_from_local = visit.world_from_parent * local_transform(node, &place)?;
        if !world_from_local.is_finite() {
            return Err(Fault::new(
                place,
                "its transform in the world is not finite",
                "use smaller scales and translations",
            ));
        }
        let mut context = Context {
            root,
            source: &mut source,
            warnings: &mut warnings,
        };
        if let Some(mesh) = node.mesh {
            if node.skin.is_some() {
                context
                    .warnings
                    .add("skins are not applied: meshes are drawn in their bind pose");
            }
            let primitives = primitive::import(
                &mut context,
                &mut materials,
                mesh.value(),
                &world_from_local,
                index,
                node.name.as_deref(),
                &mut bytes_left,
            )?;
            for primitive in primitives {
                lights.add(&mut scene, &materials, &mut warnings, primitive)?;
            }
        }
        let name = node.name.as_deref().unwrap_or(&place);
        if let Some(camera) = node.camera {
            scene.cameras.push(camera_of(
                root,
                camera.value(),
                name,
                &world_from_local,
                &place,
            )?);
        }
        if let Some(extensions) = &node.extensions {
            if let Some(light) = &extensions.khr_lights_punctual {
                let light = punctual_light::convert(root, light, name, &world_from_local, &place)?;
                scene.punctual_lights.push(light);
            }
            if let Some(light) = extensions.others.get("EXT_lights_area") {
                let light = area_light::convert(root, light, name, &world_from_local, &place)?;
                let mut mesh = light.mesh;
                mesh.material = materials.push(light.material);
                mesh.source = Some(MeshSource::AreaLight { node: index });
                let positions = light.positions;
                let primitive = Primitive {
                    mesh,
                    positions,
                    noise: 0.0,
                };
                lights.add(&mut scene, &materials, &mut warnings, primitive)?;
            }
        }
        let children = node.children.as_deref().unwrap_or_default();
        stack.extend(children.iter().enumerate().rev().map(|(i, child)| Visit {
            node: child.value(),
            user: format!("{place}.children[{i}]"),
            depth: visit.depth + 1,
            world_from_parent: world_from_local,
        }));
    }

    if scene.meshes.is_empty() {
        warnings.add("the scene has no triangles");
    }
    scene.materials = materials.materials;
    scene.textures = materials.textures;
    scene.warnings = warnings.into_list();
    Ok(scene)
}

struct Visit {
    node: usize,
    /// The place that names the node.
    user: String,
    depth: usize,
    world_from_parent: DAffine3,
}

/// How much the pictures of lights may take.
struct LightBudget<'a> {
    limits: &'a Limits,
    bytes_left: u64,
    watch: LoadWatch<'a>,
}

impl LightBudget<'_> {
    /// Adds a mesh and, where it emits, its polygon lights.
    fn add(
        &mut self,
        scene: &mut Scene,
        materials: &Materials<'_>,
        warnings: &mut Warnings,
        primitive: Primitive,
    ) -> Result<(), Fault> {
        let Primitive {
            mesh,
            positions,
            noise,
        } = primitive;
        if mesh.triangles.is_empty() {
            return Ok(());
        }
        let material = &materials.materials[mesh.material];
        if material.is_emissive() {
            self.watch.begin(LoadPhase::Lights {
                triangles: mesh.triangles.len(),
            })?;
            let emitter = Emitter {
                mesh: &mesh,
                index: scene.meshes.len(),
                positions: &positions,
                noise,
                material,
                textures: &materials.textures,
            };
            let emitted = emitter.polygons(self.limits.light_image_side);
            take_pyramids(&emitted.polygons, self.limits, &mut self.bytes_left)?;
            emitted
                .warnings
                .into_iter()
                .for_each(|text| warnings.add(text));
            scene.polygon_lights.extend(emitted.polygons);
        }
        scene.meshes.push(Arc::new(mesh));
        Ok(())
    }
}

/// The scene's root nodes, each with the place that names it.
fn roots(root: &json::Root) -> Result<Vec<(usize, String)>, Fault> {
    let index = root.scene.map(|scene| scene.value());
    if let Some(scene) = root.scenes.get(index.unwrap_or(0)) {
        let index = index.unwrap_or(0);
        let nodes = scene.nodes.iter().enumerate();
        return Ok(nodes
            .map(|(i, node)| (node.value(), format!("scenes[{index}].nodes[{i}]")))
            .collect());
    }
    if let Some(index) = index {
        let what = format!("there is no scenes[{index}]");
        return Err(Fault::new("scene", what, "use an index that exists"));
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root
        .nodes
        .iter()
        .filter_map(|node| node.children.as_ref())
        .flatten()
    {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    let parentless = (0..root.nodes.len()).filter(|&node| !is_child[node]);
    Ok(parentless.map(|node| (node, "nodes".to_owned())).collect())
}

fn local_transform(node: &json::Node, place: &str) -> Result<DAffine3, Fault> {
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        let last_row = matrix.row(3);
        if (last_row - glam::DVec4::W).abs().max_element() > 1e-6 {
            return Err(Fault::new(
                format!("{place}.matrix"),
                format!("its last row is {last_row}, not 0 0 0 1"),
                "write an affine matrix, column by column",
            ));
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    let vector =
        |v: Option<[f32; 3]>, default| v.map_or(default, |v| DVec3::from(v.map(f64::from)));
    let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
    let rotation = DQuat::from_array(rotation);
    // Exporters round it; one without length or with infinities rotates nothing.
    let length = rotation.length();
    let rotation = if length.is_finite() && length > 0.0 {
        rotation / length
    } else {
        DQuat::IDENTITY
    };
    Ok(DAffine3::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    ))
}

fn camera_of(
    root: &json::Root,
    index: usize,
    node_name: &str,
    world_from_local: &DAffine3,
    user: &str,
) -> Result<Camera, Fault> {
    let camera = root.cameras.get(index).ok_or_else(|| {
        let what = format!("there is no cameras[{index}]");
        Fault::new(user, what, "use an index that exists")
    })?;
    let place = format!("cameras[{index}]");
    let positive = |value: f32| value > 0.0 && value.is_finite();
    let projection = match (&camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(CameraType::Perspective), Some(perspective), _) => {
            let (yfov, aspect) = (perspective.yfov, perspective.aspect_ratio);
            if !(positive(yfov) && yfov < PI && aspect.is_none_or(positive)) {
                return Err(Fault::new(
                    place + ".perspective",
                    format!("yfov {yfov} or aspectRatio {aspect:?} is out of range"),
                    "keep 0 < yfov < π and 0 < aspectRatio",
                ));
            }
            Projection::Perspective { yfov, aspect }
        }
        (Checked::Valid(CameraType::Orthographic), _, Some(orthographic)) => {
            let (xmag, ymag) = (orthographic.xmag.abs(), orthographic.ymag.abs());
            if !(positive(xmag) && positive(ymag)) {
                return Err(Fault::new(
                    place + ".orthographic",
                    format!("xmag {xmag} or ymag {ymag} is not positive"),
                    "use positive magnifications",
                ));
            }
            Projection::Orthographic { xmag, ymag }
        }
        _ => {
            return Err(Fault::new(
                place,
                "its type is unknown or its projection is missing",
                "use perspective or orthographic, with the property of that name",
            ));
        }
    };
    let rotation = area_light::rotation(&world_from_local.matrix3).as_mat3();
    let position = world_from_local.translation.as_vec3();
    Ok(Camera {
        name: camera.name.as_deref().unwrap_or(node_name).to_owned(),
        world_from_camera: Affine3A::from_mat3_translation(rotation, position),
        projection,
    })
}
