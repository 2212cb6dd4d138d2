//! What happens to rust-gpu's module before it is committed: float operations pinned down (in exact modules), debug text
//! removed, memory model rewritten, order made canonical.

use crate::arithmetic::Arithmetic;
use crate::{canonical, forward, large_arrays, memory_model, verify};
use anyhow::{Result, anyhow};
use rspirv::binary::Assemble;
use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Capability, Decoration, Op};
use std::collections::BTreeSet;

/// A finished module with a single entry point.
pub struct Finished {
    /// Name of the entry point.
    pub name: String,
    /// The module.
    pub module: Module,
    /// The module's words.
    pub words: Vec<u32>,
}

/// Post-processes the compiler's words into a module for each entry point; `private` paths must not be found in them.
///
/// One module holds all entry points when it comes from the compiler. Drivers read a module whole for each pipeline: NVIDIA's
/// took 0.4 to 0.9 s a pipeline that way, and 0.03 s for a small kernel by itself.
pub fn process(words: &[u32], private: &[String], arithmetic: Arithmetic) -> Result<Vec<Finished>> {
    let mut all = load(words)?;
    strip(&mut all);
    memory_model::to_glsl450(&mut all)?;
    forward::composites(&mut all);
    large_arrays::leave_undefined(&mut all)?;
    if arithmetic == Arithmetic::Exact {
        forbid_contraction(&mut all);
    }
    canonical::order(&mut all)?;
    let mut finished = Vec::new();
    for entry in &all.entry_points {
        let mut module = all.clone();
        module.entry_points = vec![entry.clone()];
        canonical::order(&mut module)?;
        drop_unused_capabilities(&mut module);
        let words = module.assemble();
        if arithmetic == Arithmetic::Exact {
            verify::no_contraction(&words)?;
        }
        verify::no_paths(&words, private)?;
        finished.push(Finished { name: canonical::name(entry).to_owned(), module, words });
    }
    Ok(finished)
}

/// Parses words.
pub fn load(words: &[u32]) -> Result<Module> {
    rspirv::dr::load_words(words).map_err(|error| anyhow!("cannot parse the compiler's SPIR-V: {error}"))
}

/// Whether the results of `op` are floats that a driver may contract or reassociate.
///
/// Conversions, comparisons and bit casts are not: contraction is defined over arithmetic only.
pub fn is_float_arithmetic(op: Op) -> bool {
    matches!(
        op,
        Op::FAdd
            | Op::FSub
            | Op::FMul
            | Op::FDiv
            | Op::FRem
            | Op::FMod
            | Op::FNegate
            | Op::VectorTimesScalar
            | Op::Dot
            | Op::MatrixTimesScalar
            | Op::VectorTimesMatrix
            | Op::MatrixTimesVector
            | Op::MatrixTimesMatrix
            | Op::OuterProduct
    )
}

/// Removes names, lines, source text and non-semantic instructions.
///
/// Even with `spirv_metadata` none, rust-gpu without spirv-opt embeds the text and absolute path of every source file
/// (its own, those of `core`, those below the cargo registry): most of the bytes, and the building machine's paths.
pub fn strip(module: &mut Module) {
    module.debug_string_source.clear();
    module.debug_names.clear();
    module.debug_module_processed.clear();
    module.extensions.retain(|inst| !is_string(inst, |name| name == "SPV_KHR_non_semantic_info"));
    let debug = |name: &str| name.starts_with("NonSemantic.") || name.contains("DebugInfo");
    let sets: BTreeSet<u32> = module
        .ext_inst_imports
        .iter()
        .filter(|inst| is_string(inst, debug))
        .filter_map(|inst| inst.result_id)
        .collect();
    module.ext_inst_imports.retain(|inst| !is_string(inst, debug));
    let keep = |inst: &Instruction| match inst.class.opcode {
        Op::Line | Op::NoLine => false,
        Op::ExtInst => !inst.operands[0].id_ref_any().is_some_and(|set| sets.contains(&set)),
        _ => true,
    };
    module.types_global_values.retain(keep);
    for block in module.functions.iter_mut().flat_map(|function| &mut function.blocks) {
        block.instructions.retain(keep);
    }
}

fn is_string(inst: &Instruction, test: impl Fn(&str) -> bool) -> bool {
    inst.operands.iter().any(|operand| matches!(operand, Operand::LiteralString(text) if test(text)))
}

/// Decorates every float operation `NoContraction`.
///
/// rust-gpu emits none, and a driver may then fuse `a * b + c` into one rounding. NVIDIA's does.
pub fn forbid_contraction(module: &mut Module) {
    let done: BTreeSet<u32> = module.annotations.iter().filter_map(no_contraction_target).collect();
    let results: BTreeSet<u32> = module
        .all_inst_iter()
        .filter(|inst| is_float_arithmetic(inst.class.opcode))
        .filter_map(|inst| inst.result_id)
        .collect();
    module.annotations.extend(results.difference(&done).map(|&id| {
        let operands = vec![Operand::IdRef(id), Operand::Decoration(Decoration::NoContraction)];
        Instruction::new(Op::Decorate, None, None, operands)
    }));
}

fn no_contraction_target(inst: &Instruction) -> Option<u32> {
    let decorated = inst.class.opcode == Op::Decorate
        && inst.operands.get(1) == Some(&Operand::Decoration(Decoration::NoContraction));
    decorated.then(|| inst.operands[0].id_ref_any()).flatten()
}

/// Drops the subgroup capabilities that were asked for and are not used: a device need not have them then.
fn drop_unused_capabilities(module: &mut Module) {
    let mut used: BTreeSet<Capability> = BTreeSet::new();
    for inst in module.all_inst_iter() {
        used.extend(inst.class.capabilities);
        used.extend(
            inst.operands.iter().filter(|o| matches!(o, Operand::BuiltIn(_))).flat_map(Operand::required_capabilities),
        );
    }
    // The others each imply the first, which stays with them for readers that do not follow implications.
    let subgroup = |c: Capability| format!("{c:?}").starts_with("GroupNonUniform");
    let any = used.iter().any(|&capability| subgroup(capability));
    module.capabilities.retain(|inst| match inst.operands[0] {
        Operand::Capability(Capability::GroupNonUniform) => any,
        Operand::Capability(capability) if subgroup(capability) => used.contains(&capability),
        _ => true,
    });
    let name = |inst: &Instruction| inst.operands[0].to_string();
    module.capabilities.sort_by_key(name);
    module.capabilities.dedup();
    module.extensions.sort_by_key(name);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::kernel;
    use rspirv::binary::Assemble;

    #[test]
    fn stripping_removes_source_text_and_paths() {
        let module = kernel(|b, _, _| {
            let file = b.string("/home/somebody/caustic/src/lib.rs");
            b.line(file, 1, 1);
        });
        let private = ["/home/somebody".to_owned()];
        assert!(verify::no_paths(&module.assemble(), &private).is_err());
        let Finished { module, words, .. } =
            process(&module.assemble(), &private, Arithmetic::Exact).unwrap().remove(0);
        assert!(module.all_inst_iter().all(|inst| !matches!(inst.class.opcode, Op::String | Op::Line)));
        verify::no_paths(&words, &private).unwrap();
    }

    #[test]
    fn processing_twice_changes_nothing() {
        let module = kernel(|b, float, x| {
            b.f_mul(float, None, x, x).unwrap();
        });
        for arithmetic in Arithmetic::ALL {
            let once = process(&module.assemble(), &[], arithmetic).unwrap().remove(0).words;
            assert_eq!(process(&once, &[], arithmetic).unwrap().remove(0).words, once);
        }
    }

    #[test]
    fn only_exact_operations_are_decorated() {
        let module = kernel(|b, float, x| {
            b.f_div(float, None, x, x).unwrap();
        });
        let decorated = |arithmetic| {
            let Finished { module, words, .. } = process(&module.assemble(), &[], arithmetic).unwrap().remove(0);
            assert_eq!(verify::float_ops(&words).unwrap().len(), 1);
            module.annotations.iter().filter_map(no_contraction_target).count()
        };
        assert_eq!(decorated(Arithmetic::Exact), 1);
        assert_eq!(decorated(Arithmetic::Fast), 0);
    }
}
