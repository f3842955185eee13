//! Small scenes for the golden pictures: each shows one thing.

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::outline::Outline;
use super::rotation::{facing, looking};
use glam::DVec3;

/// A square camera at `eye` that looks at `target`.
fn camera(glb: &mut Glb, eye: [f64; 3], target: [f64; 3]) {
    let camera = glb.camera(1.0, 45_f64.to_radians());
    glb.root(
        Node::new("camera")
            .camera(camera)
            .translation(eye)
            .rotation(looking(eye.into(), target.into())),
    );
}

/// A square floor about the origin.
fn floor(glb: &mut Glb, perceptual_roughness: f64) {
    let material = glb.surface("floor", [0.6, 0.6, 0.6], 0.0, perceptual_roughness);
    let geometry = glb.geometry(&Mesh::quad(
        [-4.0, 0.0, 4.0],
        [8.0, 0.0, 0.0],
        [0.0, 0.0, -8.0],
    ));
    let mesh = glb.mesh("floor", &geometry, material);
    glb.root(Node::new("floor").mesh(mesh));
}

/// A one-sided light of this outline at `position`, emitting along `direction`.
fn light(
    glb: &mut Glb,
    outline: &Outline,
    radiance: [f64; 3],
    position: [f64; 3],
    direction: [f64; 3],
) {
    let material = glb.emitter("light", radiance, false);
    let geometry = glb.geometry(&Mesh::polygon(outline));
    let mesh = glb.mesh("light", &geometry, material);
    glb.root(
        Node::new("light")
            .mesh(mesh)
            .translation(position)
            .rotation(facing(direction.into())),
    );
}

/// A square light that leans over a glossy floor.
pub(crate) fn square() -> Vec<u8> {
    let mut glb = Glb::new();
    floor(&mut glb, 0.35);
    let outline = Outline::rectangle(1.2, 1.2);
    light(
        &mut glb,
        &outline,
        [5.0, 4.0, 3.0],
        [0.0, 1.0, -1.2],
        [0.0, -0.35, 1.0],
    );
    camera(&mut glb, [0.0, 1.8, 4.6], [0.0, 0.55, 0.0]);
    glb.finish()
}

/// A light with two holes, near the floor so that they print on it.
pub(crate) fn holes() -> Vec<u8> {
    let mut glb = Glb::new();
    floor(&mut glb, 0.3);
    let outline = Outline::window(
        2.4,
        1.4,
        &[[-0.95, -0.45, -0.15, 0.45], [0.2, -0.3, 0.9, 0.5]],
    );
    light(
        &mut glb,
        &outline,
        [3.0, 4.0, 5.0],
        [0.0, 0.9, -1.2],
        [0.0, -0.3, 1.0],
    );
    camera(&mut glb, [0.0, 1.8, 4.6], [0.0, 0.55, 0.0]);
    glb.finish()
}

/// A leaning light partly sunk into the floor, whose plane clips it.
pub(crate) fn horizon() -> Vec<u8> {
    let mut glb = Glb::new();
    floor(&mut glb, 0.4);
    let outline = Outline::star(5, 1.3, 0.6);
    light(
        &mut glb,
        &outline,
        [5.0, 2.5, 1.5],
        [0.0, 0.3, -0.9],
        [0.2, 0.25, 1.0],
    );
    camera(&mut glb, [0.0, 1.8, 4.6], [0.0, 0.4, 0.0]);
    glb.finish()
}

/// Five spheres of rising roughness, every other one a metal, under one quad.
pub(crate) fn spheres() -> Vec<u8> {
    let mut glb = Glb::new();
    let sphere = glb.geometry(&Mesh::sphere(24, 12));
    for (k, perceptual_roughness) in [0.1, 0.325, 0.55, 0.775, 1.0].into_iter().enumerate() {
        let metallic = if k % 2 == 0 { 1.0 } else { 0.0 };
        let name = format!("sphere {k}");
        let material = glb.surface(&name, [0.9, 0.65, 0.4], metallic, perceptual_roughness);
        let mesh = glb.mesh(&name, &sphere, material);
        glb.root(
            Node::new(&name)
                .mesh(mesh)
                .translation([k as f64 - 2.0, 0.0, 0.0])
                .scale([0.48; 3]),
        );
    }
    let outline = Outline::rectangle(4.0, 2.4);
    light(
        &mut glb,
        &outline,
        [6.0, 6.0, 6.0],
        [-0.5, 2.2, 1.6],
        DVec3::new(0.15, -1.0, -0.6).to_array(),
    );
    camera(&mut glb, [0.0, 1.0, 6.4], [0.0, 0.15, 0.0]);
    glb.finish()
}
