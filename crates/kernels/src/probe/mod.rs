//! Kernels that put a device to the test: does it compute, and lay out records, as the CPU does?

mod arithmetic;
mod copy;
mod layout;

pub use arithmetic::{Arithmetic, ArithmeticParams, arithmetic};
pub use copy::copy_quads;
#[cfg(not(target_arch = "spirv"))]
pub use layout::LAYOUTS;
pub use layout::{
    LAYOUT_WORDS, Words, layout_film, layout_grid, layout_kd, layout_ledger, layout_map, layout_rivals, layout_scene,
    layout_sort, layout_surface,
};
