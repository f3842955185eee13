//! `lumigon eval` as a process: truth values, order, errors and streams.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Output, Stdio};

use serde_json::Value;

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lumigon"));
    command
        .arg("eval")
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

fn truth(name: &str) -> (String, Vec<Value>) {
    let path = format!("{}/../../tests/truth/{name}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap();
    let questions = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    (path, questions)
}

/// Feeds standard input from a thread, so that neither pipe can fill up.
fn feed(mut child: Child, input: Vec<u8>) -> Output {
    let mut stdin = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || stdin.write_all(&input));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    output
}

fn eval(arguments: &[&str], input: impl Into<Vec<u8>>) -> (Vec<Value>, i32, String) {
    let output = feed(command(arguments).spawn().unwrap(), input.into());
    let answers = String::from_utf8(output.stdout).unwrap();
    let answers = answers
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let code = output.status.code().unwrap();
    (answers, code, String::from_utf8(output.stderr).unwrap())
}

#[test]
fn irradiance_is_the_truth() {
    let (path, questions) = truth("lambert.jsonl");
    assert_eq!(questions.len(), 240);
    for (precision, tolerance) in [("f64", 1e-8), ("f32", 1e-5)] {
        let (answers, code, _) = eval(&["--precision", precision, &path], "");
        assert_eq!((answers.len(), code), (240, 0));
        for (question, answer) in questions.iter().zip(&answers) {
            let error = answer["value"].as_f64().unwrap() - question["truth"].as_f64().unwrap();
            assert!(error.abs() <= tolerance, "{precision}: {error:e}");
        }
    }
}

#[test]
fn cubature_is_the_truth() {
    let (path, questions) = truth("ggx.jsonl");
    assert_eq!(questions.len(), 800);
    let (answers, code, _) = eval(&[&path], "");
    assert_eq!((answers.len(), code), (800, 0));
    for (question, answer) in questions.iter().zip(&answers) {
        for (field, truth) in [("value", "truth"), ("schlick", "truth_schlick")] {
            let error = answer[field].as_f64().unwrap() - question[truth].as_f64().unwrap();
            assert!(error.abs() <= 1e-5, "{field}: {error:e}");
        }
    }
}

/// The other BRDFs' truth files, line by line.
#[test]
fn cubature_of_every_brdf_is_the_truth() {
    for (name, fields) in [
        ("charlie", &[("value", "truth")][..]),
        (
            "eon",
            &[("value", "truth_single"), ("multiple", "truth_multiple")],
        ),
        (
            "ggx_anisotropic",
            &[("value", "truth"), ("schlick", "truth_schlick")],
        ),
    ] {
        let (path, questions) = truth(&format!("{name}.jsonl"));
        assert_eq!(questions.len(), 200);
        let (answers, code, errors) = eval(&[&path], "");
        assert_eq!((answers.len(), code), (200, 0), "{errors}");
        for (question, answer) in questions.iter().zip(&answers) {
            for (field, truth) in fields {
                let error = answer[field].as_f64().unwrap() - question[truth].as_f64().unwrap();
                assert!(error.abs() <= 1e-5, "{name} {field}: {error:e}");
            }
            assert_eq!(answer.as_object().unwrap().len(), fields.len());
        }
    }
}

/// Every shipped table on its truth file, in single precision: RMSE in units of the light's
/// radiance.
#[test]
fn tables_are_close_to_the_truth() {
    for (file, table, fields, most) in [
        ("ggx", "ggx", ["truth", "truth_schlick"], 0.0065),
        ("ggx", "ggx-2", ["truth", "truth_schlick"], 0.0025),
        (
            "ggx_anisotropic",
            "ggx-anisotropic",
            ["truth", "truth_schlick"],
            0.0075,
        ),
        ("charlie", "charlie", ["truth", ""], 0.0025),
        ("eon", "eon", ["truth_single", "truth_multiple"], 0.0045),
    ] {
        let (path, questions) = truth(&format!("{file}.jsonl"));
        let text = std::fs::read_to_string(path).unwrap().replace(
            &format!(r#""quantity":"{file}""#),
            &format!(r#""quantity":"ltc","table":"{table}""#),
        );
        let text = text.replace(
            r#""quantity": "ggx""#,
            &format!(r#""quantity":"ltc","table":"{table}""#),
        );
        let (answers, code, errors) = eval(&["--precision", "f32"], text);
        assert_eq!((answers.len(), code), (questions.len(), 0), "{errors}");
        let second = if table == "eon" {
            "multiple"
        } else {
            "schlick"
        };
        for (field, truth) in ["value", second].into_iter().zip(fields) {
            if truth.is_empty() {
                assert!(answers[0].get(field).is_none());
                continue;
            }
            let squares = questions.iter().zip(&answers).map(|(question, answer)| {
                (answer[field].as_f64().unwrap() - question[truth].as_f64().unwrap()).powi(2)
            });
            let rmse = (squares.sum::<f64>() / questions.len() as f64).sqrt();
            println!("{table} {field}: RMSE {rmse:.5}");
            assert!(rmse <= most, "{table} {field}: {rmse}");
        }
    }
    // Without a table's name it is the one named ggx.
    let (path, _) = truth("ggx.jsonl");
    let line = std::fs::read_to_string(path).unwrap();
    let line = line.lines().next().unwrap();
    let ltc = line.replace(r#""quantity": "ggx""#, r#""quantity":"ltc""#);
    let named = ltc.replace(r#""ltc""#, r#""ltc","table":"ggx""#);
    let (answers, code, _) = eval(&[], format!("{ltc}\n{named}"));
    assert_eq!((code, &answers[0]), (0, &answers[1]));
}

/// A line whose answer is its number: the projected area of a square at distance 1.
fn numbered(number: usize) -> String {
    let half = 0.5 * (number as f64).sqrt();
    format!(
        r#"{{"loops":[[[-{half},1,-{half}],[{half},1,-{half}],[{half},1,{half}],[-{half},1,{half}]]],"point":[0,0,0],"normal":[0,1,0],"quantity":"projected_area","basis":"centroid","comment":[{{}}]}}"#
    )
}

#[test]
fn order_is_kept_and_every_line_answered() {
    const COUNT: usize = 100_000;
    let mut input = String::new();
    for i in 1..=COUNT {
        if i % 1000 == 0 {
            input += "{\"quantity\":\"irradiance\"}\n";
        } else {
            input += &numbered(i);
            input.push('\n');
        }
    }
    let (answers, code, message) = eval(&[], input);
    assert_eq!((answers.len(), code), (COUNT, 1));
    assert_eq!(
        message,
        "lumigon: 100 of 100000 questions failed, the first on line 1000\n"
    );
    for (index, answer) in answers.iter().enumerate() {
        let number = index + 1;
        if number % 1000 == 0 {
            assert_eq!(answer["error"], "column 25: missing field `loops`");
        } else {
            let value = answer["value"].as_f64().unwrap();
            assert!((value - number as f64).abs() < 1e-6, "{number}: {value}");
        }
    }
}

#[test]
fn bad_lines_are_errors_and_nothing_else() {
    let good = numbered(7);
    let deep = "[".repeat(100_000);
    let bad = [
        "nonsense",
        "{",
        "[]",
        "null",
        &deep,
        &good.replace("projected_area", "brightness"),
        &good.replace("\"loops\":[[", "\"loops\":[[],["),
        &good.replace("[0,1,0]", "[0,0,0]"),
        &good.replace("[0,1,0]", "[0,1e200,0]"),
        &good.replace("[0,0,0]", "[0,NaN,0]"),
        &good.replace("[0,0,0]", "[0,null,0]"),
        &good.replace("\"point\"", "\"place\""),
        r#"{"loops":[[[0,0,0],[0,0,0],[0,0,0]]],"point":[0,0,0],"quantity":"solid_angle"}"#,
        r#"{"loops":[[[0,0,1],[1,0,1],[1,1,1],[0,1,3]]],"point":[0,0,0],"quantity":"solid_angle"}"#,
        r#"{"loops":[],"point":[0,0,0],"quantity":"solid_angle"}"#,
    ];
    for precision in ["f32", "f64"] {
        let mut input = String::new();
        for line in bad {
            input += &format!("{line}\n\n{good}\n");
        }
        let (answers, code, _) = eval(&["--precision", precision], input);
        assert_eq!((answers.len(), code), (2 * bad.len(), 1));
        for (pair, line) in answers.chunks(2).zip(bad) {
            assert!(pair[0]["error"].is_string(), "{line}: {}", pair[0]);
            assert!((pair[1]["value"].as_f64().unwrap() - 7.0).abs() < 1e-5);
        }
    }
}

#[test]
fn a_line_too_long_is_an_error_of_its_own() {
    let mut input = vec![b'['; (16 << 20) + 1];
    input.extend_from_slice(format!("\n{}", numbered(3)).as_bytes());
    let (answers, code, _) = eval(&[], input);
    assert_eq!((answers.len(), code), (2, 1));
    assert!(answers[0]["error"].as_str().unwrap().contains("longer"));
    assert!((answers[1]["value"].as_f64().unwrap() - 3.0).abs() < 1e-9);
}

#[test]
fn answers_come_line_by_line() {
    let mut child = command(&["-"]).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap());
    for number in 1..=5 {
        // The next question is not asked before this one is answered.
        writeln!(stdin, "{}", numbered(number)).unwrap();
        let mut line = String::new();
        answers.read_line(&mut line).unwrap();
        let answer: Value = serde_json::from_str(&line).unwrap();
        assert!((answer["value"].as_f64().unwrap() - number as f64).abs() < 1e-9);
    }
    drop(stdin);
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_closed_pipe_ends_quietly() {
    let mut child = command(&[]).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    writeln!(stdin, "{}", numbered(1)).unwrap();
    answers.read_line(&mut line).unwrap();
    drop(answers);
    let question = numbered(2) + "\n";
    // Endless input: what stops it is that the reader goes away.
    while stdin.write_all(question.as_bytes()).is_ok() {}
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let (_, code, message) = eval(&["no/such/file.jsonl"], "");
    assert_eq!(code, 1);
    assert!(message.contains("no/such/file.jsonl"), "{message}");
    let (_, code, message) = eval(&[env!("CARGO_MANIFEST_DIR")], "");
    assert_eq!(code, 1);
    assert!(message.contains("lumigon-cli"), "{message}");
    let (_, code, _) = eval(&["--precision", "f16"], "");
    assert_eq!(code, 2);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported() {
    let full = std::fs::File::options()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let child = command(&[]).stdout(full).spawn().unwrap();
    let output = feed(child, numbered(1).into_bytes());
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("No space left"), "{message}");
}

/// A mirror sees the light or not; a rough surface sees some of it, and less the farther off.
#[test]
fn mirrored_views_answer() {
    let ask = |quantity: &str, x: f64, more: &str| {
        let (view, length) = ([-x, 0.0, 2.0], (x * x + 4.0).sqrt());
        let view = view.map(|v| v / length);
        let line = format!(
            r#"{{"quantity":"{quantity}","loops":[[[-1,-1,2],[-1,1,2],[1,1,2],[1,-1,2]]],
            "point":[0,0,0],"normal":[0,0,1],"view":{view:?}{more}}}"#
        );
        let (answers, _, _) = eval(&[], line.replace('\n', " "));
        answers[0].clone()
    };
    let number = |answer: &Value| answer["value"].as_f64().unwrap();
    for (x, expected) in [(0.9, 1.0), (1.1, 0.0)] {
        assert_eq!(number(&ask("reflected_inclusion", x, "")), expected);
        let smooth = r#","perceptual_roughness":0,"smoothness":1e6"#;
        let smooth = number(&ask("reflected_distance", x, smooth));
        assert!((smooth - expected).abs() < 1e-6, "{smooth} at {x}");
    }
    let rough = |x| {
        number(&ask(
            "reflected_distance",
            x,
            r#","perceptual_roughness":0.5"#,
        ))
    };
    let values = [0.0, 1.0, 2.0, 4.0].map(rough);
    assert!(values.is_sorted_by(|a, b| a > b) && values[0] < 1.0 && values[3] > 0.0);
    for (fault, message) in [
        ("", "perceptual_roughness"),
        (
            r#","perceptual_roughness":0.5,"resolution":100"#,
            "power of two",
        ),
        (r#","perceptual_roughness":0.5,"phi":0.5"#, "1 to 16"),
    ] {
        let answer = ask("reflected_distance", 0.0, fault);
        let error = answer["error"].as_str().unwrap();
        assert!(error.contains(message), "{error}");
    }
}
