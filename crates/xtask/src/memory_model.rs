//! Rewrites the Vulkan memory model, which rust-gpu's vulkan targets declare, to GLSL450.
//!
//! Two reasons. The capability `VulkanMemoryModel` needs a device feature that wgpu does not enable, so the validation
//! layers reject the pipeline. And under the Vulkan model a barrier orders only accesses marked `NonPrivatePointer`,
//! which rust-gpu does not emit: by the letter, a workgroup barrier would then order nothing. Under GLSL450 every access
//! is non-private and the barrier means what `workgroup_memory_barrier_with_group_sync` says.
//!
//! What GLSL450 does not give: one workgroup's plain stores to a buffer seen by another in the same dispatch. That needs
//! `Coherent`, or a second dispatch, which is what the stages use.

use anyhow::{Context, Result};
use rspirv::dr::{Function, Instruction, Module, Operand};
use rspirv::spirv::{AddressingModel, Capability, MemoryAccess, MemoryModel, MemorySemantics, Op, Scope};
use std::collections::BTreeMap;

/// Rewrites the memory model; leaves a module that already has GLSL450 as it is.
pub fn to_glsl450(module: &mut Module) -> Result<()> {
    let model = module.memory_model.as_mut().context("the module declares no memory model")?;
    model.operands =
        vec![Operand::AddressingModel(AddressingModel::Logical), Operand::MemoryModel(MemoryModel::GLSL450)];
    let vulkan = [Capability::VulkanMemoryModel, Capability::VulkanMemoryModelDeviceScope];
    module.capabilities.retain(|inst| !vulkan.iter().any(|&c| inst.operands[0] == Operand::Capability(c)));
    let extension = Operand::LiteralString("SPV_KHR_vulkan_memory_model".into());
    module.extensions.retain(|inst| inst.operands[0] != extension);

    let mut constants = Constants::new(module);
    for inst in module.functions.iter_mut().flat_map(Function::all_inst_iter_mut) {
        for operand in &mut inst.operands {
            match operand {
                Operand::IdMemorySemantics(id) => *id = constants.map(*id, glsl450_semantics),
                Operand::IdScope(id) => *id = constants.map(*id, glsl450_scope),
                _ => {}
            }
        }
        strip_access(inst);
    }
    module.types_global_values.append(&mut constants.added);
    if let Some(header) = &mut module.header {
        header.bound = constants.next;
    }
    Ok(())
}

/// Semantics without the bits that only the Vulkan model has.
fn glsl450_semantics(value: u32) -> u32 {
    let vulkan = MemorySemantics::MAKE_AVAILABLE
        | MemorySemantics::MAKE_VISIBLE
        | MemorySemantics::OUTPUT_MEMORY
        | MemorySemantics::VOLATILE;
    value & !vulkan.bits()
}

/// A scope that exists in GLSL450.
fn glsl450_scope(value: u32) -> u32 {
    if value == Scope::QueueFamily as u32 { Scope::Device as u32 } else { value }
}

/// Removes the Vulkan model's bits, and the scopes that follow them, from loads, stores and copies.
fn strip_access(inst: &mut Instruction) {
    if !matches!(inst.class.opcode, Op::Load | Op::Store | Op::CopyMemory) {
        return;
    }
    let scoped = MemoryAccess::MAKE_POINTER_AVAILABLE | MemoryAccess::MAKE_POINTER_VISIBLE;
    let mut dropping = false;
    inst.operands.retain_mut(|operand| match operand {
        Operand::MemoryAccess(access) => {
            dropping = access.intersects(scoped);
            access.remove(scoped | MemoryAccess::NON_PRIVATE_POINTER);
            true
        }
        Operand::IdScope(_) => !dropping,
        _ => true,
    });
}

/// The module's 32-bit constants, and those added: a constant may have other uses, so none is changed in place.
struct Constants {
    /// Type and value by id.
    values: BTreeMap<u32, (u32, u32)>,
    added: Vec<Instruction>,
    next: u32,
}

impl Constants {
    fn new(module: &Module) -> Self {
        let value = |inst: &Instruction| match (inst.class.opcode, inst.operands.first()) {
            (Op::Constant, Some(Operand::LiteralBit32(value))) => Some((inst.result_id?, (inst.result_type?, *value))),
            _ => None,
        };
        Self {
            values: module.types_global_values.iter().filter_map(value).collect(),
            added: Vec::new(),
            next: module.header.as_ref().map_or(1, |header| header.bound),
        }
    }

    /// The id of the constant `change(value of id)`.
    fn map(&mut self, id: u32, change: impl Fn(u32) -> u32) -> u32 {
        let Some(&(of_type, old)) = self.values.get(&id) else {
            return id;
        };
        let wanted = (of_type, change(old));
        if wanted.1 == old {
            return id;
        }
        if let Some((&known, _)) = self.values.iter().find(|(_, value)| **value == wanted) {
            return known;
        }
        let new = self.next;
        self.next += 1;
        let operands = vec![Operand::LiteralBit32(wanted.1)];
        self.added.push(Instruction::new(Op::Constant, Some(of_type), Some(new), operands));
        self.values.insert(new, wanted);
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::kernel;

    #[test]
    fn barriers_lose_what_only_the_vulkan_model_has() {
        let mut module = kernel(|b, _, _| {
            let uint = b.type_int(32, 0);
            let scope = b.constant_bit32(uint, Scope::QueueFamily as u32);
            let semantics = b.constant_bit32(uint, 0x6108);
            b.memory_barrier(scope, semantics).unwrap();
        });
        to_glsl450(&mut module).unwrap();
        let constants = Constants::new(&module).values;
        let barrier = module.all_inst_iter().find(|inst| inst.class.opcode == Op::MemoryBarrier).unwrap();
        let value = |at: usize| constants[&barrier.operands[at].id_ref_any().unwrap()].1;
        assert_eq!((value(0), value(1)), (Scope::Device as u32, 0x108));
        assert_eq!(module.memory_model.unwrap().operands[1], Operand::MemoryModel(MemoryModel::GLSL450));
    }

    #[test]
    fn loads_lose_the_bit_and_its_scope() {
        let access = MemoryAccess::NON_PRIVATE_POINTER | MemoryAccess::MAKE_POINTER_VISIBLE | MemoryAccess::ALIGNED;
        let operands =
            vec![Operand::IdRef(1), Operand::MemoryAccess(access), Operand::LiteralBit32(4), Operand::IdScope(2)];
        let mut load = Instruction::new(Op::Load, Some(3), Some(4), operands);
        strip_access(&mut load);
        let kept = [Operand::IdRef(1), Operand::MemoryAccess(MemoryAccess::ALIGNED), Operand::LiteralBit32(4)];
        assert_eq!(load.operands, kept);
    }
}
