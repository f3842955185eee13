//! How much of each texel an outline covers.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// The share of every texel inside an outline, in \[0, 1\], row by row; exact for loops that do not
/// cross.
///
/// `vertices` are in texels from the image's upper left corner, those of each loop in its range.
/// Outer loops turn one way, holes the other.
///
/// Each edge adds the signed area to its right, texel by texel, and a sum along every row makes
/// areas of them: after the accumulation buffer of Levien's font-rs (2016).
pub(crate) fn coverage(
    vertices: &[[f64; 2]],
    loops: impl Iterator<Item = Range<usize>>,
    [width, height]: [u32; 2],
) -> Vec<f32> {
    let (width, height) = (width as usize, height as usize);
    // One column more, for what lies right of the image.
    let mut changes = vec![0.0_f64; (width + 1) * height];
    for range in loops {
        let Some(mut start) = vertices[range.clone()].last().copied() else {
            continue;
        };
        for &end in &vertices[range] {
            add_edge(&mut changes, [width, height], start, end);
            start = end;
        }
    }
    let mut shares = Vec::with_capacity(width * height);
    for row in changes.chunks_exact(width + 1) {
        let mut sum = 0.0;
        for change in &row[..width] {
            sum += change;
            // The sign is the sense in which the frame sees the loops turn.
            shares.push(sum.abs().min(1.0) as f32);
        }
    }
    shares
}

fn add_edge(changes: &mut [f64], [width, height]: [usize; 2], a: [f64; 2], b: [f64; 2]) {
    if a[1] == b[1] {
        return;
    }
    let (sign, top, bottom) = if a[1] < b[1] {
        (1.0, a, b)
    } else {
        (-1.0, b, a)
    };
    let slope = (bottom[0] - top[0]) / (bottom[1] - top[1]);
    let first = top[1].max(0.0);
    let last = bottom[1].min(height as f64);
    let mut y = first;
    while y < last {
        let row = y as usize;
        let next = (row as f64 + 1.0).min(last);
        let at = |y: f64| top[0] + (y - top[1]) * slope;
        let row = &mut changes[row * (width + 1)..][..=width];
        add_piece(row, sign * (next - y), at(y), at(next));
        y = next;
    }
}

/// An edge's piece within one row: `rise` of it, from `x0` to `x1`.
fn add_piece(row: &mut [f64], rise: f64, x0: f64, x1: f64) {
    let width = row.len() - 1;
    let (low, high) = if x0 < x1 { (x0, x1) } else { (x1, x0) };
    let clamp = |x: f64| x.clamp(0.0, width as f64);
    let span = high - low;
    // What is right of the piece, texel by texel: the integral of how much of it is further left.
    let left_of = |x: f64| {
        if span <= 0.0 {
            (x - low).max(0.0)
        } else if x <= low {
            0.0
        } else if x < high {
            0.5 * (x - low) * (x - low) / span
        } else {
            x - 0.5 * (low + high)
        }
    };
    let first = clamp(low) as usize;
    let last = (clamp(high) as usize + 1).min(width);
    let mut before = 0.0;
    let mut covered = left_of(first as f64);
    for (x, change) in row.iter_mut().enumerate().take(last).skip(first) {
        let next = left_of((x + 1) as f64);
        let share = next - covered;
        *change += rise * (share - before);
        (before, covered) = (share, next);
    }
    row[last] += rise * (1.0 - before);
}

/// For each texel the nearest one that is covered at all, itself where it is; texels are as wide
/// and high as `texel` says. 0 where none is.
///
/// Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing
/// 8, 2012: exact, in time proportional to the number of texels.
pub(crate) fn nearest_covered(coverage: &[f32], width: usize, [dx, dy]: [f64; 2]) -> Vec<u32> {
    let height = coverage.len() / width;
    // The row of the nearest covered texel in each column.
    let mut rows = vec![u32::MAX; coverage.len()];
    for x in 0..width {
        let mut above = None;
        for y in 0..height {
            if coverage[y * width + x] > 0.0 {
                above = Some(y);
            }
            rows[y * width + x] = above.map_or(u32::MAX, |y| y as u32);
        }
        let mut below: Option<usize> = None;
        for y in (0..height).rev() {
            if coverage[y * width + x] > 0.0 {
                below = Some(y);
            }
            let row = &mut rows[y * width + x];
            if let Some(below) = below
                && (*row == u32::MAX || below - y < y - *row as usize)
            {
                *row = below as u32;
            }
        }
    }
    // Along each row the lower envelope of the columns' parabolas.
    let mut source = vec![0; coverage.len()];
    let mut envelope: Vec<(usize, f64)> = Vec::with_capacity(width);
    for y in 0..height {
        let squared = |x: usize| {
            let row = rows[y * width + x];
            let distance = (f64::from(row) - y as f64) * dy;
            (row != u32::MAX).then_some(distance * distance)
        };
        envelope.clear();
        for x in 0..width {
            let Some(height) = squared(x) else {
                continue;
            };
            let mut from = f64::NEG_INFINITY;
            while let Some(&(other, start)) = envelope.last() {
                let (a, b) = (other as f64, x as f64);
                let below = squared(other).unwrap_or_default();
                from = 0.5 * ((height - below) / (dx * dx * (b - a)) + a + b);
                if from > start {
                    break;
                }
                envelope.pop();
                from = f64::NEG_INFINITY;
            }
            envelope.push((x, from));
        }
        let mut next = 0;
        for x in 0..width {
            while next + 1 < envelope.len() && envelope[next + 1].1 <= x as f64 {
                next += 1;
            }
            if let Some(&(column, _)) = envelope.get(next) {
                let row = rows[y * width + column];
                source[y * width + x] = row * width as u32 + column as u32;
            }
        }
    }
    source
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_areas() {
        // A concave outline with a hole, partly outside the image.
        let outline = [[1.3, 0.4], [9.5, 2.2], [6.1, 3.3], [7.2, 6.8], [-1.5, 5.1]];
        let hole = [[3.2, 3.1], [3.4, 4.7], [4.9, 4.2]];
        let vertices: Vec<_> = outline.into_iter().chain(hole).collect();
        let shares = coverage(&vertices, [0..5, 5..8].into_iter(), [8, 8]);
        let inside = |points: &[[f64; 2]], x: f64, y: f64| {
            let mut odd = false;
            let mut a = points[points.len() - 1];
            for &b in points {
                if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
                {
                    odd = !odd;
                }
                a = b;
            }
            odd
        };
        const STEPS: usize = 100;
        for (i, share) in shares.iter().enumerate() {
            let mut count = 0;
            for sample in 0..STEPS * STEPS {
                let at = |k: usize| (k as f64 + 0.5) / STEPS as f64;
                let x = (i % 8) as f64 + at(sample % STEPS);
                let y = (i / 8) as f64 + at(sample / STEPS);
                count += usize::from(inside(&outline, x, y) && !inside(&hole, x, y));
            }
            let counted = count as f64 / (STEPS * STEPS) as f64;
            assert!(
                (counted - f64::from(*share)).abs() < 0.01,
                "{i}: {counted} {share}"
            );
        }
    }

    #[test]
    fn turned_frames_cover_the_same() {
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let turned: Vec<_> = square.into_iter().rev().collect();
        let one = |vertices: &[[f64; 2]]| coverage(vertices, core::iter::once(0..4), [4, 4]);
        assert_eq!(one(&square), [1.0; 16]);
        assert_eq!(one(&turned), [1.0; 16]);
    }

    #[test]
    fn nearest_is_nearest() {
        let width = 13;
        let mut shares = vec![0.0; width * 9];
        for i in [5, 40, 77, 101] {
            shares[i] = 0.5;
        }
        let texel = [1.0, 2.5];
        let source = nearest_covered(&shares, width, texel);
        for (i, &found) in source.iter().enumerate() {
            let squared = |j: usize| {
                let x = ((i % width) as f64 - (j % width) as f64) * texel[0];
                let y = ((i / width) as f64 - (j / width) as f64) * texel[1];
                x * x + y * y
            };
            let least = [5, 40, 77, 101]
                .map(squared)
                .into_iter()
                .fold(f64::MAX, f64::min);
            assert_eq!(squared(found as usize), least, "{i}");
        }
        assert_eq!(nearest_covered(&[0.0; 4], 2, texel), [0; 4]);
    }
}
