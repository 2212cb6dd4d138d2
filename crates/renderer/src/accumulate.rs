//! Passes of a picture, added up in a tree that is the same whoever computed them.
//!
//! Passes 2n and 2n + 1 are added to a node, two such neighbours to the next, and so on: a node's bits depend on nothing but the passes below
//! it. What nodes there are depends on which passes there are, not on their order of arrival, and the picture is the sum of the nodes
//! that begin at pass 0 and leave no gap, from the last one, which is the smallest, to the first. So one process, parts of a farm and
//! several devices come to the same picture, and what is kept is one node for each bit that is set in the number of passes.

use crate::output::{Image, Layer, LayerKind};
use crate::sums::{Counts, Film, Values, plus};
use crate::work::{Split, WorkUnit};
use caustic_kernels::num::pcg4d;
use caustic_kernels::trace::{LayerPixel, Pixel};
use rayon::prelude::*;
use std::ops::Range;

/// Key with which the seeds of passes are drawn.
const PASS_KEY: u32 = 0x9a55_0000;

/// What a unit of work came to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) unit: WorkUnit,
    pub(crate) counts: Counts,
    pub(crate) film: Film,
}

impl Piece {
    /// The pixels that a device developed. Photons count for the unit that the pass begins with.
    pub(crate) fn new(unit: WorkUnit, film: &[Pixel], layers: &[LayerPixel], photons: u64) -> Self {
        let photons = if unit.first_pixel == 0 { photons } else { 0 };
        Self { unit, counts: Counts::of(film, photons), film: Film::new(film, layers) }
    }
}

/// Passes `first` to `first + 2^level − 1`, added up; `first` is a multiple of 2^level.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) first: u32,
    pub(crate) level: u32,
    pub(crate) values: Values,
}

impl Node {
    fn end(&self) -> u32 {
        self.first + (1 << self.level)
    }
}

/// Units that are done.
#[derive(Clone, Debug, Default)]
pub(crate) struct Done {
    passes: Vec<Range<u32>>,
    units: Vec<WorkUnit>,
}

impl Done {
    pub(crate) fn has(&self, unit: &WorkUnit) -> bool {
        self.passes.iter().any(|passes| passes.contains(&unit.pass)) || self.units.contains(unit)
    }
}

/// What the units of a render have come to so far, whichever they are and in whatever order they came: all that a render needs to go
/// on, that a part of a render has to say, and that parts are merged from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProgressState {
    /// Pixels in a row and in a column.
    pub(crate) size: [u32; 2],
    /// Radius of the first pass, m.
    pub(crate) first_radius: f32,
    /// Whether pixels have layers.
    pub(crate) has_layers: bool,
    /// Of the passes that are whole.
    pub(crate) counts: Counts,
    /// Passes that are whole, in their order.
    pub(crate) nodes: Vec<Node>,
    /// Of passes that are not whole, in the order of units.
    pub(crate) pieces: Vec<Piece>,
}

impl ProgressState {
    /// No pass yet, of a picture with or without layers.
    #[must_use]
    pub fn new(size: [u32; 2], first_radius: f32, has_layers: bool) -> Self {
        Self { size, first_radius, has_layers, ..Self::default() }
    }

    fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// The nodes from pass 0 on that leave no gap.
    fn prefix(&self) -> &[Node] {
        let mut end = 0;
        let count = self.nodes.iter().take_while(|node| {
            let follows = node.first == end;
            end = node.end();
            follows
        });
        &self.nodes[..count.count()]
    }

    /// Passes from the first one on that are whole: those of the picture.
    #[must_use]
    pub fn passes(&self) -> u32 {
        self.prefix().last().map_or(0, Node::end)
    }

    /// Whether there is nothing to show or to keep.
    pub(crate) fn is_empty(&self) -> bool {
        self.nodes.is_empty() && self.pieces.is_empty()
    }

    /// Photons emitted for all maps of all whole passes.
    #[must_use]
    pub fn photons(&self) -> u64 {
        self.counts.photons
    }

    /// Which units are done.
    pub(crate) fn done(&self) -> Done {
        let passes = self.nodes.iter().map(|node| node.first..node.end()).collect();
        Done { passes, units: self.pieces.iter().map(|piece| piece.unit).collect() }
    }

    /// Forgets pieces of passes that are not units of this split.
    pub(crate) fn keep_units(&mut self, split: &Split) {
        self.pieces.retain(|piece| split.has(&piece.unit));
    }

    /// Adds a unit, which must not be there yet.
    pub(crate) fn add(&mut self, piece: Piece) {
        let pass = piece.unit.pass;
        let at = self.pieces.partition_point(|other| other.unit < piece.unit);
        self.pieces.insert(at, piece);
        let of_pass = self.pieces.partition_point(|other| other.unit.pass < pass)
            ..self.pieces.partition_point(|other| other.unit.pass <= pass);
        let pixels: usize = self.pieces[of_pass.clone()].iter().map(|piece| piece.unit.pixels as usize).sum();
        if pixels == self.pixels() {
            let mut film = Film::default();
            for piece in self.pieces.drain(of_pass) {
                self.counts += piece.counts;
                film.append(piece.film);
            }
            self.place(Node { first: pass, level: 0, values: Values::Pass(film) });
        }
    }

    /// Puts a node where it belongs; siblings become their parent.
    fn place(&mut self, mut node: Node) {
        let sibling = |node: &Node| node.first ^ (1 << node.level);
        while let Some(at) = self.nodes.iter().position(|o| o.first == sibling(&node) && o.level == node.level) {
            let other = self.nodes.remove(at);
            let (left, right) = if node.first < other.first { (node, other) } else { (other, node) };
            let values = Values::parent(left.values, &right.values);
            node = Node { first: left.first, level: left.level + 1, values };
        }
        let at = self.nodes.partition_point(|other| other.first < node.first);
        self.nodes.insert(at, node);
    }

    /// The first unit that two states both hold.
    fn overlap(&self, other: &Self) -> Option<WorkUnit> {
        let pixels = self.pixels() as u32;
        let spans = |state: &Self| -> Vec<(u32, u32, u32, u32)> {
            let nodes = state.nodes.iter().map(|node| (node.first, node.end(), 0, pixels));
            let pieces =
                state.pieces.iter().map(|Piece { unit, .. }| (unit.pass, unit.pass + 1, unit.first_pixel, unit.end()));
            nodes.chain(pieces).collect()
        };
        let theirs = spans(other);
        spans(self).into_iter().find_map(|(pass, end, pixel, last)| {
            let meets = |&&(a, b, c, d): &&(u32, u32, u32, u32)| pass < b && a < end && pixel < d && c < last;
            let &(first, _, first_pixel, end) = theirs.iter().find(meets)?;
            let (pass, first_pixel) = (pass.max(first), pixel.max(first_pixel));
            Some(WorkUnit { pass, first_pixel, pixels: last.min(end) - first_pixel })
        })
    }

    /// One pass of a picture without layers, from its pixels.
    ///
    /// # Panics
    /// If there are not as many pixels as the size says.
    #[must_use]
    pub fn of_pass(size: [u32; 2], first_radius: f32, pass: u32, film: &[Pixel]) -> Self {
        let mut state = Self::new(size, first_radius, false);
        assert_eq!(film.len(), state.pixels(), "the pixels of the pass");
        state.add(Piece::new(WorkUnit { pass, first_pixel: 0, pixels: film.len() as u32 }, film, &[], 0));
        state
    }

    /// Adds all units of another state of the same picture.
    ///
    /// # Errors
    /// The first unit that both have. Nothing is added then.
    ///
    /// # Panics
    /// If the pictures differ in size or in whether they have layers.
    pub fn absorb(&mut self, other: Self) -> Result<(), WorkUnit> {
        assert_eq!((self.size, self.has_layers), (other.size, other.has_layers), "states of one picture");
        if let Some(unit) = self.overlap(&other) {
            return Err(unit);
        }
        self.counts += other.counts;
        other.nodes.into_iter().for_each(|node| self.place(node));
        other.pieces.into_iter().for_each(|piece| self.add(piece));
        Ok(())
    }

    /// What of so many passes is not there, in words; nothing if all is.
    pub(crate) fn missing(&self, passes: u32) -> Vec<String> {
        let mut missing = Vec::new();
        let mut gap = |from: u32, to: u32| match to - from {
            0 => {}
            1 => missing.push(format!("pass {from}")),
            _ => missing.push(format!("passes {from} to {}", to - 1)),
        };
        let mut next = 0;
        let whole = self.nodes.iter().map(|node| (node.first, node.end()));
        let mut begun: Vec<_> = self.pieces.iter().map(|piece| (piece.unit.pass, piece.unit.pass + 1)).collect();
        begun.dedup();
        let mut spans: Vec<_> = whole.chain(begun.iter().copied()).collect();
        spans.sort_unstable();
        for (first, end) in spans {
            gap(next, first.min(passes).max(next));
            next = end;
        }
        gap(next, passes.max(next));
        for (pass, _) in begun {
            let mut next = 0;
            let of_pass = self.pieces.iter().map(|piece| piece.unit).filter(|unit| unit.pass == pass);
            for (first, end) in of_pass.map(|u| (u.first_pixel, u.end())).chain([(self.pixels() as u32, 0)]) {
                if first > next {
                    missing.push(format!("pixels {next} to {} of pass {pass}", first - 1));
                }
                next = end;
            }
        }
        missing
    }

    /// Sums of a number of a pixel over the passes of the picture.
    fn total<const N: usize>(&self, of: impl Fn(&Values) -> [f64; N]) -> [f64; N] {
        let mut nodes = self.prefix().iter().rev();
        let Some(last) = nodes.next() else { return [0.0; N] };
        nodes.fold(of(&last.values), |sum, node| plus(of(&node.values), sum))
    }

    fn each_pixel<T: Send>(&self, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
        (0..self.pixels()).into_par_iter().map(of).collect()
    }

    /// The picture so far: the mean of the passes. Before the first one is whole, what there is of it.
    #[must_use]
    pub fn image(&self) -> Image {
        let n = f64::from(self.passes().max(1));
        let mut rgb = self.each_pixel(|i| self.total(|values| values.rgb(i)).map(|value| (value / n) as f32));
        for piece in self.first_pieces() {
            rgb[piece.unit.first_pixel as usize..piece.unit.end() as usize].copy_from_slice(&piece.film.rgb);
        }
        Image { width: self.size[0], height: self.size[1], rgb }
    }

    /// The layers so far: the mean of the passes.
    #[must_use]
    pub(crate) fn layer_pixels(&self) -> Vec<LayerPixel> {
        if !self.has_layers {
            return Vec::new();
        }
        let n = f64::from(self.passes().max(1));
        let mut layers = self.each_pixel(|i| self.total(|values| values.layers(i)).map(|value| (value / n) as f32));
        for piece in self.first_pieces() {
            layers[piece.unit.first_pixel as usize..piece.unit.end() as usize].copy_from_slice(&piece.film.layers);
        }
        layers.into_par_iter().map(bytemuck::cast).collect()
    }

    /// These layers so far.
    pub(crate) fn layers(&self, kinds: &[LayerKind]) -> Vec<Layer> {
        let pixels = self.layer_pixels();
        let layer = |&kind: &LayerKind| match kind {
            LayerKind::Variance => Layer { kind, values: self.variance_layer() },
            _ => Layer::of(kind, &pixels),
        };
        kinds.iter().map(layer).collect()
    }

    /// Counts of all units, also of passes that are not whole.
    pub(crate) fn all_counts(&self) -> Counts {
        self.pieces.iter().fold(self.counts, |mut sum, piece| {
            sum += piece.counts;
            sum
        })
    }

    /// Pieces of the first pass, as long as there are no others to show.
    fn first_pieces(&self) -> impl Iterator<Item = &Piece> {
        let shown = self.passes() == 0;
        self.pieces.iter().filter(move |piece| shown && piece.unit.pass == 0)
    }

    /// Variance of the picture: s²/n of each value, s² being the variance of the passes; nothing before the second pass. Progressive
    /// passes have shrinking radii, so that their scatter is a little more than noise.
    #[must_use]
    pub fn variance(&self) -> Option<Vec<[f64; 3]>> {
        if self.passes() < 2 {
            return None;
        }
        let n = f64::from(self.passes());
        let variance = |sum: f64, squares: f64| ((squares - sum * sum / n) / (n - 1.0) / n).max(0.0);
        Some(self.each_pixel(|i| {
            let (sum, squares) = (self.total(|values| values.rgb(i)), self.total(|values| values.squares(i)));
            std::array::from_fn(|c| variance(sum[c], squares[c]))
        }))
    }

    /// [`variance`](Self::variance) as a layer; 0 before the second pass.
    pub(crate) fn variance_layer(&self) -> Vec<f32> {
        let variance = self.variance().unwrap_or_else(|| vec![[0.0; 3]; self.pixels()]);
        variance.as_flattened().iter().map(|&value| value as f32).collect()
    }

    /// Estimate of how noisy the picture is: the relMSE that its variance alone would give against a perfect one, the mean of
    /// s²/n over value² + 0.01. What a radius blurs is not in it.
    #[must_use]
    pub fn noise(&self) -> Option<f64> {
        let variance = self.variance()?;
        let n = f64::from(self.passes());
        let sums = self.each_pixel(|i| self.total(|values| values.rgb(i)));
        let values = variance.as_flattened().iter().zip(sums.as_flattened());
        let sum: f64 = values.map(|(variance, sum)| variance / ((sum / n).powi(2) + 0.01)).sum();
        Some(sum / variance.as_flattened().len() as f64)
    }
}

/// Seed of a pass. The first one has the render's own, so that a render of one pass is that pass.
pub(crate) fn pass_seed(seed: u32, pass: u32) -> u32 {
    if pass == 0 { seed } else { pcg4d([seed, pass, PASS_KEY, 0])[0] }
}

/// Radius of a pass, counted from 0: r²ᵢ₊₁ = r²ᵢ·(i + α)/(i + 1) for i = 1, 2, … (Knaus and Zwicker, "Progressive Photon Mapping: A
/// Probabilistic Approach", 2011, equation 15), no less than `least`. The variance of the mean then falls as N^−α and the squared bias
/// as N^−2(1−α): at α = 2/3 both as N^−2/3.
pub(crate) fn pass_radius(first: f32, pass: u32, alpha: f32, least: f32) -> f32 {
    let mut radius2 = f64::from(first).powi(2);
    for i in 1..=pass {
        radius2 *= (f64::from(i) + f64::from(alpha)) / (f64::from(i) + 1.0);
    }
    (radius2.sqrt() as f32).max(least)
}

#[cfg(test)]
mod tests;
