//! SPIR-V, with every function exported by its name.

use naga::back::spv::{self, Options, WriterFlags};
use rspirv::binary::Assemble;
use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Capability, Decoration, LinkageType, Op, Word};

use super::library::refused;
use super::{ExportError, Library, Target};

pub(super) fn write(library: &Library) -> Result<Vec<u8>, ExportError> {
    let refused = refused(Target::Spirv);
    let options = Options {
        lang_version: (1, 3),
        // Names: exports go by them.
        flags: WriterFlags::DEBUG,
        // The library's loops end.
        force_loop_bounding: false,
        ..Options::default()
    };
    let words = spv::write_vec(library.module(), library.info(), &options, None)
        .map_err(|fault| refused(&fault))?;
    let mut module = rspirv::dr::load_words(&words).map_err(|fault| refused(&fault))?;
    export_functions(&mut module).map_err(|unnamed| {
        refused(&format!("function {unnamed} has no name to export it under"))
    })?;
    let words = module.assemble();
    Ok(words.into_iter().flat_map(u32::to_le_bytes).collect())
}

/// Decorates every function for the linker; an error with the id of one without a name.
fn export_functions(module: &mut Module) -> Result<(), Word> {
    for function in &module.functions {
        let id = function.def.as_ref().and_then(|def| def.result_id);
        let id = id.unwrap_or_default();
        let name = name_of(module, id).ok_or(id)?.to_owned();
        module.annotations.push(Instruction::new(
            Op::Decorate,
            None,
            None,
            vec![
                Operand::IdRef(id),
                Operand::Decoration(Decoration::LinkageAttributes),
                Operand::LiteralString(name),
                Operand::LinkageType(LinkageType::Export),
            ],
        ));
    }
    let linkage = [Operand::Capability(Capability::Linkage)];
    if !module.capabilities.iter().any(|c| c.operands == linkage) {
        module.capabilities.push(Instruction::new(
            Op::Capability,
            None,
            None,
            linkage.to_vec(),
        ));
    }
    Ok(())
}

/// The name of an id.
fn name_of(module: &Module, id: Word) -> Option<&str> {
    module.debug_names.iter().find_map(|name| {
        match (name.class.opcode, name.operands.as_slice()) {
            (Op::Name, [Operand::IdRef(named), Operand::LiteralString(text)]) if *named == id => {
                Some(text.as_str())
            }
            _ => None,
        }
    })
}
