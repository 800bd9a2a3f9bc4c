//! Readings in, the block of them that is being filled out.

/// Longest block: half a millisecond at 50 kHz.
pub(super) const MOST: usize = 25;

/// Readings of stylus and motion reference, side by side, oldest first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    stylus: [f32; MOST],
    reference: [f32; MOST],
    len: usize,
}

impl Default for Pending {
    fn default() -> Self {
        Self { stylus: [0.0; MOST], reference: [0.0; MOST], len: 0 }
    }
}

impl Pending {
    /// Appends the next reading of the stylus and of the reference (off its mean); gives the new length. What does not
    /// fit is left out, which a block of at most [`MOST`] readings never meets.
    #[inline]
    pub(super) fn push(&mut self, stylus: f32, reference: f32) -> usize {
        if let (Some(x), Some(u)) =
            (self.stylus.get_mut(self.len), self.reference.get_mut(self.len))
        {
            (*x, *u) = (stylus, reference);
            self.len += 1;
        }
        self.len
    }

    /// The readings of the stylus.
    #[inline]
    pub(super) fn stylus(&self) -> &[f32] {
        self.stylus.get(..self.len).unwrap_or(&[])
    }

    /// The readings of the reference.
    #[inline]
    pub(super) fn reference(&self) -> &[f32] {
        self.reference.get(..self.len).unwrap_or(&[])
    }

    /// Begins another block.
    #[inline]
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }
}
