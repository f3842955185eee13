use glam::DVec3;
use lumigon_renderer::Scene;

use super::*;

fn scenes() -> std::path::PathBuf {
    std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn scene(name: &str) -> Scene {
    Scene::load(scenes().join(name)).unwrap()
}

#[test]
fn a_moved_light_has_its_own_mesh_and_undo_brings_the_scene_back() {
    let scene = scene("cornell.glb");
    let mut document: Document = Document::new(scene.clone());
    let ids: Vec<LightId> = document.ids().collect();
    let id = ids[0];
    let light = document.light(id).unwrap().moved(DVec3::new(0.1, 0.0, 0.0));
    document.set_light(id, light).unwrap();
    assert_eq!(document.scene().meshes.len(), scene.meshes.len() + 1);
    assert_eq!(
        document.scene().polygon_lights.len(),
        scene.polygon_lights.len()
    );
    assert!(!document.is_saved());
    assert_eq!(document.undo().as_deref(), Some("edit light"));
    assert_eq!(**document.scene(), scene);
    assert!(document.is_saved());
}
