//! Whatever a line asks, `lumigon eval` answers it or says why not.

use lumigon_cli::{Number, Precision, Value, answer};

/// Answers `bytes` in both precisions; answers are finite, and errors say something.
pub(super) fn eval(bytes: &[u8]) {
    let Ok(line) = std::str::from_utf8(bytes) else {
        return;
    };
    for precision in [Precision::F32, Precision::F64] {
        match answer(line, precision) {
            Ok(answer) => {
                let numbers = match answer.value {
                    Value::Scalar(number) => vec![number],
                    Value::Vector(numbers) => numbers.to_vec(),
                };
                for number in numbers.into_iter().chain(answer.schlick) {
                    assert!(is_finite(number), "{answer:?}");
                }
            }
            Err(error) => assert!(!error.to_string().is_empty(), "{error:?}"),
        }
    }
}

fn is_finite(number: Number) -> bool {
    match number {
        Number::F32(number) => number.is_finite(),
        Number::F64(number) => number.is_finite(),
    }
}
