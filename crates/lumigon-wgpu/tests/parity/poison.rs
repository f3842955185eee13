//! What is not finite gives what it may, but it ends, and the device lives.

use crate::gpu::Place;
use crate::polygons::Random;

const POISON: [f32; 7] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    -f32::MAX,
    0.0,
    1e-40,
];

/// Places with one to three of their arguments, or all numbers of one, replaced by poison.
pub(crate) fn poisoned(places: &[Place], count: usize) -> Vec<Place> {
    let mut random = Random::new(73);
    (0..count)
        .map(|_| {
            let mut place = places[random.index(places.len())];
            for _ in 0..1 + random.index(3) {
                let value = POISON[random.index(POISON.len())];
                let numbers: &mut [f32] = match random.index(8) {
                    0 => &mut place.point,
                    1 => &mut place.normal,
                    2 => &mut place.view,
                    3 => &mut place.towards,
                    4 => &mut place.lobe,
                    5 => std::slice::from_mut(&mut place.alpha),
                    6 => std::slice::from_mut(&mut place.cosine),
                    _ => std::slice::from_mut(&mut place.bias),
                };
                if random.chance(0.25) {
                    numbers.fill(value);
                } else {
                    numbers[random.index(numbers.len())] = value;
                }
            }
            place
        })
        .collect()
}

#[test]
fn some_places_are_poisoned() {
    let poisoned = poisoned(&[Place::default()], 1_000);
    let bad = |place: &&Place| {
        bytemuck::cast_ref::<Place, [f32; 20]>(place)
            .iter()
            .any(|x| x.is_nan())
    };
    assert!(poisoned.iter().filter(bad).count() > 100);
}
