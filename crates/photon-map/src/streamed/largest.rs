//! The largest power among photons.

use crate::MapError;
use caustic_kernels::layout::Photon;

/// The largest power of photons in each channel, W: what the sums of a map are aligned to. Of chunks that are to count as one map it has to be
/// known before the first, so all photons are looked at once before.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LargestPower(pub [f32; 3]);

impl LargestPower {
    /// Looks at more photons.
    pub fn see(&mut self, photons: &[Photon]) {
        for photon in photons {
            self.raise(&Self(photon.power));
        }
    }

    /// The largest of both.
    pub fn raise(&mut self, other: &Self) {
        for (largest, power) in self.0.iter_mut().zip(other.0) {
            *largest = largest.max(power);
        }
    }

    /// Whether powers that are aligned to this are wrong for photons whose largest power is `other`. Only exponents matter.
    #[must_use]
    pub fn is_below(&self, other: &Self) -> bool {
        let exponent = |power: f32| power.to_bits() >> 23;
        self.0.iter().zip(other.0).any(|(&largest, power)| exponent(largest) < exponent(power))
    }

    /// Refuses photons above.
    pub(super) fn check(&self, photons: &[Photon]) -> Result<(), MapError> {
        let above = |photon: &Photon| photon.power.iter().zip(&self.0).any(|(power, largest)| power > largest);
        match photons.iter().position(above) {
            Some(index) => Err(MapError::AboveLargest { index, power: photons[index].power, largest: self.0 }),
            None => Ok(()),
        }
    }

    pub(super) fn bits(&self) -> [u32; 3] {
        self.0.map(f32::to_bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_decide_whether_powers_fit_below() {
        let mut largest = LargestPower([1.5, 0.0, 3.0]);
        assert!(!largest.is_below(&LargestPower([1.75, 0.0, 2.0])), "the same exponents");
        assert!(largest.is_below(&LargestPower([0.0, 1e-30, 0.0])) && largest.is_below(&LargestPower([2.0, 0.0, 0.0])));
        largest.raise(&LargestPower([1.0, 2.0, 4.0]));
        assert_eq!(largest, LargestPower([1.5, 2.0, 4.0]));
    }
}
