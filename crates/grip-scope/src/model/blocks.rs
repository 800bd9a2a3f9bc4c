//! Items at the one end in, out at the other; any of them by its place.
//!
//! A deque that lives in blocks as large as the samples of a chunk: an allocator gives the places of samples that were let go to what is
//! kept for good. One large array would lie beside them, and the process would hold both.

use std::collections::VecDeque;

/// Bytes of a block, about: those of the samples of a chunk.
const BLOCK: usize = 4096;

/// A deque in blocks.
#[derive(Clone, Debug)]
pub(super) struct Blocks<T> {
    /// All full but for the first, whose oldest items may be gone, and the last.
    blocks: VecDeque<VecDeque<T>>,
    len: usize,
}

impl<T> Default for Blocks<T> {
    fn default() -> Self {
        Self { blocks: VecDeque::new(), len: 0 }
    }
}

impl<T> Blocks<T> {
    /// Items of a full block.
    const ITEMS: usize = if BLOCK / size_of::<T>() > 0 { BLOCK / size_of::<T>() } else { 1 };

    pub(super) const fn len(&self) -> usize {
        self.len
    }

    pub(super) fn push_back(&mut self, item: T) {
        self.len += 1;
        // The first block is not filled again where items are gone: it ends where it did.
        let open = match self.blocks.len() {
            0 => false,
            1 => self.blocks.front().is_some_and(|block| block.len() < block.capacity()),
            _ => self.blocks.back().is_some_and(|block| block.len() < Self::ITEMS),
        };
        if !open {
            self.blocks.push_back(VecDeque::with_capacity(Self::ITEMS));
        }
        if let Some(block) = self.blocks.back_mut() {
            block.push_back(item);
        }
    }

    pub(super) fn pop_front(&mut self) -> Option<T> {
        let block = self.blocks.front_mut()?;
        let item = block.pop_front();
        if block.is_empty() {
            self.blocks.pop_front();
        }
        self.len -= usize::from(item.is_some());
        item
    }

    /// Block and place in it.
    fn place(&self, index: usize) -> Option<(usize, usize)> {
        let first = self.blocks.front()?.len();
        Some(match index.checked_sub(first) {
            None => (0, index),
            Some(behind) => (1 + behind / Self::ITEMS, behind % Self::ITEMS),
        })
    }

    pub(super) fn get(&self, index: usize) -> Option<&T> {
        let (block, place) = self.place(index)?;
        self.blocks.get(block)?.get(place)
    }

    pub(super) fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        let (block, place) = self.place(index)?;
        self.blocks.get_mut(block)?.get_mut(place)
    }

    pub(super) fn front(&self) -> Option<&T> {
        self.blocks.front()?.front()
    }

    /// Items from the newest to the oldest.
    pub(super) fn newest(&self) -> impl Iterator<Item = &T> {
        self.blocks.iter().rev().flat_map(|block| block.iter().rev())
    }

    /// Bytes of the blocks, free places included.
    pub(super) fn bytes(&self) -> usize {
        let block = super::allocated(Self::ITEMS * size_of::<T>());
        self.blocks.len() * block + self.blocks.capacity() * size_of::<VecDeque<T>>()
    }
}

#[cfg(test)]
mod tests {
    use super::Blocks;
    use proptest::prelude::{prop_assert, prop_assert_eq, proptest};
    use std::collections::VecDeque;

    proptest! {
        #[test]
        fn it_is_a_deque(pushed in proptest::collection::vec((1_usize..1500, 0_usize..1500), 1..12)) {
            let (mut blocks, mut deque, mut next) = (Blocks::default(), VecDeque::new(), 0_u64);
            for (more, fewer) in pushed {
                for _ in 0..more {
                    blocks.push_back(next);
                    deque.push_back(next);
                    next += 1;
                }
                for _ in 0..fewer {
                    prop_assert_eq!(blocks.pop_front(), deque.pop_front());
                }
                prop_assert_eq!((blocks.len(), blocks.front()), (deque.len(), deque.front()));
                prop_assert!((0..=deque.len()).all(|index| blocks.get(index) == deque.get(index)));
                prop_assert!(blocks.newest().eq(deque.iter().rev()));
                let places = blocks.bytes() / 8;
                prop_assert!(places >= deque.len() && places < deque.len() + 2000, "{}", places);
            }
        }
    }
}
