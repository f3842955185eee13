//! Truth to measure lumigon against, in f64 and by other means than its closed forms.
//!
//! - **Cubature**: [`irradiance`], [`form_factor`], [`light_vector`], [`solid_angle`], and the lobes [`ggx`],
//!   [`ggx_anisotropic`], [`charlie`] and [`eon`] of one polygon light at one point, to a requested [`Tolerance`], with an
//!   estimate of the error; [`ggx_albedo`] and its like for the whole hemisphere. The polygon is triangulated, clipped
//!   by the horizon and integrated adaptively over its directions. [`texel_weights`] tells what each texel of a textured
//!   light adds to such an integral, or to one over a fitted lobe.
//! - **A path tracer**: [`render`] for any [`Scene`], with the standard error of every pixel.
//!
//! Nothing here sums over edges or transforms cosines: an error shared with what is being measured is no truth.
//! Right-handed frames, any length unit, radiance in any unit; a light's outer loop runs counter-clockwise seen from
//! the side that emits, its holes clockwise.
//!
//! ```
//! use lumigon_reference::{Polygon, Tolerance, form_factor};
//!
//! // A square metre of ceiling, one metre above the point and facing down.
//! let ceiling = vec![[-0.5, -0.5, 1.0], [-0.5, 0.5, 1.0], [0.5, 0.5, 1.0], [0.5, -0.5, 1.0]];
//! let light = Polygon::new(&[ceiling], false)?;
//! let result = form_factor(&light, [0.0; 3], [0.0, 0.0, 1.0], Tolerance::default())?;
//! let exact = 4.0 / (std::f64::consts::PI * 5_f64.sqrt()) * (1.0 / 5_f64.sqrt()).atan();
//! assert!((result.value - exact).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod albedo;
mod bsdf;
mod charlie;
mod cubature;
mod emitter;
mod eon;
mod estimate;
mod frame;
mod ggx;
mod integrands;
mod lobes;
mod material;
mod path_tracer;
mod polygon;
mod quadrature;
mod sampling;
mod scene;
mod settings;
mod texel_weights;
mod texture;
mod triangulation;

pub use charlie::charlie_brdf;
pub use cubature::{
    CubatureError, EonIntegral, GgxIntegral, Integral, VectorIntegral, charlie, charlie_albedo,
    eon, eon_albedo, form_factor, ggx, ggx_albedo, ggx_anisotropic, ggx_anisotropic_albedo,
    irradiance, light_vector, solid_angle,
};
pub use emitter::Emitter;
pub use eon::{EonBrdf, eon_brdf, eon_multiple_scattering_albedo};
pub use estimate::{Channel, Estimate};
pub use ggx::{ggx_anisotropic_brdf, ggx_brdf};
pub use material::Material;
pub use path_tracer::render;
pub use polygon::{Polygon, PolygonError};
pub use quadrature::Tolerance;
pub use scene::{PunctualLight, Ray, Scene, Surface};
pub use settings::{RenderError, Settings};
pub use texel_weights::{MeanColor, TexelWeights, Weighting, texel_weights};
pub use texture::{TexelFilter, TexelGrid, Texture, TextureError};
