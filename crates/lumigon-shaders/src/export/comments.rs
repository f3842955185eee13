//! Doc comments, put back over what they describe.
//!
//! Writers of other languages drop comments. A translated text is still laid out one definition
//! after another, each starting at the margin of a line, fields in their order one a line; that is
//! enough to find every function, structure, field and constant by its name.

/// A definition, and the lines of its doc comment with their `///`.
#[derive(Debug)]
pub(super) struct Commented<'a> {
    pub(super) name: &'a str,
    pub(super) lines: Vec<&'a str>,
}

/// The library's doc comments, in their order.
#[derive(Debug, Default)]
pub(super) struct Comments<'a> {
    functions: Vec<Commented<'a>>,
    constants: Vec<Commented<'a>>,
    structures: Vec<Commented<'a>>,
    /// With their structure's name.
    fields: Vec<(&'a str, Commented<'a>)>,
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
            let lines = std::mem::take(&mut pending);
            if let Some(name) = named(line, "struct ", '{') {
                structure = Some(name);
                comments.structures.push(Commented { name, lines });
            } else if line.starts_with('}') {
                structure = None;
            } else if let Some(within) = structure {
                if let Some((name, _)) = trimmed.split_once(':') {
                    let name = name.trim();
                    comments.fields.push((within, Commented { name, lines }));
                }
            } else if let Some(name) = named(line, "fn ", '(') {
                comments.functions.push(Commented { name, lines });
            } else if let Some(name) = named(line, "const ", ':') {
                comments.constants.push(Commented { name, lines });
            }
        }
        comments
    }

    /// A translation of the same text, with the comments; `constant_prefix` is what the
    /// translation's constants have before their names.
    pub(super) fn restore(&'a self, translated: &str, constant_prefix: &str) -> String {
        let mut restored = String::with_capacity(2 * translated.len());
        let mut fields = [].as_slice();
        let find = |all: &'a [Commented<'a>], name: &str| {
            all.iter().find(|commented| commented.name == name)
        };
        for line in translated.lines() {
            let mut comment = None;
            if let Some(name) = named(line, "struct ", '{') {
                comment = find(&self.structures, name);
                let first = self.fields.iter().position(|(within, _)| *within == name);
                fields = first.map(|first| &self.fields[first..]).unwrap_or_default();
            } else if line.starts_with('}') {
                fields = &[];
            } else if let Some(name) = function_in(line) {
                comment = find(&self.functions, name);
            } else if let Some(name) = constant_in(line) {
                let name = name.strip_prefix(constant_prefix).unwrap_or(name);
                comment = find(&self.constants, name);
            } else if let [(_, field), rest @ ..] = fields
                && declared_as(field.name, line).is_some()
            {
                comment = Some(field);
                fields = rest;
            }
            let indent = &line[..line.len() - line.trim_start().len()];
            let lines = comment.map(|comment| comment.lines.as_slice());
            let is_definition = indent.is_empty() && lines.is_some();
            if is_definition && !restored.is_empty() && !restored.ends_with("\n\n") {
                restored.push('\n');
            }
            for commented in lines.into_iter().flatten() {
                restored.push_str(indent);
                restored.push_str(commented);
                restored.push('\n');
            }
            restored.push_str(line);
            restored.push('\n');
        }
        restored
    }

    /// Functions in their order.
    pub(super) fn functions(&self) -> &[Commented<'a>] {
        &self.functions
    }

    /// Structures in their order.
    pub(super) fn structures(&self) -> &[Commented<'a>] {
        &self.structures
    }

    /// Constants in their order.
    pub(super) fn constants(&self) -> &[Commented<'a>] {
        &self.constants
    }

    /// Fields that a translation calls otherwise: structure, name, and the name there.
    pub(super) fn renamed_fields<'t>(
        &self,
        translated: &'t str,
    ) -> Vec<(&'a str, &'a str, &'t str)> {
        let mut renamed = Vec::new();
        let mut within = "";
        for line in translated.lines() {
            if let Some(name) = named(line, "struct ", '{') {
                within = name;
            } else if line.starts_with('}') {
                within = "";
            }
            let fields = self.fields.iter().filter(|(of, _)| *of == within);
            // A field's own name comes before another's with a suffix.
            let name = fields
                .filter_map(|(of, field)| Some((*of, field.name, declared_as(field.name, line)?)))
                .max_by_key(|(_, name, _)| name.len());
            renamed.extend(name.filter(|(_, name, there)| name != there));
        }
        renamed
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

/// What a line that declares a field of this name calls it: writers append a suffix where the name
/// is a keyword.
fn declared_as<'a>(name: &str, line: &'a str) -> Option<&'a str> {
    let (_, declared) = line.trim().strip_suffix(';')?.rsplit_once(' ')?;
    let declared = declared.split('[').next().unwrap_or_default();
    let suffix = declared.strip_prefix(name)?;
    (suffix.is_empty() || suffix.starts_with('_')).then_some(declared)
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
        let comments = Comments::read(wgsl);
        assert_eq!(comments.renamed_fields(glsl), [("S", "sample", "sample_")]);
        let restored = comments.restore(glsl, "L_");
        assert_eq!(
            restored,
            "/// A.\nstruct S {\n    float plain;\n    /// Sample.\n    /// More.\n    vec3 sample_;\n};\n\n\
             /// Pi.\nconst float L_PI = 3.0;\n\n/// F.\nfloat f(float x) {\n    return x;\n}\n"
        );
    }
}
