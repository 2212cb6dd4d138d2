//! Photons of power 1: what is estimated from them is how many there are.

use crate::exec::{Input, Store};
use crate::grid::Grid;
use crate::layout::Arrival;
use crate::num::Limbs;

/// Writes photon `i` of a map with power 1 in each channel, and the largest power, 1. The irradiance of a query over such photons is
/// n / (π·r²), m⁻², for any search: the density of photons, from which the radius is known.
#[inline]
pub fn unit_powers<A: Store<Arrival> + ?Sized, P: Store<u32> + ?Sized>(
    i: u32,
    grid: &Grid,
    arrivals: &Input<Arrival>,
    units: &mut A,
    power: &mut P,
) {
    if i < 3 {
        power.set(i, 1f32.to_bits());
    }
    if i < grid.photons {
        let one = Limbs::of(1.0, 1.0).0;
        let arrival = arrivals[i as usize];
        units.set(i, Arrival::new(one, one, one, arrival.direction(), arrival.primitive()));
    }
}
