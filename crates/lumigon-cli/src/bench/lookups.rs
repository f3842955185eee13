//! What one pixel pays for a look into a fitted table.

use std::hint::black_box;

use lumigon::{AnisotropicLtcTable, LtcTable, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use super::kernels::median_seconds;
use crate::Failure;
use crate::interrupt::Interrupt;

/// Places a repetition looks up, all over the table: no neighbour helps another.
const PLACES: usize = 1024;

/// One table.
#[derive(Serialize)]
pub(super) struct LookupFigures {
    table: &'static str,
    /// Numbers that a lookup reads.
    numbers: usize,
    nanoseconds: f64,
}

/// Axes of a table, each from 0 to 1, enough for any.
type Place = [f32; 4];

/// A table's name, the numbers that a lookup reads, and the lookup.
type Row<'a> = (&'static str, usize, &'a dyn Fn(&Place));

pub(super) fn measure(interrupt: &Interrupt) -> Result<Vec<LookupFigures>, Failure> {
    println!("\n{:26} {:>12} {:>10}", "lookup", "numbers read", "ns");
    let places = places();
    let (ggx, ggx_2) = (LtcTable::ggx(), LtcTable::ggx_2());
    let anisotropic = AnisotropicLtcTable::ggx();
    let isotropic = |place: &Place| (place[0], place[1]);
    let rows: [Row<'_>; 3] = [
        ("ggx", 4 * 8, &|place| {
            let (perceptual_roughness, cosine) = isotropic(place);
            black_box(ggx.lookup(perceptual_roughness, cosine));
        }),
        ("ggx-2", 4 * 12, &|place| {
            let (perceptual_roughness, cosine) = isotropic(place);
            black_box(ggx_2.lookup(perceptual_roughness, cosine));
        }),
        ("ggx-anisotropic", 16 * 12, &|place| {
            let (sine, cosine) = ((1.0 - place[1] * place[1]).sqrt(), place[1]);
            let (y, x) = (place[3] * std::f32::consts::TAU).sin_cos();
            let view = Vec3::new(sine * x, sine * y, cosine);
            black_box(anisotropic.lookup([place[0], place[2]], view));
        }),
    ];
    let mut figures = Vec::new();
    for (table, numbers, look) in rows {
        interrupt.check()?;
        let seconds = median_seconds(|| places.iter().for_each(look));
        let nanoseconds = seconds * 1e9 / PLACES as f64;
        println!("{table:26} {numbers:>12} {nanoseconds:>10.1}");
        figures.push(LookupFigures {
            table,
            numbers,
            nanoseconds,
        });
    }
    Ok(figures)
}

fn places() -> Vec<Place> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    (0..PLACES)
        .map(|_| std::array::from_fn(|_| random.random()))
        .collect()
}
