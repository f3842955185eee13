//! stub
use std::path::Path; use std::sync::Arc; use lumigon_renderer::*;
pub(crate) struct Loaded { pub scene: Arc<Scene>, pub source: Arc<GltfSource> }
pub(crate) struct Loading(Option<Result<Loaded, SceneError>>);
impl Loading {
 pub(crate) fn start(p: &Path, wake: Box<dyn Fn()+Send+Sync>) -> Self { let r = Scene::load_with_source(p).map(|(s, g)| Loaded{scene: Arc::new(s), source: Arc::new(g)}); wake(); Self(Some(r)) }
 pub(crate) fn gallery(wake: Box<dyn Fn()+Send+Sync>) -> Self { Self::start(Path::new("/work/main/scenes/gallery.glb"), wake) }
 pub(crate) fn take(&mut self) -> Option<Result<Loaded, SceneError>> { self.0.take() }
 pub(crate) fn phase(&self) -> String { "reading".into() }
}
