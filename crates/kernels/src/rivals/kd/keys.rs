//! Initialisation: coordinates as sort keys, and the three orders as one buffer.

use super::{KD_SMALL, KD_SMALL_OWNER, KdLevel};
use crate::exec::{Input, Store};
use crate::layout::Photon;
use crate::num::{abs, total_order_key};

/// Coordinates nearer to 0 than this, 2⁻⁹⁰ m, count as 0.
const LEAST_COORDINATE: f32 = 8.077_936e-28;

/// A coordinate as the construction sees it: +0 in place of −0 and of what is below 2⁻⁹⁰ m.
///
/// So two coordinates are the same or at least 2⁻¹¹³ m apart, and nothing that is computed of them is subnormal: a device that flushes
/// subnormals builds the same tree. A box made of such coordinates still bounds distances: where taking a photon's coordinate p for
/// 0 changes the rounded difference q − p at all, |q| is below 2⁻⁶⁴ m, whose square does not show in a squared
/// distance ([`distance2`](crate::gather::distance2())).
#[inline]
#[must_use]
pub fn coordinate(x: f32) -> f32 {
    if abs(x) < LEAST_COORDINATE { 0.0 } else { x }
}

/// Writes the sort keys of photon `i` along each axis: integers in the order of the coordinates.
#[inline]
pub fn kd_keys<X: Store<u32> + ?Sized, Y: Store<u32> + ?Sized, Z: Store<u32> + ?Sized>(
    i: u32,
    level: &KdLevel,
    photons: &Input<Photon>,
    x: &mut X,
    y: &mut Y,
    z: &mut Z,
) {
    if i < level.photons {
        let position = photons[i as usize].position;
        x.set(i, total_order_key(coordinate(position[0])));
        y.set(i, total_order_key(coordinate(position[1])));
        z.set(i, total_order_key(coordinate(position[2])));
    }
}

/// Puts place `i` of the sorted orders into one buffer, one order after another, and gives it to the root.
#[inline]
pub fn kd_begin<O: Store<u32> + ?Sized, W: Store<u32> + ?Sized>(
    i: u32,
    level: &KdLevel,
    x: &Input<u32>,
    y: &Input<u32>,
    z: &Input<u32>,
    orders: &mut O,
    owners: &mut W,
) {
    if i < level.photons {
        orders.set(i, x[i as usize]);
        orders.set(level.photons + i, y[i as usize]);
        orders.set(2 * level.photons + i, z[i as usize]);
        owners.set(i, if level.photons > KD_SMALL { 0 } else { KD_SMALL_OWNER });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn zeros_of_both_signs_and_what_counts_as_zero_are_one_key() {
        let zero = total_order_key(coordinate(0.0));
        for x in [-0.0, 1e-40, -1e-40, f32::MIN_POSITIVE, -8e-28] {
            assert_eq!(coordinate(x).to_bits(), 0, "{x}");
            assert_eq!(total_order_key(coordinate(x)), zero);
        }
        let ascending = [f32::MIN, -1.0, -8.1e-28, 0.0, 8.1e-28, 1.0, 1.0f32.next_up(), f32::MAX];
        let keys: Vec<u32> = ascending.iter().map(|&x| total_order_key(coordinate(x))).collect();
        assert!(keys.is_sorted_by(|a, b| a < b), "{keys:x?}");
        assert_eq!(LEAST_COORDINATE, 2f32.powi(-90));
    }

    #[test]
    fn photons_have_a_key_an_axis_and_all_belong_to_the_root() {
        let photons = [[1.0, -2.0, 0.0], [-1.0, 5.0, -0.0]].map(|position| Photon { position, ..Photon::default() });
        let level = KdLevel { photons: 2, ..KdLevel::default() };
        let mut keys = [vec![7; 2], vec![7; 2], vec![7; 2]];
        let (mut orders, mut owners) = (vec![9; 6], vec![9; 2]);
        for i in 0..3 {
            let [x, y, z] = &mut keys;
            kd_keys(i, &level, &photons, x.as_mut_slice(), y.as_mut_slice(), z.as_mut_slice());
            kd_begin(i, &level, &[1, 0], &[0, 1], &[1, 0], orders.as_mut_slice(), owners.as_mut_slice());
        }
        assert!(keys[0][0] > keys[0][1] && keys[1][0] < keys[1][1] && keys[2][0] == keys[2][1]);
        assert_eq!((orders, owners), (vec![1, 0, 0, 1, 1, 0], vec![KD_SMALL_OWNER; 2]));
    }
}
