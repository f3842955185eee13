//! Doc comments, put back over what they describe.
//!
//! Writers of other languages drop comments. A translated text is still laid out one definition
//! after another, each starting at the margin of a line, fields in their order one a line; that is
//! enough to find every function, structure, field and constant by its name.

use std::collections::HashMap;

/// The library's doc comments, each the lines with their `///`.
#[derive(Debug, Default)]
pub(super) struct Comments<'a> {
    functions: HashMap<&'a str, Vec<&'a str>>,
    constants: HashMap<&'a str, Vec<&'a str>>,
    structures: HashMap<&'a str, Vec<&'a str>>,
    /// In their order, with their structure's name.
    fields: Vec<(&'a str, &'a str, Vec<&'a str>)>,
}

impl<'a> Comments<'a> {
    /// Reads them from WGSL whose definitions start at the margin.
    pub(super) fn read(wgsl: &'a str) -> Self {
        let mut comments = Self::default();
        let mut pending = Vec::new();
        let mut structure = None;
        for line in wgsl.lines() {
            let trimmed = line.trim();
            if trimmed.starts_with("///") {
                pending.push(trimmed);
                continue;
            }
            let comment = std::mem::take(&mut pending);
            if let Some(name) = named(line, "struct ", '{') {
                structure = Some(name);
                comments.structures.insert(name, comment);
            } else if line.starts_with('}') {
                structure = None;
            } else if let Some(within) = structure {
                if let Some((name, _)) = trimmed.split_once(':') {
                    comments.fields.push((within, name.trim(), comment));
                }
            } else if let Some(name) = named(line, "fn ", '(') {
                comments.functions.insert(name, comment);
            } else if let Some(name) = named(line, "const ", ':') {
                comments.constants.insert(name, comment);
            }
        }
        comments
    }

    /// A translation of the same text, with the comments; `constant_prefix` is what the
    /// translation's constants have before their names.
    pub(super) fn restore(&self, translated: &str, constant_prefix: &str) -> String {
        let mut restored = String::with_capacity(2 * translated.len());
        let mut fields = [].as_slice();
        for line in translated.lines() {
            let mut comment = None;
            if let Some(name) = named(line, "struct ", '{') {
                comment = self.structures.get(name);
                let first = self.fields.iter().position(|(within, ..)| *within == name);
                fields = first.map(|first| &self.fields[first..]).unwrap_or_default();
            } else if line.starts_with('}') {
                fields = &[];
            } else if let Some(name) = function_in(line) {
                comment = self.functions.get(name);
            } else if let Some(name) = constant_in(line) {
                let name = name.strip_prefix(constant_prefix).unwrap_or(name);
                comment = self.constants.get(name);
            } else if let [(_, name, lines), rest @ ..] = fields
                && is_declared_in(name, line)
            {
                comment = Some(lines);
                fields = rest;
            }
            let indent = &line[..line.len() - line.trim_start().len()];
            let is_definition = indent.is_empty() && comment.is_some();
            if is_definition && !restored.is_empty() && !restored.ends_with("\n\n") {
                restored.push('\n');
            }
            for commented in comment.into_iter().flatten() {
                restored.push_str(indent);
                restored.push_str(commented);
                restored.push('\n');
            }
            restored.push_str(line);
            restored.push('\n');
        }
        restored
    }

    /// Functions without a comment.
    #[cfg(test)]
    pub(super) fn undocumented(&self) -> Vec<&'a str> {
        let functions = self.functions.iter().filter(|(_, lines)| lines.is_empty());
        functions.map(|(name, _)| *name).collect()
    }

    /// The comment of a function.
    #[cfg(test)]
    pub(super) fn of_function(&self, name: &str) -> &[&'a str] {
        self.functions.get(name).map(Vec::as_slice).unwrap_or_default()
    }
}

/// The name between a keyword at the margin and what must follow the name.
fn named<'a>(line: &'a str, keyword: &str, before: char) -> Option<&'a str> {
    let (name, _) = line.strip_prefix(keyword)?.split_once(before)?;
    Some(name.trim())
}

/// Name of the function that starts on this line: a type, a name and a bracket at the margin, and
/// no semicolon.
fn function_in(line: &str) -> Option<&str> {
    if line.starts_with(|c: char| !c.is_ascii_alphabetic()) || line.trim_end().ends_with(';') {
        return None;
    }
    let (before, _) = line.split_once('(')?;
    let (_, name) = before.rsplit_once(' ')?;
    Some(name)
}

/// Name of the constant that is defined on this line.
fn constant_in(line: &str) -> Option<&str> {
    if !["const ", "static const ", "constant "]
        .iter()
        .any(|keyword| line.starts_with(keyword))
    {
        return None;
    }
    let (before, _) = line.split_once('=')?;
    let declared = before.trim_end().split('[').next()?;
    let (_, name) = declared.rsplit_once(' ')?;
    Some(name)
}

/// Whether a line declares a field of this name, or of the name with a suffix: writers append one
/// where the name is a keyword.
fn is_declared_in(name: &str, line: &str) -> bool {
    let Some(declared) = line.trim().strip_suffix(';') else {
        return false;
    };
    let Some((_, declared)) = declared.rsplit_once(' ') else {
        return false;
    };
    let declared = declared.split('[').next().unwrap_or_default();
    declared
        .strip_prefix(name)
        .is_some_and(|suffix| suffix.is_empty() || suffix.starts_with('_'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_come_back() {
        let wgsl = "/// A.\nstruct S {\n    plain: f32,\n    /// Sample.\n    /// More.\n    sample: vec3f,\n}\n\
                    /// Pi.\nconst PI: f32 = 3.0;\n\n/// F.\nfn f(\n    x: f32,\n) -> f32 {\n    return x;\n}\n";
        let glsl = "struct S {\n    float plain;\n    vec3 sample_;\n};\nconst float L_PI = 3.0;\n\n\
                    float f(float x) {\n    return x;\n}\n";
        let restored = Comments::read(wgsl).restore(glsl, "L_");
        assert_eq!(
            restored,
            "/// A.\nstruct S {\n    float plain;\n    /// Sample.\n    /// More.\n    vec3 sample_;\n};\n\n\
             /// Pi.\nconst float L_PI = 3.0;\n\n/// F.\nfloat f(float x) {\n    return x;\n}\n"
        );
    }
}
