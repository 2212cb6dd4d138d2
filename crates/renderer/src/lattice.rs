//! A lattice of points over the picture at which light of the global map is estimated, for the samples between them.

use crate::scene::Scene;
use crate::{RenderError, Settings};
use caustic_device::{Buffer, Device, Kernel, Masked, Plan};
use caustic_kernels::layout::{Irradiance, Query};
use caustic_kernels::trace::{Camera, CameraTile, GatherTile, LatticeTile, Vertex};

/// The keys of a picture, and what the stages of a tile need to know of those around it.
pub(crate) struct Lattice {
    /// Pixels between two keys.
    spacing: u32,
    /// Pixels in a row of the picture.
    width: u32,
    /// Keys in a row.
    row: u32,
    reach2: f32,
    /// Sees the keys as the picture's camera sees its pixels, each at its corner.
    pub(crate) camera: Buffer,
    /// Which keys are traced.
    pub(crate) keys: Buffer,
    /// The same for a final gather.
    pub(crate) gather: Buffer,
    tile: Buffer,
}

impl Lattice {
    /// The lattice of a picture whose estimates reach `radius`, m.
    pub(crate) fn new(device: &Device, scene: &Scene, settings: &Settings, radius: f32) -> Result<Self, RenderError> {
        let [width, height] = settings.size;
        let spacing = settings.interpolate;
        let pixel = scene.camera(width, height);
        let apart = |step: [f32; 3]| step.map(|step| step * spacing as f32);
        let [row, rows] = [width, height].map(|side| side.div_ceil(spacing) + 1);
        let camera = Camera {
            width: row,
            height: rows,
            right: apart(pixel.right),
            down: apart(pixel.down),
            jitter: 0.0,
            ..pixel
        };
        Ok(Self {
            spacing,
            width,
            row,
            reach2: radius * radius,
            camera: device.upload::<Camera>("camera of keys", &[camera])?,
            keys: device.scratch::<CameraTile>("tile of keys", 1)?,
            gather: device.scratch::<GatherTile>("tile of keys of gather", 1)?,
            tile: device.scratch::<LatticeTile>("tile of a lattice", 1)?,
        })
    }

    /// Keys of a tile of so many pixels.
    fn keys(&self, pixels: u32) -> u32 {
        keys(pixels, self.width, self.spacing)
    }

    /// Writes the parameters of a tile, whose plan is for `planned` pixels. Keys below the picture are traced as others are.
    pub(crate) fn write(&self, device: &Device, tile: &CameraTile, planned: u32, rays: u32) {
        let CameraTile { first_pixel, pixels, samples, seed } = *tile;
        let first_row = first_pixel / self.width / self.spacing;
        let (first_key, keys) = (first_row * self.row, self.keys(planned));
        device.write(&self.keys, &[CameraTile { first_pixel: first_key, pixels: keys, samples: 1, seed }]);
        device.write(&self.gather, &[GatherTile { first_pixel: first_key, pixels: keys, samples: 1, rays, seed }]);
        let per_pixel = 1.0 / self.spacing as f32;
        let (rows, width, reach2) = (keys / self.row, self.row, self.reach2);
        let lattice = LatticeTile { first_pixel, pixels, samples, seed, first_row, rows, width, per_pixel, reach2 };
        device.write(&self.tile, &[lattice]);
    }

    /// Appends an estimate for the samples of a tile to a plan: `estimate` appends it for points, at keys first and then at the samples that
    /// no keys are for.
    pub(crate) fn plan(
        &self,
        device: &Device,
        plan: &mut Plan,
        tile: &Tile<'_>,
        trace: Masked,
        mut estimate: impl FnMut(&mut Plan, Points<'_>, &Buffer) -> Result<(), RenderError>,
        out: &Buffer,
    ) -> Result<(), RenderError> {
        let keys = self.keys(tile.pixels);
        let key_queries = device.scratch::<Query>("key queries", u64::from(keys))?;
        let key_vertices = device.scratch::<Vertex>("key vertices", u64::from(keys))?;
        let key_light = device.scratch::<Irradiance>("key irradiance", u64::from(keys))?;
        let from = [&[&self.keys, &self.camera], tile.scene].concat();
        plan.each(trace, keys, &[&from[..], &[&key_queries, &key_vertices]].concat());
        let points = Points { queries: &key_queries, vertices: &key_vertices, count: keys, gather: &self.gather };
        estimate(plan, points, &key_light)?;
        let samples = tile.points.count;
        let spared = device.scratch::<Query>("sample queries not spared", u64::from(samples))?;
        let own = device.scratch::<Irradiance>("sample own", u64::from(samples))?;
        let around = [&self.tile, tile.camera, tile.points.queries, tile.points.vertices, &key_queries, &key_vertices];
        plan.each(Kernel::SpareQueries, samples, &[&around[..], &[&spared]].concat());
        estimate(plan, Points { queries: &spared, ..tile.points }, &own)?;
        plan.each(Kernel::LendIrradiance, samples, &[&around[..], &[&key_light, &spared, &own, out]].concat());
        Ok(())
    }
}

/// Rows of keys around `pixels` of a picture, wherever in it they are.
fn rows(pixels: u32, width: u32, spacing: u32) -> u32 {
    // Rows of pixels from the first to the last, where they begin at the end of one.
    let apart = if pixels == 1 { 0 } else { (pixels - 2) / width + 1 };
    apart.div_ceil(spacing) + 2
}

/// Keys of a tile of so many pixels.
pub(crate) fn keys(pixels: u32, width: u32, spacing: u32) -> u32 {
    rows(pixels, width, spacing) * (width.div_ceil(spacing) + 1)
}

/// Points for which light is estimated.
#[derive(Clone, Copy)]
pub(crate) struct Points<'a> {
    pub(crate) queries: &'a Buffer,
    pub(crate) vertices: &'a Buffer,
    pub(crate) count: u32,
    /// The tile of a final gather from them.
    pub(crate) gather: &'a Buffer,
}

/// A tile of the picture, whose samples may borrow from keys.
pub(crate) struct Tile<'a> {
    pub(crate) pixels: u32,
    pub(crate) camera: &'a Buffer,
    /// Buffers of the scene, as kernels of the camera take them.
    pub(crate) scene: &'a [&'a Buffer],
    pub(crate) points: Points<'a>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever tile of whatever picture: the keys before its first pixel and after its last are there.
    #[test]
    fn all_pixels_of_a_tile_lie_between_its_rows_of_keys() {
        for (width, spacing) in [(1, 1), (7, 1), (7, 3), (16, 4), (5, 64)] {
            for pixels in 1..60 {
                let mut tightest = u32::MAX;
                for first in 0..400 {
                    let [top, bottom] = [first / width, (first + pixels - 1) / width];
                    let first_row = top / spacing;
                    let needed = bottom / spacing + 1 - first_row + 1;
                    let rows = rows(pixels, width, spacing);
                    assert!(needed <= rows, "{width} {spacing} {pixels} {first}");
                    tightest = tightest.min(rows - needed);
                }
                assert_eq!(tightest, 0, "no more rows than that: {width} {spacing} {pixels}");
            }
        }
    }
}
