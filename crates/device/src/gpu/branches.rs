//! Removes from a SPIR-V module the blocks that its constants rule out, so that a driver does not read code which never runs.
//!
//! Drivers find the same, but only after they have read everything: of a kernel that knows nothing that is nine tenths. What a block computes is followed as
//! far as masks are tested (Wegman and Zadeck, "Constant Propagation with Conditional Branches", ACM TOPLAS 1991), and no arithmetic is touched.

use std::collections::{HashMap, HashSet};

/// Words before the first instruction.
const HEADER: usize = 5;
const OP_CONSTANT_TRUE: u32 = 41;
const OP_CONSTANT_FALSE: u32 = 42;
const OP_CONSTANT: u32 = 43;
const OP_FUNCTION: u32 = 54;
const OP_FUNCTION_END: u32 = 56;
const OP_DECORATE: u32 = 71;
/// From `OpFNegate` to `OpDot`: arithmetic, whose results are decorated.
const ARITHMETIC: std::ops::RangeInclusive<u32> = 126..=148;
const OP_LOGICAL_OR: u32 = 166;
const OP_LOGICAL_AND: u32 = 167;
const OP_LOGICAL_NOT: u32 = 168;
const OP_EQUAL: u32 = 170;
const OP_NOT_EQUAL: u32 = 171;
const OP_BITWISE_AND: u32 = 199;
const OP_PHI: u32 = 245;
const OP_LOOP_MERGE: u32 = 246;
const OP_SELECTION_MERGE: u32 = 247;
const OP_LABEL: u32 = 248;
const OP_BRANCH: u32 = 249;
const OP_BRANCH_CONDITIONAL: u32 = 250;
const OP_SWITCH: u32 = 251;
const OP_UNREACHABLE: u32 = 255;

fn opcode(instruction: &[u32]) -> u32 {
    instruction[0] & 0xffff
}

/// The module without blocks that no run reaches; as it is, if it is not understood.
pub(super) fn without_unreachable(words: Vec<u32>) -> Vec<u32> {
    pruned(&words).unwrap_or(words)
}

fn pruned(words: &[u32]) -> Option<Vec<u32>> {
    let instructions = split(words.get(HEADER..)?)?;
    let body = instructions.iter().position(|i| opcode(i) == OP_LABEL)?;
    let flow = Flow::of(&instructions);
    let mut removed = HashSet::new();
    let mut code = Vec::new();
    for block in instructions[body..].chunk_by(|_, next| opcode(next) != OP_LABEL) {
        if flow.reached.contains(&block[0][1]) {
            flow.emit(block, &mut code);
            continue;
        }
        removed.extend(block.iter().filter(|i| ARITHMETIC.contains(&opcode(i))).map(|i| i[2]));
        // A construct that stays names its merge block, reached or not. A loop that never turns again is left to the driver.
        if flow.continues.contains(&block[0][1]) {
            return None;
        }
        if flow.merges.contains(&block[0][1]) {
            code.extend_from_slice(block[0]);
            code.push((1 << 16) | OP_UNREACHABLE);
        }
        // The function's end, and the next one's head, stand after its last block.
        let end = block.iter().position(|i| opcode(i) == OP_FUNCTION_END).unwrap_or(block.len());
        block[end..].iter().for_each(|i| code.extend_from_slice(i));
    }
    let mut out = words[..HEADER].to_vec();
    let stays = |i: &&&[u32]| opcode(i) != OP_DECORATE || !removed.contains(&i[1]);
    instructions[..body].iter().filter(stays).for_each(|i| out.extend_from_slice(i));
    out.append(&mut code);
    Some(out)
}

fn split(mut rest: &[u32]) -> Option<Vec<&[u32]>> {
    let mut instructions = Vec::new();
    while let Some(first) = rest.first() {
        let (instruction, after) = rest.split_at_checked((first >> 16) as usize).filter(|(i, _)| !i.is_empty())?;
        instructions.push(instruction);
        rest = after;
    }
    Some(instructions)
}

/// Which way control can go.
#[derive(Default)]
struct Flow {
    /// What ids are, as far as it is known: `None` is anything.
    values: HashMap<u32, Option<u32>>,
    /// Blocks that can be reached.
    reached: HashSet<u32>,
    /// Ways from block to block that can be taken.
    edges: HashSet<(u32, u32)>,
    /// Merge blocks of reached constructs that stay.
    merges: HashSet<u32>,
    /// Blocks by which reached loops turn again.
    continues: HashSet<u32>,
}

impl Flow {
    /// Grows what can be reached and shrinks what is known, from nothing and everything, until they fit each other.
    fn of(instructions: &[&[u32]]) -> Self {
        let mut flow = Self::default();
        let mut before = (usize::MAX, 0);
        while before != (flow.edges.len(), flow.unknown()) {
            before = (flow.edges.len(), flow.unknown());
            let mut block = 0;
            let mut first = false;
            for instruction in instructions {
                match **instruction {
                    // A function's first block needs no way to it.
                    [head, ..] if head & 0xffff == OP_FUNCTION => first = true,
                    [head, label] if head & 0xffff == OP_LABEL => {
                        block = label;
                        if std::mem::take(&mut first) {
                            flow.reached.insert(label);
                        }
                    }
                    _ if block == 0 || flow.reached.contains(&block) => flow.step(block, instruction),
                    _ => {}
                }
            }
        }
        for block in instructions.chunk_by(|_, next| opcode(next) != OP_LABEL) {
            if flow.reached.contains(block[0].get(1).unwrap_or(&0)) {
                for (instruction, next) in block.iter().zip(&block[1..]) {
                    match (opcode(instruction), flow.only_target(next)) {
                        (OP_SELECTION_MERGE, None) => _ = flow.merges.insert(instruction[1]),
                        (OP_LOOP_MERGE, _) => {
                            flow.merges.insert(instruction[1]);
                            flow.continues.insert(instruction[2]);
                        }
                        _ => {}
                    }
                }
            }
        }
        flow
    }

    fn unknown(&self) -> usize {
        self.values.values().filter(|value| value.is_none()).count()
    }

    fn value(&self, id: u32) -> Option<u32> {
        self.values.get(&id).copied().flatten()
    }

    /// Where a conditional branch goes, if that is known.
    fn only_target(&self, branch: &[u32]) -> Option<u32> {
        match *branch {
            [head, condition, yes, no, ..] if head & 0xffff == OP_BRANCH_CONDITIONAL => {
                self.value(condition).map(|value| if value != 0 { yes } else { no })
            }
            _ => None,
        }
    }

    fn step(&mut self, block: u32, instruction: &[u32]) {
        let known = |this: &Self, at: usize| this.value(instruction[at]);
        let either = |a: Option<u32>, b: Option<u32>, value: u32| a == Some(value) || b == Some(value);
        let found = match opcode(instruction) {
            OP_CONSTANT_TRUE => Some(1),
            OP_CONSTANT_FALSE => Some(0),
            OP_CONSTANT if instruction.len() == 4 => Some(instruction[3]),
            OP_LOGICAL_NOT => known(self, 3).map(|value| 1 - value),
            op @ (OP_LOGICAL_OR | OP_LOGICAL_AND | OP_EQUAL | OP_NOT_EQUAL | OP_BITWISE_AND) => {
                let (a, b) = (known(self, 3), known(self, 4));
                match (op, a.zip(b)) {
                    (OP_EQUAL, both) => both.map(|(a, b)| u32::from(a == b)),
                    (OP_NOT_EQUAL, both) => both.map(|(a, b)| u32::from(a != b)),
                    (OP_LOGICAL_OR, None) if either(a, b, 1) => Some(1),
                    (OP_LOGICAL_OR, both) => both.map(|(a, b)| a | b),
                    (_, None) if either(a, b, 0) => Some(0),
                    (_, both) => both.map(|(a, b)| a & b),
                }
            }
            OP_PHI => {
                let taken = instruction[3..].chunks_exact(2).filter(|from| self.edges.contains(&(from[1], block)));
                let mut values = taken.map(|from| self.value(from[0]));
                values.next().flatten().filter(|&first| values.all(|value| value == Some(first)))
            }
            op => {
                match op {
                    OP_BRANCH => self.go(block, instruction[1]),
                    OP_BRANCH_CONDITIONAL => match self.only_target(instruction) {
                        Some(target) => self.go(block, target),
                        None => instruction[2..4].iter().for_each(|&target| self.go(block, target)),
                    },
                    OP_SWITCH => instruction[2..].iter().step_by(2).for_each(|&target| self.go(block, target)),
                    _ => {}
                }
                return;
            }
        };
        // What was anything stays so.
        self.values
            .entry(instruction[2])
            .and_modify(|value| *value = value.filter(|_| *value == found))
            .or_insert(found);
    }

    fn go(&mut self, from: u32, to: u32) {
        self.edges.insert((from, to));
        self.reached.insert(to);
    }

    /// Appends a block that is reached: a branch of which the way is known becomes a plain one, and phis forget ways that are not taken.
    fn emit(&self, block: &[&[u32]], code: &mut Vec<u32>) {
        let label = block[0][1];
        for (i, instruction) in block.iter().enumerate() {
            let known = |branch: &[u32]| self.only_target(branch).is_some();
            match opcode(instruction) {
                OP_SELECTION_MERGE if known(block[i + 1]) => {}
                OP_BRANCH_CONDITIONAL if known(instruction) => {
                    code.push((2 << 16) | OP_BRANCH);
                    code.extend(self.only_target(instruction));
                }
                OP_PHI => {
                    let head = code.len();
                    code.extend_from_slice(&instruction[..3]);
                    let ways = instruction[3..].chunks_exact(2);
                    ways.filter(|way| self.edges.contains(&(way[1], label)))
                        .for_each(|way| code.extend_from_slice(way));
                    code[head] = ((code.len() - head) as u32) << 16 | OP_PHI;
                }
                _ => code.extend_from_slice(instruction),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::specialise;
    use crate::{Kernel, Precision};
    use caustic_kernels::trace::EVERYTHING;

    const fn op(length: u32, opcode: u32) -> u32 {
        (length << 16) | opcode
    }

    /// `if constant & 4 != 0 { then } merge: phi`, with an addition in the block of the condition.
    fn module(constant: u32) -> Vec<u32> {
        [
            &[0x0723_0203, 0x0001_0500, 0, 40, 0][..],
            &[op(3, OP_DECORATE), 20, 42, op(3, OP_DECORATE), 21, 42],
            &[op(4, OP_CONSTANT), 1, 2, constant, op(4, OP_CONSTANT), 1, 3, 4, op(4, OP_CONSTANT), 1, 4, 0],
            &[op(5, OP_FUNCTION), 1, 5, 0, 6, op(2, OP_LABEL), 10],
            &[op(5, OP_BITWISE_AND), 1, 11, 2, 3, op(5, OP_NOT_EQUAL), 7, 12, 11, 4, op(5, 129), 8, 20, 9, 9],
            &[op(3, OP_SELECTION_MERGE), 15, 0, op(4, OP_BRANCH_CONDITIONAL), 12, 14, 15],
            &[op(2, OP_LABEL), 14, op(5, 129), 8, 21, 20, 20, op(2, OP_BRANCH), 15],
            &[op(2, OP_LABEL), 15, op(7, OP_PHI), 8, 22, 20, 10, 21, 14, op(1, 253), op(1, OP_FUNCTION_END)],
        ]
        .concat()
    }

    #[test]
    fn what_the_mask_rules_out_is_gone_and_what_it_does_not_stays() {
        let without = without_unreachable(module(3));
        let tail = [op(2, OP_BRANCH), 15, op(2, OP_LABEL), 15, op(5, OP_PHI), 8, 22, 20, 10, op(1, 253)];
        assert_eq!(without[without.len() - 11..without.len() - 1], tail);
        assert_eq!(
            without[5..9],
            [op(3, OP_DECORATE), 20, 42, op(4, OP_CONSTANT)],
            "nor is what it computed decorated"
        );
        let with = without_unreachable(module(7));
        assert_eq!(with.len(), module(7).len() - 3 - 2 - 2, "a merge, a shorter branch, a way of the phi");
        assert_eq!(without_unreachable(with.clone()), with);
        assert_eq!(without_unreachable(without.clone()), without);
        for broken in [vec![0; 3], vec![0; 6], module(3)[..21].to_vec()] {
            assert_eq!(without_unreachable(broken.clone()), broken);
        }
    }

    /// Of every tracing kernel with every mask something is removed, and the more the less it knows.
    #[test]
    fn kernels_that_know_less_are_smaller() {
        let names = ["count_photons", "store_photons", "trace_camera", "shade_direct", "trace_paths", "trace_gather"];
        for (name, precision) in names.into_iter().flat_map(|name| [(name, Precision::Exact), (name, Precision::Fast)])
        {
            let words = Kernel::named(name).unwrap().words(precision);
            let sizes: Vec<usize> = (0..=EVERYTHING)
                .map(|mask| pruned(&specialise::with(&words, mask)).expect("understood").len())
                .collect();
            for mask in 0..=EVERYTHING {
                for bit in (0..6).map(|i| 1 << i).filter(|bit| mask & bit != 0) {
                    assert!(sizes[(mask & !bit) as usize] <= sizes[mask as usize], "{name}: {mask} without {bit}");
                }
            }
            assert!(sizes[0] * 2 < sizes[EVERYTHING as usize] && sizes[0] * 2 < words.len(), "{name}: {sizes:?}");
        }
    }
}
