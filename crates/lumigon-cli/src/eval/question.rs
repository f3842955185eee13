//! Questions: what a line asks, and why it cannot be answered.

use lumigon::{ImageMethod, LightImage, MINIMUM_ALPHA, PolygonLight, Scalar};
use serde::Deserialize;

use crate::method::{Basis, Images, Occlusion};

/// Directions may be this far from unit length; they are normalised.
const UNIT_TOLERANCE: f64 = 1e-3;

/// What a line asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Quantity {
    Irradiance,
    FormFactor,
    LightVector,
    SolidAngle,
    ProjectedArea,
    Ltc,
    ReflectedInclusion,
    ReflectedDistance,
    Ggx,
    GgxAnisotropic,
    Charlie,
    Eon,
}

/// A table that `ltc` looks up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TableName {
    Ggx,
    Ggx2,
    GgxAnisotropic,
    Charlie,
    Eon,
}

impl TableName {
    const ALL: [(&str, Self); 5] = [
        ("ggx", Self::Ggx),
        ("ggx-2", Self::Ggx2),
        ("ggx-anisotropic", Self::GgxAnisotropic),
        ("charlie", Self::Charlie),
        ("eon", Self::Eon),
    ];
}

/// A line, parsed. Fields it has besides are ignored.
#[derive(Debug, Deserialize)]
pub(super) struct Question {
    pub(super) quantity: Quantity,
    pub(super) loops: Vec<Vec<[f64; 3]>>,
    pub(super) point: [f64; 3],
    #[serde(default)]
    normal: Option<[f64; 3]>,
    #[serde(default)]
    view: Option<[f64; 3]>,
    #[serde(default)]
    perceptual_roughness: Option<f64>,
    #[serde(default)]
    anisotropy_strength: Option<f64>,
    #[serde(default)]
    tangent: Option<[f64; 3]>,
    #[serde(default)]
    sheen_perceptual_roughness: Option<f64>,
    #[serde(default)]
    diffuse_roughness: Option<f64>,
    #[serde(default)]
    table: Option<String>,
    #[serde(default)]
    pub(super) two_sided: bool,
    #[serde(default)]
    basis: Option<Basis>,
    #[serde(default)]
    bias: Option<f64>,
    #[serde(default)]
    pub(super) occlusion: Occlusion,
    #[serde(default)]
    pub(super) texture: Option<Texture>,
    #[serde(default)]
    pub(super) resolution: Option<u32>,
    #[serde(default)]
    pub(super) phi: Option<f32>,
    #[serde(default)]
    pub(super) smoothness: Option<f32>,
}

/// What the light shows.
#[derive(Debug, Deserialize)]
pub(super) struct Texture {
    /// Rows of linear RGB, the first at the corner.
    texels: Vec<Vec<[f32; 3]>>,
    /// Of the image's first texel.
    corner: [f64; 3],
    /// From there along the rows.
    edge_u: [f64; 3],
    /// From there down the columns.
    edge_v: [f64; 3],
    #[serde(default)]
    method: Images,
}

impl Texture {
    pub(super) fn method(&self) -> ImageMethod {
        self.method.into()
    }

    /// The image, prepared.
    pub(super) fn image<S: Scalar>(
        &self,
        light: &PolygonLight<f64>,
    ) -> Result<LightImage<S>, QuestionError> {
        let width = self.texels.first().map_or(0, Vec::len);
        if let Some(row) = self.texels.iter().position(|row| row.len() != width) {
            return Err(QuestionError::Ragged {
                row,
                count: self.texels[row].len(),
                expected: width,
            });
        }
        let side = |length| u32::try_from(length).unwrap_or(u32::MAX);
        let size = [side(width), side(self.texels.len())];
        let frame = [self.corner, self.edge_u, self.edge_v];
        let mut image = LightImage::new(light, frame, size)?;
        image.replace(&self.texels.concat())?;
        if self.method() == ImageMethod::Lookup {
            image.filter_gaussian_levels();
        }
        Ok(image)
    }
}

/// Why a line cannot be answered.
#[derive(Debug, thiserror::Error)]
pub enum QuestionError {
    /// The bytes are not text.
    #[error("not UTF-8 text: {0}")]
    NotUtf8(std::str::Utf8Error),
    /// The line is longer than memory is kept for.
    #[error("the line is longer than {most} bytes")]
    TooLong {
        /// The most there may be.
        most: usize,
    },
    /// The line is not JSON, or not a question.
    #[error("column {column}: {message}")]
    Json {
        /// Where, counted in bytes from 1.
        column: usize,
        /// What is wrong there.
        message: String,
    },
    /// This quantity needs a field that is not there.
    #[error("missing field `{field}`: this quantity needs it")]
    Missing {
        /// Its name.
        field: &'static str,
    },
    /// A direction is not a unit vector.
    #[error("`{field}` has length {length:?}: give a unit vector")]
    NotUnit {
        /// Its name.
        field: &'static str,
        /// Its length.
        length: f64,
    },
    /// The tangent is not in the surface.
    #[error("`tangent` leans out of the surface: its product with `normal` is {product:?}, not 0")]
    NotOrthogonal {
        /// Dot product with the normal.
        product: f64,
    },
    /// There is no such table.
    #[error("`table` is {name:?}: give ggx, ggx-2, ggx-anisotropic, charlie or eon")]
    UnknownTable {
        /// What was given.
        name: String,
    },
    /// A number is outside its range.
    #[error("`{field}` is {value:?}: give {range}")]
    OutOfRange {
        /// Its name.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A row of texels is shorter or longer than the first.
    #[error("`texture`: row {row} has {count} texels, the first {expected}: give all as many")]
    Ragged {
        /// Which, from 0.
        row: usize,
        /// How many it has.
        count: usize,
        /// How many the first has.
        expected: usize,
    },
    /// The texture is no image of this light.
    #[error("`texture`: {0}")]
    Texture(#[from] lumigon::LightImageError),
    /// This quantity knows no textures.
    #[error("`texture`: this quantity is that of a uniform light; leave the texture out")]
    NoTexture,
    /// The loops are no polygon.
    #[error("`loops`: {0}")]
    Polygon(#[from] lumigon::PolygonError),
    /// The distance field cannot be baked or read so.
    #[error("{0}")]
    DistanceField(#[from] lumigon::DistanceFieldError),
    /// The loops are no polygon that cubature can integrate over.
    #[error("`loops`: {0}")]
    ReferencePolygon(#[from] lumigon_reference::PolygonError),
    /// The integral was not found.
    #[error("{0}")]
    Cubature(#[from] lumigon_reference::CubatureError),
    /// The answer overflowed.
    #[error("the answer is not finite in this precision: try f64, or move the polygon closer")]
    NotFinite,
}

impl From<serde_json::Error> for QuestionError {
    fn from(error: serde_json::Error) -> Self {
        let text = error.to_string();
        // The line of a line is always the first.
        let place = format!(" at line {} column {}", error.line(), error.column());
        Self::Json {
            column: error.column(),
            message: text.strip_suffix(&place).unwrap_or(&text).to_owned(),
        }
    }
}

impl Question {
    /// The surface's unit normal.
    pub(super) fn normal(&self) -> Result<[f64; 3], QuestionError> {
        unit("normal", self.normal)
    }

    /// The unit vector to the viewer.
    pub(super) fn view(&self) -> Result<[f64; 3], QuestionError> {
        unit("view", self.view)
    }

    /// The square root of GGX's alpha.
    pub(super) fn perceptual_roughness(&self) -> Result<f64, QuestionError> {
        fraction("perceptual_roughness", self.perceptual_roughness)
    }

    /// GGX's alpha, not below the narrowest lobe that the tables hold.
    pub(super) fn alpha(&self) -> Result<f64, QuestionError> {
        let perceptual_roughness = self.perceptual_roughness()?;
        Ok((perceptual_roughness * perceptual_roughness).max(MINIMUM_ALPHA))
    }

    /// Both alphas, along and across the tangent, as `KHR_materials_anisotropy` has them.
    pub(super) fn alphas(&self) -> Result<[f64; 2], QuestionError> {
        let alpha = self.alpha()?;
        let strength = fraction("anisotropy_strength", self.anisotropy_strength)?;
        Ok([alpha + (1.0 - alpha) * strength * strength, alpha])
    }

    /// The square root of Charlie's alpha.
    pub(super) fn sheen_perceptual_roughness(&self) -> Result<f64, QuestionError> {
        fraction(
            "sheen_perceptual_roughness",
            self.sheen_perceptual_roughness,
        )
    }

    /// EON's r.
    pub(super) fn diffuse_roughness(&self) -> Result<f64, QuestionError> {
        fraction("diffuse_roughness", self.diffuse_roughness)
    }

    /// The unit tangent, made orthogonal to the normal as far as rounding has left it oblique.
    pub(super) fn tangent(&self) -> Result<[f64; 3], QuestionError> {
        let (normal, tangent) = (self.normal()?, unit("tangent", self.tangent)?);
        let product = (0..3).map(|i| normal[i] * tangent[i]).sum::<f64>();
        if product.abs() > UNIT_TOLERANCE {
            return Err(QuestionError::NotOrthogonal { product });
        }
        let flat = std::array::from_fn(|i| tangent[i] - product * normal[i]);
        unit("tangent", Some(flat))
    }

    /// The table of `ltc`.
    pub(super) fn table(&self) -> Result<TableName, QuestionError> {
        let Some(name) = &self.table else {
            return Ok(TableName::Ggx);
        };
        let mut tables = TableName::ALL.into_iter();
        match tables.find(|(known, _)| known == name) {
            Some((_, table)) => Ok(table),
            None => Err(QuestionError::UnknownTable {
                name: name.chars().take(40).collect(),
            }),
        }
    }

    pub(super) fn basis(&self) -> Result<lumigon::ProjectionBasis, QuestionError> {
        let basis = self
            .basis
            .ok_or(QuestionError::Missing { field: "basis" })?;
        match self.bias {
            Some(value) if value < 0.0 => Err(QuestionError::OutOfRange {
                field: "bias",
                value,
                range: "0 or more",
            }),
            bias => Ok(basis.with_bias(bias)),
        }
    }
}

fn unit(field: &'static str, vector: Option<[f64; 3]>) -> Result<[f64; 3], QuestionError> {
    let vector = vector.ok_or(QuestionError::Missing { field })?;
    let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    match (length - 1.0).abs() <= UNIT_TOLERANCE {
        true => Ok(vector.map(|x| x / length)),
        false => Err(QuestionError::NotUnit { field, length }),
    }
}

fn fraction(field: &'static str, value: Option<f64>) -> Result<f64, QuestionError> {
    let value = value.ok_or(QuestionError::Missing { field })?;
    match (0.0..=1.0).contains(&value) {
        true => Ok(value),
        false => Err(QuestionError::OutOfRange {
            field,
            value,
            range: "0 to 1",
        }),
    }
}
