//! Large private arrays are not zeroed before their first use.
//!
//! Rust has every array initialised; rust-gpu writes that as one store of a composite with every element. A driver spends
//! a minute and more on such a store for 1025 elements (llvmpipe: 90 s a kernel), and each invocation fills kilobytes that
//! it overwrites before it reads them. So the store is taken apart, and arrays of more than [`SMALL`] elements in a struct
//! are left out of it. Where rust-gpu took the struct apart, such an array stands alone, and the store of a constant in all of it is
//! left out. Kernels keep the rule that they read nothing of such an array that they have not written
//! (`caustic_kernels::exec`); a test on the CPU fills them with rubbish instead of zeros.

use crate::forward::remove_unused;
use anyhow::{Context, Result};
use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Op, StorageClass};
use std::collections::BTreeMap;

/// Arrays up to this many elements keep their initial values.
const SMALL: u32 = 32;

/// Leaves large arrays out of the stores that initialise structs.
pub fn leave_undefined(module: &mut Module) -> Result<()> {
    let globals: BTreeMap<u32, Instruction> =
        module.types_global_values.iter().filter_map(|inst| Some((inst.result_id?, inst.clone()))).collect();
    let mut types = Types { module_types: Vec::new(), globals: &globals, bound: bound(module)? };
    for function in &mut module.functions {
        let made: BTreeMap<u32, Instruction> = function
            .all_inst_iter()
            .filter(|inst| inst.class.opcode == Op::CompositeConstruct)
            .filter_map(|inst| Some((inst.result_id?, inst.clone())))
            .collect();
        let mut changed = false;
        for block in &mut function.blocks {
            let mut instructions = Vec::with_capacity(block.instructions.len());
            for inst in block.instructions.drain(..) {
                if inst.class.opcode == Op::Store && types.is_large_constant(inst.operands[1].unwrap_id_ref()) {
                    changed = true;
                    continue;
                }
                let whole = (inst.class.opcode == Op::Store)
                    .then(|| made.get(&inst.operands[1].unwrap_id_ref()))
                    .flatten()
                    .filter(|made| made.result_type.is_some_and(|id| types.has_large_array(id)));
                let Some(whole) = whole else {
                    instructions.push(inst);
                    continue;
                };
                changed = true;
                let mut parts = Vec::new();
                types.kept(whole, &made, &[], &mut parts);
                for (path, member, value) in parts {
                    let pointer = types.pointer(member);
                    let place = types.new_id();
                    let mut operands = vec![inst.operands[0].clone()];
                    for i in path {
                        operands.push(Operand::IdRef(types.index(i).context("the module has no u32")?));
                    }
                    instructions.push(Instruction::new(Op::AccessChain, Some(pointer), Some(place), operands));
                    instructions.push(Instruction::new(Op::Store, None, None, vec![Operand::IdRef(place), value]));
                }
            }
            block.instructions = instructions;
        }
        if changed {
            remove_unused(function);
        }
    }
    let Types { module_types, bound, .. } = types;
    module.types_global_values.extend(module_types);
    if let Some(header) = &mut module.header {
        header.bound = bound;
    }
    Ok(())
}

fn bound(module: &Module) -> Result<u32> {
    Ok(module.header.as_ref().context("the module has no header")?.bound)
}

/// The module's types and constants, and those that are added.
struct Types<'a> {
    module_types: Vec<Instruction>,
    globals: &'a BTreeMap<u32, Instruction>,
    bound: u32,
}

impl Types<'_> {
    fn new_id(&mut self) -> u32 {
        self.bound += 1;
        self.bound - 1
    }

    /// Types of a struct's members, if it is one.
    fn members(&self, id: u32) -> Option<Vec<u32>> {
        let inst = self.globals.get(&id).filter(|inst| inst.class.opcode == Op::TypeStruct)?;
        Some(inst.operands.iter().map(Operand::unwrap_id_ref).collect())
    }

    /// Whether it is a constant of a large array.
    fn is_large_constant(&self, id: u32) -> bool {
        let constant = |inst: &&Instruction| matches!(inst.class.opcode, Op::ConstantComposite | Op::ConstantNull);
        let type_of = self.globals.get(&id).filter(constant).and_then(|inst| inst.result_type);
        type_of.is_some_and(|type_of| self.is_large_array(type_of))
    }

    fn is_large_array(&self, id: u32) -> bool {
        let length = self
            .globals
            .get(&id)
            .filter(|inst| inst.class.opcode == Op::TypeArray)
            .and_then(|inst| self.globals.get(&inst.operands[1].unwrap_id_ref()));
        length.is_some_and(|length| matches!(length.operands[0], Operand::LiteralBit32(n) if n > SMALL))
    }

    /// Whether a struct has one, or has a struct that has one.
    fn has_large_array(&self, id: u32) -> bool {
        let members = self.members(id).unwrap_or_default();
        members.into_iter().any(|member| self.is_large_array(member) || self.has_large_array(member))
    }

    /// What a struct keeps of its values: where each lies in it, its type and the value.
    fn kept(
        &self,
        whole: &Instruction,
        made: &BTreeMap<u32, Instruction>,
        path: &[u32],
        parts: &mut Vec<(Vec<u32>, u32, Operand)>,
    ) {
        let members = whole.result_type.and_then(|id| self.members(id)).unwrap_or_default();
        for ((i, member), value) in (0..).zip(members).zip(&whole.operands) {
            let path = [path, &[i]].concat();
            let inner = made.get(&value.unwrap_id_ref()).filter(|_| self.has_large_array(member));
            if let Some(inner) = inner {
                self.kept(inner, made, &path, parts);
            } else if !self.is_large_array(member) {
                parts.push((path, member, value.clone()));
            }
        }
    }

    fn known(&self, same: impl Fn(&Instruction) -> bool) -> Option<u32> {
        self.globals.values().chain(&self.module_types).find(|inst| same(inst)).and_then(|inst| inst.result_id)
    }

    fn add(&mut self, op: Op, result_type: Option<u32>, operands: Vec<Operand>) -> u32 {
        let same = |inst: &Instruction| {
            inst.class.opcode == op && inst.result_type == result_type && inst.operands == operands
        };
        if let Some(id) = self.known(same) {
            return id;
        }
        let id = self.new_id();
        self.module_types.push(Instruction::new(op, result_type, Some(id), operands));
        id
    }

    fn pointer(&mut self, to: u32) -> u32 {
        let operands = vec![Operand::StorageClass(StorageClass::Function), Operand::IdRef(to)];
        self.add(Op::TypePointer, None, operands)
    }

    fn index(&mut self, i: u32) -> Option<u32> {
        let unsigned = vec![Operand::LiteralBit32(32), Operand::LiteralBit32(0)];
        let word = self.known(|inst| inst.class.opcode == Op::TypeInt && inst.operands == unsigned)?;
        Some(self.add(Op::Constant, Some(word), vec![Operand::LiteralBit32(i)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::kernel;

    /// A kernel that stores a struct of an array of `length` and a float in a variable, or a struct of that and another float.
    fn stores_left(length: u32, nested: bool) -> (usize, usize) {
        let mut module = kernel(|b, float, x| {
            let word = b.type_int(32, 0);
            let n = b.constant_bit32(word, length);
            let array = b.type_array(float, n);
            let mut record = b.type_struct([array, float]);
            let elements: Vec<u32> = (0..length).map(|_| x).collect();
            let all = b.composite_construct(array, None, elements).unwrap();
            let mut value = b.composite_construct(record, None, [all, x]).unwrap();
            if nested {
                record = b.type_struct([float, record]);
                value = b.composite_construct(record, None, [x, value]).unwrap();
            }
            let pointer = b.type_pointer(None, StorageClass::Function, record);
            let variable = b.variable(pointer, None, StorageClass::Function, None);
            b.store(variable, value, None, []).unwrap();
        });
        leave_undefined(&mut module).unwrap();
        let count = |op| module.all_inst_iter().filter(|inst| inst.class.opcode == op).count();
        (count(Op::Store), count(Op::CompositeConstruct))
    }

    /// A kernel that stores a constant array of `length` in a variable of its own.
    fn constant_stores_left(length: u32) -> usize {
        let mut module = kernel(|b, float, _| {
            let word = b.type_int(32, 0);
            let n = b.constant_bit32(word, length);
            let array = b.type_array(float, n);
            let pointer = b.type_pointer(None, StorageClass::Function, array);
            let zero = b.constant_bit32(float, 0);
            let all = b.constant_composite(array, vec![zero; length as usize]);
            let variable = b.variable(pointer, None, StorageClass::Function, None);
            b.store(variable, all, None, []).unwrap();
        });
        leave_undefined(&mut module).unwrap();
        module.all_inst_iter().filter(|inst| inst.class.opcode == Op::Store).count()
    }

    #[test]
    fn a_large_array_that_stands_alone_is_not_filled_with_a_constant() {
        assert_eq!(constant_stores_left(33) + 1, constant_stores_left(32));
    }

    #[test]
    fn small_arrays_keep_their_values_and_large_ones_do_not() {
        let (stores, composites) = stores_left(32, false);
        assert_eq!(composites, 2);
        // One store in place of the other: that of the float.
        assert_eq!(stores_left(33, false), (stores, 0));
        assert_eq!(stores_left(32, true), (stores, 3));
        assert_eq!(stores_left(33, true), (stores + 1, 0), "two floats");
    }
}
