//! Fits BRDFs with linearly transformed cosines.
//!
//! A linearly transformed cosine (Heitz, Dupuy, Hill and Neubelt 2016, "Real-time polygonal-light
//! shading with linearly transformed cosines") is the clamped cosine distribution seen through a
//! 3x3 matrix. Its integral over a polygon has a closed form, so a table of matrices that follow a
//! BRDF turns polygonal lights into exact sums. This crate makes such a [`Table`]:
//!
//! ```no_run
//! use std::{path::Path, sync::atomic::AtomicBool};
//! use lumigon_fit::{Settings, fit};
//!
//! let cancel = AtomicBool::new(false);
//! let table = fit(&Settings::default(), &|done, total| eprint!("\r{done}/{total}"), &cancel)?;
//! table.write(Path::new("tables"), "my-own-program")?;
//! # Ok::<(), lumigon_fit::FitError>(())
//! ```
//!
//! # Frame
//! Shading space: z is the surface normal; of an isotropic BRDF the view direction lies in the x-z
//! plane with x >= 0, `view = (sin theta, 0, cos theta)`. [`Ltc::shading_to_cosine`] maps this frame
//! to the space of the clamped cosine. A table stores it relative to what the BRDF tends to, its
//! [`Limit`]: a mirror's direction and width are known exactly at every point, and a table that does
//! not have to carry them is a quarter of the size and right down to `alpha = 1e-4`.
//!
//! # How a fit runs
//! Every texel is a [`Node`]: a [`Brdf`] and a view direction. An [`Objective`] turns the node into
//! residuals, a [`Parametrisation`] says which of the [`Coordinates`] may move, and
//! Levenberg-Marquardt moves them. All texels are reached from one, each starting where its
//! neighbour ended; then sweeps pull every texel softly towards a smooth table, because what counts
//! is the table *between* its nodes. A new BRDF is one file with an implementation of [`Brdf`], and
//! its axes in [`BrdfKind`]; a new objective is one of [`Objective`].

mod brdf;
mod charlie;
mod checkpoint;
mod coordinates;
mod density;
mod eon;
mod errors;
mod fit;
mod form_factor;
mod ggx;
mod grid;
mod integral;
mod kind;
mod layout;
mod least_squares;
mod limit;
mod lobe;
mod ltc;
mod manifest;
mod node;
mod objective;
mod polygon;
mod polynomial;
mod settings;
mod symmetric;
mod table;

pub use brdf::{Brdf, LightSample};
pub use charlie::Charlie;
pub use checkpoint::Checkpoint;
pub use coordinates::{Coordinates, Parametrisation};
pub use density::Density;
pub use eon::Eon;
pub use errors::ErrorReport;
pub use fit::{Fit, FitError, fit, refit};
pub use ggx::Ggx;
pub use integral::Integral;
pub use kind::BrdfKind;
pub use layout::Layout;
pub use limit::Limit;
pub use lobe::Lobe;
pub use ltc::Ltc;
pub use manifest::Manifest;
pub use node::Node;
pub use objective::{Objective, Residuals};
pub use polynomial::Polynomial;
pub use settings::{ObjectiveKind, Settings};
pub use table::Table;
