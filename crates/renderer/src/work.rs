//! Units of work: what of a render can be computed by itself, by whoever is free.

use crate::RenderError;
use crate::settings::Settings;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Some pixels of one pass. A unit needs nothing but the scene and the settings: seed and radius of a pass are functions of its number, and
/// the photons of a pass that several units share are traced by each who has one of them, to the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct WorkUnit {
    /// The pass, counted from 0.
    pub pass: u32,
    /// First pixel, row by row from the top left.
    pub first_pixel: u32,
    /// Pixels.
    pub pixels: u32,
}

impl WorkUnit {
    /// The pixel after the last.
    #[must_use]
    pub fn end(&self) -> u32 {
        self.first_pixel + self.pixels
    }
}

/// One of several parts into which a render, or a set of cases, is split: `I/N`, I from 1 to N.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Part {
    /// Which part, from 1.
    pub number: u32,
    /// How many parts there are.
    pub of: u32,
}

impl Part {
    /// The cases of a part, or all: every N-th, since cases that cost alike stand side by side.
    pub fn share<T>(part: Option<Self>, cases: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
        let (first, step) = part.map_or((0, 1), |part| (part.number as usize - 1, part.of as usize));
        cases.into_iter().skip(first).step_by(step)
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// Most parts of a render.
const MAX_PARTS: u32 = 1 << 20;

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.parse::<u32>().ok();
        let part = text.split_once('/').and_then(|(i, n)| Some(Self { number: number(i)?, of: number(n)? }));
        part.filter(|part| part.of <= MAX_PARTS && (1..=part.of).contains(&part.number))
            .ok_or_else(|| format!("it must be I/N, such as 3/8: part I of N, I from 1 to N, N up to {MAX_PARTS}"))
    }
}

/// How the passes of a render are cut into units, which are numbered: pass by pass, from the top of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Split {
    /// Pixels of the picture.
    pub(crate) pixels: u32,
    /// Units of a pass.
    pub(crate) tiles: u32,
}

/// Units that a worker should find at least, so that none waits long for another's last one.
const UNITS_A_WORKER: u32 = 4;

impl Split {
    /// Whole passes where there are enough of them for `parts` of `workers` devices each; else passes in tiles.
    pub(crate) fn new(settings: &Settings, parts: u32, workers: u32) -> Self {
        let pixels = settings.size[0] * settings.size[1];
        let wanted = parts.saturating_mul(if workers > 1 { UNITS_A_WORKER * workers } else { 1 });
        let tiles = settings.passes().map_or(1, |passes| wanted.div_ceil(passes)).clamp(1, pixels);
        Self { pixels, tiles }
    }

    /// The unit of a number.
    pub(crate) fn unit(&self, number: u64) -> WorkUnit {
        let (pass, tile) = (number / u64::from(self.tiles), number % u64::from(self.tiles));
        let begin = |tile: u64| (tile * u64::from(self.pixels) / u64::from(self.tiles)) as u32;
        WorkUnit { pass: pass as u32, first_pixel: begin(tile), pixels: begin(tile + 1) - begin(tile) }
    }

    /// Whether a unit is one of these.
    pub(crate) fn has(&self, unit: &WorkUnit) -> bool {
        let tile = (u64::from(unit.first_pixel) * u64::from(self.tiles)).div_ceil(u64::from(self.pixels));
        self.unit(u64::from(unit.pass) * u64::from(self.tiles) + tile) == *unit
    }

    /// Numbers of the units of a part, or of all: from the first to the one after the last, if that is known.
    pub(crate) fn numbers(&self, settings: &Settings, part: Option<Part>) -> Result<(u64, Option<u64>), RenderError> {
        let units = settings.passes().map(|passes| u64::from(passes) * u64::from(self.tiles));
        let Some(Part { number, of }) = part else { return Ok((0, units)) };
        let stop = &settings.stop;
        let open = stop.seconds.is_some() || stop.photons.is_some() || stop.error.is_some();
        let Some(units) = units.filter(|_| !open) else {
            let range =
                "left out, with a number of --passes and no other stop: what ends a render must be known to all parts";
            return Err(RenderError::Setting {
                name: "part",
                value: format!("{number}/{of}"),
                range: range.to_string(),
            });
        };
        let begin = |part: u32| u64::from(part) * units / u64::from(of);
        Ok((begin(number - 1), Some(begin(number))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stop;
    use crate::scene::Scene;

    fn settings(size: [u32; 2], passes: u32) -> Settings {
        let stop = Stop { passes: Some(passes), ..Stop::default() };
        Settings { size, stop, ..Settings::of(&Scene::load("plane").unwrap()) }
    }

    #[test]
    fn parts_are_all_units_and_each_once() {
        for (size, passes, parts) in
            [([7, 3], 1, 8), ([2, 1], 1, 5), ([16, 16], 9, 4), ([5, 5], 3, 7), ([4, 4], 64, 64)]
        {
            let settings = settings(size, passes);
            let split = Split::new(&settings, parts, 1);
            let mut covered = vec![0; (size[0] * size[1] * passes) as usize];
            for number in 1..=parts {
                let (first, end) = split.numbers(&settings, Some(Part { number, of: parts })).unwrap();
                for unit in (first..end.unwrap()).map(|number| split.unit(number)) {
                    assert!(split.has(&unit) && unit.pixels > 0, "{unit:?}");
                    assert!(!split.has(&WorkUnit { pixels: unit.pixels + 1, ..unit }));
                    let at = (unit.pass * size[0] * size[1] + unit.first_pixel) as usize;
                    covered[at..at + unit.pixels as usize].iter_mut().for_each(|count| *count += 1);
                }
            }
            assert!(covered.iter().all(|&count| count == 1), "{size:?}, {passes} passes, {parts} parts");
        }
    }

    #[test]
    fn a_part_is_written_as_it_is_said() {
        assert_eq!("3/8".parse(), Ok(Part { number: 3, of: 8 }));
        for wrong in ["0/8", "9/8", "8", "a/b", "1/0", "-1/4", "1/2000000"] {
            assert!(wrong.parse::<Part>().is_err(), "{wrong}");
        }
    }
}
