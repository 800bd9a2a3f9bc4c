//! How deep the stack has been.

use core::ptr;

const MARK: u32 = 0x5AFE_57AC;
const WORDS: usize = 4096;
/// Below the present frame, so that nothing in use is painted over.
const MARGIN: usize = 64;

fn here() -> *mut u32 {
    let mut probe = 0_u32;
    ptr::from_mut(core::hint::black_box(&mut probe))
}

/// Marks the free stack below.
#[inline(never)]
pub fn paint() {
    let top = here();
    for word in MARGIN..WORDS {
        // SAFETY: the stack has megabytes of free RAM below it, and nothing else lies there.
        unsafe { top.sub(word).write_volatile(MARK) }
    }
}

/// Bytes of stack below the caller that were used since [`paint`].
#[inline(never)]
pub fn used() -> u32 {
    let top = here();
    let mut deepest = 0;
    for word in MARGIN..WORDS - MARGIN {
        // SAFETY: as in `paint`.
        if unsafe { top.sub(word).read_volatile() } != MARK {
            deepest = word;
        }
    }
    u32::try_from(deepest * 4).unwrap_or(u32::MAX)
}
