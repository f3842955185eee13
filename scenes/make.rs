//! Makes the project's own scenes, the same bytes on every run:
//! `cargo run --release --example make_scenes -p lumigon-renderer -- scenes`.
//!
//! It writes glTF 2.0 binaries and knows nothing of the renderer's own code, so the renderer is tested on
//! files, not on itself. Flat emissive faces are triangulated polygons whose front, counter-clockwise, emits.

#[path = "make/check.rs"]
mod check;
#[path = "make/cornell.rs"]
mod cornell;
#[path = "make/gallery.rs"]
mod gallery;
#[path = "make/glb.rs"]
mod glb;
#[path = "make/materials.rs"]
mod materials;
#[path = "make/mesh.rs"]
mod mesh;
#[path = "make/neon.rs"]
mod neon;
#[path = "make/outline.rs"]
mod outline;
#[path = "make/quads.rs"]
mod quads;
#[path = "make/random.rs"]
mod random;
#[path = "make/room.rs"]
mod room;
#[path = "make/rotation.rs"]
mod rotation;
#[path = "make/screens.rs"]
mod screens;
#[path = "make/stained_glass.rs"]
mod stained_glass;
#[path = "make/texture.rs"]
mod texture;
#[path = "make/two_rooms.rs"]
mod two_rooms;

use std::path::Path;
use std::process::ExitCode;

/// A scene's path below the scenes folder, and the bytes of its file.
pub(crate) type Scene = (&'static str, Vec<u8>);

/// Every scene.
pub(crate) fn scenes() -> Vec<Scene> {
    vec![
        ("gallery.glb", gallery::gallery()),
        ("cornell.glb", cornell::cornell()),
        ("materials.glb", materials::materials()),
        ("stained-glass.glb", stained_glass::stained_glass()),
        ("screens.glb", screens::screens()),
        ("neon.glb", neon::neon()),
        ("room.glb", room::room()),
        ("two-rooms.glb", two_rooms::two_rooms()),
        ("quads-10.glb", quads::quads(10)),
        ("quads-20.glb", quads::quads(20)),
        ("quads-50.glb", quads::quads(50)),
        ("quads-98.glb", quads::quads(98)),
        ("check/square.glb", check::square()),
        ("check/holes.glb", check::holes()),
        ("check/horizon.glb", check::horizon()),
        ("check/spheres.glb", check::spheres()),
    ]
}

/// Writes every scene below `folder`.
pub(crate) fn write(folder: &Path) -> std::io::Result<()> {
    for (name, bytes) in scenes() {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::write(&path, &bytes)?;
        println!("{:>9} bytes  {}", bytes.len(), path.display());
    }
    Ok(())
}

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let (Some(folder), None) = (arguments.next(), arguments.next()) else {
        eprintln!("usage: make_scenes FOLDER");
        return ExitCode::FAILURE;
    };
    match write(folder.as_ref()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!(
                "cannot write below {}: {error}",
                Path::new(&folder).display()
            );
            ExitCode::FAILURE
        }
    }
}
