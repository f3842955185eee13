//! The library in other languages, as functions to call: no entry point, no binding.

mod comments;
mod glsl;
mod hlsl;
mod library;
mod msl;
mod spirv;
mod target;

pub use library::{ExportError, Library};
pub use target::Target;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_target_is_written() {
        let library = Library::new().unwrap();
        for target in Target::ALL {
            let bytes = library.export(target).unwrap();
            std::fs::write("/tmp/ex/client.spv", library.export_client(Target::Wgsl.example().1).unwrap()).unwrap();
            std::fs::write(format!("/tmp/ex/out-{target:?}"), &bytes).unwrap();
        }
    }
}
