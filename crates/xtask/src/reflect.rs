//! Reads an entry point's workgroup size and bindings out of the finished module.

use crate::{canonical, check};
use anyhow::{Context, Result, bail};
use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, ExecutionMode, Op, StorageClass};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// What `crates/device` needs to know about the modules, and what they were made from.
#[derive(Serialize, Deserialize)]
pub struct Manifest {
    /// Of everything that goes in: see `sources`.
    pub sources_sha256: String,
    /// The compiler's name and version.
    pub compiler: String,
    /// Sorted by name.
    pub entry_points: Vec<EntryPoint>,
}

/// One kernel.
#[derive(Serialize, Deserialize)]
pub struct EntryPoint {
    /// As in the module, which is the path of the Rust function.
    pub name: String,
    /// Of its exact module, `<name>.spv`.
    pub spirv_sha256: String,
    /// Of its fast module, `fast/<name>.spv`.
    pub fast_sha256: String,
    /// The same for both.
    #[serde(flatten)]
    pub interface: Interface,
}

/// How a kernel is dispatched and what is bound to it.
#[derive(Serialize, Deserialize, Debug, PartialEq)]
pub struct Interface {
    /// Invocations a workgroup.
    pub local_size: [u32; 3],
    /// Sorted by set and binding.
    pub bindings: Vec<Binding>,
}

/// One buffer.
#[derive(Serialize, Deserialize, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Binding {
    /// Descriptor set.
    pub set: u32,
    /// Binding in the set.
    pub binding: u32,
    /// Which kind of buffer.
    pub kind: Kind,
    /// What the kernel does to it.
    pub access: Access,
}

/// The kind of a buffer.
#[derive(Serialize, Deserialize, Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Uniform buffer.
    Uniform,
    /// Storage buffer.
    Storage,
}

/// What a kernel does to a buffer.
#[derive(Serialize, Deserialize, Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[serde(rename_all = "snake_case")]
pub enum Access {
    /// It is decorated `NonWritable`, or nothing that the kernel calls stores to it.
    Read,
    /// Anything else.
    ReadWrite,
}

/// Reflects a module's only entry point.
pub fn interface(module: &Module) -> Result<Interface> {
    let [entry] = &module.entry_points[..] else {
        bail!("a module has {} entry points instead of one", module.entry_points.len());
    };
    let variables = variables(module);
    let name = canonical::name(entry);
    let main = entry.operands[1].id_ref_any().context("an entry point names no function")?;
    let written = written(module, &variables, &check::reachable(module, main));
    let mut bindings = Vec::new();
    // From SPIR-V 1.4 on, an entry point lists every global it uses, buffers included.
    for id in entry.operands[3..].iter().filter_map(Operand::id_ref_any) {
        let kind = match variables.get(&id) {
            Some(StorageClass::StorageBuffer) => Kind::Storage,
            Some(StorageClass::Uniform) => Kind::Uniform,
            Some(StorageClass::Input | StorageClass::Workgroup | StorageClass::Private) => continue,
            other => bail!("{name} uses a global of storage class {other:?}, which caustic does not bind"),
        };
        let number = |what| decoration(module, id, what).with_context(|| format!("{name}: a buffer has no {what:?}"));
        let read = kind == Kind::Uniform || non_writable(module, id) || !written.contains(&id);
        bindings.push(Binding {
            set: number(Decoration::DescriptorSet)?,
            binding: number(Decoration::Binding)?,
            kind,
            access: if read { Access::Read } else { Access::ReadWrite },
        });
    }
    bindings.sort();
    if let Some(pair) =
        bindings.windows(2).find(|pair| (pair[0].set, pair[0].binding) == (pair[1].set, pair[1].binding))
    {
        bail!("{name} has two buffers at set {} binding {}", pair[0].set, pair[0].binding);
    }
    let local_size =
        local_size(module, main).with_context(|| format!("{name} has no LocalSize: is it a compute entry?"))?;
    Ok(Interface { local_size, bindings })
}

fn local_size(module: &Module, main: u32) -> Option<[u32; 3]> {
    let mode = [Operand::IdRef(main), Operand::ExecutionMode(ExecutionMode::LocalSize)];
    let found = module.execution_modes.iter().find(|inst| inst.operands.starts_with(&mode))?;
    let size = |at: usize| found.operands.get(at).map(Operand::unwrap_literal_bit32);
    Some([size(2)?, size(3)?, size(4)?])
}

/// Global variables and their storage classes.
fn variables(module: &Module) -> BTreeMap<u32, StorageClass> {
    let variable = |inst: &Instruction| match (inst.class.opcode, inst.operands.first()) {
        (Op::Variable, Some(Operand::StorageClass(class))) => Some((inst.result_id?, *class)),
        _ => None,
    };
    module.types_global_values.iter().filter_map(variable).collect()
}

/// A decoration's number.
fn decoration(module: &Module, id: u32, what: Decoration) -> Option<u32> {
    let wanted = [Operand::IdRef(id), Operand::Decoration(what)];
    let found =
        module.annotations.iter().find(|i| i.class.opcode == Op::Decorate && i.operands.starts_with(&wanted))?;
    found.operands.get(2).map(Operand::unwrap_literal_bit32)
}

fn non_writable(module: &Module, id: u32) -> bool {
    let wanted = [Operand::IdRef(id), Operand::Decoration(Decoration::NonWritable)];
    module.annotations.iter().any(|inst| inst.class.opcode == Op::Decorate && inst.operands == wanted)
}

/// Variables that `functions` may store to.
///
/// Follows pointers through access chains, copies and calls until nothing new is found. A pointer that goes anywhere
/// but into a load or a length counts as written: the answer errs towards `read_write`.
fn written(module: &Module, variables: &BTreeMap<u32, StorageClass>, functions: &BTreeSet<u32>) -> BTreeSet<u32> {
    let bodies: Vec<_> =
        module.functions.iter().filter(|f| f.def_id().is_some_and(|id| functions.contains(&id))).collect();
    let parameters: BTreeMap<u32, Vec<u32>> = bodies
        .iter()
        .filter_map(|f| Some((f.def_id()?, f.parameters.iter().filter_map(|p| p.result_id).collect())))
        .collect();
    // Which variables a pointer may point into.
    let mut origins: BTreeMap<u32, BTreeSet<u32>> = variables.keys().map(|&id| (id, BTreeSet::from([id]))).collect();
    let mut written = BTreeSet::new();
    loop {
        let before: (usize, usize) = (origins.values().map(BTreeSet::len).sum(), written.len());
        for inst in bodies.iter().flat_map(|f| f.all_inst_iter()) {
            let ids: Vec<u32> = inst.operands.iter().filter_map(Operand::id_ref_any).collect();
            let mut flow = |from: u32, to: u32| {
                let new = origins.get(&from).cloned().unwrap_or_default();
                origins.entry(to).or_default().extend(new);
            };
            match inst.class.opcode {
                Op::Load | Op::ArrayLength | Op::AtomicLoad => {}
                Op::AccessChain | Op::InBoundsAccessChain | Op::CopyObject => {
                    inst.result_id.into_iter().for_each(|to| flow(ids[0], to));
                }
                Op::FunctionCall if parameters.contains_key(&ids[0]) => {
                    ids[1..].iter().zip(&parameters[&ids[0]]).for_each(|(&from, &to)| flow(from, to));
                }
                _ => ids.iter().filter_map(|id| origins.get(id)).for_each(|found| written.extend(found)),
            }
        }
        if before == (origins.values().map(BTreeSet::len).sum(), written.len()) {
            return written;
        }
    }
}
