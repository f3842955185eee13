//! What the document remembers besides the scene: how it is lit and shown.

use lumigon::{DiffuseMethod, ImageMethod, SpecularMethod};
use lumigon_renderer::{BounceSettings, RenderSettings, ToneMap};

/// The methods that light one picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Look {
    pub(crate) diffuse: DiffuseMethod,
    pub(crate) specular: SpecularMethod,
    pub(crate) images: ImageMethod,
    /// See [`RenderSettings::light_bound`].
    pub(crate) light_bound: f32,
    pub(crate) bounce: Option<BounceSettings>,
}

impl Look {
    pub(crate) fn render_settings(
        &self,
        [width, height]: [u32; 2],
        samples: u32,
    ) -> RenderSettings {
        RenderSettings {
            width,
            height,
            samples,
            diffuse: self.diffuse,
            specular: self.specular,
            image_method: self.images,
            light_bound: self.light_bound,
            ..RenderSettings::default()
        }
    }
}

/// What a side of the window shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Content {
    /// The scene, lit by the side's methods.
    #[default]
    Picture,
    /// The path-traced truth, as far as it has come.
    Reference,
    /// The picture's difference from the truth, as colours.
    Error,
    /// What the truth may still be off by, relative to it.
    Noise,
    /// How many lights are computed at each pixel.
    LightCounts,
}

impl Content {
    pub(crate) const ALL: [Self; 5] = [
        Self::Picture,
        Self::Reference,
        Self::Error,
        Self::Noise,
        Self::LightCounts,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Picture => "Picture",
            Self::Reference => "Reference",
            Self::Error => "Error",
            Self::Noise => "Noise",
            Self::LightCounts => "Lights per pixel",
        }
    }

    pub(crate) fn help(self) -> &'static str {
        match self {
            Self::Picture => "The scene, lit by this side's methods",
            Self::Reference => "The path-traced truth, converging while nothing moves",
            Self::Error => {
                "This side's methods against the truth: red where too bright, blue where too dark"
            }
            Self::Noise => {
                "What the truth may still be off by: its standard error over its brightness"
            }
            Self::LightCounts => "How many lights each pixel computes",
        }
    }

    /// Whether the truth is needed for it.
    pub(crate) fn needs_reference(self) -> bool {
        matches!(self, Self::Reference | Self::Error | Self::Noise)
    }
}

/// One side of the window.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Side {
    pub(crate) content: Content,
    pub(crate) look: Look,
}

/// All of it. Changes can be undone like edits of lights.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Settings {
    /// The left one, or the only one; then the right one.
    pub(crate) sides: [Side; 2],
    /// Whether there are two.
    pub(crate) is_split: bool,
    /// Stops.
    pub(crate) exposure: f32,
    pub(crate) tone_map: ToneMap,
    /// Whether surfaces block light in the truth. The methods' light is not blocked.
    pub(crate) reference_shadows: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            sides: Default::default(),
            is_split: false,
            exposure: 0.0,
            tone_map: ToneMap::default(),
            reference_shadows: false,
        }
    }
}

impl Settings {
    /// The sides that are shown.
    pub(crate) fn shown(&self) -> &[Side] {
        &self.sides[..if self.is_split { 2 } else { 1 }]
    }

    pub(crate) fn needs_reference(&self) -> bool {
        self.shown()
            .iter()
            .any(|side| side.content.needs_reference())
    }

    /// How often light is scattered in the truth that the pictures stand for.
    pub(crate) fn reference_bounces(&self) -> u32 {
        let bounces = |side: &Side| side.look.bounce.as_ref().map_or(0, |bounce| bounce.bounces);
        1 + self.shown().iter().map(bounces).max().unwrap_or(0)
    }
}
