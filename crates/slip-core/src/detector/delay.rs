//! Energies of blocks in, the same a number of blocks later out: the stylus waits for a reference that is late.

use super::config::BANDS;

/// Longest delay in blocks: 25 ms of the shortest ones.
pub(super) const MOST: usize = 50;

/// The blocks that wait.
#[derive(Clone, Copy, Debug)]
pub(super) struct Delay {
    past: [[f32; BANDS]; MOST],
    len: usize,
    at: usize,
    filled: usize,
}

impl Delay {
    /// None waits.
    pub(super) const fn new() -> Self {
        Self { past: [[0.0; BANDS]; MOST], len: 0, at: 0, filled: 0 }
    }

    /// The delay (blocks).
    #[inline]
    pub(super) fn blocks(&self) -> usize {
        self.len
    }

    /// Another delay (blocks), at most [`MOST`]; it begins empty.
    pub(super) fn set(&mut self, blocks: usize) {
        self.len = blocks.min(MOST);
        self.clear();
    }

    /// What waits belongs to nothing that follows.
    pub(super) fn clear(&mut self) {
        (self.at, self.filled) = (0, 0);
    }

    /// Takes the energies of a block; gives those of the block that far before, `None` until there is one.
    #[inline]
    pub(super) fn pass(&mut self, energy: [f32; BANDS]) -> Option<[f32; BANDS]> {
        if self.len == 0 {
            return Some(energy);
        }
        let before = core::mem::replace(self.past.get_mut(self.at)?, energy);
        self.at = if self.at + 1 < self.len { self.at + 1 } else { 0 };
        if self.filled < self.len {
            self.filled += 1;
            return None;
        }
        Some(before)
    }

    /// The floors that the energies are over are `1 / factors` of those before.
    #[cold]
    pub(super) fn rescale(&mut self, factors: [f32; BANDS]) {
        for energy in self.past.iter_mut().take(self.filled) {
            energy.iter_mut().zip(factors).for_each(|(e, factor)| *e *= factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{super::config::BANDS, Delay, MOST};

    #[test]
    fn a_block_comes_out_as_many_blocks_later_in_the_floors_of_then() {
        let energy = |i: u16| [f32::from(i); BANDS];
        let mut delay = Delay::new();
        assert_eq!(delay.pass(energy(7)), Some(energy(7)));
        for blocks in [1_u16, 3, 50] {
            delay.set(blocks.into());
            for i in 0..200 {
                assert_eq!(delay.pass(energy(i)), i.checked_sub(blocks).map(energy), "{blocks}");
            }
            delay.rescale([2.0; BANDS]);
            assert_eq!(delay.pass(energy(0)), Some(energy(2 * (200 - blocks))));
        }
        delay.set(MOST + 1);
        assert_eq!(delay.blocks(), MOST);
    }
}
