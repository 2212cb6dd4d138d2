//! How far the experiments go: the ranges of the thesis, and those beyond it that today's devices allow.
//!
//! The copies of the thesis at hand have lost its plots, so that ranges are those that its text names, and defaults are inferred:
//! figure 24 says that the smallest of the radii 0.5, 1, 1.5 and 2 takes more than four times the memory of the two largest "with small photon maps",
//! which a table of 8 bytes a cell and 10,000 photons of 32 bytes do in a box 27 radii wide. Our box is 2 m wide, so that the
//! radii are 37, 74, 111 and 148 mm.

use crate::case::{Case, Map, What};

/// Photons up to which the thesis went (figures 12 to 18).
pub const MOST_PHOTONS: u32 = 500_000;
/// Neighbours up to which it went (figures 20 and 21).
pub const MOST_K: u32 = 50;
/// Its largest radius (figures 22 to 24), mm.
pub const MOST_RADIUS: u32 = 148;
/// Its largest picture (figures 25 to 27), pixels.
pub const MOST_QUERIES: u32 = 1280 * 1024;

/// The ranges.
#[derive(Clone, Copy, Debug)]
pub struct Scope {
    /// Whether they are cut short, to take less than three minutes on two cores.
    pub quick: bool,
    /// Whether most is measured on a GPU.
    pub gpu: bool,
}

impl Scope {
    /// Numbers of photons.
    #[must_use]
    pub fn photons(&self) -> &'static [u32] {
        if self.quick {
            &[10_000, 50_000, 200_000]
        } else {
            &[10_000, 50_000, 100_000, 200_000, 300_000, 400_000, 500_000, 1_000_000, 3_000_000, 10_000_000]
        }
    }

    /// Neighbours a query.
    #[must_use]
    pub fn ks(&self) -> &'static [u32] {
        if self.quick { &[10, 20, 30, 40, 50] } else { &[10, 20, 30, 40, 50, 100, 200, 500] }
    }

    /// Query radii, mm.
    #[must_use]
    pub fn radii(&self) -> &'static [u32] {
        if self.quick { &[37, 74, 148] } else { &[37, 74, 111, 148, 296] }
    }

    /// Sizes of pictures whose pixels ask.
    #[must_use]
    pub fn sizes(&self) -> &'static [[u32; 2]] {
        if self.quick {
            &[[80, 60], [160, 120], [320, 240]]
        } else {
            &[[320, 240], [512, 384], [640, 480], [800, 600], [1024, 768], [1280, 1024], [3840, 2160]]
        }
    }

    /// What stays as it is while something else varies.
    #[must_use]
    pub fn base(&self, map: Map) -> Case {
        Case {
            what: What::Speed,
            subject: String::new(),
            map,
            photons: if self.quick { 50_000 } else { 100_000 },
            k: 50,
            radius_mm: 74,
            size: if self.quick { [160, 120] } else { [640, 480] },
        }
    }
}
