//! The library's modules, and the linker that joins them.

use wesl::{CompileOptions, Feature, Features, ManglerKind, ModulePath, VirtualResolver, Wesl};

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../shaders/", $name, ".wesl")))),*]
    };
}

/// Every module of the library: its name, and its text in WESL.
pub const MODULES: &[(&str, &str)] = modules![
    "arctangent",
    "bound",
    "clip",
    "irradiance",
    "ltc",
    "polygon",
    "vector",
];

/// Why modules could not be joined.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct LinkError(String);

/// The WGSL of a `root` module in WESL with what it imports: from the library as
/// `import lumigon::irradiance::irradiance;`, from `modules` (name and text) likewise.
///
/// Names stay as they are, so they must differ from the library's. `conditions` are the values of
/// `@if`; what they leave out, and what nothing uses, is not in the result.
///
/// # Errors
/// Where a module does not parse, or an import finds nothing.
pub fn link(
    root: &str,
    modules: &[(&str, &str)],
    conditions: &[(&str, bool)],
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
    let mut features = Features::default();
    features.flags = conditions
        .iter()
        .map(|&(name, on)| {
            (
                name.to_owned(),
                if on {
                    Feature::Enable
                } else {
                    Feature::Disable
                },
            )
        })
        .collect();
    compiler.set_options(CompileOptions {
        features,
        keep_root: true,
        ..CompileOptions::default()
    });
    let compiled = compiler
        .compile(&main)
        .map_err(|fault| LinkError(fault.to_string()))?;
    Ok(compiled.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_and_validates() {
        let root = "
            import package::irradiance::{IrradianceSum, irradiance};
            import package::ltc::{LtcFormFactorSum, ltc_form_factor};
            @compute @workgroup_size(1)
            fn main() {
                var sum: IrradianceSum;
                var lobe_sum: LtcFormFactorSum;
                let value = irradiance(sum) + ltc_form_factor(lobe_sum);
            }";
        let text = link(root, &[], &[]).unwrap();
        let module = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|fault| panic!("{}", fault.emit_to_string(&text)));
        naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        )
        .validate(&module)
        .unwrap();
    }
}
