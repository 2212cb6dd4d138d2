//! What a unit came to, as bytes between processes.

use crate::accumulate::Piece;
use crate::frame::Said;
use crate::record::{Bytes, digested, undigested};
use crate::sums::{Counts, Film};
use crate::work::WorkUnit;
use crate::worker::Outcome;
use serde::{Deserialize, Serialize};

/// What a message says before the numbers of the film.
#[derive(Serialize, Deserialize)]
struct Header {
    /// Pixels, and pixels with layers.
    unit: WorkUnit,
    layers: u32,
    counts: Counts,
    notes: Vec<String>,
    problems: Vec<String>,
}

/// The bytes of an outcome, or of why there is none.
pub(crate) fn encode(outcome: &Result<Outcome, String>) -> Vec<u8> {
    let header = outcome.as_ref().map(|Outcome { piece, said, .. }| Header {
        unit: piece.unit,
        layers: piece.film.layers.len() as u32,
        counts: piece.counts,
        notes: said.notes.clone(),
        problems: said.problems.clone(),
    });
    let mut bytes = Vec::new();
    let films = outcome.iter().map(|outcome| &outcome.piece.film);
    digested(&mut bytes, &header, |bytes| films.for_each(|film| film.put(bytes)));
    bytes
}

/// The outcome in bytes, or why there is none.
pub(crate) fn decode(bytes: &[u8]) -> Result<Outcome, String> {
    let damaged = || "what it sent is damaged".to_string();
    let (header, mut rest): (Result<Header, String>, Bytes<'_>) = undigested(bytes).ok_or_else(damaged)?;
    let Header { unit, layers, counts, notes, problems } = header?;
    let film = Film::take(&mut rest, unit.pixels as usize, layers as usize).ok_or_else(damaged)?;
    let said = Said { reports: Vec::new(), notes, problems };
    Ok(Outcome { piece: Piece { unit, counts, film }, complete: true, said })
}
