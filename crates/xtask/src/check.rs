//! Refuses what would not run on every device, or, of exact modules, not give the same bits there.

use crate::arithmetic::Arithmetic;
use crate::canonical;
use anyhow::{Result, bail};
use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Capability, GlslStd450Op as Glsl, Op};
use std::collections::{BTreeMap, BTreeSet};

/// Capabilities a kernel may need: all but the first are subgroup operations.
const CAPABILITIES: [Capability; 7] = [
    Capability::Shader,
    Capability::GroupNonUniform,
    Capability::GroupNonUniformVote,
    Capability::GroupNonUniformBallot,
    Capability::GroupNonUniformArithmetic,
    Capability::GroupNonUniformShuffle,
    Capability::GroupNonUniformShuffleRelative,
];

/// `GLSL.std.450` instructions whose result the specification gives exactly.
///
/// `FMin` and its kin are not among them: which of +0 and −0, and with `FMin` which of a number and a NaN, is left open.
const EXACT: [Glsl; 18] = [
    Glsl::RoundEven,
    Glsl::Trunc,
    Glsl::FAbs,
    Glsl::SAbs,
    Glsl::FSign,
    Glsl::SSign,
    Glsl::Floor,
    Glsl::Ceil,
    Glsl::Step,
    Glsl::UMin,
    Glsl::SMin,
    Glsl::UMax,
    Glsl::SMax,
    Glsl::UClamp,
    Glsl::SClamp,
    Glsl::FindILsb,
    Glsl::FindSMsb,
    Glsl::FindUMsb,
];

/// Checks the finished module; returns warnings.
///
/// A float constant that is infinite or no number is worth a warning in an exact module, which goes past naga, and an error
/// in a fast one, which must get through it.
pub fn structure(module: &Module, arithmetic: Arithmetic) -> Result<Vec<String>> {
    for inst in &module.capabilities {
        if !CAPABILITIES.iter().any(|&allowed| inst.operands[0] == Operand::Capability(allowed)) {
            bail!("the shaders need the capability {}, which not every device has", inst.operands[0]);
        }
    }
    let glsl: BTreeSet<u32> = module.ext_inst_imports.iter().filter_map(|inst| inst.result_id).collect();
    for inst in &module.ext_inst_imports {
        if inst.operands[0] != Operand::LiteralString("GLSL.std.450".into()) {
            bail!("the shaders use the unknown instruction set {}", inst.operands[0]);
        }
    }
    pointers_stand_alone(module)?;
    let odd: Vec<String> = module.types_global_values.iter().filter_map(|inst| odd_constant(module, inst)).collect();
    if arithmetic == Arithmetic::Fast {
        return if odd.is_empty() { Ok(odd) } else { bail!(odd.join("; ")) };
    }
    for function in &module.functions {
        for inst in function.all_inst_iter() {
            if let Some(refused) = refused(inst, &glsl) {
                let users = users(module, function.def_id().unwrap_or_default()).join(", ");
                bail!("{refused} does not give the same bits on all devices; it is used by {users}");
            }
        }
    }
    Ok(odd)
}

/// Refuses pointers in structs and in phis: see [`forward`](crate::forward) for the driver that crashes on them.
fn pointers_stand_alone(module: &Module) -> Result<()> {
    let of = |op| module.types_global_values.iter().filter(move |inst: &&Instruction| inst.class.opcode == op);
    let pointers: BTreeSet<u32> = of(Op::TypePointer).filter_map(|inst| inst.result_id).collect();
    let holds_pointer =
        |inst: &Instruction| inst.operands.iter().filter_map(Operand::id_ref_any).any(|id| pointers.contains(&id));
    let chosen = |inst: &Instruction| {
        matches!(inst.class.opcode, Op::Phi | Op::Select) && inst.result_type.is_some_and(|id| pointers.contains(&id))
    };
    if of(Op::TypeStruct).any(holds_pointer) || module.functions.iter().any(|f| f.all_inst_iter().any(chosen)) {
        bail!(
            "a kernel keeps a reference inside a value or chooses between references, on which NVIDIA's driver crashes: make the closures `move`, or pass the buffers themselves"
        );
    }
    Ok(())
}

/// The names of the capabilities that the module declares.
pub fn capabilities(module: &Module) -> Vec<String> {
    let name = |inst: &Instruction| match inst.operands[0] {
        Operand::Capability(capability) => format!("{capability:?}"),
        _ => String::new(),
    };
    module.capabilities.iter().map(name).collect()
}

/// The name of an instruction that is not exact.
fn refused(inst: &Instruction, glsl: &BTreeSet<u32>) -> Option<String> {
    match inst.class.opcode {
        // Remainders are exact in Rust and off by any multiple in a driver; float reductions come in any order.
        op @ (Op::FRem
        | Op::FMod
        | Op::AtomicFAddEXT
        | Op::GroupNonUniformFAdd
        | Op::GroupNonUniformFMul
        | Op::GroupNonUniformFMin
        | Op::GroupNonUniformFMax) => Some(format!("Op{op:?}")),
        Op::ExtInst if inst.operands[0].id_ref_any().is_some_and(|set| glsl.contains(&set)) => {
            let number = inst.operands[1].unwrap_literal_ext_inst_integer();
            match Glsl::from_u32(number) {
                Some(op) if EXACT.contains(&op) => None,
                Some(op) => Some(format!("GLSL.std.450 {op:?}")),
                None => Some(format!("GLSL.std.450 instruction {number}")),
            }
        }
        _ => None,
    }
}

/// Names of the entry points that reach the function `wanted`.
fn users(module: &Module, wanted: u32) -> Vec<String> {
    let reaches = |entry: &&Instruction| {
        entry.operands[1].id_ref_any().is_some_and(|main| reachable(module, main).contains(&wanted))
    };
    module.entry_points.iter().filter(reaches).map(|entry| canonical::name(entry).to_owned()).collect()
}

/// The functions that `main` calls, itself included.
pub fn reachable(module: &Module, main: u32) -> BTreeSet<u32> {
    let bodies: BTreeMap<_, _> = module.functions.iter().filter_map(|f| Some((f.def_id()?, f))).collect();
    let (mut found, mut queue) = (BTreeSet::new(), vec![main]);
    while let Some(id) = queue.pop() {
        if found.insert(id) {
            let calls = bodies.get(&id).into_iter().flat_map(|f| f.all_inst_iter());
            let calls = calls.filter(|inst| inst.class.opcode == Op::FunctionCall);
            queue.extend(calls.filter_map(|inst| inst.operands[0].id_ref_any()));
        }
    }
    found
}

/// What to say about a float constant that is infinite or no number: naga's SPIR-V reader refuses those.
fn odd_constant(module: &Module, inst: &Instruction) -> Option<String> {
    let (Op::Constant, Some(Operand::LiteralBit32(bits))) = (inst.class.opcode, inst.operands.first()) else {
        return None;
    };
    let of_type = module.types_global_values.iter().find(|other| other.result_id == inst.result_type)?;
    let value = f32::from_bits(*bits);
    (of_type.class.opcode == Op::TypeFloat && !value.is_finite())
        .then(|| format!("a float constant is {value}: wgpu's portable path (naga) refuses such a module"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::kernel;

    fn with_glsl(op: Glsl, arithmetic: Arithmetic) -> Result<Vec<String>> {
        let mut module = kernel(|b, float, x| {
            let set = b.ext_inst_import("GLSL.std.450");
            b.ext_inst(float, None, set, op as u32, [Operand::IdRef(x)]).unwrap();
        });
        crate::memory_model::to_glsl450(&mut module).unwrap();
        structure(&module, arithmetic)
    }

    #[test]
    fn an_exact_square_root_is_refused_and_a_floor_or_a_fast_root_is_not() {
        let error = with_glsl(Glsl::Sqrt, Arithmetic::Exact).unwrap_err().to_string();
        assert_eq!(error, "GLSL.std.450 Sqrt does not give the same bits on all devices; it is used by main");
        with_glsl(Glsl::Floor, Arithmetic::Exact).unwrap();
        with_glsl(Glsl::Sqrt, Arithmetic::Fast).unwrap();
    }

    #[test]
    fn remainders_capabilities_and_infinities_are_noticed() {
        let mut module = kernel(|b, float, x| {
            b.constant_bit32(float, f32::INFINITY.to_bits());
            b.f_rem(float, None, x, x).unwrap();
        });
        for arithmetic in Arithmetic::ALL {
            assert!(structure(&module, arithmetic).unwrap_err().to_string().contains("VulkanMemoryModel"));
        }
        crate::memory_model::to_glsl450(&mut module).unwrap();
        assert!(structure(&module, Arithmetic::Exact).unwrap_err().to_string().starts_with("OpFRem"));
        for block in &mut module.functions[0].blocks {
            block.instructions.retain(|inst| inst.class.opcode != Op::FRem);
        }
        let warning = structure(&module, Arithmetic::Exact).unwrap().remove(0);
        let error = structure(&module, Arithmetic::Fast).unwrap_err().to_string();
        assert_eq!(warning, error);
        assert!(error.starts_with("a float constant is inf"), "{error}");
    }
}
