//! Images on lights.

use std::path::Path;
use std::sync::Arc;

use glam::{DAffine2, DMat2, DVec2};
use lumigon_renderer::{
    ImageFile, Limits, Sampler, SceneError, Texture, Wrap, decode_image, read_image,
};

use super::Light;
use super::light::{quarter_turn, quarters_upright};

/// An image where it lies on a light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightPicture {
    /// Which image.
    pub image: PictureImage,
    /// From metres in the light's plane to texture coordinates: (0, 0) is the image's upper left
    /// corner, (1, 1) its lower right one.
    pub texture_from_plane: DAffine2,
}

/// Where a light's image comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum PictureImage {
    /// The scene's own: an index into [`lumigon_renderer::Scene::textures`].
    Scene(usize),
    /// A file that was put on it.
    File(Arc<PictureFile>),
}

/// An image file as it was read, kept whole so that it is saved as it came.
#[derive(Debug)]
pub struct PictureFile {
    /// The file's name without its folder.
    pub name: String,
    /// The file: PNG, JPEG, Radiance HDR or EXR.
    pub bytes: Vec<u8>,
    /// What it says.
    pub image: ImageFile,
}

impl PartialEq for PictureFile {
    fn eq(&self, other: &Self) -> bool {
        // The same bytes say the same.
        std::ptr::eq(self, other) || (self.name == other.name && self.bytes == other.bytes)
    }
}

/// How an image fills a light's bounding box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureFit {
    /// Its proportions are kept; what hangs over on two sides is not shown.
    #[default]
    Cropped,
    /// All of it is shown, drawn out to the box.
    Stretched,
}

impl PictureFile {
    /// Reads an image file.
    ///
    /// # Errors
    /// A [`SceneError`] that names the file, what is wrong with it, and the mend.
    pub fn read(path: &Path, limits: &Limits) -> Result<Arc<Self>, SceneError> {
        // First with its limits; then its bytes for saving.
        let image = read_image(path, limits)?;
        let bytes = std::fs::read(path).map_err(|fault| SceneError {
            path: path.display().to_string(),
            place: "file".to_owned(),
            what: format!("cannot be read: {fault}"),
            mend: "give a file that can be read".to_owned(),
        })?;
        let name = path.file_name().unwrap_or(path.as_os_str());
        Ok(Arc::new(Self {
            name: name.to_string_lossy().into_owned(),
            bytes,
            image,
        }))
    }

    /// From a file's bytes; `name` stands for it in errors.
    ///
    /// # Errors
    /// As [`PictureFile::read`].
    pub fn from_bytes(
        name: &str,
        bytes: Vec<u8>,
        limits: &Limits,
    ) -> Result<Arc<Self>, SceneError> {
        let image = decode_image(&bytes, name, limits)?;
        Ok(Arc::new(Self {
            name: name.to_owned(),
            bytes,
            image,
        }))
    }

    /// Its texture on a light: shown once, its border going on beyond.
    pub(super) fn texture(&self) -> Texture {
        let sampler = Sampler {
            wrap_s: Wrap::ClampToEdge,
            wrap_t: Wrap::ClampToEdge,
            ..Sampler::default()
        };
        let mut texture = self.image.texture(true, sampler);
        texture.name.clone_from(&self.name);
        texture
    }
}

impl Light {
    /// The light with an image on the bounding box of its outline, upright as seen from its front, in
    /// the place of the one it had. Its radiance multiplies the image.
    #[must_use]
    pub fn with_picture(&self, file: &Arc<PictureFile>, fit: PictureFit) -> Self {
        let quarters = quarters_upright(self.world_from_plane.matrix3);
        // Coordinates whose y points up, then right and down over the box.
        let upright_from_plane = quarter_turn(4 - quarters);
        let points = self.loops.iter().flatten().map(|&p| upright_from_plane * p);
        let (low, high) = points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        let mut extent = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        let center = (low + high) * 0.5;
        if fit == PictureFit::Cropped {
            let [width, height] = file.image.size.map(f64::from);
            let metres = (extent.x / width).max(extent.y / height);
            extent = DVec2::new(width, height) * metres;
        }
        let texture_from_upright = DAffine2 {
            matrix2: DMat2::from_diagonal(DVec2::new(1.0 / extent.x, -1.0 / extent.y)),
            translation: DVec2::new(0.5 - center.x / extent.x, 0.5 + center.y / extent.y),
        };
        let mut light = self.clone();
        light.picture = Some(LightPicture {
            image: PictureImage::File(Arc::clone(file)),
            texture_from_plane: texture_from_upright * DAffine2::from_mat2(upright_from_plane),
        });
        light
    }

    /// The light without an image: one colour, `radiance`.
    #[must_use]
    pub fn without_picture(&self) -> Self {
        let mut light = self.clone();
        light.picture = None;
        light
    }
}
