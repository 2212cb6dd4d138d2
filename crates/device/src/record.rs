//! Which words of a record are floats.

use bytemuck::Pod;
use caustic_kernels::gather::{Compact, EstimateParams, GatherParams, Reach};
use caustic_kernels::grid::{Grid, Row};
use caustic_kernels::layout::{Arrival, Irradiance, Neighbour, Photon, PowerSum, Query, Site};
use caustic_kernels::probe::{Arithmetic, ArithmeticParams};
use caustic_kernels::rivals::kd::{KdLarge, KdLevel, KdRadius, KdSmall, KdSplit};
use caustic_kernels::rivals::{BruteParams, SearchParams};
use caustic_kernels::sort::{RadixPass, ScanParams};
use caustic_kernels::trace::{
    BvhNode, Camera, CameraTile, Corners, FilmTile, GatherTile, LatticeTile, LayerPixel, LedgerBlock, LedgerPass,
    LedgerSum, Light, Material, PhotonPass, Pixel, Primitive, SceneInfo, Tally, Target, Texel, Texture, Vertex,
};

/// A record whose words are known to be floats or integers.
pub trait Record: Pod {
    /// A letter a word: `f` for a float, `u` for an integer.
    const WORDS: &'static str;
}

macro_rules! records {
    ($($name:ty: $words:literal),* $(,)?) => {
        $(impl Record for $name {
            const WORDS: &'static str = {
                assert!(4 * $words.len() == size_of::<$name>());
                $words
            };
        })*
    };
}

records! {
    u32: "u",
    f32: "f",
    Photon: "fffufffu",
    Query: "fffu",
    Neighbour: "fu",
    Irradiance: "fffu",
    PowerSum: "uuuuuuuuuuuuu",
    Site: "uuuu",
    Arrival: "uuuuuuuuuuuu",
    Compact: "uuuu",
    Grid: "ffffuuuuuufffuf",
    Row: "uuf",
    GatherParams: "uuf",
    EstimateParams: "uuuu",
    Reach: "fuu",
    SearchParams: "uuuf",
    BruteParams: "uuuuuf",
    KdLevel: "uuuuf",
    KdLarge: "uuuffffff",
    KdSplit: "uuu",
    KdSmall: "uuu",
    KdRadius: "uuuuf",
    RadixPass: "uuuu",
    ScanParams: "uu",
    PhotonPass: "uuuuuuuu",
    SceneInfo: "uuuuuuuuu",
    BvhNode: "fffufffu",
    Primitive: "uuufffffffffffff",
    Material: "fffuffuufffffuff",
    Corners: "uuuffffff",
    Texture: "uuuu",
    Texel: "uu",
    Light: "fffufffuffffffffffffuuuuu",
    Target: "ffff",
    CameraTile: "uuuu",
    Tally: "fffffffffffffff",
    LedgerPass: "u",
    LedgerBlock: "uu",
    LedgerSum: "fffffffffffffffffuu",
    Camera: "fffufffuffffffffffffff",
    Vertex: "fffuffffffuf",
    FilmTile: "uuuu",
    GatherTile: "uuuuu",
    LatticeTile: "uuuuuuuff",
    LayerPixel: "fffffffffffffffffffffff",
    Pixel: "fffuuuuu",
    // Bits of operands and results, NaN among them.
    Arithmetic: "uuuuuuuuuuuuuuuuuuu",
    ArithmeticParams: "uuu",
}
