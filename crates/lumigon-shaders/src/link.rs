//! The library's modules, and the linker that joins them.

use wesl::{CompileOptions, ManglerKind, ModulePath, VirtualResolver, Wesl};

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../shaders/", $name, ".wesl")))),*]
    };
}

/// Every module of the library: its name, and its text in WESL.
pub const MODULES: &[(&str, &str)] = modules![
    "anisotropic_ltc",
    "arctangent",
    "bound",
    "charlie",
    "clip",
    "distance_field",
    "eon",
    "ggx",
    "ggx_polynomial",
    "image_lookup",
    "image_pyramid",
    "image_quadrature",
    "irradiance",
    "light_direction",
    "ltc",
    "ltc_table",
    "mean_image",
    "polygon",
    "projected_area",
    "pyramid",
    "reflection",
    "solid_angle",
    "vector",
];

/// The whole library as one WGSL module: every name as it is, with its documentation.
///
/// It is what [`link`] makes of a root that uses everything, but for the comments.
///
/// # Errors
/// Where a module of the library has an import that is not closed by a semicolon.
pub fn library() -> Result<String, LinkError> {
    library_with(&[])
}

/// [`library`] and more modules (name and text in WESL) that import from it or from each other as
/// `import package::irradiance::irradiance;`. Their names must differ from the library's.
///
/// # Errors
/// Where a module has an import that is not closed by a semicolon.
pub fn library_with(modules: &[(&str, &str)]) -> Result<String, LinkError> {
    let texts = MODULES
        .iter()
        .chain(modules)
        .map(|(name, text)| without_imports(name, text))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(texts.join("\n"))
}

/// A module's text without its import statements, each of which starts its own line.
fn without_imports(name: &str, text: &str) -> Result<String, LinkError> {
    let mut kept = String::with_capacity(text.len());
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line.starts_with("import ") {
            let mut last = line;
            while !last.trim_end().ends_with(';') {
                last = lines.next().ok_or_else(|| {
                    LinkError(format!(
                        "{name}: an import is not closed: end it with a semicolon"
                    ))
                })?;
            }
            continue;
        }
        // Where imports stood, one empty line is enough.
        if !(line.is_empty() && kept.ends_with("\n\n")) {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    Ok(kept)
}

/// Why modules could not be joined.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct LinkError(String);

/// The WGSL of a `root` module in WESL with what it imports: from the library as
/// `import package::irradiance::irradiance;`, from `modules` (name and text) likewise.
///
/// Names stay as they are, so they must differ from the library's. What nothing uses is not in the
/// result.
///
/// # Errors
/// Where a module does not parse, or an import finds nothing.
pub fn link(root: &str, modules: &[(&str, &str)]) -> Result<String, LinkError> {
    let options = CompileOptions {
        keep_root: true,
        ..CompileOptions::default()
    };
    linked(root, modules, options)
}

fn linked(
    root: &str,
    modules: &[(&str, &str)],
    options: CompileOptions,
) -> Result<String, LinkError> {
    let path = |name: &str| -> Result<ModulePath, LinkError> {
        format!("package::{name}")
            .parse()
            .map_err(|_| LinkError(format!("{name:?} is no module's name")))
    };
    let mut resolver = VirtualResolver::new();
    for (name, text) in MODULES.iter().chain(modules) {
        resolver.add_module(path(name)?, (*text).into());
    }
    let main = path("main")?;
    resolver.add_module(main.clone(), root.into());
    let mut compiler = Wesl::new("").set_custom_resolver(resolver);
    compiler.set_mangler(ManglerKind::None);
    compiler.set_options(options);
    let compiled = compiler
        .compile(&main)
        .map_err(|fault| LinkError(fault.to_string()))?;
    Ok(compiled.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checked by naga, with no GPU.
    fn validated(text: &str) -> (naga::Module, naga::valid::ModuleInfo) {
        let module = naga::front::wgsl::parse_str(text)
            .unwrap_or_else(|fault| panic!("{}", fault.emit_to_string(text)));
        let info = naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        )
        .validate(&module)
        .unwrap_or_else(|fault| panic!("{}", fault.emit_to_string(text)));
        (module, info)
    }

    fn parsed(text: &str) -> naga::Module {
        validated(text).0
    }

    fn function_names(module: &naga::Module) -> Vec<&str> {
        let mut names: Vec<_> = module
            .functions
            .iter()
            .map(|(_, function)| function.name.as_deref().unwrap())
            .collect();
        names.sort_unstable();
        names
    }

    fn struct_names(module: &naga::Module) -> Vec<&str> {
        let mut names: Vec<_> = module
            .types
            .iter()
            .filter(|(_, kind)| matches!(kind.inner, naga::TypeInner::Struct { .. }))
            .map(|(_, kind)| kind.name.as_deref().unwrap())
            .collect();
        names.sort_unstable();
        names
    }

    fn constant_names(module: &naga::Module) -> Vec<&str> {
        let mut names: Vec<_> = module
            .constants
            .iter()
            .filter_map(|(_, constant)| constant.name.as_deref())
            .collect();
        names.sort_unstable();
        names
    }

    #[test]
    fn library_validates() {
        let text = library().unwrap();
        assert!(!text.contains("import "));
        let module = parsed(&text);
        assert!(function_names(&module).contains(&"irradiance"));
        assert!(module.entry_points.is_empty());
        assert!(module.global_variables.is_empty());
    }

    /// Pure functions: what any engine can take.
    #[test]
    fn library_binds_nothing() {
        let text = library().unwrap();
        for word in [
            "@group",
            "@binding",
            "@compute",
            "@fragment",
            "@vertex",
            "var<",
            "ptr<",
            "override ",
            "enable ",
        ] {
            assert!(!text.contains(word), "{word}");
        }
        assert!(!function_names(&parsed(&text)).is_empty());
    }

    /// naga writes it as `?:`, which HLSL since 2021 keeps for single truths.
    #[test]
    fn nothing_is_selected_by_a_vector() {
        let (module, info) = validated(&library().unwrap());
        let mut count = 0;
        for (handle, function) in module.functions.iter() {
            for (_, expression) in function.expressions.iter() {
                if let naga::Expression::Select { condition, .. } = expression {
                    let kind = info[handle][*condition].ty.inner_with(&module.types);
                    let name = &function.name;
                    assert!(matches!(kind, naga::TypeInner::Scalar(_)), "{name:?}");
                    count += 1;
                }
            }
        }
        assert!(count > 20);
    }

    /// naga adds an underscore to names that end in a digit, and suffixes names that clash.
    #[test]
    fn names_are_unique_and_survive_translation() {
        let text = library().unwrap();
        let module = parsed(&text);
        let mut names = function_names(&module);
        names.extend(struct_names(&module));
        names.extend(constant_names(&module));
        let members = module.types.iter().flat_map(|(_, kind)| match &kind.inner {
            naga::TypeInner::Struct { members, .. } => members.as_slice(),
            _ => &[],
        });
        for member in members {
            let name = member.name.as_deref().unwrap();
            assert!(!name.ends_with(|c: char| c.is_ascii_digit()), "{name}");
        }
        for name in &names {
            assert!(!name.ends_with(|c: char| c.is_ascii_digit()), "{name}");
        }
        // naga refuses what is declared twice, so what is left are the same names in two kinds.
        names.sort_unstable();
        for pair in names.windows(2) {
            assert_ne!(pair[0], pair[1]);
        }
    }

    /// One module after the other, or joined by the linker: the same items.
    #[test]
    fn library_is_what_the_linker_makes() {
        let root: String = MODULES
            .iter()
            .flat_map(|(name, text)| {
                text.lines()
                    .filter_map(|line| line.strip_prefix("fn ")?.split('(').next())
                    .map(move |function| format!("import package::{name}::{function};\n"))
            })
            .collect();
        let options = || CompileOptions {
            strip: false,
            lazy: false,
            ..CompileOptions::default()
        };
        let linked_apart = linked(&root, &[], options()).unwrap();
        let joined = linked(&library().unwrap(), &[], options()).unwrap();
        parsed(&linked_apart);
        assert!(items(&joined).len() > 50);
        assert_eq!(items(&linked_apart), items(&joined));
    }

    /// The linker's text, item by item, in order of their text.
    fn items(text: &str) -> Vec<String> {
        let mut items: Vec<String> = Vec::new();
        for line in text.lines() {
            let starts = ["fn ", "struct ", "const "];
            if items.is_empty() || starts.iter().any(|start| line.starts_with(start)) {
                items.push(String::new());
            }
            if let (Some(item), false) = (items.last_mut(), line.is_empty()) {
                item.push_str(line);
                item.push('\n');
            }
        }
        items.sort_unstable();
        items
    }

    #[test]
    fn readme_s_shaders_link() {
        let readme = include_str!("../../../shaders/README.md");
        let shaders: Vec<_> = readme
            .split("```wgsl\n")
            .skip(1)
            .map(|rest| rest.split("```").next().unwrap())
            .collect();
        assert_eq!(shaders.len(), 2);
        for shader in shaders {
            let module = parsed(&link(shader, &[]).unwrap());
            assert!(module.functions.len() > 5);
        }
        for (name, _) in MODULES {
            assert!(readme.contains(&format!("`{name}")), "{name}");
        }
    }
}
