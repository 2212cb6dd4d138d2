//! A device that computes units.

use crate::accumulate::{Piece, pass_radius, pass_seed};
use crate::film::Pixels;
use crate::frame::{Frame, Maps, Said};
use crate::report::Progress;
use crate::work::WorkUnit;
use crate::{Integrator, RenderError, Settings};
use caustic_photon_map::RADII;

/// What a unit came to.
pub(crate) struct Outcome {
    /// The pixels, fewer than the unit has if the caller stopped it.
    pub(crate) piece: Piece,
    /// Whether it has all.
    pub(crate) complete: bool,
    /// What there is to say of the maps of its pass.
    pub(crate) said: Said,
}

/// A device with a scene on it, and the maps of the pass that it was at last.
pub(crate) struct Worker<'a> {
    frame: Frame<'a>,
    first_radius: f32,
    maps: Option<(u32, Maps)>,
}

/// Radius of a pass of a render whose first pass has `first`, m.
pub(crate) fn radius_of(settings: &Settings, first: f32, pass: u32) -> f32 {
    match settings.integrator {
        Integrator::Progressive => pass_radius(first, pass, settings.alpha, *RADII.start()),
        _ => first,
    }
}

impl<'a> Worker<'a> {
    pub(crate) fn new(frame: Frame<'a>, first_radius: f32) -> Self {
        Self { frame, first_radius, maps: None }
    }

    /// Computes a unit. `progress` stops it by returning false: with [`RenderError::Interrupted`] before there are pixels.
    pub(crate) fn run(
        &mut self,
        unit: WorkUnit,
        progress: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<Outcome, RenderError> {
        let Frame { device, settings, .. } = self.frame;
        let mut maps = match self.maps.take().filter(|(pass, _)| *pass == unit.pass) {
            Some((_, maps)) => maps,
            None => {
                let radius = radius_of(settings, self.first_radius, unit.pass);
                self.frame.maps(pass_seed(settings.seed, unit.pass), radius, progress)?
            }
        };
        let Pixels { film, layers } = self.frame.film(unit, &mut maps, progress)?;
        match film.iter().map(|pixel| u64::from(pixel.cut_short)).sum() {
            0 => {}
            searches => return Err(RenderError::CutShort { device: device.name(), searches }),
        }
        let said = maps.said.clone();
        let photons = said.reports.iter().map(|map| u64::from(map.photons_emitted)).sum();
        let complete = film.len() == unit.pixels as usize;
        let done = WorkUnit { pixels: film.len() as u32, ..unit };
        // The next unit may be of the same pass.
        self.maps = Some((unit.pass, maps)).filter(|_| unit.end() != settings.size[0] * settings.size[1]);
        Ok(Outcome { piece: Piece::new(done, &film, &layers, photons), complete, said })
    }
}
