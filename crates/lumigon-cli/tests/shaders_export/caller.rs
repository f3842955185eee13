//! A shader that calls every function of an exported text, made from the text's own definitions.

/// A language whose functions are written `type name(type argument, ...)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Language {
    Glsl,
    Hlsl,
}

/// `main` with a call of every library function in a text.
pub(crate) fn c_like(text: &str, language: Language) -> String {
    let library = lumigon_shaders::Library::new().unwrap();
    let mut body = String::new();
    for name in library.functions() {
        let (result, arguments) =
            definition(text, name).unwrap_or_else(|| panic!("the text does not define {name}"));
        body += "    {\n";
        for (index, ty) in arguments.iter().enumerate() {
            let value = match language {
                Language::Glsl => String::new(),
                Language::Hlsl => format!(" = ({ty})0"),
            };
            body += &format!("        {ty} a{index}{value};\n");
        }
        let names: Vec<String> = (0..arguments.len()).map(|i| format!("a{i}")).collect();
        body += &format!(
            "        {result} r = {name}({});\n    }}\n",
            names.join(", ")
        );
    }
    match language {
        Language::Glsl => format!("void main() {{\n{body}}}\n"),
        Language::Hlsl => {
            format!("float4 main() : SV_Target {{\n{body}    return float4(0, 0, 0, 1);\n}}\n")
        }
    }
}

/// Result and argument types of a function that is defined on one line.
fn definition<'a>(text: &'a str, name: &str) -> Option<(&'a str, Vec<&'a str>)> {
    let start = format!(" {name}(");
    text.lines()
        .filter(|line| !line.starts_with([' ', '/']))
        .find_map(|line| {
            let (result, rest) = line.split_once(&start)?;
            let (arguments, _) = rest.split_once(')')?;
            let types = arguments
                .split(", ")
                .filter_map(|argument| Some(argument.rsplit_once(' ')?.0));
            Some((result, types.collect()))
        })
}

/// A fragment entry point in WGSL that calls every function of a library in WGSL.
pub(crate) fn wgsl(library: &str) -> String {
    let mut body = String::new();
    for (at, _) in library.match_indices("\nfn ") {
        let (name, rest) = library[at + 4..].split_once('(').unwrap();
        let end = rest.find(") ->").unwrap();
        let arguments = rest[..end].split_terminator(',').filter_map(|argument| {
            let (_, ty) = argument.split_once(':')?;
            Some(ty.trim())
        });
        let arguments: Vec<&str> = arguments.collect();
        body += "    {\n";
        for (index, ty) in arguments.iter().enumerate() {
            body += &format!("        var a{index}: {ty};\n");
        }
        let names: Vec<String> = (0..arguments.len()).map(|i| format!("a{i}")).collect();
        body += &format!("        let r = {name}({});\n    }}\n", names.join(", "));
    }
    format!("@fragment\nfn main() -> @location(0) vec4f {{\n{body}    return vec4f();\n}}\n")
}
