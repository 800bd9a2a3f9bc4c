//! Slices of a given length that begin at a cache line: vectors of 512 bits are then never split between two lines.

/// Bytes of a cache line and of the widest vector.
const LINE: usize = 64;

/// A slice that begins at a cache line.
#[derive(Debug)]
pub(super) struct Aligned<T> {
    storage: Vec<T>,
    start: usize,
    len: usize,
}

impl<T: Clone> Aligned<T> {
    fn filled(len: usize, value: T) -> Self {
        let spare = LINE / size_of::<T>();
        let storage = vec![value; len + spare];
        let start = storage.as_ptr().align_offset(LINE).min(spare);
        Self { storage, start, len }
    }

    /// `len` zeros.
    pub(super) fn zeros(len: usize) -> Self
    where
        T: Default,
    {
        Self::filled(len, T::default())
    }

    #[inline(always)]
    pub(super) fn get(&self) -> &[T] {
        &self.storage[self.start..self.start + self.len]
    }

    #[inline(always)]
    pub(super) fn get_mut(&mut self) -> &mut [T] {
        &mut self.storage[self.start..self.start + self.len]
    }
}

impl<T: Clone> Clone for Aligned<T> {
    /// The copy lies elsewhere and finds its own beginning.
    fn clone(&self) -> Self {
        let mut copy = Self::filled(self.len, self.storage[0].clone());
        copy.get_mut().clone_from_slice(self.get());
        copy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_and_their_copies_begin_at_a_line() {
        for len in [0, 1, 15, 16, 17, 1000] {
            let mut zeros = Aligned::<f32>::zeros(len);
            zeros.get_mut().iter_mut().zip(1_u16..).for_each(|(x, at)| *x = f32::from(at));
            let copy = zeros.clone();
            assert_eq!(zeros.get(), copy.get());
            assert_eq!(copy.get().len(), len);
            for slice in [zeros.get(), copy.get()] {
                assert_eq!(slice.as_ptr().align_offset(LINE), 0);
            }
        }
    }
}
