//! Sums of passes: the nodes of the tree in which a picture is added up.

use caustic_kernels::trace::{LayerPixel, Pixel};
use rayon::prelude::*;
use std::ops::AddAssign;

/// Words of a [`LayerPixel`].
pub(crate) const LAYER_WORDS: usize = size_of::<LayerPixel>() / size_of::<f32>();

/// What some pixels of one pass came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Film {
    /// Radiance, W·sr⁻¹·m⁻².
    pub(crate) rgb: Vec<[f32; 3]>,
    /// The words of a [`LayerPixel`] each; empty if there are none.
    pub(crate) layers: Vec<[f32; LAYER_WORDS]>,
}

/// Sums over two passes or more.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sums {
    /// Of radiance, W·sr⁻¹·m⁻².
    pub(crate) rgb: Vec<[f64; 3]>,
    /// Of its squares.
    pub(crate) squares: Vec<[f64; 3]>,
    /// Of the words of layers; empty if there are none.
    pub(crate) layers: Vec<[f64; LAYER_WORDS]>,
}

/// What counts are kept of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Counts {
    /// Photons emitted for all maps.
    pub(crate) photons: u64,
    /// Rays of camera paths and towards lights.
    pub(crate) rays: u64,
    /// Camera paths that were given up.
    pub(crate) lost: u64,
    /// Camera samples that were not finite.
    pub(crate) not_finite: u64,
}

impl Counts {
    pub(crate) fn of(film: &[Pixel], photons: u64) -> Self {
        let count = |of: fn(&Pixel) -> u32| film.iter().map(|pixel| u64::from(of(pixel))).sum();
        Self {
            photons,
            rays: count(|pixel| pixel.rays),
            lost: count(|pixel| pixel.lost),
            not_finite: count(|pixel| pixel.not_finite),
        }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.photons += other.photons;
        self.rays += other.rays;
        self.lost += other.lost;
        self.not_finite += other.not_finite;
    }
}

/// A node's numbers: of a pass as it is, or sums.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Values {
    Pass(Film),
    Sums(Sums),
}

impl Film {
    pub(crate) fn new(film: &[Pixel], layers: &[LayerPixel]) -> Self {
        Self {
            rgb: film.iter().map(|pixel| pixel.rgb).collect(),
            layers: layers.iter().map(|pixel| bytemuck::cast(*pixel)).collect(),
        }
    }

    /// Appends the film of the pixels that follow.
    pub(crate) fn append(&mut self, mut next: Self) {
        self.rgb.append(&mut next.rgb);
        self.layers.append(&mut next.layers);
    }
}

fn square(value: [f64; 3]) -> [f64; 3] {
    value.map(|value| value * value)
}

pub(crate) fn plus<const N: usize>(left: [f64; N], right: [f64; N]) -> [f64; N] {
    std::array::from_fn(|i| left[i] + right[i])
}

impl Values {
    pub(crate) fn rgb(&self, pixel: usize) -> [f64; 3] {
        match self {
            Self::Pass(film) => film.rgb[pixel].map(f64::from),
            Self::Sums(sums) => sums.rgb[pixel],
        }
    }

    pub(crate) fn squares(&self, pixel: usize) -> [f64; 3] {
        match self {
            Self::Pass(film) => square(film.rgb[pixel].map(f64::from)),
            Self::Sums(sums) => sums.squares[pixel],
        }
    }

    pub(crate) fn layers(&self, pixel: usize) -> [f64; LAYER_WORDS] {
        match self {
            Self::Pass(film) => film.layers[pixel].map(f64::from),
            Self::Sums(sums) => sums.layers[pixel],
        }
    }

    /// The parent of two siblings: left + right, whichever came first.
    pub(crate) fn parent(left: Self, right: &Self) -> Self {
        let mut sums = left.into_sums();
        sums.rgb.par_iter_mut().enumerate().for_each(|(i, sum)| *sum = plus(*sum, right.rgb(i)));
        sums.squares.par_iter_mut().enumerate().for_each(|(i, sum)| *sum = plus(*sum, right.squares(i)));
        sums.layers.par_iter_mut().enumerate().for_each(|(i, sum)| *sum = plus(*sum, right.layers(i)));
        Self::Sums(sums)
    }

    fn into_sums(self) -> Sums {
        let film = match self {
            Self::Sums(sums) => return sums,
            Self::Pass(film) => film,
        };
        Sums {
            rgb: film.rgb.par_iter().map(|rgb| rgb.map(f64::from)).collect(),
            squares: film.rgb.par_iter().map(|rgb| square(rgb.map(f64::from))).collect(),
            layers: film.layers.par_iter().map(|words| words.map(f64::from)).collect(),
        }
    }
}
