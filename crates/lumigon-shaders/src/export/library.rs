//! The library, parsed once and written to any target.

use naga::Module;
use naga::front::wgsl;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use crate::export::comments::Comments;
use crate::export::prefix::Prefix;
use crate::export::{Target, glsl, hlsl, msl, spirv};
use crate::{LinkError, MODULES};

/// What constants' names start with where the language has a preprocessor.
const CONSTANT_PREFIX: &str = "LUMIGON_";

/// Why the library could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The modules do not link.
    #[error("the library's modules: {0}")]
    Link(#[from] LinkError),
    /// Names cannot start so.
    #[error("{prefix:?} cannot start a name in every language: {problem}")]
    Prefix {
        /// The prefix.
        prefix: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// The linked text is not WGSL.
    #[error("the library as WGSL: {0}")]
    Wgsl(String),
    /// The target's writer refuses it.
    #[error("the library as {}: {problem}", target.language())]
    Writer {
        /// The target.
        target: Target,
        /// What it said.
        problem: String,
    },
}

/// The library as one module.
#[derive(Debug)]
pub struct Library {
    text: String,
    module: Module,
    info: ModuleInfo,
    prefix: Option<Prefix>,
}

impl Library {
    /// Joins, parses and validates the library.
    ///
    /// # Errors
    /// Where a module is faulty.
    pub fn new() -> Result<Self, ExportError> {
        Self::parse(crate::library()?)
    }

    /// The library with this before the name of every function and structure, for engines that have
    /// such names already; in upper case before constants.
    ///
    /// # Errors
    /// Where no name can start so, or a module is faulty.
    pub fn with_prefix(prefix: &str) -> Result<Self, ExportError> {
        if let Some(problem) = Prefix::fault(prefix) {
            let prefix = prefix.to_owned();
            return Err(ExportError::Prefix { prefix, problem });
        }
        let text = crate::library()?;
        let prefix = Prefix::new(prefix, &text);
        let library = Self::parse(prefix.apply_to_library(&text))?;
        Ok(Self {
            prefix: Some(prefix),
            ..library
        })
    }

    pub(super) fn parse(text: String) -> Result<Self, ExportError> {
        let module = wgsl::parse_str(&text)
            .map_err(|fault| ExportError::Wgsl(fault.emit_to_string(&text)))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .map_err(|fault| ExportError::Wgsl(fault.emit_to_string(&text)))?;
        Ok(Self {
            text,
            module,
            info,
            prefix: None,
        })
    }

    /// The library in WGSL, with its comments.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// A shader that calls the library, or a text about it, with the library's prefix where names of
    /// functions and structures have none.
    #[must_use]
    pub fn prefixed(&self, text: &str) -> String {
        match &self.prefix {
            Some(prefix) => prefix.apply(text),
            None => text.to_owned(),
        }
    }

    /// What constants' names start with in a target: where there is a preprocessor, an engine's
    /// `#define PI` would rewrite a constant of that name.
    #[must_use]
    pub fn constant_prefix(&self, target: Target) -> String {
        match (&self.prefix, target) {
            (Some(prefix), _) => prefix.of_constants(),
            (None, Target::Wgsl | Target::Spirv) => String::new(),
            (None, _) => CONSTANT_PREFIX.to_owned(),
        }
    }

    /// Names of all functions.
    pub fn functions(&self) -> impl Iterator<Item = &str> {
        let functions = self.module.functions.iter();
        functions.filter_map(|(_, function)| function.name.as_deref())
    }

    /// Functions by module, each with the first sentence of its comment.
    pub fn contents(&self) -> Vec<(&'static str, Vec<(String, String)>)> {
        let contents = MODULES.iter().map(|(module, text)| {
            let text = self.prefixed(text);
            let comments = Comments::read(&text);
            let functions = comments.functions().iter();
            let summaries =
                functions.map(|function| (function.name.to_owned(), summary(&function.lines)));
            (*module, summaries.collect())
        });
        contents.collect()
    }

    /// Fields whose name is a keyword of the target, where they are called otherwise: structure,
    /// name, and the name there.
    ///
    /// # Errors
    /// Where the target cannot express the library.
    pub fn renamed_fields(
        &self,
        target: Target,
    ) -> Result<Vec<(String, String, String)>, ExportError> {
        let bytes = self.export(target)?;
        // SPIR-V has no text, and keeps all names.
        let text = String::from_utf8(bytes).unwrap_or_default();
        let comments = self.comments();
        let renamed = match target {
            Target::Wgsl | Target::Spirv => Vec::new(),
            _ => comments.renamed_fields(&text),
        };
        let owned = renamed.into_iter().map(|(structure, name, there)| {
            (structure.to_owned(), name.to_owned(), there.to_owned())
        });
        Ok(owned.collect())
    }

    /// The bytes of the target's file. Texts keep the names of functions and
    /// structures, and all doc comments.
    ///
    /// # Errors
    /// Where the target cannot express the library.
    pub fn export(&self, target: Target) -> Result<Vec<u8>, ExportError> {
        Ok(match target {
            Target::Wgsl => format!("{}\n{}", heading(target), self.text).into_bytes(),
            Target::GlslEs300 | Target::Glsl450 => glsl::write(self, target)?.into_bytes(),
            Target::Hlsl => hlsl::write(self)?.into_bytes(),
            Target::Msl => msl::write(self)?.into_bytes(),
            Target::Spirv => spirv::write(self)?,
        })
    }

    /// A WGSL shader that calls the library's functions, as SPIR-V that imports what it calls from
    /// [`Target::Spirv`]'s file, for a linker to join.
    ///
    /// # Errors
    /// Where `client` is not valid behind the library.
    pub fn export_client(&self, client: &str) -> Result<Vec<u8>, ExportError> {
        spirv::write_client(self, client)
    }

    pub(super) fn comments(&self) -> Comments<'_> {
        Comments::read(&self.text)
    }

    pub(super) fn module(&self) -> &Module {
        &self.module
    }

    pub(super) fn info(&self) -> &ModuleInfo {
        &self.info
    }

    /// The module for languages with a preprocessor.
    pub(super) fn with_prefixed_constants(&self) -> Module {
        let mut module = self.module.clone();
        if self.prefix.is_none() {
            for (_, constant) in module.constants.iter_mut() {
                if let Some(name) = &mut constant.name {
                    name.insert_str(0, CONSTANT_PREFIX);
                }
            }
        }
        module
    }

    /// A translation of [`Library::with_prefixed_constants`] with the comments.
    pub(super) fn with_comments(&self, translated: &str) -> String {
        let prefix = match self.prefix {
            Some(_) => "",
            None => CONSTANT_PREFIX,
        };
        self.comments().restore(translated, prefix)
    }
}

/// The first lines of a text.
pub(super) fn heading(target: Target) -> String {
    format!(
        "// lumigon {}: light from polygons, as functions to call, in {}.\n\
         // Generated by `lumigon shaders export`: do not edit. MIT or Apache-2.0, as you like.\n",
        env!("CARGO_PKG_VERSION"),
        target.language(),
    )
}

/// An error of a target's writer.
pub(super) fn refused(target: Target) -> impl Fn(&dyn std::fmt::Display) -> ExportError {
    move |problem| ExportError::Writer {
        target,
        problem: problem.to_string(),
    }
}

/// The first sentence of a doc comment, on one line.
fn summary(lines: &[&str]) -> String {
    let words: Vec<&str> = lines
        .iter()
        .map(|line| line.trim_start_matches('/').trim())
        .take_while(|line| !line.is_empty())
        .collect();
    let paragraph = words.join(" ");
    let end = paragraph.find(". ").unwrap_or(paragraph.len());
    paragraph[..end]
        .trim_end_matches(['.', ':', ';'])
        .to_owned()
}
