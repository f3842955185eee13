//! The host's code prepares lights as the crate does.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use lumigon::{PolygonLight, Sides};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::es300::random_light;
use crate::tool::run;
use crate::{export, read, write};

const LIGHTS: usize = 200;

/// A few units in the last place of 1, or relative: the order of sums differs.
const TOLERANCE: f32 = 5e-7;

/// Reads lights as text, one a line: sides, number of loops, and for each loop its number of vertices
/// and their coordinates. Prints the light's 16 numbers and its records', or `error`.
const CPP: &str = r#"
#include "prepare_light.hpp"
#include <iostream>
#include <sstream>
int main() {
    std::cout.precision(9);
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream numbers(line);
        int sides = 0, loop_count = 0;
        numbers >> sides >> loop_count;
        std::vector<std::vector<lumigon_host::Vector>> loops(loop_count);
        for (auto& loop : loops) {
            int count = 0;
            numbers >> count;
            loop.resize(count);
            for (auto& v : loop) {
                numbers >> v[0] >> v[1] >> v[2];
            }
        }
        try {
            std::vector<lumigon_host::Record> records;
            const auto light = lumigon_host::prepare_light(loops, sides == 2, records);
            const float* fields = light.center;
            for (const auto* group : {fields, light.normal, light.centroid}) {
                std::cout << group[0] << ' ' << group[1] << ' ' << group[2] << ' ' << group[3] << ' ';
            }
            for (float x : light.plane_axis) {
                std::cout << x << ' ';
            }
            std::cout << light.both_sides;
            for (const auto& record : records) {
                for (float x : record) {
                    std::cout << ' ' << x;
                }
            }
            std::cout << '\n';
        } catch (const std::invalid_argument&) {
            std::cout << "error\n";
        }
    }
}
"#;

/// The same.
const JS: &str = r#"
import { readFileSync } from "node:fs";
import { prepareLight } from "./prepare_light.js";
for (const line of readFileSync(0, "utf8").trimEnd().split("\n")) {
    const numbers = line.split(" ").map(Number);
    const next = () => numbers.shift();
    const sides = next();
    const loops = Array.from({ length: next() }, () =>
        Array.from({ length: next() }, () => [next(), next(), next()]),
    );
    try {
        const light = prepareLight(loops, sides === 2);
        const fields = [...new Float32Array(light.bytes).slice(0, 15)];
        const both = new Uint32Array(light.bytes)[15];
        console.log([...fields, both, ...light.records].join(" "));
    } catch (error) {
        if (!(error instanceof RangeError)) throw error;
        console.log("error");
    }
}
"#;

/// What the README's script finds: a context that lists what it is called with.
const GL: &str = r#"
import { readFileSync } from "node:fs";
const program = {};
const calls = [];
const called = (name) => (...values) => (calls.push([name, ...values]), values[1]);
const gl = new Proxy({}, {
    get: (_, name) => (name === name.toUpperCase() ? name : called(name)),
});
const fetch = async (path) => ({ arrayBuffer: () => new Uint8Array(readFileSync(path)).buffer });
"#;

/// Good lights, and a few that are none.
fn questions() -> Vec<(Vec<Vec<[f64; 3]>>, Sides)> {
    let mut random = Pcg64Mcg::seed_from_u64(0x4057);
    let mut questions: Vec<_> = (0..LIGHTS).map(|_| random_light(&mut random)).collect();
    // Far from the origin, as scenes in metres have it.
    for (loops, _) in questions.iter_mut().step_by(3) {
        let offset: [f64; 3] = [(); 3].map(|()| random.random_range(-500.0..500.0));
        for v in loops.iter_mut().flatten() {
            *v = [v[0] + offset[0], v[1] + offset[1], v[2] + offset[2]];
        }
    }
    let square = |z: f64| {
        vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, z],
            [0.0, 1.0, 0.0],
        ]
    };
    let bad = [
        vec![],
        vec![vec![[0.0; 3]; 2]],
        vec![vec![[1.0; 3]; 4]],
        vec![vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]],
        vec![square(0.1)],
    ];
    questions.extend(bad.into_iter().map(|loops| (loops, Sides::Front)));
    // Off its plane, but within tolerance.
    questions.push((vec![square(1e-5)], Sides::Front));
    questions
}

fn asked(questions: &[(Vec<Vec<[f64; 3]>>, Sides)]) -> String {
    let mut text = String::new();
    for (loops, sides) in questions {
        let sides = if *sides == Sides::Both { 2 } else { 1 };
        write!(text, "{sides} {}", loops.len()).unwrap();
        for vertices in loops {
            write!(text, " {}", vertices.len()).unwrap();
            for x in vertices.iter().flatten() {
                write!(text, " {x:?}").unwrap();
            }
        }
        text.push('\n');
    }
    text
}

/// The crate's numbers in the same order.
fn expected(loops: &[Vec<[f64; 3]>], sides: Sides) -> Option<Vec<f32>> {
    let light = PolygonLight::new(loops, sides).ok()?.cast::<f32>().ok()?;
    let (center, radius) = light.circumscribed_circle();
    let mut numbers = vec![center.x, center.y, center.z, 1.0 / radius];
    let (normal, centroid, axis) = (
        light.normal(),
        light.centroid_offset(),
        light.plane_axes().0,
    );
    numbers.extend([normal.x, normal.y, normal.z, light.doubled_unit_area()]);
    numbers.extend([centroid.x, centroid.y, centroid.z, light.plane_tolerance()]);
    let both = f32::from(light.sides() == Sides::Both);
    numbers.extend([axis.x, axis.y, axis.z, both]);
    for range in light.loop_ranges() {
        let vertices = &light.offsets()[range];
        let moved = vertices.last().map(|v| [v.x, v.y, v.z, 1.0]);
        let lines = vertices.iter().map(|v| [v.x, v.y, v.z, 0.0]);
        numbers.extend(moved.into_iter().chain(lines).flatten());
    }
    Some(numbers)
}

fn compare(answers: &str, questions: &[(Vec<Vec<[f64; 3]>>, Sides)]) {
    assert_eq!(answers.lines().count(), questions.len());
    let mut refused = 0;
    for (answer, (loops, sides)) in answers.lines().zip(questions) {
        match expected(loops, *sides) {
            None => {
                assert_eq!(answer, "error", "{loops:?}");
                refused += 1;
            }
            Some(expected) => {
                let found: Vec<f32> = answer.split(' ').map(|x| x.parse().unwrap()).collect();
                assert_eq!(found.len(), expected.len(), "{loops:?}");
                for (index, (&found, &expected)) in found.iter().zip(&expected).enumerate() {
                    let allowed = TOLERANCE * expected.abs().max(1.0);
                    assert!(
                        (found - expected).abs() <= allowed,
                        "number {index}: {found} is not {expected}: {loops:?}"
                    );
                }
            }
        }
    }
    assert_eq!(refused, 5);
}

fn answers(command: &mut Command, folder: &Path, questions: &str, mend: &str) -> String {
    let path = folder.join("questions");
    fs::write(&path, questions).unwrap();
    run(command.stdin(fs::File::open(path).unwrap()), mend)
}

#[test]
fn cpp_prepares_lights() {
    for target in ["hlsl", "msl", "glsl450", "spirv"] {
        assert!(export(target).path().join("prepare_light.hpp").is_file());
    }
    let folder = export("hlsl");
    let source = write(&folder, "main.cpp", CPP);
    let program = folder.path().join("main");
    run(
        Command::new("c++")
            .args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-O1", "-o"])
            .args([&program, &source]),
        "install Debian's build-essential, or run ./check",
    );
    let questions = questions();
    let mut command = Command::new(program);
    let answers = answers(&mut command, folder.path(), &asked(&questions), "");
    compare(&answers, &questions);
}

#[test]
fn javascript_prepares_lights() {
    for target in ["wgsl", "glsl-es300"] {
        assert!(export(target).path().join("prepare_light.js").is_file());
    }
    let folder = export("wgsl");
    write(&folder, "package.json", r#"{"type": "module"}"#);
    let source = write(&folder, "main.js", JS);
    let questions = questions();
    let answers = answers(
        Command::new("node").arg(source),
        folder.path(),
        &asked(&questions),
        "install Debian's nodejs, or run ./check",
    );
    compare(&answers, &questions);
}

#[test]
fn readme_fills_every_uniform_of_the_example() {
    let folder = export("glsl-es300");
    let readme = read(&folder, "README.md");
    let (_, script) = readme.split_once("```js\n").unwrap();
    let (script, _) = script.split_once("```").unwrap();
    let report = "for (const [name, ...values] of calls) console.log(name, ...values.slice(0, 2));";
    write(&folder, "package.json", r#"{"type": "module"}"#);
    let source = write(&folder, "main.js", &format!("{GL}\n{script}\n{report}"));
    let mut command = Command::new("node");
    command.arg(source).current_dir(folder.path());
    let calls = run(&mut command, "install Debian's nodejs, or run ./check");
    let example = read(&folder, "example.frag");
    let library = read(&folder, "lumigon.glsl");
    let (_, fields) = library.split_once("struct PolygonLight {\n").unwrap();
    let (fields, _) = fields.split_once("};").unwrap();
    let declared = |line: &str| {
        let name = line.trim().strip_suffix(';')?.rsplit(' ').next()?;
        Some(name.split('[').next()?.to_owned())
    };
    let fields = fields.lines().filter_map(declared);
    let uniforms = example.lines().filter(|line| line.starts_with("uniform "));
    let uniforms = uniforms.filter_map(declared);
    let wanted = fields.map(|name| format!("light.{name}")).chain(uniforms);
    let mut count = 0;
    for name in wanted.filter(|name| !["light", "ggx_table", "camera"].contains(&name.as_str())) {
        let line = calls
            .lines()
            .find(|line| line.ends_with(&format!(" {name}")));
        assert!(line.is_some(), "{name} is not set:\n{calls}");
        count += 1;
    }
    assert_eq!(count, 11, "{calls}");
    assert!(calls.contains("texImage2D TEXTURE_2D 0"), "{calls}");
}
