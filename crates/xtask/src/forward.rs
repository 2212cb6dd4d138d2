//! Takes values out of composites without making the composites.
//!
//! rust-gpu passes closures and slices as structs of pointers: `OpCompositeInsert` builds one and `OpCompositeExtract` takes
//! the pointer out again; around a loop `OpPhi` carries the struct, needed or not. spirv-val accepts it, but NVIDIA's driver
//! (580.159) crashes on it. Here each extraction is replaced by what was inserted, and composites that nothing needs are
//! removed. A test of the finished modules sees that no pointer is left in a composite or a phi.

use rspirv::dr::{Function, Instruction, Module, Operand};
use rspirv::spirv::Op;
use std::collections::{BTreeMap, BTreeSet};

/// Forwards inserted values to their extractions in every function.
pub fn composites(module: &mut Module) {
    let globals: BTreeMap<u32, Instruction> =
        module.types_global_values.iter().filter_map(|inst| Some((inst.result_id?, inst.clone()))).collect();
    for function in &mut module.functions {
        forward(function, &globals);
        remove_unused(function);
    }
}

fn forward(function: &mut Function, globals: &BTreeMap<u32, Instruction>) {
    let locals: BTreeMap<u32, Instruction> = function
        .all_inst_iter()
        .filter(|inst| matches!(inst.class.opcode, Op::CompositeInsert | Op::CompositeConstruct | Op::CompositeExtract))
        .filter_map(|inst| Some((inst.result_id?, inst.clone())))
        .collect();
    let mut instead = BTreeMap::new();
    for inst in locals.values().filter(|inst| inst.class.opcode == Op::CompositeExtract) {
        if let (Some(id), Some(source)) =
            (inst.result_id, source(id_of(&inst.operands[0]), &path(inst, 1), &locals, globals))
        {
            instead.insert(id, source);
        }
    }
    for inst in function.all_inst_iter_mut() {
        for id in inst.operands.iter_mut().filter_map(Operand::id_ref_any_mut) {
            // A source is never an extraction that is itself replaced: `source` looks through those.
            if let Some(&source) = instead.get(id) {
                *id = source;
            }
        }
    }
}

/// The id that stands at `path` in composite `id`, if an instruction that made the composite says so.
fn source(
    mut id: u32,
    path: &[u32],
    locals: &BTreeMap<u32, Instruction>,
    globals: &BTreeMap<u32, Instruction>,
) -> Option<u32> {
    let mut path = path.to_vec();
    while !path.is_empty() {
        let inst = locals.get(&id)?;
        match inst.class.opcode {
            Op::CompositeInsert => {
                let inserted = self::path(inst, 2);
                if path.starts_with(&inserted) {
                    id = id_of(&inst.operands[0]);
                    path.drain(..inserted.len());
                } else if inserted.starts_with(&path) {
                    return None;
                } else {
                    id = id_of(&inst.operands[1]);
                }
            }
            Op::CompositeConstruct => {
                // The parts of a vector may be vectors themselves: only structs and arrays have a part an index.
                let made = globals.get(&inst.result_type?)?.class.opcode;
                if !matches!(made, Op::TypeStruct | Op::TypeArray) {
                    return None;
                }
                id = id_of(inst.operands.get(path.remove(0) as usize)?);
            }
            Op::CompositeExtract => {
                let mut outer = self::path(inst, 1);
                outer.append(&mut path);
                path = outer;
                id = id_of(&inst.operands[0]);
            }
            _ => return None,
        }
    }
    // What is left may be an extraction of something that nothing here made, or one that is replaced in its turn.
    match locals.get(&id) {
        Some(inst) if inst.class.opcode == Op::CompositeExtract => {
            Some(source(id_of(&inst.operands[0]), &self::path(inst, 1), locals, globals).unwrap_or(id))
        }
        _ => Some(id),
    }
}

fn id_of(operand: &Operand) -> u32 {
    operand.id_ref_any().unwrap_or(0)
}

fn path(inst: &Instruction, from: usize) -> Vec<u32> {
    inst.operands[from..]
        .iter()
        .filter_map(|operand| if let Operand::LiteralBit32(index) = operand { Some(*index) } else { None })
        .collect()
}

/// Removes composites, extractions and phis from which nothing that has an effect is computed: also those that only feed each
/// other around a loop.
pub fn remove_unused(function: &mut Function) {
    let removable = |inst: &Instruction| {
        matches!(
            inst.class.opcode,
            Op::CompositeInsert | Op::CompositeConstruct | Op::CompositeExtract | Op::Undef | Op::Phi
        )
    };
    let operands = |inst: &Instruction| inst.operands.iter().filter_map(Operand::id_ref_any).collect::<Vec<_>>();
    let mut feeds: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let mut waiting = Vec::new();
    for inst in function.all_inst_iter() {
        match inst.result_id {
            Some(id) if removable(inst) => {
                feeds.insert(id, operands(inst));
            }
            _ => waiting.extend(operands(inst)),
        }
    }
    let mut used = BTreeSet::new();
    while let Some(id) = waiting.pop() {
        if used.insert(id) {
            waiting.extend(feeds.get(&id).into_iter().flatten());
        }
    }
    for block in &mut function.blocks {
        block.instructions.retain(|inst| !removable(inst) || inst.result_id.is_some_and(|id| used.contains(&id)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arithmetic::Arithmetic;
    use crate::testing::kernel;
    use rspirv::spirv::StorageClass;

    fn count(module: &Module, op: Op) -> usize {
        module.all_inst_iter().filter(|inst| inst.class.opcode == op).count()
    }

    #[test]
    fn what_was_inserted_is_used_and_the_composite_goes() {
        let mut y = 0;
        let mut module = kernel(|b, float, x| {
            y = b.f_add(float, None, x, x).unwrap();
            let inner = b.type_struct([float, float]);
            let outer = b.type_struct([inner, float]);
            let blank = b.undef(outer, None);
            let one = b.composite_insert(outer, None, y, blank, [0, 1]).unwrap();
            let two = b.composite_insert(outer, None, x, one, [1]).unwrap();
            let part = b.composite_extract(inner, None, two, [0]).unwrap();
            let again = b.composite_extract(float, None, part, [1]).unwrap();
            b.f_mul(float, None, again, again).unwrap();
        });
        composites(&mut module);
        assert_eq!(count(&module, Op::CompositeInsert) + count(&module, Op::CompositeExtract), 0);
        let product = module.all_inst_iter().find(|inst| inst.class.opcode == Op::FMul).unwrap();
        assert_eq!(product.operands, [Operand::IdRef(y), Operand::IdRef(y)]);
    }

    #[test]
    fn a_part_of_what_was_inserted_is_left_alone() {
        let mut module = kernel(|b, float, x| {
            let inner = b.type_struct([float, float]);
            let outer = b.type_struct([inner, float]);
            let blank = b.undef(outer, None);
            let one = b.composite_insert(outer, None, x, blank, [0, 1]).unwrap();
            let part = b.composite_extract(inner, None, one, [0]).unwrap();
            b.composite_insert(inner, None, x, part, [0]).unwrap();
            let whole = b.composite_extract(float, None, part, [0]).unwrap();
            b.f_mul(float, None, whole, whole).unwrap();
        });
        composites(&mut module);
        assert_eq!(
            count(&module, Op::CompositeExtract),
            2,
            "the element that nobody inserted is still taken from the part"
        );
        assert_eq!(count(&module, Op::CompositeInsert), 1, "and the second insertion, which nothing needs, is gone");
    }

    #[test]
    fn a_pointer_left_in_a_composite_is_refused() {
        let mut module = kernel(|b, float, x| {
            let pointer = b.type_pointer(None, StorageClass::Function, float);
            let holder = b.type_struct([pointer]);
            let blank = b.undef(holder, None);
            let got = b.composite_extract(pointer, None, blank, [0]).unwrap();
            b.store(got, x, None, []).unwrap();
        });
        crate::memory_model::to_glsl450(&mut module).unwrap();
        composites(&mut module);
        for arithmetic in Arithmetic::ALL {
            let error = crate::check::structure(&module, arithmetic).unwrap_err().to_string();
            assert!(error.contains("move"), "{error}");
        }
    }
}
