use std::fmt::Write;

use crate::description::value_index;
use crate::image::TableImage;

/// A module or the target of an `include!`: documentation, sizes, channel names, the numbers.
pub(crate) fn encode(image: &TableImage) -> String {
    let mut text = String::new();
    let constant = image.name().replace('-', "_").to_ascii_uppercase();
    // An identifier does not begin with a digit.
    let constant = match constant.starts_with(|c: char| c.is_ascii_digit()) {
        true => format!("TABLE_{constant}"),
        false => constant,
    };
    let mut line = |line: &str| {
        text.push_str(line);
        text.push('\n');
    };
    line(&format!(
        "/// Texels along each axis of [`{constant}`], the fastest first."
    ));
    line(&format!(
        "pub const {constant}_SIZES: [usize; {}] = {:?};",
        image.sizes().len(),
        image.sizes()
    ));
    line(&format!(
        "/// Names of the numbers of a texel of [`{constant}`]."
    ));
    line(&format!(
        "pub const {constant}_CHANNELS: [&str; {}] = {:?};",
        image.channels().len(),
        image.channels()
    ));
    line(&format!(
        "/// The table {}; a number is at `{}`.",
        image.name(),
        value_index(image)
    ));
    for (key, value) in image.texts() {
        line("///");
        // Text of its own: nothing in it is markup or ends the comment.
        let value: String = value.replace(['\n', '\r'], " ").replace('`', "'");
        line(&format!(
            "/// {}: `{value}`",
            key.replace(['\n', '\r'], " ")
        ));
    }
    line("#[rustfmt::skip]");
    line(&format!(
        "pub static {constant}: [f32; {}] = [",
        image.values().len()
    ));
    for texel in image.values().chunks(image.channels().len()) {
        text.push_str("   ");
        for value in texel {
            // The shortest digits that come back as the same f32. Writing to text cannot fail.
            let _ = write!(text, " {value:?},");
        }
        text.push('\n');
    }
    text.push_str("];\n");
    text
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;
    use crate::image::tests::{bits, example};

    /// The compiler reads it back: a program that prints the bits.
    #[test]
    fn compiles_to_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let image = example(&[3, 2, 5, 4]);
        std::fs::write(folder.path().join("table.rs"), encode(&image)).unwrap();
        let main = "#![deny(warnings, missing_docs)]\n//! Prints.\npub mod table;\n\
            /// Prints.\nfn main() {\n\
            assert_eq!(table::EXAMPLE_3_SIZES, [3, 2, 5, 4]);\n\
            assert_eq!(table::EXAMPLE_3_CHANNELS[4], \"amplitude\");\n\
            for x in &table::EXAMPLE_3 { println!(\"{}\", x.to_bits()); }\n}\n";
        let main = main.replace("pub mod", "/// Table.\npub mod");
        std::fs::write(folder.path().join("main.rs"), main).unwrap();
        let compiler = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
        let compiled = Command::new(compiler)
            .args(["--edition=2024", "main.rs", "-o", "print"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&compiled.stderr);
        assert!(compiled.status.success(), "{message}");
        let printed = Command::new(folder.path().join("print")).output().unwrap();
        let printed = String::from_utf8(printed.stdout).unwrap();
        let read: Vec<u32> = printed.lines().map(|line| line.parse().unwrap()).collect();
        assert_eq!(read, bits(image.values()));
    }
}
