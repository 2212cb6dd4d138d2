//! What units of a render came to, in a file: a checkpoint, or a part of a render.
//!
//! A file is a line with the version and then what [`record`](crate::record) writes: a header, the numbers of each node and piece, a checksum. It is
//! written beside its place, brought to the disk and renamed, so that there is always a whole one, whenever the program is killed.

use crate::ProgressState;
use crate::accumulate::{Node, Piece};
use crate::output::{LayerKind, Metadata};
use crate::record::{Bytes, digested, undigested_after};
use crate::sums::{Counts, Film, Sums, Values};
use crate::work::{Part, WorkUnit};
use serde::{Deserialize, Serialize};

/// First line of a file.
const VERSION: &[u8] = b"caustic passes 2\n";

/// What a file says of its numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Header {
    /// Everything that their bits depend on, with its names.
    pub(crate) identity: Vec<(String, String)>,
    /// If the file is a part of a render: which, and what its picture is to be.
    pub(crate) about: Option<About>,
    size: [u32; 2],
    /// The bits of the radius of the first pass, m.
    first_radius: u32,
    has_layers: bool,
    counts: Counts,
    /// First pass and level of each node.
    nodes: Vec<(u32, u32)>,
    pieces: Vec<(WorkUnit, Counts)>,
}

/// What a part says of the picture that it is a part of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// Which part.
    pub part: Part,
    /// Parts that were merged into it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub merged: Vec<Part>,
    /// Passes of the picture.
    pub passes: u32,
    /// Layers of the picture.
    pub layers: Vec<LayerKind>,
    /// What the picture's file says.
    pub metadata: Metadata,
}

/// Why bytes are no file of ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// They are something else, or of another version.
    Foreign,
    /// They are not what was written.
    Damaged,
}

pub(crate) fn encode(identity: &[(String, String)], about: Option<&About>, state: &ProgressState) -> Vec<u8> {
    let header = Header {
        identity: identity.to_vec(),
        about: about.cloned(),
        size: state.size,
        first_radius: state.first_radius.to_bits(),
        has_layers: state.has_layers,
        counts: state.counts,
        nodes: state.nodes.iter().map(|node| (node.first, node.level)).collect(),
        pieces: state.pieces.iter().map(|piece| (piece.unit, piece.counts)).collect(),
    };
    let mut bytes = VERSION.to_vec();
    digested(&mut bytes, &header, |bytes| {
        for node in &state.nodes {
            match &node.values {
                Values::Pass(film) => film.put(bytes),
                Values::Sums(sums) => sums.put(bytes),
            }
        }
        state.pieces.iter().for_each(|piece| piece.film.put(bytes));
    });
    bytes
}

pub(crate) fn decode(bytes: &[u8]) -> Result<(Header, ProgressState), Fault> {
    if !bytes.starts_with(VERSION) {
        return Err(Fault::Foreign);
    }
    let (header, rest) = undigested_after::<Header>(bytes, VERSION.len()).ok_or(Fault::Damaged)?;
    let state = state(&header, rest).ok_or(Fault::Damaged)?;
    Ok((header, state))
}

fn state(header: &Header, mut rest: Bytes<'_>) -> Option<ProgressState> {
    let Header { size, has_layers, counts, .. } = *header;
    let pixels = usize::try_from(u64::from(size[0]) * u64::from(size[1])).ok()?;
    let layers_of = |pixels: usize| if has_layers { pixels } else { 0 };
    let node = |&(first, level): &(u32, u32)| {
        let values = match level {
            0 => Values::Pass(Film::take(&mut rest, pixels, layers_of(pixels))?),
            _ => Values::Sums(Sums::take(&mut rest, pixels, layers_of(pixels))?),
        };
        Some(Node { first, level, values })
    };
    let nodes = header.nodes.iter().map(node).collect::<Option<Vec<_>>>()?;
    let piece = |&(unit, counts): &(WorkUnit, Counts)| {
        let pixels = unit.pixels as usize;
        Some(Piece { unit, counts, film: Film::take(&mut rest, pixels, layers_of(pixels))? })
    };
    let pieces = header.pieces.iter().map(piece).collect::<Option<Vec<_>>>()?;
    let first_radius = f32::from_bits(header.first_radius);
    rest.is_empty().then_some(ProgressState { size, first_radius, has_layers, counts, nodes, pieces })
}
