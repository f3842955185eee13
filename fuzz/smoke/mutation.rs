//! Mutations: what disks, networks and people do to files, and what fuzzers do.

use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Longest input; libFuzzer's default for a corpus of small files is the same.
const LONGEST: usize = 64 << 10;

/// Bytes and numbers at the edges of types.
const EDGES: [&[u8]; 18] = [
    b"0",
    b"-0",
    b"-1",
    b"1",
    b"2",
    b"127",
    b"255",
    b"65535",
    b"4294967295",
    b"9007199254740993",
    b"18446744073709551615",
    b"1e-45",
    b"3.4028235e38",
    b"1e39",
    b"-1e308",
    b"1e999",
    b"null",
    b"0.1",
];
const WORDS: [u32; 10] = [
    0,
    1,
    0x7fff_ffff,
    0x8000_0000,
    u32::MAX,
    0x3f80_0000, // 1.0
    0x7f80_0000, // infinity
    0x7fc0_0000, // NaN
    0x7f7f_ffff, // the largest f32
    0x0000_8000, // a subnormal
];

/// Makes inputs from seeds.
pub(super) struct Mutator<'a> {
    seeds: &'a [Vec<u8>],
    tokens: Vec<Vec<u8>>,
}

impl<'a> Mutator<'a> {
    pub(super) fn new(seeds: &'a [Vec<u8>], tokens: Vec<Vec<u8>>) -> Self {
        Self { seeds, tokens }
    }

    /// The `index`th input: a seed with a few mutations. Most inputs keep the syntax of JSON, or
    /// nothing behind the parser would ever be reached.
    pub(super) fn input(&self, index: u64) -> Vec<u8> {
        let mut rng = Pcg64Mcg::seed_from_u64(index);
        let mut input = self.seed(&mut rng).clone();
        let keeps_syntax = rng.random_bool(0.75);
        for _ in 0..rng.random_range(1..=4) {
            if input.is_empty() {
                input.push(rng.random());
            }
            if keeps_syntax {
                self.mutate_values(&mut input, &mut rng);
            } else {
                self.mutate_bytes(&mut input, &mut rng);
            }
        }
        input.truncate(LONGEST);
        // Most mutations change the length, and a container that fails there tests no more.
        if keeps_syntax || rng.random_bool(0.5) {
            mend_glb(&mut input);
        }
        input
    }

    fn seed(&self, rng: &mut Pcg64Mcg) -> &'a Vec<u8> {
        &self.seeds[rng.random_range(0..self.seeds.len())]
    }

    /// Numbers for numbers, strings for strings, a field more, and anything for binary data.
    fn mutate_values(&self, input: &mut Vec<u8>, rng: &mut Pcg64Mcg) {
        let json_end = find(input, b"BIN\0").unwrap_or(input.len());
        if json_end < input.len() && rng.random_bool(0.3) {
            let at = rng.random_range(json_end..input.len());
            mutate_word(input, at, rng);
            return;
        }
        let at = rng.random_range(0..json_end);
        let other = rng.random_range(0..json_end);
        match rng.random_range(0..10) {
            0..3 => {
                if let Some(to) = number_after(input, at) {
                    let edge = EDGES[rng.random_range(0..EDGES.len())];
                    input.splice(to, edge.iter().copied());
                }
            }
            3..6 => {
                if let (Some(to), Some(from)) =
                    (number_after(input, at), number_after(input, other))
                {
                    let number = input[from].to_vec();
                    input.splice(to, number);
                }
            }
            6 => {
                // A neighbour: one less is an index still in range, one more may not be.
                if let Some(to) = number_after(input, at)
                    && let Some(digit) = input[to].last_mut()
                    && digit.is_ascii_digit()
                {
                    *digit = if *digit == b'9' { b'0' } else { *digit + 1 };
                }
            }
            7 => {
                if let (Some(to), Some(from)) =
                    (string_after(input, at), string_after(input, other))
                {
                    let string = input[from].to_vec();
                    input.splice(to, string);
                }
            }
            _ => {
                let fields: Vec<_> = self.tokens.iter().filter(|t| t.contains(&b':')).collect();
                if let Some(brace) = input[at..json_end].iter().position(|&byte| byte == b'{')
                    && !fields.is_empty()
                {
                    let mut field = fields[rng.random_range(0..fields.len())].clone();
                    field.push(b',');
                    input.splice(at + brace + 1..at + brace + 1, field);
                }
            }
        }
    }

    /// What disks and wires do.
    fn mutate_bytes(&self, input: &mut Vec<u8>, rng: &mut Pcg64Mcg) {
        let at = rng.random_range(0..input.len());
        let end = (at + rng.random_range(1..=16)).min(input.len());
        match rng.random_range(0..10) {
            0..2 => input[at] ^= 1 << rng.random_range(0..8),
            2 => input[at] = rng.random(),
            3 => input.truncate(at),
            4 => drop(input.drain(at..end)),
            5 => {
                let piece = input[at..end].to_vec();
                let to = rng.random_range(0..=input.len());
                input.splice(to..to, piece);
            }
            6 => {
                let other = self.seed(rng);
                let from = rng.random_range(0..other.len());
                input.truncate(at);
                input.extend_from_slice(&other[from..]);
            }
            7 => mutate_word(input, at, rng),
            _ if self.tokens.is_empty() => {}
            _ => {
                let token = &self.tokens[rng.random_range(0..self.tokens.len())];
                let replaced = if rng.random() { at } else { end };
                input.splice(at..replaced, token.iter().copied());
            }
        }
    }
}

/// A little-endian word of binary data becomes one at the edge of its type.
fn mutate_word(input: &mut [u8], at: usize, rng: &mut Pcg64Mcg) {
    let at = at & !3;
    if let Some(word) = input.get_mut(at..at + 4) {
        let edge = WORDS[rng.random_range(0..WORDS.len())];
        word.copy_from_slice(&edge.to_le_bytes());
    }
}

/// The first JSON number at or behind `from`. Digits within strings count too.
fn number_after(input: &[u8], from: usize) -> Option<Range<usize>> {
    let is_part = |byte: u8| matches!(byte, b'0'..=b'9' | b'.' | b'-' | b'+' | b'e' | b'E');
    // Behind what separates values, so that no digit is taken out of the middle of a word.
    let separator = |byte: &u8| matches!(byte, b':' | b',' | b'[' | b' ');
    let start = input[from..]
        .windows(2)
        .position(|two| separator(&two[0]) && matches!(two[1], b'0'..=b'9' | b'-'))?;
    let start = from + start + 1;
    let length = input[start..]
        .iter()
        .take_while(|&&byte| is_part(byte))
        .count();
    Some(start..start + length)
}

/// The first quoted string behind `from`, with its quotes.
fn string_after(input: &[u8], from: usize) -> Option<Range<usize>> {
    // Only an opening quote stands behind these.
    let opens = |two: &[u8]| matches!(two[0], b':' | b',' | b'[' | b'{') && two[1] == b'"';
    let open = from + input[from..].windows(2).position(opens)? + 1;
    let length = input[open + 1..].iter().position(|&byte| byte == b'"')?;
    Some(open..open + length + 2)
}

fn find(input: &[u8], wanted: &[u8; 4]) -> Option<usize> {
    input.windows(4).position(|four| four == wanted)
}

/// Makes the lengths in a binary glTF file fit again.
fn mend_glb(input: &mut [u8]) {
    if !input.starts_with(b"glTF") || input.len() < 20 {
        return;
    }
    let word = |length: usize| (length as u32).to_le_bytes();
    let total = input.len();
    input[8..12].copy_from_slice(&word(total));
    let binary = find(&input[20..], b"BIN\0");
    // The chunk's length stands before its name.
    let json_end = binary.map_or(total, |at| at + 20 - 4);
    if json_end < 20 {
        return;
    }
    input[12..16].copy_from_slice(&word(json_end - 20));
    if binary.is_some() {
        let length = total - json_end - 8;
        input[json_end..json_end + 4].copy_from_slice(&word(length));
    }
}

/// The tokens of a libFuzzer dictionary: `"token"` a line, with `\xAB`, `\"` and `\\`.
pub(super) fn tokens(dictionary: &str) -> Vec<Vec<u8>> {
    dictionary
        .lines()
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .map(|line| {
            token(line).unwrap_or_else(|| panic!("{line}: not a line of a libFuzzer dictionary"))
        })
        .collect()
}

fn token(line: &str) -> Option<Vec<u8>> {
    let mut bytes = line.strip_prefix('"')?.strip_suffix('"')?.bytes();
    let mut token = Vec::new();
    while let Some(byte) = bytes.next() {
        token.push(match byte {
            b'\\' => match bytes.next()? {
                b'x' => {
                    let digits = [bytes.next()?, bytes.next()?];
                    u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?
                }
                escaped => escaped,
            },
            byte => byte,
        });
    }
    Some(token)
}
