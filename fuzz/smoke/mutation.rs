//! Mutations: what disks, networks and people do to files, and what fuzzers do.

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

    /// The `index`th input: a seed with one to six mutations.
    pub(super) fn input(&self, index: u64) -> Vec<u8> {
        let mut rng = Pcg64Mcg::seed_from_u64(index);
        let mut input = self.seed(&mut rng).clone();
        for _ in 0..rng.random_range(1..=6) {
            self.mutate(&mut input, &mut rng);
        }
        input.truncate(LONGEST);
        // Most mutations change the length, and a container that fails there tests no more.
        if rng.random_bool(0.8) {
            mend_glb(&mut input);
        }
        input
    }

    fn seed(&self, rng: &mut Pcg64Mcg) -> &'a Vec<u8> {
        &self.seeds[rng.random_range(0..self.seeds.len())]
    }

    fn mutate(&self, input: &mut Vec<u8>, rng: &mut Pcg64Mcg) {
        if input.is_empty() {
            input.push(rng.random());
        }
        let at = rng.random_range(0..input.len());
        let end = (at + rng.random_range(1..=16)).min(input.len());
        match rng.random_range(0..20) {
            0..3 => input[at] ^= 1 << rng.random_range(0..8),
            3 => input[at] = rng.random(),
            4 => input.truncate(at),
            5 => drop(input.drain(at..end)),
            6 => {
                let piece = input[at..end].to_vec();
                let to = rng.random_range(0..=input.len());
                input.splice(to..to, piece);
            }
            7 => {
                let other = self.seed(rng);
                let from = rng.random_range(0..other.len());
                input.truncate(at);
                input.extend_from_slice(&other[from..]);
            }
            8..10 => {
                let at = at & !3;
                if let Some(word) = input.get_mut(at..at + 4) {
                    let edge = WORDS[rng.random_range(0..WORDS.len())];
                    word.copy_from_slice(&edge.to_le_bytes());
                }
            }
            10..15 => {
                // A whole number of the text for one at the edge of a type.
                let is_number = |byte: &u8| matches!(byte, b'0'..=b'9' | b'.' | b'-' | b'+' | b'e');
                let Some(start) = input[at..].iter().position(is_number) else {
                    return;
                };
                let start = at + start;
                let length = input[start..].iter().take_while(|byte| is_number(byte));
                let end = start + length.count();
                let number = EDGES[rng.random_range(0..EDGES.len())];
                input.splice(start..end, number.iter().copied());
            }
            15..18 if !self.tokens.is_empty() => {
                let token = &self.tokens[rng.random_range(0..self.tokens.len())];
                let replaced = if rng.random() { at } else { end };
                input.splice(at..replaced, token.iter().copied());
            }
            _ => {
                // One token's place taken by another of the file's own.
                let quoted = |from: usize| {
                    let open = from + input[from..].iter().position(|&byte| byte == b'"')?;
                    let length = input[open + 1..].iter().position(|&byte| byte == b'"')?;
                    Some(open..open + length + 2)
                };
                let other = rng.random_range(0..input.len());
                if let (Some(to), Some(from)) = (quoted(at), quoted(other)) {
                    let piece = input[from].to_vec();
                    input.splice(to, piece);
                }
            }
        }
    }
}

/// Makes the lengths in a binary glTF file fit again.
fn mend_glb(input: &mut [u8]) {
    if !input.starts_with(b"glTF") || input.len() < 20 {
        return;
    }
    let word = |length: usize| (length as u32).to_le_bytes();
    let total = input.len();
    input[8..12].copy_from_slice(&word(total));
    let binary = input.windows(4).skip(20).position(|four| four == b"BIN\0");
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
