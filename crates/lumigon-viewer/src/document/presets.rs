//! New lights of common shapes.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec2};

use super::letter::letter;
use super::{Light, check};

/// Corners of a disk and of each of a ring's circles: the outline is within 0.15 % of a radius of the
/// circle of the same area.
const DISK_CORNERS: u32 = 48;
/// The radius of a star's inner corners, as a fraction of its outer ones': that of the pentagram.
const STAR_WAIST: f64 = 0.381_966;

/// A shape for a new light. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Preset {
    /// A rectangle.
    Rectangle {
        /// Along x.
        width: f64,
        /// Along y.
        height: f64,
    },
    /// A regular polygon of 48 corners with the area of a circle.
    Disk {
        /// Of the circle.
        diameter: f64,
    },
    /// A star, one point up.
    Star {
        /// How many points, at least 3.
        points: u32,
        /// Of the circle through the points.
        diameter: f64,
    },
    /// A character of the window's fonts.
    Letter {
        /// Which one.
        character: char,
        /// Height of a capital.
        height: f64,
    },
    /// A disk with a round hole.
    Ring {
        /// Of the outer circle.
        diameter: f64,
        /// Of the hole.
        hole: f64,
    },
}

/// Why a preset is no light.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PresetError {
    /// The fonts have no such character, or it shows nothing.
    #[error("the fonts of this window have no outline for {0:?}: choose another character")]
    NoCharacter(char),
    /// The parts of a character lie over each other.
    #[error("the outline of {0:?} crosses itself: choose another character")]
    CrossedCharacter(char),
    /// A length is not positive, or the hole is not smaller than the disk.
    #[error("sizes are positive, and a ring's hole is smaller than the ring")]
    Size,
}

impl Preset {
    /// The light, its bounding box centred on the origin of a frame of rotation and translation, facing
    /// along its z with its y up.
    ///
    /// # Errors
    /// Where it is none.
    pub fn light(self, frame: DAffine3) -> Result<Light, PresetError> {
        let loops = self.loops()?;
        let name = match self {
            Self::Rectangle { .. } => "rectangle",
            Self::Disk { .. } => "disk",
            Self::Star { .. } => "star",
            Self::Letter { .. } => "letter",
            Self::Ring { .. } => "ring",
        };
        Ok(Light::new(name, frame, loops).recentred())
    }

    /// The outline on its own, about the origin.
    ///
    /// # Errors
    /// As [`Preset::light`].
    pub fn loops(self) -> Result<Vec<Vec<DVec2>>, PresetError> {
        let is_size = |size: f64| size > 0.0 && size.is_finite();
        let loops = match self {
            Self::Rectangle { width, height } if is_size(width) && is_size(height) => {
                let (x, y) = (0.5 * width, 0.5 * height);
                let corners = [(-x, -y), (x, -y), (x, y), (-x, y)];
                vec![corners.map(DVec2::from).to_vec()]
            }
            Self::Disk { diameter } if is_size(diameter) => vec![circle(diameter)],
            Self::Star { points, diameter }
                if is_size(diameter) && (3..=1000).contains(&points) =>
            {
                let step = TAU / f64::from(2 * points);
                let corner = |i: u32| {
                    let radius = 0.5 * diameter * if i % 2 == 0 { 1.0 } else { STAR_WAIST };
                    DVec2::from_angle(0.25 * TAU + step * f64::from(i)) * radius
                };
                vec![(0..2 * points).map(corner).collect()]
            }
            Self::Ring { diameter, hole }
                if is_size(hole) && hole < diameter && is_size(diameter) =>
            {
                let mut inner = circle(hole);
                inner.reverse();
                vec![circle(diameter), inner]
            }
            Self::Letter { character, height } if is_size(height) => {
                let mut loops = letter(character).ok_or(PresetError::NoCharacter(character))?;
                for point in loops.iter_mut().flatten() {
                    *point *= height;
                }
                if check(&loops).is_err() {
                    return Err(PresetError::CrossedCharacter(character));
                }
                loops
            }
            _ => return Err(PresetError::Size),
        };
        // A ring may be too thin, a rectangle too narrow.
        check(&loops).map_err(|_| PresetError::Size)?;
        Ok(loops)
    }
}

/// The regular polygon with a circle's area, counter-clockwise.
fn circle(diameter: f64) -> Vec<DVec2> {
    let step = TAU / f64::from(DISK_CORNERS);
    let radius = 0.5 * diameter * (step / step.sin()).sqrt();
    let corner = |i| DVec2::from_angle(step * (f64::from(i) + 0.5)) * radius;
    (0..DISK_CORNERS).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DVec3;

    use super::*;
    use crate::document::plane_frame;

    fn light(preset: Preset) -> Light {
        preset.light(plane_frame(DVec3::ZERO, DVec3::Z)).unwrap()
    }

    #[test]
    fn round_shapes_have_the_area_of_circles() {
        let disk = light(Preset::Disk { diameter: 2.0 });
        assert!((disk.area() - PI).abs() < 1e-12);
        let corners = disk.loops[0].iter().map(|p| p.length());
        // The circle lies between the corners and the middles of the sides.
        assert!(corners.clone().all(|r| (r - 1.0).abs() < 1.5e-3));
        let ring = light(Preset::Ring {
            diameter: 2.0,
            hole: 1.0,
        });
        assert!((ring.area() - 0.75 * PI).abs() < 1e-12);
    }

    #[test]
    fn letters_have_their_holes() {
        for (character, loops, holes) in [
            ('L', 1, 0),
            ('O', 2, 1),
            ('B', 3, 2),
            ('i', 2, 0),
            ('%', 5, 2),
            ('é', 3, 1),
        ] {
            let light = light(Preset::Letter {
                character,
                height: 0.5,
            });
            let own_holes = light
                .loops
                .iter()
                .filter(|points| super::super::light::signed_area(points) < 0.0);
            assert_eq!(
                (light.loops.len(), own_holes.count()),
                (loops, holes),
                "{character}"
            );
        }
        let letter = light(Preset::Letter {
            character: 'H',
            height: 0.5,
        });
        let (low, high) = letter.bounds();
        assert!((high.y - low.y - 0.5).abs() < 1e-3, "{low} {high}");
        // Most of a sans-serif H's area is its two stems: it stands upright, 3 to 20 % of it ink.
        let ink = letter.area() / ((high.x - low.x) * (high.y - low.y));
        assert!((0.1..0.6).contains(&ink), "{ink}");
    }

    #[test]
    fn most_characters_of_the_keyboard_are_lights() {
        let printable = (b'!'..=b'~').map(char::from);
        let refused: Vec<char> = printable
            .filter(|&character| {
                Preset::Letter {
                    character,
                    height: 1.0,
                }
                .loops()
                .is_err()
            })
            .collect();
        assert!(refused.is_empty(), "{refused:?}");
        for none in [' ', '\u{0}', '\u{10ffff}'] {
            let preset = Preset::Letter {
                character: none,
                height: 1.0,
            };
            assert_eq!(preset.loops(), Err(PresetError::NoCharacter(none)));
        }
    }

    #[test]
    fn bad_sizes_are_refused() {
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            for preset in [
                Preset::Rectangle {
                    width: size,
                    height: 1.0,
                },
                Preset::Disk { diameter: size },
                Preset::Star {
                    points: 5,
                    diameter: size,
                },
                Preset::Letter {
                    character: 'A',
                    height: size,
                },
                Preset::Ring {
                    diameter: 1.0,
                    hole: size,
                },
                Preset::Ring {
                    diameter: 1.0,
                    hole: 1.0,
                },
                Preset::Star {
                    points: 2,
                    diameter: 1.0,
                },
            ] {
                assert_eq!(preset.loops(), Err(PresetError::Size), "{preset:?}");
            }
        }
    }
}
