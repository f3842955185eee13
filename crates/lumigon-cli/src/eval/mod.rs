//! `lumigon eval`: integrals by the million, as JSON lines.

mod answer;
mod lines;
mod mirror;
mod question;

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use rayon::prelude::*;

use crate::Failure;
pub use answer::{Answer, Number, Value, answer};
use lines::{Batch, Line, LongestLine, ReadAhead};
pub use question::QuestionError;

/// The number type to compute in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Precision {
    /// Single precision, as the renderers compute
    F32,
    /// Double precision
    #[default]
    F64,
}

/// Answers questions about light from polygons: JSON lines in, JSON lines out, in the same order
#[derive(Debug, Args)]
#[command(after_help = "\
A question is one line:
  loops                 [[[x,y,z], ...], ...], counter-clockwise seen from the emitting side, holes
                        clockwise; radiance is 1
  point                 [x,y,z], the shading point
  quantity              irradiance, form_factor, light_vector (unclipped), solid_angle (unclipped),
                        projected_area, ltc (a fitted table), reflected_inclusion and
                        reflected_distance (of the mirrored view), or a BRDF itself by cubature: ggx,
                        ggx_anisotropic, charlie, eon
  normal                [x,y,z], unit; all but light_vector and solid_angle want it
  view                  [x,y,z], unit, from the point to the viewer (ltc, mirrored views and BRDFs)
  two_sided             true or false, false unless given
  table                 of ltc: ggx, ggx-2 (two lobes), ggx-anisotropic, charlie or eon; ggx unless
                        given
  basis                 centroid, weighted, biased or optimal (projected_area)
  bias                  how far behind the point, 0.5 unless given (basis biased)
  occlusion             exact or circle, exact unless given (projected_area)
  resolution, phi       of the distance field, 128 and 2 unless given (reflected_distance)
  smoothness            k of 1/(1 + d)^k, from the roughness unless given (reflected_distance)
  texture               what the light shows: {\"texels\":[[[r,g,b], ...], ...], rows of linear RGB,
                        \"corner\":[x,y,z] of the first, \"edge_u\":[x,y,z] along the rows,
                        \"edge_v\":[x,y,z] down the columns, \"method\": lookup, 1x1, 2x2, 3x3 or 4x4,
                        2x2 unless given}; rows and columns are powers of two, and the value is RGB
A BRDF, and ltc with its table, want their own numbers from 0 to 1; reflected_distance wants ggx's:
  ggx                   perceptual_roughness, the square root of alpha
  ggx_anisotropic       the same, anisotropy_strength as in KHR_materials_anisotropy, and tangent,
                        [x,y,z], unit, along the greater width
  charlie               sheen_perceptual_roughness
  eon                   diffuse_roughness
Other fields and blank lines are ignored. The answer is {\"value\":...}, or {\"error\":\"...\"}; the
exit code is 1 where any line failed. Beside the value GGX has \"schlick\", the same weighted with
(1 - h.v)^5; EON's value is light scattered once by a white surface, and \"multiple\" what is
scattered more than once for a multiple-scattering albedo of 1. Cubature is in double precision
whatever --precision says.

Examples:
  lumigon eval questions.jsonl > answers.jsonl
  echo '{\"quantity\":\"irradiance\",\"loops\":[[[-1,1,-1],[1,1,-1],[1,1,1],[-1,1,1]]],\"point\":[0,0,0],\
\"normal\":[0,1,0]}' | lumigon eval")]
pub struct Eval {
    /// File of questions, one a line; - for standard input
    #[arg(value_name = "FILE", default_value = "-")]
    file: PathBuf,
    /// Number type to compute in
    #[arg(long, value_enum, default_value_t)]
    precision: Precision,
}

/// Longest question in bytes.
const LONGEST_LINE: LongestLine = LongestLine(16 << 20);

impl Eval {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let input: Box<dyn Read + Send> = if self.file.as_os_str() == "-" {
            Box::new(io::stdin())
        } else {
            let file = File::open(&self.file)
                .map_err(|error| format!("{}: {error}", self.file.display()))?;
            Box::new(file)
        };
        let output = BufWriter::with_capacity(1 << 16, io::stdout().lock());
        let tally = match answer_all(input, output, self.precision) {
            Ok(tally) => tally,
            Err(StreamError::Write(error)) if error.kind() == io::ErrorKind::BrokenPipe => {
                return Ok(());
            }
            Err(StreamError::Write(error)) => return Err(format!("the answers: {error}").into()),
            Err(StreamError::Read(error)) => {
                return Err(format!("{}: {error}", self.file.display()).into());
            }
        };
        match tally.first_failed {
            None => Ok(()),
            Some(first) => Err(format!(
                "{} of {} questions failed, the first on line {first}",
                tally.failed, tally.questions
            )
            .into()),
        }
    }
}

#[derive(Debug)]
enum StreamError {
    Read(io::Error),
    Write(io::Error),
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Tally {
    questions: u64,
    failed: u64,
    /// Number of the first failed line, from 1.
    first_failed: Option<u64>,
}

/// Answers every line of `input`, in order, as soon as there is one.
fn answer_all(
    input: impl Read + Send + 'static,
    mut output: impl Write,
    precision: Precision,
) -> Result<Tally, StreamError> {
    let ahead = ReadAhead::start(input, LONGEST_LINE).map_err(StreamError::Read)?;
    let mut batch = Batch::default();
    let mut tally = Tally::default();
    let mut lines_before = 0;
    // How many lines to answer before writing: a wait that nobody notices, whatever they cost.
    let mut portion = 64;
    loop {
        let more = ahead.next(&mut batch);
        let mut rest = batch.lines();
        while !rest.is_empty() {
            let (lines, later) = rest.split_at(portion.min(rest.len()));
            rest = later;
            let start = Instant::now();
            let chunk = (lines.len() / (8 * rayon::current_num_threads())).clamp(1, 512);
            let answered: Vec<Answered> = lines
                .par_chunks(chunk)
                .map(|lines| Answered::new(&batch, lines, precision))
                .collect();
            let elapsed = start.elapsed();
            if elapsed > Duration::from_millis(100) {
                portion = (portion / 2).max(2);
            } else if elapsed < Duration::from_millis(25) && lines.len() == portion {
                portion = (portion * 2).min(1 << 16);
            }
            for part in answered {
                output.write_all(&part.text).map_err(StreamError::Write)?;
                tally.questions += part.questions;
                tally.failed += part.failed;
                if let (None, Some(first)) = (tally.first_failed, part.first_failed) {
                    tally.first_failed = Some(lines_before + first as u64 + 1);
                }
                lines_before += part.lines as u64;
            }
            output.flush().map_err(StreamError::Write)?;
        }
        if !more.map_err(StreamError::Read)? {
            return Ok(tally);
        }
    }
}

/// The answers to some lines.
struct Answered {
    text: Vec<u8>,
    lines: usize,
    questions: u64,
    failed: u64,
    /// Index of the first failed one among the lines.
    first_failed: Option<usize>,
}

impl Answered {
    fn new(batch: &Batch, lines: &[Line], precision: Precision) -> Self {
        let mut answered = Self {
            text: Vec::with_capacity(40 * lines.len()),
            lines: lines.len(),
            questions: 0,
            failed: 0,
            first_failed: None,
        };
        for (index, line) in lines.iter().enumerate() {
            let answer = match batch.text(line) {
                Some(line) if line.trim_ascii().is_empty() => continue,
                Some(line) => std::str::from_utf8(line)
                    .map_err(QuestionError::NotUtf8)
                    .and_then(|line| answer(line, precision)),
                None => Err(QuestionError::TooLong {
                    most: LONGEST_LINE.0,
                }),
            };
            answered.questions += 1;
            if answer.is_err() {
                answered.failed += 1;
                answered.first_failed.get_or_insert(index);
            }
            answer::write(&answer, &mut answered.text);
            answered.text.push(b'\n');
        }
        answered
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answered(input: &[u8]) -> (Vec<String>, Tally) {
        let mut output = Vec::new();
        let input = io::Cursor::new(input.to_vec());
        let tally = answer_all(input, &mut output, Precision::F64).unwrap();
        let text = String::from_utf8(output).unwrap();
        (text.lines().map(str::to_owned).collect(), tally)
    }

    #[test]
    fn failed_lines_are_answered_and_counted() {
        let good =
            r#"{"quantity":"solid_angle","loops":[[[0,0,1],[0,1,1],[1,0,1]]],"point":[0,0,0]}"#;
        let input = format!("\n{good}\r\n   \nnonsense\n{good}");
        let (answers, tally) = answered(input.as_bytes());
        assert_eq!(answers.len(), 3);
        assert_eq!(answers[0], answers[2]);
        assert!(answers[0].starts_with("{\"value\":0."), "{}", answers[0]);
        assert!(
            answers[1].starts_with("{\"error\":\"column 2: "),
            "{}",
            answers[1]
        );
        let expected = Tally {
            questions: 3,
            failed: 1,
            first_failed: Some(4),
        };
        assert_eq!(tally, expected);
    }

    #[test]
    fn bytes_that_are_no_text_are_an_error_of_their_line() {
        let (answers, tally) = answered(b"\xff\xfe\n{}\n");
        assert!(answers[0].contains("UTF-8"), "{}", answers[0]);
        assert!(answers[1].contains("missing field"), "{}", answers[1]);
        assert_eq!(tally.failed, 2);
    }

    /// Writes nothing but what fits, like a full disk.
    struct Full(usize);

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.0 == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            let count = bytes.len().min(self.0);
            self.0 -= count;
            Ok(count)
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn full_disk_is_reported() {
        let input = io::Cursor::new(b"{}\n".repeat(1000));
        let error = answer_all(input, Full(1000), Precision::F64).unwrap_err();
        let StreamError::Write(error) = error else {
            panic!("{error:?}")
        };
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    }
}
