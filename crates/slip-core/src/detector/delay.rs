//! Energies of blocks in, the same a number of blocks later out: the stylus waits for a reference that is late, a
//! reference that is early for the stylus.

use super::{
    config::BANDS,
    lanes::{LANES, of_bands, padded},
};

/// Longest delay in blocks: 107.5 ms at 50 kHz and below.
pub(super) const MOST: u8 = 215;

/// The blocks that wait.
#[derive(Clone, Copy, Debug)]
pub(super) struct Delay {
    past: [[f32; BANDS]; MOST as usize],
    len: u8,
    /// The reference waits, not the stylus.
    early: bool,
    at: u8,
    filled: u8,
}

impl Delay {
    /// None waits.
    pub(super) const fn new() -> Self {
        Self { past: [[0.0; BANDS]; MOST as usize], len: 0, early: false, at: 0, filled: 0 }
    }

    /// How long the stylus waits (blocks); below 0 the reference.
    #[inline]
    pub(super) fn blocks(&self) -> i16 {
        let len = i16::from(self.len);
        if self.early { -len } else { len }
    }

    /// Another delay (blocks), at most [`MOST`]; it begins empty.
    pub(super) fn set(&mut self, blocks: i16) {
        self.len = u8::try_from(blocks.unsigned_abs()).map_or(MOST, |len| len.min(MOST));
        self.early = blocks < 0;
        self.clear();
    }

    /// What waits belongs to nothing that follows.
    pub(super) fn clear(&mut self) {
        (self.at, self.filled) = (0, 0);
    }

    /// The robot starts or stops: what waits of the reference belongs to another stretch of motion.
    pub(super) fn turn(&mut self) {
        if self.early {
            self.clear();
        }
    }

    /// Takes the energies of a block of the stylus; gives those that are decided on, `None` until there are any.
    #[inline]
    pub(super) fn stylus(&mut self, energy: [f32; BANDS]) -> Option<[f32; BANDS]> {
        if self.early { Some(energy) } else { self.pass(energy) }
    }

    /// Takes the energies of a block of the reference; gives those that belong to the block that is decided on.
    #[inline]
    pub(super) fn reference(&mut self, energy: [f32; LANES]) -> [f32; LANES] {
        if self.early {
            padded(self.pass(of_bands(&energy)).unwrap_or_default(), 0.0)
        } else {
            energy
        }
    }

    /// Takes the energies of a block; gives those of the block that far before, `None` until there is one.
    #[inline]
    fn pass(&mut self, energy: [f32; BANDS]) -> Option<[f32; BANDS]> {
        if self.len == 0 {
            return Some(energy);
        }
        let before = core::mem::replace(self.past.get_mut(usize::from(self.at))?, energy);
        self.at = if self.at + 1 < self.len { self.at + 1 } else { 0 };
        if self.filled < self.len {
            self.filled += 1;
            return None;
        }
        Some(before)
    }

    /// The floors that the energies of the stylus are over are `1 / factors` of those before.
    #[cold]
    pub(super) fn rescale(&mut self, factors: [f32; BANDS]) {
        if self.early {
            return;
        }
        for energy in self.past.iter_mut().take(self.filled.into()) {
            energy.iter_mut().zip(factors).for_each(|(e, factor)| *e *= factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{super::config::BANDS, Delay, LANES, MOST, of_bands};

    #[test]
    fn a_block_comes_out_as_many_blocks_later_in_the_floors_of_then() {
        let energy = |i: u16| [f32::from(i); BANDS];
        let mut delay = Delay::new();
        assert_eq!(delay.pass(energy(7)), Some(energy(7)));
        for blocks in [1_u16, 3, 50] {
            delay.set(i16::try_from(blocks).unwrap());
            for i in 0..200 {
                assert_eq!(delay.pass(energy(i)), i.checked_sub(blocks).map(energy), "{blocks}");
            }
            delay.rescale([2.0; BANDS]);
            assert_eq!(delay.pass(energy(0)), Some(energy(2 * (200 - blocks))));
        }
        delay.set(i16::from(MOST) + 1);
        assert_eq!(delay.blocks(), i16::from(MOST));
        assert_eq!(delay.reference([1.0; LANES]), [1.0; LANES]);
    }

    #[test]
    fn a_reference_that_is_early_waits_and_the_stylus_does_not() {
        let mut delay = Delay::new();
        delay.set(-2);
        for (i, wanted) in [0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 5.0].into_iter().enumerate() {
            if i == 4 {
                delay.turn();
            }
            let given = delay.reference([1.0 + i as f32; LANES]);
            assert_eq!(of_bands(&given), [wanted; BANDS], "{i}");
            delay.rescale([9.0; BANDS]);
            assert_eq!(delay.stylus([3.0; BANDS]), Some([3.0; BANDS]));
        }
        assert_eq!(delay.blocks(), -2);
    }
}
