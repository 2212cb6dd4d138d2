//! Writes a kernel's mask into its SPIR-V: a specialisation constant becomes a constant, and drivers remove what it rules out.
//!
//! wgpu passes modules through with specialisation constants at their defaults, and its translation would make variables of them. A constant
//! is the same to both paths, and no driver can take it for anything else.

/// The number that marks the mask among specialisation constants; `shaders-crate` gives it.
const MASK: u32 = 1;
/// Words before the first instruction.
const HEADER: usize = 5;
const OP_CONSTANT: u32 = 43;
const OP_SPEC_CONSTANT: u32 = 50;
const OP_FUNCTION: u32 = 54;
const OP_DECORATE: u32 = 71;
const DECORATION_SPEC_ID: u32 = 1;

/// The module with `value` for its mask, if it has one.
pub(super) fn with(words: &[u32], value: u32) -> Vec<u32> {
    let mut out = words[..HEADER].to_vec();
    let mut mask = None;
    let mut rest = &words[HEADER..];
    while let Some(&first) = rest.first() {
        let (opcode, length) = (first & 0xffff, (first >> 16) as usize);
        // No decorations or constants of a module from the first function on.
        if opcode == OP_FUNCTION || length == 0 || length > rest.len() {
            break;
        }
        let (instruction, after) = rest.split_at(length);
        match *instruction {
            // Decorations come before what they decorate.
            [_, id, DECORATION_SPEC_ID, MASK] if opcode == OP_DECORATE => mask = Some(id),
            [_, of_type, id, _] if opcode == OP_SPEC_CONSTANT && mask == Some(id) => {
                out.extend([(4 << 16) | OP_CONSTANT, of_type, id, value]);
            }
            _ => out.extend_from_slice(instruction),
        }
        rest = after;
    }
    out.extend_from_slice(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kernel, Precision};
    use caustic_kernels::trace::EVERYTHING;

    const fn op(length: u32, opcode: u32) -> u32 {
        (length << 16) | opcode
    }

    /// A header, the decorations, an integer type, two specialisation constants and a function that holds words like a decoration's.
    const MODULE: [u32; 32] = [
        0x0723_0203,
        0x0001_0500,
        0,
        20,
        0,
        op(4, OP_DECORATE),
        7,
        DECORATION_SPEC_ID,
        MASK,
        op(4, OP_DECORATE),
        8,
        DECORATION_SPEC_ID,
        2,
        op(4, 21),
        6,
        32,
        0,
        op(4, OP_SPEC_CONSTANT),
        6,
        7,
        63,
        op(4, OP_SPEC_CONSTANT),
        6,
        8,
        63,
        op(3, OP_FUNCTION),
        6,
        9,
        op(4, OP_DECORATE),
        7,
        DECORATION_SPEC_ID,
        MASK,
    ];

    #[test]
    fn the_mask_becomes_a_constant_and_all_else_stays() {
        let mut expected = MODULE.to_vec();
        expected[17] = op(4, OP_CONSTANT);
        expected[20] = 5;
        expected.drain(5..9);
        assert_eq!(with(&MODULE, 5), expected);
        assert_eq!(with(&expected, 9), expected, "a module without a mask");
        // What is no module is left to the driver to refuse.
        for broken in [&MODULE[..5], &MODULE[..7], &[0; 6]] {
            assert_eq!(with(broken, 1), broken);
        }
    }

    /// Of the kernels that there are: the tracing ones have one mask each, which knows everything by default, and the others none.
    #[test]
    fn tracing_kernels_have_a_mask() {
        let masked = ["count_photons", "store_photons", "trace_camera", "shade_direct", "trace_paths", "trace_gather"];
        for kernel in Kernel::ALL {
            for precision in [Precision::Exact, Precision::Fast] {
                let words = kernel.words(precision);
                let (some, all) = (with(&words, 5), with(&words, EVERYTHING));
                let name = kernel.entry_point();
                if !masked.contains(&name) {
                    assert_eq!((&some, &all), (&words, &words), "{name}");
                    continue;
                }
                assert_eq!(some.len(), words.len() - 4, "{name}");
                let differing: Vec<_> = some.iter().zip(&all).filter(|(a, b)| a != b).collect();
                assert_eq!(differing, [(&5, &EVERYTHING)], "{name}");
                let default = [op(4, OP_SPEC_CONSTANT), EVERYTHING];
                assert!(words.windows(4).any(|w| [w[0], w[3]] == default), "{name}");
            }
        }
    }
}
