//! Bounce light: what surfaces reflect lights others, by virtual lights.
//!
//! A cube map sees the surfaces around a point, lit by all lights at once; what each of its texels sees
//! is a small polygon that emits what it reflects. These are merged and clustered into a few virtual
//! polygon lights, which light the scene like any other. From the idea of C. Cooper, "Thoughts on VPL
//! Generation Using Cube Maps" (28 March 2013); virtual point lights are A. Keller's, "Instant
//! Radiosity" (1997), reflective shadow maps C. Dachsbacher's and M. Stamminger's (2005).

mod cells;
mod centers;
mod clusters;
mod cube_map;
mod debug_view;
mod facets;
mod footprint;
mod gather;
mod reduction;
mod targets;
mod virtual_lights;

pub use cube_map::{CubeMap, CubeTexel};
pub(crate) use facets::Facets;
pub(crate) use gather::{BounceLights, Gather, virtual_lights};
pub(crate) use targets::{LightTargets, light_places};
pub use virtual_lights::VirtualLights;
pub(crate) use virtual_lights::VirtualPoint;

/// Most texels across a face of a cube map.
pub const MAXIMUM_FACE_SIZE: u32 = 512;

/// Most virtual lights.
pub const MAXIMUM_VIRTUAL_LIGHTS: u32 = 1 << 20;

/// Most times that light is reflected before it reaches what is seen.
pub const MAXIMUM_BOUNCES: u32 = 16;

/// What finds the surfaces that light bounces off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BounceMethod {
    /// Cube maps, each lit by all lights.
    #[default]
    CubeMap,
    /// Reflective shadow maps: for each light what it sees, lit by that light alone.
    ReflectiveShadowMaps,
}

/// Where cube maps look from.
#[derive(Clone, Debug, PartialEq)]
pub enum BounceCenters {
    /// The camera.
    Camera,
    /// These points, in world space.
    Points(Vec<[f32; 3]>),
    /// As many points as this or fewer, chosen in the scene so that together they see much of its
    /// surfaces. They stay where they are when camera or lights move.
    Scene(u32),
}

impl Default for BounceCenters {
    /// Four in the scene: one cube map sees too little, and flickers as it moves.
    fn default() -> Self {
        Self::Scene(4)
    }
}

/// What stands for the surfaces that light bounces off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum VirtualLightKind {
    /// Polygons, by the exact integral.
    #[default]
    Polygon,
    /// Points that emit by the cosine, with 1/d^2 clamped: the usual practice.
    Point {
        /// Distance below which light no longer grows, in scene units; `None` for a twentieth of the
        /// scene's diagonal.
        least_distance: Option<f32>,
    },
}

/// Whether surfaces block the light of virtual lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BounceVisibility {
    /// They do not: light leaks.
    #[default]
    None,
    /// One ray to a point of each virtual light.
    Traced,
}

/// How bounce light is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct BounceSettings {
    /// How often light is reflected, at most, before it reaches the surface that is seen: 1 to
    /// [`MAXIMUM_BOUNCES`].
    pub bounces: u32,
    /// What finds the surfaces.
    pub method: BounceMethod,
    /// Where cube maps look from; reflective shadow maps look from their lights.
    pub centers: BounceCenters,
    /// Texels across a face, 1 to [`MAXIMUM_FACE_SIZE`].
    pub face_size: u32,
    /// Virtual lights at most, 1 to [`MAXIMUM_VIRTUAL_LIGHTS`]; of no effect without
    /// [`clusters`](Self::clusters).
    pub virtual_lights: u32,
    /// What they are.
    pub kind: VirtualLightKind,
    /// Whether texels of one plane become polygons with the true outlines of the surfaces; if not, they
    /// are clustered like those of curved ones, or stay what they are.
    pub merges: bool,
    /// Whether texels are brought down to as many lights as wanted; if not, merged ones stop where
    /// they are alike, and each other texel is a light.
    pub clusters: bool,
    /// Whether surfaces block virtual lights.
    pub visibility: BounceVisibility,
    /// Whether surfaces block the scene's own lights before the first bounce.
    pub shadows: bool,
}

impl Default for BounceSettings {
    fn default() -> Self {
        Self {
            bounces: 1,
            method: BounceMethod::default(),
            centers: BounceCenters::default(),
            face_size: 64,
            virtual_lights: 1024,
            kind: VirtualLightKind::default(),
            merges: true,
            clusters: true,
            visibility: BounceVisibility::default(),
            shadows: false,
        }
    }
}
