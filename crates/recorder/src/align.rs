//! Which accesses of a warp's lanes are one request.
//!
//! A GPU runs the lanes of a warp in lockstep. Lanes that part at a branch or leave a loop early meet again where it ends (the immediate
//! post-dominator; Fung et al., "Dynamic Warp Formation and Scheduling for Efficient GPU Control Flow", 2007), so that lanes
//! run an instruction together if they are in the same turn of every loop around it. A lane's accesses show its way through the
//! program: places in the source are the nodes of a graph, and what was accessed after what are its edges. Loops are the strongly
//! connected parts of that graph; without the edges into its first node, its header, such a part shows the loops inside it
//! (Ramalingam, "On Loops, Dominators, and Dominance Frontiers", 2002). A loop's turns are counted at its header from where it
//! was entered. A place, its buffer and the turns of the loops around it make the key by which lanes are matched.
//!
//! A loop in whose turns nothing is accessed but by a loop inside it is not told from that: their turns count on as one.

use caustic_kernels_recorded::sink::Access;
use std::collections::HashMap;
use std::panic::Location;

/// Aligns the lanes of warps.
#[derive(Default)]
pub(crate) struct Aligner {
    /// Numbers of places in the source, by their address: the compiler may have several of one place.
    known: HashMap<*const Location<'static>, u32>,
    places: HashMap<(&'static str, u32, u32), u32>,
    path: Vec<u32>,
    keys: Vec<(u64, u32)>,
}

impl Aligner {
    /// Calls `request` with what lanes access together, for all accesses of a warp: each lane's in their order, lane after lane.
    pub(crate) fn align(&mut self, warp: &[Access], mut request: impl FnMut(RequestOf<'_>)) {
        let mut path = std::mem::take(&mut self.path);
        path.clear();
        path.extend(warp.iter().map(|access| self.place(access.at)));
        let starts = |i: usize| i == 0 || warp[i].lane != warp[i - 1].lane;
        let graph = Graph::of(&path, starts);
        let mut turns = vec![0; graph.headers.len()];
        let mut previous = None;
        self.keys.clear();
        for (i, (&place, access)) in path.iter().zip(warp).enumerate() {
            if starts(i) {
                previous = None;
            }
            let turns = graph.enter(&mut turns, previous, place);
            let key = turns.fold(mix(access.buffer as u64, place), mix);
            self.keys.push((key, i as u32));
            previous = Some(place);
        }
        self.path = path;
        self.keys.sort_unstable();
        for keys in self.keys.chunk_by(|a, b| a.0 == b.0) {
            request(RequestOf { warp, keys: keys.iter() });
        }
    }

    fn place(&mut self, at: &'static Location<'static>) -> u32 {
        *self.known.entry(at).or_insert_with(|| {
            let next = self.places.len() as u32;
            *self.places.entry((at.file(), at.line(), at.column())).or_insert(next)
        })
    }
}

/// The accesses of one request.
pub(crate) struct RequestOf<'a> {
    warp: &'a [Access],
    keys: std::slice::Iter<'a, (u64, u32)>,
}

impl Iterator for RequestOf<'_> {
    type Item = Access;

    fn next(&mut self) -> Option<Access> {
        self.keys.next().map(|&(_, i)| self.warp[i as usize])
    }
}

/// One more number in a hash, by the finaliser of SplitMix64.
fn mix(hash: u64, number: u32) -> u64 {
    let mut x = hash ^ u64::from(number).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The loops in which the places of a warp are.
struct Graph {
    /// The loops around each place, outermost first.
    around: Vec<Vec<usize>>,
    /// The header of each loop.
    headers: Vec<u32>,
}

impl Graph {
    /// Of the places that lanes went along; a lane begins at `i` if `starts(i)`.
    fn of(path: &[u32], starts: impl Fn(usize) -> bool) -> Self {
        let nodes = path.iter().max().map_or(0, |&place| place as usize + 1);
        let mut finder = Finder {
            edges: vec![vec![false; nodes]; nodes],
            entered: vec![false; nodes],
            visits: vec![0; nodes],
            found: Self { around: vec![Vec::new(); nodes], headers: Vec::new() },
        };
        for (i, &place) in path.iter().enumerate() {
            finder.visits[place as usize] += 1;
            if starts(i) {
                finder.entered[place as usize] = true;
            } else {
                finder.edges[path[i - 1] as usize][place as usize] = true;
            }
        }
        let visited: Vec<_> = (0..nodes).filter(|&node| finder.visits[node] > 0).collect();
        finder.loops_among(&visited);
        finder.found
    }

    /// Goes from the place `previous` to `place`; returns the turns of the loops around it.
    fn enter(&self, turns: &mut [u32], previous: Option<u32>, place: u32) -> impl Iterator<Item = u32> {
        let around = &self.around[place as usize];
        let before = previous.map_or(&[][..], |previous| &self.around[previous as usize]);
        for (depth, &inside) in around.iter().enumerate() {
            if before.get(depth) != Some(&inside) {
                turns[inside] = 0;
            }
            if self.headers[inside] == place {
                turns[inside] += 1;
            }
        }
        around.iter().map(|&inside| turns[inside])
    }
}

/// Finds loops.
struct Finder {
    /// From where to where lanes went, without the edges into headers of loops that were found.
    edges: Vec<Vec<bool>>,
    /// Where lanes began.
    entered: Vec<bool>,
    visits: Vec<u32>,
    found: Graph,
}

impl Finder {
    /// Finds the loops in a part of the graph, outer ones before those inside them.
    fn loops_among(&mut self, part: &[usize]) {
        let reached: Vec<Vec<bool>> = part.iter().map(|&node| self.reached_from(node, part)).collect();
        let mut done = vec![false; self.edges.len()];
        for (i, &node) in part.iter().enumerate() {
            if done[node] || !reached[i][node] {
                continue;
            }
            let both = |(j, &other): (usize, &usize)| (reached[i][other] && reached[j][node]).then_some(other);
            let members: Vec<usize> = part.iter().enumerate().filter_map(both).collect();
            let header = self.header(&members);
            for &member in &members {
                done[member] = true;
                self.edges[member][header] = false;
                self.found.around[member].push(self.found.headers.len());
            }
            self.found.headers.push(header as u32);
            self.loops_among(&members);
        }
    }

    /// Nodes of a part that can be reached from `node` in one step or more.
    fn reached_from(&self, node: usize, part: &[usize]) -> Vec<bool> {
        let mut reached = vec![false; self.edges.len()];
        let mut left = vec![node];
        while let Some(from) = left.pop() {
            for &to in part {
                if self.edges[from][to] && !reached[to] {
                    reached[to] = true;
                    left.push(to);
                }
            }
        }
        reached
    }

    /// Where a loop is entered. Of several such places, because some turns leave some out, it is the one that is visited most.
    fn header(&self, members: &[usize]) -> usize {
        let from_outside = |node: usize| {
            self.entered[node] || (0..self.edges.len()).any(|from| !members.contains(&from) && self.edges[from][node])
        };
        let first = |&&node: &&usize| (from_outside(node), self.visits[node], std::cmp::Reverse(node));
        *members.iter().max_by_key(first).expect("a loop has members")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What lanes do together, as (place, lanes), in any order; lanes are letters a place.
    fn together(lanes: &[&str]) -> Vec<(char, Vec<u32>)> {
        let mut path = vec![];
        let mut lane_of = vec![];
        for (lane, places) in (0..).zip(lanes) {
            for place in places.bytes() {
                path.push(u32::from(place - b'a'));
                lane_of.push(lane);
            }
        }
        let starts = |i: usize| i == 0 || lane_of[i] != lane_of[i - 1];
        let graph = Graph::of(&path, starts);
        let mut turns = vec![0; graph.headers.len()];
        let mut groups: std::collections::BTreeMap<(u32, Vec<u32>), Vec<u32>> = Default::default();
        for i in 0..path.len() {
            let previous = (!starts(i)).then(|| path[i - 1]);
            let key: Vec<u32> = graph.enter(&mut turns, previous, path[i]).collect();
            groups.entry((path[i], key)).or_default().push(lane_of[i]);
        }
        groups.into_iter().map(|((place, _), lanes)| (char::from(b'a' + place as u8), lanes)).collect()
    }

    fn of(groups: &[(char, Vec<u32>)], place: char) -> Vec<&[u32]> {
        groups.iter().filter(|group| group.0 == place).map(|group| group.1.as_slice()).collect()
    }

    #[test]
    fn lanes_without_loops_meet_again_after_a_branch() {
        let groups = together(&["abd", "acd", "ad"]);
        assert_eq!(of(&groups, 'a'), [[0, 1, 2]]);
        assert_eq!(of(&groups, 'b'), [[0]]);
        assert_eq!(of(&groups, 'd'), [[0, 1, 2]]);
    }

    #[test]
    fn a_loop_goes_on_without_those_that_left_and_they_meet_again_behind_it() {
        let groups = together(&["abbbc", "abc", "ac"]);
        assert_eq!(of(&groups, 'b'), [&[0, 1][..], &[0], &[0]]);
        assert_eq!(of(&groups, 'c'), [[0, 1, 2]]);
    }

    #[test]
    fn lanes_that_leave_an_inner_loop_wait_for_the_others() {
        // Two turns of an outer loop: the lanes' inner loops have 3 + 1 and 1 + 2 turns.
        let groups = together(&["xabbbabz", "xababbz"]);
        assert_eq!(of(&groups, 'a'), [[0, 1], [0, 1]]);
        assert_eq!(of(&groups, 'b'), [&[0, 1][..], &[0], &[0], &[0, 1], &[1]]);
        assert_eq!(of(&groups, 'z'), [[0, 1]]);
    }

    #[test]
    fn an_inner_loop_that_is_left_out_starts_again_in_the_next_turn() {
        let groups = together(&["xaabbz", "xabbaz", "xaaaz"]);
        assert_eq!(of(&groups, 'a'), [&[0, 1, 2][..], &[0, 1, 2], &[2]]);
        // Those of lane 1 are in the first turn, those of lane 0 in the second.
        assert_eq!(of(&groups, 'b'), [[1], [1], [0], [0]]);
    }

    #[test]
    fn turns_that_leave_out_the_first_place_count() {
        // if … { p } q: four turns.
        let groups = together(&["apqqqpq", "aqqpqq"]);
        assert_eq!(of(&groups, 'q'), [[0, 1]; 4]);
        assert_eq!(of(&groups, 'p'), [[0], [1], [0]]);
    }

    #[test]
    fn three_loops_deep() {
        let groups = together(&["abccbccabc", "abcabccbc"]);
        assert_eq!(of(&groups, 'a'), [[0, 1], [0, 1]]);
        assert_eq!(of(&groups, 'b'), [&[0, 1][..], &[0], &[0, 1], &[1]]);
        assert_eq!(of(&groups, 'c'), [&[0, 1][..], &[0], &[0], &[0], &[0, 1], &[1], &[1]]);
    }
}
