//! Numbers of extensions that the `gltf` crate has no types for.

use serde_json::{Map, Value};

use crate::scene::error::Fault;

/// An object, or a fault at `place`.
pub(super) fn object<'v>(value: &'v Value, place: &str) -> Result<&'v Map<String, Value>, Fault> {
    value
        .as_object()
        .ok_or_else(|| Fault::new(place, "this is not an object", "write a JSON object there"))
}

/// The finite number under `key`, or `default` where there is none.
pub(super) fn number(
    object: &Map<String, Value>,
    key: &str,
    default: f32,
    place: &str,
) -> Result<f32, Fault> {
    object.get(key).map_or(Ok(default), |value| {
        finite(value, &format!("{place}.{key}"))
    })
}

/// The `N` finite numbers under `key`, or `default` where there are none.
pub(super) fn numbers<const N: usize>(
    object: &Map<String, Value>,
    key: &str,
    default: [f32; N],
    place: &str,
) -> Result<[f32; N], Fault> {
    let Some(value) = object.get(key) else {
        return Ok(default);
    };
    let place = format!("{place}.{key}");
    let list = value
        .as_array()
        .filter(|list| list.len() == N)
        .ok_or_else(|| {
            Fault::new(
                &place,
                format!("this is not an array of {N} numbers"),
                "write one there",
            )
        })?;
    let mut numbers = default;
    for (i, (number, value)) in numbers.iter_mut().zip(list).enumerate() {
        *number = finite(value, &format!("{place}[{i}]"))?;
    }
    Ok(numbers)
}

/// The index under `key`, or `None` where there is none.
pub(super) fn index(
    object: &Map<String, Value>,
    key: &str,
    place: &str,
) -> Result<Option<usize>, Fault> {
    let Some(value) = object.get(key) else {
        return Ok(None);
    };
    let index = value.as_u64().and_then(|index| usize::try_from(index).ok());
    index.map(Some).ok_or_else(|| {
        Fault::new(
            format!("{place}.{key}"),
            "this is not an index",
            "write an integer from 0",
        )
    })
}

fn finite(value: &Value, place: &str) -> Result<f32, Fault> {
    value
        .as_f64()
        .map(|number| number as f32)
        .filter(|number| number.is_finite())
        .ok_or_else(|| Fault::new(place, "this is not a finite number", "write a number there"))
}

/// Refuses numbers that overflowed f32.
pub(super) fn check_finite(numbers: &[f32], place: impl FnOnce() -> String) -> Result<(), Fault> {
    if numbers.iter().all(|number| number.is_finite()) {
        Ok(())
    } else {
        Err(Fault::new(
            place(),
            "a number here is too large",
            "keep it below 3e38",
        ))
    }
}
