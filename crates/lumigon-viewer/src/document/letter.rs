//! Outlines of characters.

use epaint_default_fonts::{HACK_REGULAR, UBUNTU_LIGHT};
use glam::{DAffine2, DVec2};
use ttf_parser::{Face, OutlineBuilder};

use super::light::signed_area;

/// How far the straight pieces of a curve may leave it, in heights of a capital.
const FLATNESS: f64 = 0.003;

/// The loops of a character, capitals one metre high, its box centred on the origin, in the first of the
/// window's fonts that has it. `None` where none has, or it shows nothing.
pub(super) fn letter(character: char) -> Option<Vec<Vec<DVec2>>> {
    let fonts = [UBUNTU_LIGHT, HACK_REGULAR];
    fonts.into_iter().find_map(|font| {
        let face = Face::parse(font, 0).ok()?;
        let glyph = face.glyph_index(character)?;
        let capital = face.capital_height().filter(|height| *height > 0);
        let height = f64::from(capital.unwrap_or_else(|| face.ascender()).max(1));
        let mut contours = Contours::new(FLATNESS * height);
        face.outline_glyph(glyph, &mut contours)?;
        contours.loops(1.0 / height)
    })
}

struct Contours {
    loops: Vec<Vec<DVec2>>,
    flatness: f64,
}

impl Contours {
    fn new(flatness: f64) -> Self {
        Self {
            loops: Vec::new(),
            flatness,
        }
    }

    fn to(&mut self, p: DVec2) {
        if let Some(points) = self.loops.last_mut()
            && points.last() != Some(&p)
        {
            points.push(p);
        }
    }

    fn last(&self) -> DVec2 {
        let points = self.loops.last();
        points
            .and_then(|points| points.last().copied())
            .unwrap_or_default()
    }

    /// Scaled and centred; outer loops first and counter-clockwise. `None` without loops.
    fn loops(self, scale: f64) -> Option<Vec<Vec<DVec2>>> {
        let mut loops = self.loops;
        for points in &mut loops {
            // Contours may close with a line of their own.
            if points.first() == points.last() {
                points.pop();
            }
        }
        loops.retain(|points| points.len() >= 3);
        let points = || loops.iter().flatten().copied();
        let low = points().reduce(DVec2::min)?;
        let high = points().reduce(DVec2::max)?;
        let place = DAffine2::from_scale(DVec2::splat(scale))
            * DAffine2::from_translation((low + high) * -0.5);
        for point in loops.iter_mut().flatten() {
            *point = place.transform_point2(*point);
        }
        // TrueType fills on the right, and not every font keeps to it.
        if loops.iter().map(|points| signed_area(points)).sum::<f64>() < 0.0 {
            loops.iter_mut().for_each(|points| points.reverse());
        }
        loops.sort_by_key(|points| signed_area(points) < 0.0);
        Some(loops)
    }
}

fn point(x: f32, y: f32) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y))
}

impl OutlineBuilder for Contours {
    fn move_to(&mut self, x: f32, y: f32) {
        self.loops.push(vec![point(x, y)]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.to(point(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (a, b, c) = (self.last(), point(x1, y1), point(x, y));
        // A parabola leaves the chords of n equal parts by its second difference over 4 n².
        let pieces = ((a - b * 2.0 + c).length() / (4.0 * self.flatness))
            .sqrt()
            .ceil();
        let pieces = pieces.clamp(1.0, 64.0);
        for i in 1..=pieces as u32 {
            let t = f64::from(i) / pieces;
            self.to(a.lerp(b, t).lerp(b.lerp(c, t), t));
        }
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let (a, b, c, d) = (self.last(), point(x1, y1), point(x2, y2), point(x, y));
        let bend = (a - b * 2.0 + c).length().max((b - c * 2.0 + d).length());
        let pieces = (0.75 * bend / self.flatness).sqrt().ceil().clamp(1.0, 64.0);
        for i in 1..=pieces as u32 {
            let t = f64::from(i) / pieces;
            let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
            self.to(ab.lerp(bc, t).lerp(bc.lerp(cd, t), t));
        }
    }

    fn close(&mut self) {}
}
