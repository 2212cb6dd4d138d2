//! How fast a device copies: the roofline of what is bound by bytes.

use crate::exec::{Input, Store};
use crate::layout::Site;

/// Copies element `i`.
#[inline]
pub fn copy_quads<O: Store<Site> + ?Sized>(i: u32, input: &Input<Site>, output: &mut O) {
    if (i as usize) < input.len() {
        output.set(i, input[i as usize]);
    }
}
