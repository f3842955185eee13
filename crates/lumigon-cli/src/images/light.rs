//! The lights of the study: outlines, their images, and the same for the reference.

use lumigon::{LightImage, PolygonLight, Sides};
use lumigon_reference::{Polygon, TexelFilter, TexelGrid};
use rand::{Rng, RngExt};

use super::texture::Kind;
use crate::Failure;

/// An outline in its image's coordinates.
struct Outline {
    name: &'static str,
    loops: &'static [&'static [[f64; 2]]],
}

/// Outlines, counter-clockwise; holes clockwise.
const OUTLINES: [Outline; 4] = [
    Outline {
        name: "rectangle",
        loops: &[&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]],
    },
    Outline {
        name: "star",
        loops: &[&[
            [1.0, 0.5],
            [0.68, 0.63],
            [0.655, 0.976],
            [0.431, 0.711],
            [0.095, 0.794],
            [0.277, 0.5],
            [0.095, 0.206],
            [0.431, 0.289],
            [0.655, 0.024],
            [0.68, 0.37],
        ]],
    },
    Outline {
        name: "letter",
        loops: &[
            &[
                [0.0, 0.0],
                [0.2, 0.0],
                [0.28, 0.25],
                [0.72, 0.25],
                [0.8, 0.0],
                [1.0, 0.0],
                [0.62, 1.0],
                [0.38, 1.0],
            ],
            &[[0.35, 0.42], [0.5, 0.8], [0.65, 0.42]],
        ],
    },
    Outline {
        name: "frame",
        loops: &[
            &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            &[[0.25, 0.3], [0.25, 0.75], [0.7, 0.75], [0.7, 0.3]],
        ],
    },
];

/// Aspect ratio of the parallelogram, and how far it leans.
const FRAMES: [[f64; 2]; 3] = [[1.0, 0.0], [16.0 / 9.0, 0.0], [0.7, 0.35]];

/// A light in the plane z = 0 that shines upwards, with images of every kind. The parallelogram of
/// its images has an area of 1 and its centre at the origin.
pub(super) struct StudyLight {
    pub(super) name: &'static str,
    /// Corner and edges of its images.
    pub(super) frame: [[f64; 3]; 3],
    pub(super) light: PolygonLight<f32>,
    pub(super) reference: Polygon,
    pub(super) grid: TexelGrid,
    pub(super) images: Vec<Shown>,
}

/// One image.
pub(super) struct Shown {
    pub(super) kind: Kind,
    pub(super) image: LightImage<f32>,
    pub(super) texels: Vec<[f32; 3]>,
    /// Mean of its channels inside the outline.
    pub(super) mean: f64,
}

impl StudyLight {
    /// How many there are: every outline in every frame.
    pub(super) const COUNT: usize = OUTLINES.len() * FRAMES.len();

    /// Light `index`, with images of `size` x `size` texels, one a kind.
    pub(super) fn new(
        index: usize,
        size: usize,
        kinds: &[Kind],
        rng: &mut impl Rng,
    ) -> Result<Self, Failure> {
        let outline = &OUTLINES[index % OUTLINES.len()];
        let [aspect, lean] = FRAMES[index / OUTLINES.len() % FRAMES.len()];
        let (width, height) = (aspect.sqrt(), 1.0 / aspect.sqrt());
        let place = |[u, v]: [f64; 2]| {
            let (u, v) = (u - 0.5, v - 0.5);
            [width * u + lean * v, height * v, 0.0]
        };
        let frame = [place([0.0, 0.0]), [width, 0.0, 0.0], [lean, height, 0.0]];
        let loops: Vec<Vec<[f64; 3]>> = outline
            .loops
            .iter()
            .map(|points| points.iter().copied().map(place).collect())
            .collect();
        let light = PolygonLight::new(&loops, Sides::Front)?;
        let mut images = Vec::new();
        for &kind in kinds {
            let side = u32::try_from(size)?;
            let mut image = LightImage::new(&light, frame, [side; 2])?;
            let covered: Option<Vec<f32>> = image.coverage().map(|(shares, _)| shares.to_vec());
            let inside = |i: usize| covered.as_ref().is_none_or(|shares| shares[i] >= 1.0);
            let texels = kind.texels(size, inside, &mut *rng);
            image.filter_gaussian_levels();
            image.replace(&texels)?;
            let mean = image.mean().iter().map(|c| f64::from(*c)).sum::<f64>() / 3.0;
            images.push(Shown {
                kind,
                image,
                texels,
                mean,
            });
        }
        Ok(Self {
            name: outline.name,
            frame,
            light: light.cast()?,
            reference: Polygon::new(&loops, false)?,
            grid: TexelGrid::new(frame, [size; 2], TexelFilter::Bilinear)?,
            images,
        })
    }

    /// A random point of the parallelogram, or up to a fifth beside it.
    pub(super) fn target(&self, rng: &mut impl Rng) -> [f64; 3] {
        let [corner, u, v] = self.frame;
        let [s, t] = [(); 2].map(|()| rng.random_range(-0.2..1.2));
        std::array::from_fn(|i| corner[i] + u[i] * s + v[i] * t)
    }
}
