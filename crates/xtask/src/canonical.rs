//! One order and one numbering for a module, whatever order the compiler came to.
//!
//! rustc's crate hashes, and with them symbol names and the order of functions, types and constants, follow the path of
//! the checkout and of the toolchain. Everything here is therefore ordered by how it is reached from the entry points,
//! which are sorted by name; what is not reached is dropped; ids count up in that order.

use anyhow::{Result, bail};
use rspirv::dr::{Function, Instruction, Module, Operand};
use rspirv::spirv::Op;
use std::collections::{BTreeMap, BTreeSet};

/// Brings `module` into canonical order.
pub fn order(module: &mut Module) -> Result<()> {
    module.entry_points.sort_by_key(|inst| name(inst).to_owned());
    let mut walk = Walk::new(module);
    walk.run(&module.entry_points)?;
    let Walk { globals, functions, ids, .. } = walk;

    let take = |list: &mut Vec<Instruction>| {
        let order: BTreeMap<u32, usize> = globals.iter().enumerate().map(|(at, &id)| (id, at)).collect();
        let place = |inst: &Instruction| inst.result_id.and_then(|id| order.get(&id));
        list.retain(|inst| place(inst).is_some());
        list.sort_by_key(|inst| place(inst).copied());
    };
    take(&mut module.ext_inst_imports);
    take(&mut module.types_global_values);
    let mut by_id: BTreeMap<u32, Function> =
        module.functions.drain(..).filter_map(|function| Some((function.def_id()?, function))).collect();
    module.functions = functions.iter().filter_map(|id| by_id.remove(id)).collect();
    let known = |inst: &Instruction| inst.operands[0].id_ref_any().is_some_and(|id| ids.contains_key(&id));
    module.execution_modes.retain(known);
    module.annotations.retain(known);

    for inst in module.all_inst_iter_mut() {
        let fields = inst.result_type.iter_mut().chain(&mut inst.result_id);
        for id in fields.chain(inst.operands.iter_mut().filter_map(Operand::id_ref_any_mut)) {
            match ids.get(id) {
                Some(&new) => *id = new,
                None => bail!("%{id} is used in the module and defined nowhere"),
            }
        }
    }
    for entry in &mut module.entry_points {
        entry.operands[3..].sort_by_key(Operand::id_ref_any);
    }
    module.execution_modes.sort_by_cached_key(words);
    module.annotations.sort_by_cached_key(words);
    module.annotations.dedup();
    if let Some(header) = &mut module.header {
        header.bound = ids.len() as u32 + 1;
    }
    Ok(())
}

/// An entry point's name.
pub fn name(entry: &Instruction) -> &str {
    entry.operands[2].unwrap_literal_string()
}

/// Sorts by target id, then by what is said of it.
fn words(inst: &Instruction) -> Vec<u32> {
    let mut words = Vec::new();
    rspirv::binary::Assemble::assemble_into(inst, &mut words);
    // The first word is opcode and length: it goes last, so that the target leads.
    words.rotate_left(1);
    words
}

/// The walk from the entry points.
struct Walk<'a> {
    /// Instructions outside of functions, by id.
    definitions: BTreeMap<u32, &'a Instruction>,
    bodies: BTreeMap<u32, &'a Function>,
    /// Ids of types, constants and variables, each after all that it refers to.
    globals: Vec<u32>,
    /// Ids of functions, in the order of first mention.
    functions: Vec<u32>,
    seen: BTreeSet<u32>,
    /// New number of every id.
    ids: BTreeMap<u32, u32>,
}

impl<'a> Walk<'a> {
    fn new(module: &'a Module) -> Self {
        let globals = module.ext_inst_imports.iter().chain(&module.types_global_values);
        Self {
            definitions: globals.filter_map(|inst| Some((inst.result_id?, inst))).collect(),
            bodies: module.functions.iter().filter_map(|function| Some((function.def_id()?, function))).collect(),
            globals: Vec::new(),
            functions: Vec::new(),
            seen: BTreeSet::new(),
            ids: BTreeMap::new(),
        }
    }

    fn run(&mut self, entry_points: &[Instruction]) -> Result<()> {
        let mut done = 0;
        for entry in entry_points {
            self.visit_operands(&entry.operands[1..2])?;
            while let Some(&id) = self.functions.get(done) {
                done += 1;
                let body: &Function = self.bodies[&id];
                for inst in body.all_inst_iter() {
                    self.visit_inst(inst)?;
                }
            }
            self.visit_operands(&entry.operands[3..])?;
        }
        for id in self.globals.clone() {
            self.number(id);
        }
        for id in self.functions.clone() {
            let body: &Function = self.bodies[&id];
            for inst in body.all_inst_iter() {
                inst.result_id.into_iter().for_each(|id| self.number(id));
            }
        }
        Ok(())
    }

    fn number(&mut self, id: u32) {
        let next = self.ids.len() as u32 + 1;
        self.ids.entry(id).or_insert(next);
    }

    fn visit_inst(&mut self, inst: &Instruction) -> Result<()> {
        if let Some(id) = inst.result_type {
            self.visit(id)?;
        }
        self.visit_operands(&inst.operands)
    }

    fn visit_operands(&mut self, operands: &[Operand]) -> Result<()> {
        operands.iter().filter_map(Operand::id_ref_any).try_for_each(|id| self.visit(id))
    }

    /// Visits what `id` refers to, then lists `id`; ids that are local to a function are left alone.
    fn visit(&mut self, id: u32) -> Result<()> {
        if let Some(&inst) = self.definitions.get(&id) {
            if inst.class.opcode == Op::TypeForwardPointer {
                bail!("forward pointers are not expected of rust-gpu: canonical order would have to learn them");
            }
            if self.seen.insert(id) {
                self.visit_inst(inst)?;
                self.globals.push(id);
            }
        } else if self.bodies.contains_key(&id) && self.seen.insert(id) {
            self.functions.push(id);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::kernel;
    use rspirv::binary::Assemble;

    #[test]
    fn ordering_is_idempotent_and_drops_what_nothing_uses() {
        let mut module = kernel(|b, float, x| {
            b.f_add(float, None, x, x).unwrap();
        });
        let unused = Instruction::new(Op::TypeFloat, None, Some(900), vec![Operand::LiteralBit32(64)]);
        module.types_global_values.push(unused);
        order(&mut module).unwrap();
        let once = module.assemble();
        assert!(module.types_global_values.iter().all(|inst| inst.operands != [Operand::LiteralBit32(64)]));
        order(&mut module).unwrap();
        assert_eq!(module.assemble(), once);
    }

    #[test]
    fn numbering_does_not_depend_on_the_compilers() {
        let build = || {
            kernel(|b, float, x| {
                b.f_add(float, None, x, x).unwrap();
            })
        };
        let (mut plain, mut shifted) = (build(), build());
        for inst in shifted.all_inst_iter_mut() {
            let fields = inst.result_type.iter_mut().chain(&mut inst.result_id);
            for id in fields.chain(inst.operands.iter_mut().filter_map(Operand::id_ref_any_mut)) {
                *id = 1000 - *id;
            }
        }
        shifted.annotations.reverse();
        order(&mut plain).unwrap();
        order(&mut shifted).unwrap();
        assert_eq!(plain.assemble(), shifted.assemble());
    }
}
