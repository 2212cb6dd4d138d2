//! Exact arithmetic: the operations whose result a device may choose, rebuilt from those it may not.
//!
//! Integer operations and single, correctly rounded `+ - ×` give the same bits on every device; a native `/`, `sqrt`
//! or `sin` does not. Everything here is made of the former only, so a kernel that computes with this module gives the
//! same bits on a CPU and on a GPU.
//!
//! Subnormal numbers do not exist here: devices differ in whether they keep them, so every function takes a subnormal
//! operand for the zero of its sign, and gives that zero where the result would be subnormal. A NaN that comes out is
//! always [`NAN`].
//!
//! The feature `fast` gives all that up, on a GPU only: division, root, sine and cosine are then the driver's own, 2.5 ulp
//! off or worse (Vulkan specification, "Precision and Operation of SPIR-V Instructions"), and what an infinite or NaN
//! operand gives is the driver's choice. On the CPU nothing changes: its own division and root are exact already.
#![cfg_attr(all(target_arch = "spirv", feature = "fast"), allow(unreachable_code))] // the exact bodies, then bypassed

mod convert;
mod div;
mod exp;
mod float;
mod rng;
mod sqrt;
mod sum;
mod trig;

pub use convert::{f32_to_u32_clamped, floor_to_i32, u32_to_unit, ulp_distance};
pub use div::{div, div_corrected, recip};
pub use exp::{exp, exp2, ln, log2, pow};
pub use float::{
    NAN, abs, canonical, flush, from_total_order_key, fsign, is_finite, is_nan, max, min, powi2, total_order_key,
};
pub use rng::{Rng, pcg4d, shuffle_index, sobol2};
pub use sqrt::{inv_sqrt, sqrt, sqrt_corrected};
pub use sum::{Limbs, MAX_TERMS};
pub use trig::{atan2_turns, sin_cos_turns};

#[cfg(test)]
mod samples;
