//! Conversion of pointers of C to checked ones and values.

use crate::SlipStatus;
use core::{
    ffi::{CStr, c_char},
    panic::AssertUnwindSafe,
};
use std::panic::catch_unwind;

/// The status of `work`; a panic in it ends here.
pub(crate) fn guarded(work: impl FnOnce() -> Result<(), SlipStatus>) -> SlipStatus {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => SlipStatus::Ok,
        Ok(Err(status)) => status,
        Err(_) => SlipStatus::Panicked,
    }
}

/// The same pointer, where it can point to a `T`.
pub(crate) fn place<T>(pointer: *mut T) -> Result<*mut T, SlipStatus> {
    if pointer.is_null() {
        Err(SlipStatus::Null)
    } else if !pointer.is_aligned() {
        Err(SlipStatus::Align)
    } else {
        Ok(pointer)
    }
}

/// A text, where there is one.
///
/// # Safety
/// `text` is null or ends with a zero byte, and outlives what is made of it.
pub(crate) unsafe fn text<'a>(text: *const c_char) -> Result<Option<&'a str>, SlipStatus> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: as this function asks for.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map(Some).map_err(|_| SlipStatus::Text)
}

/// Writes `text` and a zero byte, as much of it as `size` bytes hold.
///
/// # Safety
/// `to` is null or has room for `size` bytes.
pub(crate) unsafe fn copy_text(text: &str, to: *mut c_char, size: usize) {
    if to.is_null() || size == 0 {
        return;
    }
    let length = text.floor_char_boundary(size - 1);
    // SAFETY: `length` is below `size`, which the caller has room for.
    unsafe { to.copy_from_nonoverlapping(text.as_ptr().cast(), length) };
    // SAFETY: still below `size`.
    unsafe { to.add(length).write(0) };
}

/// Values of one channel, row by row, or none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column<T>(*const T);

impl<T: Copy> Column<T> {
    /// `values` values at `pointer`, which may be null.
    pub(crate) fn new(pointer: *const T, values: usize) -> Result<Self, SlipStatus> {
        if values > isize::MAX.unsigned_abs() / size_of::<T>() {
            return Err(SlipStatus::Size);
        }
        if pointer.is_aligned() { Ok(Self(pointer)) } else { Err(SlipStatus::Align) }
    }

    /// Where it has values.
    pub(crate) fn start(self) -> Option<*const T> {
        (!self.0.is_null()).then_some(self.0)
    }

    /// The value of row `row`, where there are values.
    ///
    /// # Safety
    /// `row` is below the number of values.
    pub(crate) unsafe fn at(self, row: usize) -> Option<T> {
        // SAFETY: aligned, and by the caller's word within the values.
        self.start().map(|start| unsafe { start.add(row).read() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_status() {
        assert_eq!(guarded(|| panic!("within")), SlipStatus::Panicked);
        assert_eq!(guarded(|| Err(SlipStatus::Value)), SlipStatus::Value);
        assert_eq!(guarded(|| Ok(())), SlipStatus::Ok);
    }
}
