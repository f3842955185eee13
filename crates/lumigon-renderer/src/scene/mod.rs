//! What a glTF file says, in world space and ready to be lit.

mod camera;
mod emissive;
mod error;
mod export;
mod image_file;
mod import;
mod limits;
mod load_watch;
mod material;
mod mesh;
mod punctual;
mod surface;
mod texture;

use std::path::Path;
use std::sync::Arc;

pub use camera::{Camera, Projection};
pub use emissive::{AlphaMask, EmissiveImage, EmissivePolygon, PlacedTexture, TextureMap};
pub(crate) use emissive::{FlatFace, flat_faces};
pub use error::SceneError;
pub use export::{GltfSource, SaveError};
pub use image_file::{ImageFile, decode_image, read_image};
pub use limits::Limits;
pub use load_watch::{LoadPhase, LoadWatch};
pub use material::{AlphaMode, Material, TextureRef, TextureTransform};
pub use mesh::{Mesh, MeshSource};
pub use punctual::{PunctualKind, PunctualLight};
pub use surface::SurfaceSample;
pub use texture::{Filter, Sampler, Texture, Wrap};
pub(crate) use texture::{SRGB_TO_LINEAR, Texels};

/// A scene in world space: right-handed, Y up, metres.
///
/// Radiance is in W m⁻² sr⁻¹ or, as most glTF files mean it, in nits: nothing here depends on which.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// One mesh for each pair of node and primitive. All of its indices are in range.
    pub meshes: Vec<Arc<Mesh>>,
    /// The materials that [`Mesh::material`] indexes.
    pub materials: Vec<Material>,
    /// The textures that [`TextureRef::texture`] indexes: one for each pair of glTF texture and
    /// colour space it is used in.
    pub textures: Vec<Texture>,
    /// Cameras in the order of the nodes that carry them; empty where the file has none.
    /// See [`Camera::framing`] for such files.
    pub cameras: Vec<Camera>,
    /// The outlines of the scene's flat emissive faces: what lights it.
    pub polygon_lights: Vec<EmissivePolygon>,
    /// Point, spot and directional lights (`KHR_lights_punctual`).
    pub punctual_lights: Vec<PunctualLight>,
    /// What the file asks for and this renderer does not do, each named once.
    pub warnings: Vec<String>,
}

impl Scene {
    /// Reads a `.gltf` or `.glb` file, its buffers and its images, within [`Limits::default`].
    ///
    /// # Errors
    /// A [`SceneError`] that names the file, the place in it, and the mend.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::load_within(path, &Limits::default())
    }

    /// As [`Scene::load`], within limits of the caller's choice.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_within(path: impl AsRef<Path>, limits: &Limits) -> Result<Self, SceneError> {
        import::load(path.as_ref(), limits)
    }

    /// As [`Scene::load_within`], for scenes that will be changed and saved: the file is kept beside
    /// what was understood of it. `watch` follows the reading and can stop it.
    ///
    /// # Errors
    /// As [`Scene::load`], and where `watch` stops it.
    pub fn load_watched(
        path: impl AsRef<Path>,
        limits: &Limits,
        watch: LoadWatch<'_>,
    ) -> Result<(Self, GltfSource), SceneError> {
        import::load_watched(path.as_ref(), limits, watch)
    }

    /// As [`Scene::load_watched`], of bytes as for [`Scene::from_slice`].
    ///
    /// # Errors
    /// As [`Scene::load_watched`].
    pub fn from_slice_watched(
        bytes: &[u8],
        base_folder: Option<&Path>,
        name: &str,
        limits: &Limits,
        watch: LoadWatch<'_>,
    ) -> Result<(Self, GltfSource), SceneError> {
        import::from_slice_watched(bytes, base_folder, name, limits, watch)
    }

    /// Reads the bytes of a `.gltf` or `.glb` file within [`Limits::default`].
    ///
    /// External buffers and images are read from inside `base_folder`; without one they are
    /// refused. `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_slice(
        bytes: &[u8],
        base_folder: Option<&Path>,
        name: &str,
    ) -> Result<Self, SceneError> {
        Self::from_slice_within(bytes, base_folder, name, &Limits::default())
    }

    /// As [`Scene::from_slice`], within limits of the caller's choice.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_slice_within(
        bytes: &[u8],
        base_folder: Option<&Path>,
        name: &str,
        limits: &Limits,
    ) -> Result<Self, SceneError> {
        import::from_slice(bytes, base_folder, name, limits)
    }

    /// The smallest and largest coordinates over all triangles, or `None` where there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<(glam::Vec3, glam::Vec3)> {
        self.meshes
            .iter()
            .filter_map(|mesh| mesh.bounds())
            .reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))
    }
}
