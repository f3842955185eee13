//! Planar outlines of lights: concave, with holes, polygonised where curved.

use std::f64::consts::TAU;

/// An outer loop, counter-clockwise, then holes, clockwise.
pub(crate) struct Outline {
    pub(crate) loops: Vec<Vec<[f64; 2]>>,
}

/// `count` points of an arc of `radius` about `centre`, from `start` to `end` turns, both ends included.
fn arc(centre: [f64; 2], radius: [f64; 2], start: f64, end: f64, count: u32) -> Vec<[f64; 2]> {
    (0..count)
        .map(|k| {
            let turn = start + (end - start) * f64::from(k) / f64::from(count - 1);
            let (sin, cos) = libm::sincos(TAU * turn);
            [centre[0] + radius[0] * cos, centre[1] + radius[1] * sin]
        })
        .collect()
}

fn circle(radius: f64, count: u32) -> Vec<[f64; 2]> {
    let mut points = arc([0.0; 2], [radius; 2], 0.0, 1.0, count + 1);
    points.pop();
    points
}

fn reversed(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.reverse();
    points
}

impl Outline {
    /// A rectangle about the origin.
    pub(crate) fn rectangle(width: f64, height: f64) -> Self {
        let [x, y] = [width / 2.0, height / 2.0];
        Self {
            loops: vec![vec![[-x, -y], [x, -y], [x, y], [-x, y]]],
        }
    }

    /// A regular polygon of `count` vertices.
    pub(crate) fn disk(radius: f64, count: u32) -> Self {
        Self {
            loops: vec![circle(radius, count)],
        }
    }

    /// A star with a point upwards.
    pub(crate) fn star(points: u32, outer: f64, inner: f64) -> Self {
        let vertices = (0..2 * points)
            .map(|k| {
                let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(2 * points));
                let radius = if k % 2 == 0 { outer } else { inner };
                [-radius * sin, radius * cos]
            })
            .collect();
        Self {
            loops: vec![vertices],
        }
    }

    /// A disk with a round hole.
    pub(crate) fn ring(outer: f64, inner: f64, count: u32) -> Self {
        Self {
            loops: vec![circle(outer, count), reversed(circle(inner, count))],
        }
    }

    /// A rectangle with rectangular holes, each given by its lower left and upper right corner.
    pub(crate) fn window(width: f64, height: f64, holes: &[[f64; 4]]) -> Self {
        let mut outline = Self::rectangle(width, height);
        outline.loops.extend(
            holes
                .iter()
                .map(|&[x0, y0, x1, y1]| vec![[x0, y0], [x0, y1], [x1, y1], [x1, y0]]),
        );
        outline
    }

    /// The capital letter R, one unit high, its foot on y = 0, centred on x = 0.
    pub(crate) fn letter_r() -> Self {
        const STROKE: f64 = 0.19;
        const LEFT: f64 = -0.34;
        // The bowl: two half circles about one centre, the inner one a stroke smaller.
        let centre = [0.07, 0.725];
        let [outer, inner] = [0.275, 0.275 - STROKE];
        let mut outside = vec![
            [LEFT, 0.0],
            [LEFT + STROKE, 0.0],
            [LEFT + STROKE, centre[1] - outer],
            [-0.01, centre[1] - outer],
            [0.16, 0.0],
            [0.37, 0.0],
            [0.185, 0.475],
        ];
        outside.extend(arc(centre, [outer; 2], -0.17, 0.25, 20));
        outside.push([LEFT, centre[1] + outer]);
        let mut counter = vec![
            [LEFT + STROKE, centre[1] - inner],
            [LEFT + STROKE, centre[1] + inner],
        ];
        counter.extend(reversed(arc(centre, [inner; 2], -0.25, 0.25, 13)));
        Self {
            loops: vec![outside, counter],
        }
    }

    /// A lancet: a rectangle below a pointed arch whose two arcs are as wide as it is, its foot on
    /// y = 0, centred on x = 0.
    pub(crate) fn lancet(width: f64, springing: f64) -> Self {
        let half = width / 2.0;
        let mut points = vec![[-half, 0.0], [half, 0.0]];
        // A sixth of a turn up to the point, about the other side's springing.
        points.extend(arc([-half, springing], [width; 2], 0.0, 1.0 / 6.0, 17));
        points.pop();
        points.extend(arc([half, springing], [width; 2], 1.0 / 3.0, 0.5, 17));
        Self {
            loops: vec![points],
        }
    }

    /// A rectangle with round corners, about the origin, as a tube.
    pub(crate) fn round_frame(width: f64, height: f64, corner: f64, stroke: f64) -> Self {
        let around = |inset: f64| -> Vec<[f64; 2]> {
            let [x, y] = [width / 2.0 - corner, height / 2.0 - corner];
            [[x, -y], [x, y], [-x, y], [-x, -y]]
                .into_iter()
                .zip([-0.25, 0.0, 0.25, 0.5])
                .flat_map(|(centre, turn)| arc(centre, [corner - inset; 2], turn, turn + 0.25, 9))
                .collect()
        };
        Self {
            loops: vec![around(0.0), reversed(around(stroke))],
        }
    }

    /// The same outline elsewhere.
    pub(crate) fn moved(mut self, by: [f64; 2]) -> Self {
        for point in self.loops.iter_mut().flatten() {
            *point = [point[0] + by[0], point[1] + by[1]];
        }
        self
    }

    /// The capital letter O, one unit high, its lower left corner at the origin.
    pub(crate) fn letter_o(width: f64, stroke: f64) -> Self {
        let centre = [width / 2.0, 0.5];
        let ellipse = |inset: f64| {
            let radius = [centre[0] - inset, 0.5 - inset];
            let mut points = arc(centre, radius, 0.0, 1.0, 49);
            points.pop();
            points
        };
        Self {
            loops: vec![ellipse(0.0), reversed(ellipse(stroke))],
        }
    }

    /// The capital letter P.
    pub(crate) fn letter_p(width: f64, stroke: f64) -> Self {
        let outer = 0.28;
        let inner = outer - stroke;
        let centre = [width - outer, 1.0 - outer];
        let mut outside = vec![
            [0.0, 0.0],
            [stroke, 0.0],
            [stroke, centre[1] - outer],
            [centre[0], centre[1] - outer],
        ];
        outside.extend(arc(centre, [outer; 2], -0.25, 0.25, 25).split_off(1));
        outside.push([0.0, 1.0]);
        let mut counter = vec![[stroke, centre[1] - inner], [stroke, centre[1] + inner]];
        counter.extend(reversed(arc(centre, [inner; 2], -0.25, 0.25, 17)));
        Self {
            loops: vec![outside, counter],
        }
    }

    /// The capital letter E.
    pub(crate) fn letter_e(width: f64, stroke: f64) -> Self {
        let [low, high] = [0.5 - stroke / 2.0, 0.5 + stroke / 2.0];
        let middle = 0.85 * width;
        Self {
            loops: vec![vec![
                [0.0, 0.0],
                [width, 0.0],
                [width, stroke],
                [stroke, stroke],
                [stroke, low],
                [middle, low],
                [middle, high],
                [stroke, high],
                [stroke, 1.0 - stroke],
                [width, 1.0 - stroke],
                [width, 1.0],
                [0.0, 1.0],
            ]],
        }
    }

    /// The capital letter N.
    pub(crate) fn letter_n(width: f64, stroke: f64) -> Self {
        let rise = 0.78;
        Self {
            loops: vec![vec![
                [0.0, 0.0],
                [stroke, 0.0],
                [stroke, rise],
                [width - stroke, 0.0],
                [width, 0.0],
                [width, 1.0],
                [width - stroke, 1.0],
                [width - stroke, 1.0 - rise],
                [stroke, 1.0],
                [0.0, 1.0],
            ]],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[[f64; 2]]) -> f64 {
        (0..points.len())
            .map(|k| {
                let [[x0, y0], [x1, y1]] = [points[k], points[(k + 1) % points.len()]];
                (x0 * y1 - x1 * y0) / 2.0
            })
            .sum()
    }

    #[test]
    fn outer_loops_turn_left_and_holes_right() {
        for outline in [
            Outline::rectangle(2.0, 1.0),
            Outline::disk(1.0, 7),
            Outline::star(5, 1.0, 0.4),
            Outline::ring(1.0, 0.5, 12),
            Outline::window(2.0, 2.0, &[[-0.5, -0.5, 0.5, 0.5]]),
            Outline::letter_r(),
            Outline::lancet(1.0, 2.0),
            Outline::round_frame(2.0, 1.0, 0.3, 0.1),
            Outline::letter_o(0.7, 0.1),
            Outline::letter_p(0.6, 0.1),
            Outline::letter_e(0.6, 0.1),
            Outline::letter_n(0.7, 0.1),
        ] {
            let areas: Vec<f64> = outline.loops.iter().map(|points| area(points)).collect();
            assert!(areas[0] > 0.0, "{areas:?}");
            assert!(areas[1..].iter().all(|&a| a < 0.0), "{areas:?}");
            assert!(areas.iter().sum::<f64>() > 0.0, "{areas:?}");
        }
    }
}
