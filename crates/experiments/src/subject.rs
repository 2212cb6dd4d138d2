//! Whom the experiments compare.

use caustic_photon_map::{Gather, Hash};
use caustic_rivals::{BruteSort, Cells, KdSearch, Technique};

/// Entries of Teschner's table in the thesis. Section 4.3 says "2" and an exponent that the copies of the thesis at hand have lost; a table of
/// 2¹⁶ entries shows the collisions "larger than 200,000" photons of section 5.3.1.
const TABLE: u32 = 1 << 16;
/// The larger table that section 5.3.1 recommends.
const LARGE_TABLE: u32 = 1 << 20;

/// A technique under a name.
#[derive(Clone, Copy, Debug)]
pub struct Subject {
    /// Name in results.
    pub name: &'static str,
    /// Name for people.
    pub label: &'static str,
    /// What it is.
    pub technique: Technique,
    /// Whether it is measured on the CPU, whatever the device.
    pub on_cpu: bool,
}

const fn subject(name: &'static str, label: &'static str, technique: Technique) -> Subject {
    Subject { name, label, technique, on_cpu: false }
}

const fn teschner(table: u32, gather: Gather) -> Technique {
    Technique::Hash { hash: Hash::Teschner, table: Some(table), cells: Cells::CentreFirst, gather }
}

/// Brute force with insertion sort.
pub const BRUTE: &str = "brute";
/// Brute force with comb sort.
pub const BRUTE_COMB: &str = "brute-comb";
/// The kd-tree of Zhou et al., searched by ranges of radii.
pub const KD: &str = "kd";
/// The same tree with a heap of the nearest.
pub const KD_NEAREST: &str = "kd-nearest";
/// Jensen's kd-tree, on the CPU.
pub const JENSEN: &str = "jensen";
/// A lane a cell.
pub const CELLS: &str = "cells";
/// Spatial hashing with linear cell numbers, as in the thesis.
pub const LINEAR: &str = "linear";
/// The same with Teschner's hash.
pub const TESCHNER: &str = "teschner";
/// With the larger table.
pub const TESCHNER_LARGE: &str = "teschner-large";
/// Linear, with a heap.
pub const LINEAR_HEAP: &str = "linear-heap";
/// Teschner's, with a heap.
pub const TESCHNER_HEAP: &str = "teschner-heap";
/// Linear, visiting cells in the order of their offsets.
pub const LINEAR_IN_ORDER: &str = "linear-in-order";
/// Teschner's, likewise.
pub const TESCHNER_IN_ORDER: &str = "teschner-in-order";
/// caustic's own.
pub const CAUSTIC: &str = "caustic";
/// caustic's own with Teschner's hash.
pub const CAUSTIC_TESCHNER: &str = "caustic-teschner";
/// caustic's own with the Z-order curve.
pub const CAUSTIC_MORTON: &str = "caustic-morton";

/// All of them. The first ten have colours of their own in plots.
pub const SUBJECTS: &[Subject] = &[
    subject(KD, "kd-tree (Zhou et al.)", Technique::KdTree { search: KdSearch::Range }),
    subject(LINEAR, "linear hash, list (thesis)", Technique::hash(Hash::Linear, Cells::CentreFirst, Gather::List)),
    subject(TESCHNER, "Teschner hash, list (thesis)", teschner(TABLE, Gather::List)),
    subject(CAUSTIC, "caustic", Technique::hash(Hash::Linear, Cells::Crowding, Gather::Auto)),
    Subject { name: JENSEN, label: "kd-tree on the CPU (Jensen)", technique: Technique::Jensen, on_cpu: true },
    subject(KD_NEAREST, "kd-tree, with a heap", Technique::KdTree { search: KdSearch::Nearest }),
    subject(TESCHNER_LARGE, "Teschner hash of 2²⁰, list", teschner(LARGE_TABLE, Gather::List)),
    subject(LINEAR_HEAP, "linear hash, heap", Technique::hash(Hash::Linear, Cells::CentreFirst, Gather::Heap)),
    subject(BRUTE, "brute force, insertion sort", Technique::Brute { sort: BruteSort::Insertion }),
    subject(CAUSTIC_MORTON, "caustic, Morton hash", Technique::hash(Hash::Morton, Cells::Crowding, Gather::Auto)),
    subject(TESCHNER_HEAP, "Teschner hash, heap", teschner(TABLE, Gather::Heap)),
    subject(
        LINEAR_IN_ORDER,
        "linear hash, list, cells in order",
        Technique::hash(Hash::Linear, Cells::InOrder, Gather::List),
    ),
    subject(
        TESCHNER_IN_ORDER,
        "Teschner hash, list, cells in order",
        Technique::Hash { hash: Hash::Teschner, table: Some(TABLE), cells: Cells::InOrder, gather: Gather::List },
    ),
    subject(BRUTE_COMB, "brute force, comb sort", Technique::Brute { sort: BruteSort::Comb }),
    subject(CAUSTIC_TESCHNER, "caustic, Teschner hash", Technique::hash(Hash::Teschner, Cells::Crowding, Gather::Auto)),
    subject(CELLS, "linear hash, a lane a cell", Technique::Cells { hash: Hash::Linear }),
];

/// The subject of a name.
#[must_use]
pub fn named(name: &str) -> Option<&'static Subject> {
    SUBJECTS.iter().find(|subject| subject.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_of_one_each() {
        for subject in SUBJECTS {
            let twins = SUBJECTS.iter().filter(|other| other.name == subject.name || other.label == subject.label);
            assert_eq!(twins.count(), 1, "{}", subject.name);
        }
    }
}
