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
                for value in [Some(answer.value), answer.schlick, answer.multiple] {
                    let numbers = match value {
                        None => vec![],
                        Some(Value::Scalar(number)) => vec![number],
                        Some(Value::Vector(numbers)) => numbers.to_vec(),
                    };
                    assert!(numbers.into_iter().all(is_finite), "{answer:?}");
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
