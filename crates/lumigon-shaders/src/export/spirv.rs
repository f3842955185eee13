//! SPIR-V, linked by functions' names.

use std::collections::{HashMap, HashSet};
use std::mem::take;

use naga::back::spv::{self, Options, WriterFlags};
use rspirv::binary::Assemble;
use rspirv::dr::{Function, Instruction, Module, Operand};
use rspirv::spirv::{Capability, Decoration, LinkageType, Op, Word};

use super::library::refused;
use super::{ExportError, Library, Target};

fn options() -> Options<'static> {
    Options {
        lang_version: (1, 3),
        // Names: linkage goes by them.
        flags: WriterFlags::DEBUG,
        // The library's loops end.
        force_loop_bounding: false,
        ..Options::default()
    }
}

/// The library, every function exported.
pub(super) fn write(library: &Library) -> Result<Vec<u8>, ExportError> {
    let refused = refused(Target::Spirv);
    let words = spv::write_vec(library.module(), library.info(), &options(), None)
        .map_err(|fault| refused(&fault))?;
    let mut module = rspirv::dr::load_words(&words).map_err(|fault| refused(&fault))?;
    let names = function_names(&module);
    if names.len() != module.functions.len() {
        return Err(refused(&"a function has no name to export it under"));
    }
    for (id, name) in names {
        link_by_name(&mut module, id, name, LinkageType::Export);
    }
    Ok(bytes(&module))
}

/// `client` in WGSL, which calls the library, as a module that imports what it calls.
pub(super) fn write_client(library: &Library, client: &str) -> Result<Vec<u8>, ExportError> {
    let refused = refused(Target::Spirv);
    let whole = Library::parse(format!("{}\n{client}", library.text()))?;
    let words = spv::write_vec(whole.module(), whole.info(), &options(), None)
        .map_err(|fault| refused(&fault))?;
    let mut module = rspirv::dr::load_words(&words).map_err(|fault| refused(&fault))?;
    let mut imports = HashMap::new();
    for (id, name) in function_names(&module) {
        if library.functions().any(|function| function == name) {
            imports.insert(id, name);
        }
    }
    let (mut imported, own): (Vec<_>, Vec<_>) = take(&mut module.functions)
        .into_iter()
        .partition(|function| imports.contains_key(&id_of(function)));
    for function in &mut imported {
        let id = id_of(function);
        function.blocks.clear();
        if let Some(name) = imports.remove(&id) {
            link_by_name(&mut module, id, name, LinkageType::Import);
        }
    }
    // Declarations come first.
    module.functions = imported;
    module.functions.extend(own);
    remove_names_of_nothing(&mut module);
    Ok(bytes(&module))
}

fn bytes(module: &Module) -> Vec<u8> {
    let words = module.assemble();
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// The id of a function.
fn id_of(function: &Function) -> Word {
    function.def_id().unwrap_or_default()
}

/// Functions with their names, those that have one.
fn function_names(module: &Module) -> Vec<(Word, String)> {
    let names: HashMap<Word, &str> = module
        .debug_names
        .iter()
        .filter_map(|name| match (name.class.opcode, name.operands.as_slice()) {
            (Op::Name, [Operand::IdRef(id), Operand::LiteralString(text)]) => {
                Some((*id, text.as_str()))
            }
            _ => None,
        })
        .collect();
    let ids = module.functions.iter().map(id_of);
    ids.filter_map(|id| Some((id, (*names.get(&id)?).to_owned())))
        .collect()
}

/// Lets the linker know a function by this name.
fn link_by_name(module: &mut Module, id: Word, name: String, linkage: LinkageType) {
    module.annotations.push(Instruction::new(
        Op::Decorate,
        None,
        None,
        vec![
            Operand::IdRef(id),
            Operand::Decoration(Decoration::LinkageAttributes),
            Operand::LiteralString(name),
            Operand::LinkageType(linkage),
        ],
    ));
    let capability = vec![Operand::Capability(Capability::Linkage)];
    if !module.capabilities.iter().any(|c| c.operands == capability) {
        let declared = Instruction::new(Op::Capability, None, None, capability);
        module.capabilities.push(declared);
    }
}

/// Drops names and decorations of ids that went with a function's body.
fn remove_names_of_nothing(module: &mut Module) {
    let defined: HashSet<Word> = module
        .all_inst_iter()
        .filter_map(|instruction| instruction.result_id)
        .collect();
    let is_of_something = |instruction: &Instruction| match instruction.operands.first() {
        Some(Operand::IdRef(id)) => defined.contains(id),
        _ => true,
    };
    module.debug_names.retain(is_of_something);
    module.annotations.retain(is_of_something);
}
