//! The library in other languages, as functions to call: no entry point, no binding.

mod comments;
mod glsl;
mod hlsl;
mod library;
mod msl;
mod prefix;
mod spirv;
mod target;

pub use library::{ExportError, Library};
pub use target::Target;

#[cfg(test)]
mod tests {
    use super::comments::Comments;
    use super::*;

    const TEXTS: [Target; 5] = [
        Target::Wgsl,
        Target::GlslEs300,
        Target::Glsl450,
        Target::Hlsl,
        Target::Msl,
    ];

    fn text(library: &Library, target: Target) -> String {
        String::from_utf8(library.export(target).unwrap()).unwrap()
    }

    /// The lines over a definition that starts with `start` where the margin is.
    fn comment_over(text: &str, is_start: impl Fn(&str) -> bool) -> Option<Vec<&str>> {
        let lines: Vec<&str> = text.lines().collect();
        let at = lines.iter().position(|line| is_start(line))?;
        let mut comment: Vec<_> = lines[..at]
            .iter()
            .rev()
            .take_while(|line| line.starts_with("///"))
            .copied()
            .collect();
        comment.reverse();
        Some(comment)
    }

    #[test]
    fn every_function_keeps_its_name_and_comment() {
        let library = Library::new().unwrap();
        let comments = Comments::read(library.text());
        assert!(comments.functions().len() > 50);
        for target in TEXTS {
            let text = text(&library, target);
            for function in comments.functions() {
                let name = function.name;
                let is_start = |line: &str| {
                    let before = line.split_once('(').map(|(before, _)| before);
                    let word = before.and_then(|before| before.rsplit(' ').next());
                    !line.starts_with([' ', '/']) && !line.ends_with(';') && word == Some(name)
                };
                let comment = comment_over(&text, is_start);
                let comment = comment.unwrap_or_else(|| panic!("{target:?} has no {name}"));
                assert_eq!(comment, function.lines, "{target:?}: {name}");
                assert!(!comment.is_empty(), "{name} has no comment");
            }
        }
    }

    #[test]
    fn every_structure_keeps_its_name_and_fields() {
        let library = Library::new().unwrap();
        let wgsl = library.text();
        for target in TEXTS {
            let text = text(&library, target);
            for line in wgsl.lines().filter(|line| line.starts_with("struct ")) {
                assert!(
                    text.lines().any(|found| found == line),
                    "{target:?}: {line}"
                );
            }
            let documented = wgsl.lines().filter(|line| line.starts_with("    ///"));
            let kept = text.lines().filter(|line| line.starts_with("    ///"));
            let (mut documented, mut kept): (Vec<_>, Vec<_>) =
                (documented.collect(), kept.collect());
            documented.sort();
            kept.sort();
            assert_eq!(kept, documented, "{target:?}");
        }
    }

    #[test]
    fn engines_macros_do_not_meet_constants() {
        let library = Library::new().unwrap();
        for target in [
            Target::GlslEs300,
            Target::Glsl450,
            Target::Hlsl,
            Target::Msl,
        ] {
            let text = text(&library, target);
            let defined: Vec<_> = text
                .lines()
                .filter(|line| {
                    ["const ", "static const ", "constant "]
                        .iter()
                        .any(|keyword| line.starts_with(keyword))
                })
                .collect();
            assert!(!defined.is_empty(), "{target:?}");
            for line in defined {
                assert!(line.contains(" LUMIGON_"), "{target:?}: {line}");
            }
        }
    }

    #[test]
    fn prefix_is_before_every_name() {
        let plain = Library::new().unwrap();
        let library = Library::with_prefix("our_").unwrap();
        let names: Vec<_> = plain
            .functions()
            .map(|name| format!("our_{name}"))
            .collect();
        assert_eq!(library.functions().collect::<Vec<_>>(), names);
        for target in TEXTS {
            let text = text(&library, target);
            let words: Vec<_> = text
                .split(|c: char| !c.is_ascii_alphanumeric() && c != '_')
                .collect();
            let structures = Comments::read(plain.text());
            let structures = structures.structures().iter().map(|s| s.name);
            for name in structures.chain(["LUMIGON_PI", "PI"]) {
                assert!(!words.contains(&name), "{target:?}: {name}");
            }
            assert!(words.contains(&"OUR_PI"), "{target:?}");
            for line in text.lines().filter(|line| line.starts_with("///")) {
                assert!(!line.contains("[irradiance]"), "{target:?}: {line}");
            }
        }
        let error = Library::with_prefix("gl_").unwrap_err().to_string();
        assert!(error.contains("gl_"), "{error}");
    }

    #[test]
    fn keywords_are_listed() {
        let library = Library::new().unwrap();
        let renamed = library.renamed_fields(Target::GlslEs300).unwrap();
        let centroid = ["PolygonLight", "centroid", "centroid_"].map(str::to_owned);
        let [structure, name, there] = centroid;
        assert!(renamed.contains(&(structure, name, there)), "{renamed:?}");
        assert_eq!(library.renamed_fields(Target::Wgsl).unwrap(), []);
    }
}
