//! The bodies of `caustic_kernels`, compiled a second time from the same files with another [`exec`]: inputs and private arrays
//! that write down every access. What accesses no buffers is not compiled again.

pub mod exec;
pub mod sink;

pub use caustic_kernels::{layout, num, stages};

#[path = "../../kernels/src/gather/mod.rs"]
pub mod gather;
#[path = "../../kernels/src/grid/mod.rs"]
pub mod grid;
#[path = "../../kernels/src/probe/mod.rs"]
pub mod probe;
#[path = "../../kernels/src/rivals/mod.rs"]
pub mod rivals;
#[path = "../../kernels/src/sort/mod.rs"]
pub mod sort;
#[path = "../../kernels/src/trace/mod.rs"]
pub mod trace;
