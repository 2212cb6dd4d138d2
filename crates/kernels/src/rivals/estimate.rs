//! Irradiance from neighbours that any technique found.

use super::SearchParams;
use crate::exec::{Input, Store};
use crate::gather::{CUT_SHORT, Power, over_disc};
use crate::layout::{Irradiance, Neighbour, Photon};

/// Irradiance at query `q` (eq. 2.1) from its `k` nearest photons, with the bits of
/// [`gather_irradiance`](crate::gather::gather_irradiance). The disc reaches to the neighbour after them: `neighbours` has k + 1 places a
/// query, `counts` how many of those are taken, and `power` is the largest power of any photon in each channel, as bits.
#[inline]
pub fn estimate_of_neighbours<I: Store<Irradiance> + ?Sized>(
    q: u32,
    params: &SearchParams,
    photons: &Input<Photon>,
    power: &Input<u32>,
    neighbours: &Input<Neighbour>,
    counts: &Input<u32>,
    irradiance: &mut I,
) {
    if q >= params.queries {
        return;
    }
    let count = counts[q as usize];
    if count == CUT_SHORT {
        irradiance.set(q, Irradiance { rgb: [0.0, 0.0, 0.0], photons: CUT_SHORT });
        return;
    }
    let row = q * (params.k + 1);
    let mut radius2 = params.radius2;
    let mut counted = count;
    if count > params.k {
        counted = params.k;
        radius2 = neighbours[(row + params.k) as usize].distance2;
    }
    let mut sum = Power::new();
    let mut n = 0;
    while n < counted {
        let photon = neighbours[(row + n) as usize].photon;
        sum.add_photon(&photons[photon as usize], power);
        n += 1;
    }
    let rgb = over_disc(sum.value(power), radius2, params.radius2);
    irradiance.set(q, Irradiance { rgb, photons: counted });
}
