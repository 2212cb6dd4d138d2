//! Where the power of photon paths goes.

use super::vector::dot;
use crate::exec::{Input, Store};
use crate::num::{div, is_finite};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Paths that one invocation of [`sum_ledger`] adds up.
pub const LEDGER_PATHS: u32 = 64;

/// What became of a path's power, W, for each of red, green and blue.
///
/// What a surface or medium absorbs is its expectation, 1 less the share that goes on; Russian roulette, which decides whether the path
/// goes on, takes nothing and gives nothing on average. So emitted = absorbed + escaped + landed + lost holds for many paths
/// and not for each: it fails if roulette, a lobe's chance or a weight is wrong.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Tally {
    /// Emitted by the light.
    pub emitted: [f32; 3],
    /// Taken by surfaces and media.
    pub absorbed: [f32; 3],
    /// Gone where nothing is.
    pub escaped: [f32; 3],
    /// On the diffuse surfaces where paths of the caustic map end.
    pub landed: [f32; 3],
    /// On paths that were given up.
    pub lost: [f32; 3],
}

impl Tally {
    /// Of no path.
    #[inline]
    #[must_use]
    pub fn nothing() -> Self {
        Self { emitted: [0.0; 3], absorbed: [0.0; 3], escaped: [0.0; 3], landed: [0.0; 3], lost: [0.0; 3] }
    }
}

/// Paths of one light that are added up together.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LedgerBlock {
    /// The first path, counted in its dispatch.
    pub first: u32,
    /// How many there are, at most [`LEDGER_PATHS`].
    pub paths: u32,
}

/// Parameters of [`sum_ledger`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LedgerPass {
    /// Blocks to add up.
    pub blocks: u32,
}

/// The sum of some paths.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LedgerSum {
    /// Sums of power, W.
    pub power: Tally,
    /// Sum over paths of (emitted − absorbed − escaped − landed − lost) / emitted, of the mean of the colours. Its expectation is 0.
    pub imbalance: f32,
    /// Sum of the squares of that.
    pub imbalance2: f32,
    /// Paths that emitted something.
    pub paths: u32,
    /// Paths of which a number is not finite; they are not in the sums.
    pub not_finite: u32,
}

const _: () = {
    assert!(size_of::<Tally>() == 60);
    assert!(size_of::<LedgerBlock>() == 8);
    assert!(size_of::<LedgerSum>() == 76);
};

/// Adds up the `i`-th block of paths in their order. Plain sums: 64 terms that are not negative are off by less than 64·2⁻²⁴ of
/// themselves, a hundredth of what the paths' randomness makes of a million.
#[inline]
pub fn sum_ledger<S: Store<LedgerSum> + ?Sized>(
    i: u32,
    pass: &LedgerPass,
    blocks: &Input<LedgerBlock>,
    tallies: &Input<Tally>,
    sums: &mut S,
) {
    if i >= pass.blocks {
        return;
    }
    let block = blocks[i as usize];
    let mut emitted = Vec3::ZERO;
    let mut absorbed = Vec3::ZERO;
    let mut escaped = Vec3::ZERO;
    let mut landed = Vec3::ZERO;
    let mut lost = Vec3::ZERO;
    let mut imbalance = 0.0;
    let mut imbalance2 = 0.0;
    let mut paths = 0;
    let mut not_finite = 0;
    let mut at = block.first;
    while at < block.first + block.paths {
        let tally = tallies[at as usize];
        let sent = Vec3::from_array(tally.emitted);
        let kept = Vec3::from_array(tally.absorbed);
        let gone = Vec3::from_array(tally.escaped);
        let came = Vec3::from_array(tally.landed);
        let missed = Vec3::from_array(tally.lost);
        let all = dot(sent, Vec3::ONE);
        let off = dot((((sent - kept) - gone) - came) - missed, Vec3::ONE);
        if !is_finite(all) || !is_finite(off) {
            not_finite += 1;
        } else if all > 0.0 {
            let relative = div(off, all);
            imbalance += relative;
            imbalance2 += relative * relative;
            paths += 1;
            emitted += sent;
            absorbed += kept;
            escaped += gone;
            landed += came;
            lost += missed;
        }
        at += 1;
    }
    let power = Tally {
        emitted: emitted.to_array(),
        absorbed: absorbed.to_array(),
        escaped: escaped.to_array(),
        landed: landed.to_array(),
        lost: lost.to_array(),
    };
    sums.set(i, LedgerSum { power, imbalance, imbalance2, paths, not_finite });
}
