//! Translates SPIR-V modules into CUDA C++: naga writes them as Metal's C++, whose words `metal.cuh` explains to nvcc, and what CUDA
//! calls a kernel is put around each. `translate FOLDER MODULE.spv …` writes `FOLDER/NAME.cuh`, and `FOLDER/kernels.cuh`, which includes all.

use naga::{AddressSpace, Block, Expression, Handle, LocalVariable, ResourceBinding, Span, Statement, TypeInner};
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("name a folder and modules")?;
    let mut all = String::new();
    let mut table = String::new();
    for path in arguments {
        let name = Path::new(&path).file_stem().and_then(|name| name.to_str()).ok_or("no name")?;
        let text = translated(&std::fs::read(&path)?, name).map_err(|error| format!("{path}: {error}"))?;
        std::fs::write(Path::new(&folder).join(format!("{name}.cuh")), text)?;
        writeln!(all, "#include \"{name}.cuh\"")?;
        writeln!(table, "    {{\"{name}\", k_{name}::run}},")?;
    }
    writeln!(all, "struct Entry {{ const char* name; void (*run)(const Arguments); }};\nconst Entry KERNELS[] = {{\n{table}}};")?;
    std::fs::write(Path::new(&folder).join("kernels.cuh"), all)?;
    Ok(())
}

fn translated(bytes: &[u8], name: &str) -> Result<String, Box<dyn Error>> {
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    use naga::{back::msl, front::spv};
    let options = spv::Options { adjust_coordinate_space: false, strict_capabilities: false, block_ctx_dump_prefix: None };
    let mut module = spv::parse_u8_slice(bytes, &options)?;
    // Names by which types are found again in the text.
    let handles: Vec<_> = module.types.iter().map(|(handle, _)| handle).collect();
    for handle in handles {
        let mut named = module.types[handle].clone();
        if !matches!(named.inner, TypeInner::Struct { .. } | TypeInner::Array { .. }) {
            continue;
        }
        named.name = Some(format!("type{}x", handle.index()));
        module.types.replace(handle, named);
    }
    for function in module.functions.iter_mut().map(|(_, function)| function) {
        keep_conditions(function, boolean(&mut module.types));
    }
    for entry in &mut module.entry_points {
        keep_conditions(&mut entry.function, boolean(&mut module.types));
    }
    let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module)?;
    let options = msl::Options {
        lang_version: (2, 4),
        fake_missing_bindings: true,
        zero_initialize_workgroup_memory: false,
        force_loop_bounding: false,
        ..Default::default()
    };
    let (text, written) = msl::write_string(&module, &info, &options, &msl::PipelineOptions::default())?;
    let entry = written.entry_point_names[0].as_ref().map_err(|error| error.to_string())?.clone();

    // Records of an array lie as its stride allows, and buffers begin at a multiple of 256 bytes: a driver knows, nvcc has to be told.
    let mut aligned = Vec::new();
    for (_, of_type) in module.types.iter() {
        if let TypeInner::Array { base, stride, size: naga::ArraySize::Dynamic } = of_type.inner {
            let to = if stride % 16 == 0 { 16 } else if stride % 8 == 0 { 8 } else { 4 };
            aligned.push((format!("struct type{}x {{", base.index()), format!("struct __align__({to}) type{}x {{", base.index())));
        }
    }
    let mut cuda = format!("namespace k_{name} {{\n");
    // CUDA's pointers know no address spaces.
    let text = ["device ", "constant ", "threadgroup ", "thread "].into_iter().fold(text, |text, space| text.replace(space, ""));
    for line in text.lines() {
        let function = line.starts_with(char::is_alphabetic) && line.contains('(') && !line.starts_with("struct");
        if line.starts_with("#include") || line.starts_with("using metal::uint") {
            continue;
        }
        if let Some((_, kernel)) = line.split_once("]] kernel ") {
            cuda += &format!("__device__ __forceinline__ {kernel}\n");
        } else if line.starts_with(['[', ' ', ',']) && line.contains("[[") {
            cuda += &format!("{}\n", line.split(" [[").next().unwrap_or_default());
        } else if function {
            cuda += &format!("__device__ __forceinline__ {line}\n");
        } else if let Some((_, to)) = aligned.iter().find(|(from, _)| from == line) {
            cuda += &format!("{to}\n");
        } else {
            cuda += &format!("{line}\n");
        }
    }

    // The kernel: its globals in the order in which the entry point has them.
    let lanes = module.entry_points[0].workgroup_size[0];
    let mut arguments = vec!["uint3_of(blockIdx)".to_string(), "uint3_of(gridDim)".to_string(), "uint3_of(threadIdx)".to_string()];
    let (mut shared, mut sizes) = (String::new(), Vec::new());
    for (handle, variable) in module.global_variables.iter() {
        let variable_type = format!("type{}x", variable.ty.index());
        match (variable.space, variable.binding) {
            (AddressSpace::WorkGroup, _) => {
                shared += &format!("    __shared__ {variable_type} shared{};\n", handle.index());
                arguments.push(format!("shared{}", handle.index()));
            }
            (_, Some(ResourceBinding { binding, .. })) => {
                let dynamic = matches!(&module.types[variable.ty].inner, TypeInner::Struct { members, .. }
                    if members.iter().any(|member| matches!(module.types[member.ty].inner, TypeInner::Array { size: naga::ArraySize::Dynamic, .. })));
                if dynamic {
                    sizes.push(format!("arguments.bytes[{binding}]"));
                    arguments.push(format!("*({variable_type}*)arguments.buffer[{binding}]"));
                } else {
                    // A single record comes as a constant.
                    arguments.push(format!("*(const {variable_type}*)arguments.one[{binding}]"));
                }
            }
            _ => {}
        }
    }
    if !sizes.is_empty() {
        arguments.push("sizes".to_string());
        shared += &format!("    _mslBufferSizes sizes = {{{}}};\n", sizes.join(", "));
    }
    cuda += &format!(
        "__global__ void __launch_bounds__({lanes}) run(const __grid_constant__ Arguments arguments) {{\n{shared}    {entry}({});\n}}\n}}\n",
        arguments.join(", ")
    );
    Ok(cuda)
}

fn boolean(types: &mut naga::UniqueArena<naga::Type>) -> Handle<naga::Type> {
    types.insert(naga::Type { name: None, inner: TypeInner::Scalar(naga::Scalar::BOOL) }, Span::UNDEFINED)
}

/// Keeps the condition under which a loop goes on in a variable. naga 30 writes the condition again where the next turn begins, out of what
/// that turn has already changed: the loop would end a turn too early.
fn keep_conditions(function: &mut naga::Function, boolean: Handle<naga::Type>) {
    let mut body = std::mem::take(&mut function.body);
    keep_in(&mut body, function, boolean);
    function.body = body;
}

fn keep_in(block: &mut Block, function: &mut naga::Function, boolean: Handle<naga::Type>) {
    for statement in block.iter_mut() {
        match statement {
            Statement::Block(block) => keep_in(block, function, boolean),
            Statement::If { accept, reject, .. } => {
                keep_in(accept, function, boolean);
                keep_in(reject, function, boolean);
            }
            Statement::Switch { cases, .. } => cases.iter_mut().for_each(|case| keep_in(&mut case.body, function, boolean)),
            Statement::Loop { body, continuing, break_if } => {
                keep_in(body, function, boolean);
                keep_in(continuing, function, boolean);
                let Some(negated) = *break_if else { continue };
                let Expression::Unary { op: op @ naga::UnaryOperator::LogicalNot, expr: condition } = function.expressions[negated] else {
                    panic!("a loop ends otherwise than rust-gpu's do");
                };
                let goes_on = LocalVariable { name: Some("goes_on".into()), ty: boolean, init: None };
                let variable = function.local_variables.append(goes_on, Span::UNDEFINED);
                let mut new = |expression| function.expressions.append(expression, Span::UNDEFINED);
                let pointer = new(Expression::LocalVariable(variable));
                let first = new(Expression::Load { pointer });
                let ends = new(Expression::Unary { op, expr: first });
                let store = Statement::Store { pointer, value: condition };
                assert!(stored_after(body, condition, &store), "the condition of a loop is nowhere in it");
                continuing.push(Statement::Emit(naga::Range::new_from_bounds(first, ends)), Span::UNDEFINED);
                *break_if = Some(ends);
            }
            _ => {}
        }
    }
}

/// Puts a statement behind the one that computes an expression.
fn stored_after(block: &mut Block, expression: Handle<Expression>, store: &Statement) -> bool {
    let mut place = None;
    for (i, statement) in block.iter_mut().enumerate() {
        let found = match statement {
            Statement::Emit(range) if range.clone().any(|emitted| emitted == expression) => {
                place = Some(i + 1);
                break;
            }
            Statement::Block(block) => stored_after(block, expression, store),
            Statement::If { accept, reject, .. } => {
                stored_after(accept, expression, store) || stored_after(reject, expression, store)
            }
            Statement::Switch { cases, .. } => cases.iter_mut().any(|case| stored_after(&mut case.body, expression, store)),
            _ => false,
        };
        if found {
            return true;
        }
    }
    let Some(place) = place else { return false };
    let mut with = Block::new();
    with.push(store.clone(), Span::UNDEFINED);
    block.splice(place..place, with);
    true
}
