//! A prefix for all names, where an engine has functions of the same names.

use std::collections::HashSet;

use super::comments::Comments;

/// The longest; names of 64 characters are no trouble anywhere.
const LONGEST: usize = 32;

/// A prefix, and the names that get it.
#[derive(Clone, Debug)]
pub(super) struct Prefix {
    text: String,
    functions: HashSet<String>,
    structures: HashSet<String>,
    constants: HashSet<String>,
}

impl Prefix {
    /// Why `prefix` cannot start a name in every language; nothing where it can.
    pub(super) fn fault(prefix: &str) -> Option<&'static str> {
        let is_letter = |c: char| c.is_ascii_lowercase();
        if !prefix.starts_with(is_letter) {
            return Some("it must start with a lower-case letter");
        }
        if !prefix
            .chars()
            .all(|c| is_letter(c) || c.is_ascii_digit() || c == '_')
        {
            return Some("it must consist of lower-case letters, digits and _");
        }
        if prefix.len() > LONGEST {
            return Some("it must have at most 32 characters");
        }
        if prefix.contains("__") || prefix.starts_with("gl_") || prefix.starts_with("naga_") {
            return Some("names with __, gl_ or naga_ belong to compilers");
        }
        None
    }

    /// The prefix of everything that `wgsl` defines.
    pub(super) fn new(prefix: &str, wgsl: &str) -> Self {
        let comments = Comments::read(wgsl);
        let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect();
        Self {
            text: prefix.to_owned(),
            functions: owned(comments.functions().iter().map(|f| f.name).collect()),
            structures: owned(comments.structures().iter().map(|s| s.name).collect()),
            constants: owned(comments.constants().iter().map(|c| c.name).collect()),
        }
    }

    /// A shader or a text about it, with the prefix before functions (where they are called, defined
    /// or quoted) and structures.
    pub(super) fn apply(&self, text: &str) -> String {
        rename(text, |before, word, after| {
            if before == Some('.') {
                return None;
            }
            let is_quoted = matches!((before, after.chars().next()), (Some('`'), Some('`')))
                || matches!((before, after.chars().next()), (Some('['), Some(']')));
            let is_function = after.starts_with('(') || is_quoted;
            let is_named = is_function && self.functions.contains(word);
            // Rust's own PolygonLight stays.
            let is_type = self.structures.contains(word) && !after.starts_with("::");
            (is_named || is_type).then(|| format!("{}{word}", self.text))
        })
    }

    /// The library's text with the prefix; upper-case before constants.
    pub(super) fn apply_to_library(&self, wgsl: &str) -> String {
        let constants = self.text.to_ascii_uppercase();
        rename(&self.apply(wgsl), |_, word, _| {
            self.constants
                .contains(word)
                .then(|| format!("{constants}{word}"))
        })
    }

    /// What constants start with.
    pub(super) fn of_constants(&self) -> String {
        self.text.to_ascii_uppercase()
    }
}

/// `text` with each identifier as `name` wants it, from the character before it, itself, and what
/// follows.
fn rename(text: &str, name: impl Fn(Option<char>, &str, &str) -> Option<String>) -> String {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut renamed = String::with_capacity(text.len() + text.len() / 4);
    let mut rest = text;
    let mut before = None;
    while let Some(first) = rest.chars().next() {
        let length = match first {
            _ if is_part(first) => rest.find(|c| !is_part(c)).unwrap_or(rest.len()),
            _ => first.len_utf8(),
        };
        let (word, after) = rest.split_at(length);
        match name(before, word, after) {
            Some(new) if is_part(first) => renamed += &new,
            _ => renamed += word,
        }
        before = word.chars().next_back();
        rest = after;
    }
    renamed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_where_they_are_names() {
        let wgsl = "const TINY: f32 = 1e-37;\nstruct Seen {\n    see: f32,\n}\nfn see(x: f32) -> Seen {\n}\n";
        let prefix = Prefix::new("lumi_", wgsl);
        assert_eq!(
            prefix.apply("see(a.see, see) `see` [see] Seen(1) ours_see( Seen::new see_not("),
            "lumi_see(a.see, see) `lumi_see` [lumi_see] lumi_Seen(1) ours_see( Seen::new see_not("
        );
        assert_eq!(
            prefix.apply_to_library("let x = TINY + TINYER;"),
            "let x = LUMI_TINY + TINYER;"
        );
        assert_eq!(prefix.apply("ü see(ü)"), "ü lumi_see(ü)");
    }

    #[test]
    fn prefixes_that_no_language_allows() {
        for bad in [
            "",
            "_x",
            "X_",
            "9",
            "gl_x_",
            "a__b",
            "naga_",
            "é",
            "a b",
            &"x".repeat(33),
        ] {
            assert!(Prefix::fault(bad).is_some(), "{bad:?}");
        }
        assert_eq!(Prefix::fault("lumigon_"), None);
    }
}
