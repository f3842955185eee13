//! Following and stopping the reading of a scene.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

use super::error::Fault;

/// What reading a scene is at. Displays as a line for a person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadPhase {
    /// The scene's file comes from the disk.
    Reading {
        /// Its length.
        bytes: u64,
    },
    /// The JSON is read.
    Parsing {
        /// Its length.
        bytes: u64,
    },
    /// An image is read and decoded.
    Image {
        /// Which, from 1, in the order they are needed.
        number: usize,
        /// How many the file has; not all of them need be shown.
        of: usize,
    },
    /// A node's meshes are placed.
    Node {
        /// Which, from 1, in the order they are visited.
        number: usize,
        /// How many the file has; not all of them need be in the scene.
        of: usize,
    },
    /// A mesh's emissive faces become polygon lights.
    Lights {
        /// How many faces.
        triangles: usize,
    },
    /// What saving needs of the file is put by: the JSON, buffers and images as they are.
    Keeping,
}

impl LoadPhase {
    /// How far it is into its phase, 0 to 1, where that is known.
    #[must_use]
    pub fn fraction(self) -> Option<f32> {
        match self {
            Self::Image { number, of } | Self::Node { number, of } => {
                Some((number.saturating_sub(1) as f32 / of.max(1) as f32).min(1.0))
            }
            _ => None,
        }
    }
}

impl fmt::Display for LoadPhase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Reading { bytes } => write!(f, "reading {}", Size(bytes)),
            Self::Parsing { bytes } => {
                write!(f, "reading the scene's description, {}", Size(bytes))
            }
            Self::Image { number, of } => write!(f, "decoding image {number} of {of}"),
            Self::Node { number, of } => write!(f, "placing node {number} of {of}"),
            Self::Lights { triangles } => write!(f, "finding lights among {triangles} faces"),
            Self::Keeping => write!(f, "keeping the file for saving"),
        }
    }
}

/// Bytes, shown to two or three digits.
struct Size(u64);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = self.0 as f64;
        let (value, unit) = match self.0 {
            0..1_000 => return write!(f, "{} bytes", self.0),
            1_000..1_000_000 => (bytes / 1e3, "kB"),
            1_000_000..1_000_000_000 => (bytes / 1e6, "MB"),
            _ => (bytes / 1e9, "GB"),
        };
        let digits = usize::from(value < 9.95);
        write!(f, "{value:.digits$} {unit}")
    }
}

/// Follows the reading of a scene, and can stop it.
#[derive(Clone, Copy)]
pub struct LoadWatch<'a> {
    /// Called as each piece of work begins, often; it should return at once.
    pub progress: &'a (dyn Fn(LoadPhase) + Sync),
    /// Set it to stop reading with an error that says so.
    pub cancelled: &'a AtomicBool,
}

impl LoadWatch<'_> {
    /// Neither follows nor stops.
    #[must_use]
    pub fn none() -> LoadWatch<'static> {
        static NEVER: AtomicBool = AtomicBool::new(false);
        LoadWatch {
            progress: &|_| {},
            cancelled: &NEVER,
        }
    }

    /// Tells of work that begins, unless there is to be no more of it.
    pub(super) fn begin(&self, phase: LoadPhase) -> Result<(), Fault> {
        if self.cancelled.load(Ordering::Relaxed) {
            return Err(Fault::new("file", "reading was stopped", "open it again"));
        }
        (self.progress)(phase);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phases_read_as_lines() {
        let line = |phase: LoadPhase| phase.to_string();
        assert_eq!(
            line(LoadPhase::Reading { bytes: 120_400_000 }),
            "reading 120 MB"
        );
        assert_eq!(line(LoadPhase::Reading { bytes: 999 }), "reading 999 bytes");
        assert_eq!(line(LoadPhase::Reading { bytes: 9_949 }), "reading 9.9 kB");
        assert_eq!(
            line(LoadPhase::Reading {
                bytes: 2_500_000_000
            }),
            "reading 2.5 GB"
        );
        let image = LoadPhase::Image { number: 3, of: 12 };
        assert_eq!(line(image), "decoding image 3 of 12");
        assert_eq!(image.fraction(), Some(2.0 / 12.0));
        assert_eq!(LoadPhase::Image { number: 0, of: 0 }.fraction(), Some(0.0));
        assert_eq!(LoadPhase::Keeping.fraction(), None);
    }
}
