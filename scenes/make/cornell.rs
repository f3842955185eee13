//! The Cornell box: the measured geometry of Cornell University's program of computer graphics
//! (<https://www.graphics.cornell.edu/online/box/data.html>, in millimetres there), in metres, with the
//! reflectances in linear RGB that renderers have come to share. Every surface is diffuse.

use super::glb::{Glb, Node};
use super::mesh::Mesh;
use super::rotation::facing;
use glam::DVec3;

/// A block of the given height over a parallelogram: a corner of its foot and that corner's two neighbours.
fn block(foot: [[f64; 2]; 3], height: f64) -> Mesh {
    let [corner, u, v] = foot.map(|[x, z]| DVec3::new(x, 0.0, z) / 1000.0);
    let edges = [
        v - corner,
        u - corner,
        DVec3::new(0.0, height / 1000.0, 0.0),
    ];
    // The triple is right-handed with the up edge last exactly if u x v points up.
    let [a, b, up] = edges;
    let edges = if a.cross(b).y > 0.0 {
        [a, b, up]
    } else {
        [b, a, up]
    };
    Mesh::cuboid(corner.to_array(), edges.map(|e| e.to_array()))
}

pub(crate) fn cornell() -> Vec<u8> {
    const X: f64 = 0.5528;
    const Y: f64 = 0.5488;
    const Z: f64 = 0.5592;
    let mut glb = Glb::new();
    let white = glb.surface("white", [0.725, 0.71, 0.68], 0.0, 1.0);
    let red = glb.surface("red", [0.63, 0.065, 0.05], 0.0, 1.0);
    let green = glb.surface("green", [0.14, 0.45, 0.091], 0.0, 1.0);
    let light = glb.emitter("light", [17.0, 12.0, 4.0], false);

    // The lamp hangs half a millimetre below the ceiling, so that no surface coincides with it.
    let pieces = [
        (
            "floor",
            Mesh::quad([0.0, 0.0, 0.0], [0.0, 0.0, Z], [X, 0.0, 0.0]),
            white,
        ),
        (
            "ceiling",
            Mesh::quad([0.0, Y, 0.0], [X, 0.0, 0.0], [0.0, 0.0, Z]),
            white,
        ),
        (
            "back wall",
            Mesh::quad([X, 0.0, Z], [-X, 0.0, 0.0], [0.0, Y, 0.0]),
            white,
        ),
        (
            "red wall",
            Mesh::quad([X, 0.0, 0.0], [0.0, 0.0, Z], [0.0, Y, 0.0]),
            red,
        ),
        (
            "green wall",
            Mesh::quad([0.0, 0.0, Z], [0.0, 0.0, -Z], [0.0, Y, 0.0]),
            green,
        ),
        (
            "short block",
            block([[130.0, 65.0], [82.0, 225.0], [290.0, 114.0]], 165.0),
            white,
        ),
        (
            "tall block",
            block([[423.0, 247.0], [265.0, 296.0], [472.0, 406.0]], 330.0),
            white,
        ),
        (
            "lamp",
            Mesh::quad(
                [0.213, Y - 0.0005, 0.227],
                [0.130, 0.0, 0.0],
                [0.0, 0.0, 0.105],
            ),
            light,
        ),
    ];
    for (name, mesh, material) in &pieces {
        let geometry = glb.geometry(mesh);
        let mesh = glb.mesh(name, &geometry, *material);
        glb.root(Node::new(name).mesh(mesh));
    }

    // A film 25 mm high behind a lens of 35 mm.
    let camera = glb.camera(1.0, 2.0 * libm::atan(0.0125 / 0.035));
    glb.root(
        Node::new("camera")
            .camera(camera)
            .translation([0.278, 0.273, -0.8])
            .rotation(facing(DVec3::NEG_Z)),
    );
    glb.finish()
}
