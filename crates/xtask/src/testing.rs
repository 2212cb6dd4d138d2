//! Small modules for the unit tests.

use rspirv::dr::{Builder, Module};
use rspirv::spirv::{AddressingModel, Capability, ExecutionMode, ExecutionModel, FunctionControl, MemoryModel, Word};

/// A compute entry `main` whose body `fill` writes; it is given the builder, the float type and a float.
pub fn kernel(fill: impl FnOnce(&mut Builder, Word, Word)) -> Module {
    let mut b = Builder::new();
    b.set_version(1, 5);
    b.capability(Capability::Shader);
    b.capability(Capability::VulkanMemoryModel);
    b.memory_model(AddressingModel::Logical, MemoryModel::Vulkan);
    let void = b.type_void();
    let float = b.type_float(32, None);
    let x = b.constant_bit32(float, 1.5f32.to_bits());
    let signature = b.type_function(void, []);
    let main = b.begin_function(void, None, FunctionControl::NONE, signature).unwrap();
    b.begin_block(None).unwrap();
    fill(&mut b, float, x);
    b.ret().unwrap();
    b.end_function().unwrap();
    b.entry_point(ExecutionModel::GLCompute, main, "main", []);
    b.execution_mode(main, ExecutionMode::LocalSize, [64, 1, 1]);
    b.module()
}
