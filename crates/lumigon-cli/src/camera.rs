//! The camera that a command line asks for.

use std::path::Path;

use lumigon_renderer::{Camera, Scene};

use crate::Failure;

/// The camera of this name or number; without a wish the file's first, or one that sees everything
/// where it has none. `path` names the scene in errors.
pub(crate) fn choose_camera(
    scene: &Scene,
    path: &Path,
    wanted: Option<&str>,
) -> Result<Camera, Failure> {
    let Some(wanted) = wanted else {
        let first = scene.cameras.first().cloned();
        return Ok(first.unwrap_or_else(|| Camera::framing(scene)));
    };
    let by_name = scene.cameras.iter().find(|camera| camera.name == wanted);
    let by_index = || scene.cameras.get(wanted.parse::<usize>().ok()?);
    by_name.or_else(by_index).cloned().ok_or_else(|| {
        let names: Vec<_> = scene
            .cameras
            .iter()
            .enumerate()
            .map(|(index, camera)| format!("{index} {:?}", camera.name))
            .collect();
        let there_are = match names.is_empty() {
            true => "it has none; leave --camera out".to_owned(),
            false => format!("it has {}", names.join(", ")),
        };
        let scene = path.display();
        format!("{scene}: there is no camera {wanted:?}: {there_are}").into()
    })
}
