//! A picture's size on the command line.

use std::fmt;
use std::str::FromStr;

use lumigon_renderer::MAXIMUM_SIDE;

/// Width and height in pixels, written as 1440x900.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl fmt::Display for Size {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}x{}", self.width, self.height)
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| {
            let side = text.parse().ok()?;
            (1..=MAXIMUM_SIDE).contains(&side).then_some(side)
        };
        let size = text.split_once('x').and_then(|(width, height)| {
            Some(Self {
                width: side(width)?,
                height: side(height)?,
            })
        });
        size.ok_or_else(|| format!("give WIDTHxHEIGHT, each 1 to {MAXIMUM_SIDE}, such as 1440x900"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        for good in ["1x1", "1440x900", "32768x32768"] {
            assert_eq!(good.parse::<Size>().unwrap().to_string(), good);
        }
        for bad in [
            "", "x", "0x5", "5x0", "5", "5x5x5", "-1x5", "32769x1", "1.5x2", "5X5",
        ] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
    }
}
