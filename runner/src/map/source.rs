//! Where the photons of `caustic map` come from.

use crate::Failure;
use caustic_bench::points::{Distribution, Points};
use caustic_kernels::layout::{Photon, Query};
use caustic_photon_map::LargestPower;
use caustic_renderer::scene::suggestion;
use caustic_renderer::{PhotonFile, PhotonFileError, SavedPhotons};
use std::ops::Range;
use std::path::Path;

/// Photons that are looked at together where only something of each is wanted: a file's window.
const TOGETHER: u32 = 1 << 19;

/// Where photons come from.
pub enum Source {
    /// So many of a distribution.
    Drawn(Points, u32),
    /// A text file.
    Text(Vec<Photon>),
    /// A file of `caustic photons`, with the number of its photons.
    Saved(SavedPhotons, u32),
}

impl Source {
    /// What `--photons` names. `streamed` says that photons will be asked for in chunks.
    pub fn parse(text: &str, k: u32, streamed: bool) -> Result<Self, Failure> {
        let most = if streamed { u32::MAX } else { 1 << 28 };
        let number = |n: &str| {
            let number = n.parse::<u32>().ok().filter(|n| (1..=most).contains(n));
            number.ok_or_else(|| {
                let more = if streamed { "" } else { "; --memory allows more" };
                Failure::input(format!("--photons {text}: the number must be 1 to {most}{more}"))
            })
        };
        let drawn = |distribution, n: &str| {
            let n = number(n)?;
            Ok(Self::Drawn(Points::new(distribution, n, k), n))
        };
        match text.split_once(':') {
            Some(("uniform", n)) => drawn(Distribution::Uniform, n),
            Some(("surface", n)) => drawn(Distribution::Surface, n),
            Some(("clustered", n)) => drawn(Distribution::Caustic, n),
            Some(("cell", n)) => drawn(Distribution::Cell, n),
            // A file may be called so; a kind that is misspelt is none.
            Some((kind, n)) if n.parse::<u64>().is_ok() && !Path::new(text).exists() => {
                let meant = suggestion(kind, ["uniform", "surface", "clustered", "cell"]);
                Err(Failure::input(format!(
                    "--photons {text}: there is no kind `{kind}`{meant}; give uniform:N, surface:N, clustered:N, cell:N or a file"
                )))
            }
            _ => Self::open(Path::new(text), streamed),
        }
    }

    fn open(path: &Path, streamed: bool) -> Result<Self, Failure> {
        if path.extension().is_some_and(|ending| ending == "caustic") || PhotonFile::is_one(path) {
            let saved = SavedPhotons::open(path).map_err(Failure::input)?;
            return match u32::try_from(saved.count()) {
                Ok(0) => Err(Failure::input(format!("{} holds no photons; write one with more", path.display()))),
                Ok(count) => Ok(Self::Saved(saved, count)),
                Err(_) => Err(Failure::input(format!(
                    "{} holds {} photons, but a map has at most {}; write one with fewer",
                    path.display(),
                    saved.count(),
                    u32::MAX
                ))),
            };
        }
        if streamed {
            return Err(Failure::input(
                "--memory is for synthetic photons, such as uniform:100000000, and for files of `caustic photons`; a text file is read whole",
            ));
        }
        let photon = |position| Photon { position, power: [1.0; 3], ..Photon::default() };
        Ok(Self::Text(read(path)?.into_iter().map(photon).collect()))
    }

    /// How many photons there are.
    pub fn count(&self) -> u32 {
        match self {
            Self::Drawn(_, count) | Self::Saved(_, count) => *count,
            Self::Text(photons) => photons.len() as u32,
        }
    }

    /// The photons of these indices.
    pub fn photons(&self, indices: Range<u32>) -> Result<Vec<Photon>, PhotonFileError> {
        match self {
            Self::Drawn(points, _) => Ok(points.photons_of(indices)),
            Self::Text(photons) => Ok(photons[indices.start as usize..indices.end as usize].to_vec()),
            Self::Saved(saved, _) => saved.read(indices.start.into()..indices.end.into()),
        }
    }

    /// So many queries: drawn like the photons, or where photons of a file are.
    pub fn queries(&self, queries: u32) -> Result<Vec<Query>, PhotonFileError> {
        let at = |photon: &Photon| Query { position: photon.position, active: 1 };
        match self {
            Self::Drawn(points, _) => Ok(points.queries(queries)),
            Self::Text(photons) => Ok((0..queries).map(|i| at(&photons[i as usize % photons.len()])).collect()),
            Self::Saved(_, count) => {
                // Evenly from all, so that none of the file's maps is left out.
                let place = |i: usize| (i as u64 * u64::from(*count) / u64::from(queries)) as u32;
                let mut found = Vec::with_capacity(queries as usize);
                self.each(TOGETHER, |first, photons| {
                    while found.len() < queries as usize
                        && let Some(photon) = photons.get((place(found.len()) - first) as usize)
                    {
                        found.push(at(photon));
                    }
                    true
                })?;
                Ok(found)
            }
        }
    }

    /// The largest power in each channel. `go_on` is told how many photons have been looked at, and may end it.
    pub fn largest_power(&self, mut go_on: impl FnMut(u32) -> bool) -> Result<LargestPower, PhotonFileError> {
        if let Self::Saved(saved, _) = self {
            return Ok(LargestPower(saved.largest_power()));
        }
        let mut largest = LargestPower::default();
        self.each(TOGETHER, |first, photons| {
            largest.see(photons);
            go_on(first)
        })?;
        Ok(largest)
    }

    /// Shows `see` chunks of `together` photons, with the index of the first, while it wants more.
    pub fn each(&self, together: u32, mut see: impl FnMut(u32, &[Photon]) -> bool) -> Result<(), PhotonFileError> {
        let count = self.count();
        let mut first = 0;
        while first < count {
            let photons = self.photons(first..first.saturating_add(together).min(count))?;
            if !see(first, &photons) {
                break;
            }
            first += photons.len() as u32;
        }
        Ok(())
    }

    /// A radius within which 2·k photons are expected around an average query, or the one that a file's photons were traced for.
    pub fn radius(&self, k: u32) -> f32 {
        match self {
            Self::Drawn(points, count) => points.distribution.radius(*count, k),
            Self::Text(photons) => Distribution::Uniform.radius(photons.len() as u32, k),
            Self::Saved(saved, _) => saved.header().radius,
        }
    }
}

/// Reads `x y z` lines. Lines that begin with # are comments.
fn read(path: &Path) -> Result<Vec<[f32; 3]>, Failure> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        Failure::input(format!(
            "{}: {error}; give a text file with `x y z` a line, a file of `caustic photons`, or uniform:N",
            path.display()
        ))
    })?;
    positions(&path.display().to_string(), &text)
}

/// The positions in the text of `file`.
fn positions(file: &str, text: &str) -> Result<Vec<[f32; 3]>, Failure> {
    let mut positions = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#')) {
        let numbers: Vec<f32> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
        match numbers[..] {
            [x, y, z, ..] => positions.push([x, y, z]),
            _ => return Err(Failure::input(format!("{file}, line {}: three numbers `x y z` must stand here", i + 1))),
        }
    }
    if positions.is_empty() {
        return Err(Failure::input(format!("{file} holds no photons; it needs a line `x y z` for each")));
    }
    Ok(positions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use caustic_photon_map::bounds;

    /// Any text gives positions, which the map then checks, or one sentence. `CAUSTIC_FUZZ` sets how many are tried.
    #[test]
    fn any_text_is_positions_or_a_sentence() {
        let pieces = [
            "1", "-2.5", "1e-40", "3e38", "1e39", "nan", "inf", "-0", " ", "\t", "\n", "\r\n", "#", "x", "ü", ",",
            "\u{0}",
        ];
        let count = std::env::var("CAUSTIC_FUZZ").ok().map_or(20_000, |count| count.parse().expect("a number"));
        let (mut good, mut bad) = (0, 0);
        for seed in 0..count {
            let random = |step: u32| caustic_kernels::num::pcg4d([seed, step, 0xf11e, 0])[0] as usize;
            let word = |step| pieces[random(step) % if random(0) % 2 == 0 { 10 } else { pieces.len() }];
            let text: String = (1..2 + random(99) as u32 % 30).map(|step| format!("{} ", word(step))).collect();
            match positions("photons.txt", &text) {
                Ok(positions) => {
                    assert!(!positions.is_empty());
                    let finite = positions.as_flattened().iter().all(|x| x.is_finite());
                    assert_eq!(bounds("photons", positions.iter().copied()).is_ok(), finite);
                    good += 1;
                }
                Err(failure) => {
                    assert!(failure.message().starts_with("photons.txt") && !failure.message().contains('\n'));
                    bad += 1;
                }
            }
        }
        assert!(good > count / 50 && bad > count / 50, "{good} good, {bad} bad");
    }
}
