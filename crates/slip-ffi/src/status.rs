//! What a call led to, and its sentence.

use core::ffi::CStr;

/// What a call led to.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipStatus {
    /// Done.
    Ok = 0,
    /// A pointer is NULL that must not be.
    Null = 1,
    /// A pointer is not aligned to its type.
    Align = 2,
    /// The memory is too small, or a count is too large.
    Size = 3,
    /// There is no pipeline: never created, copied, or destroyed.
    NotCreated = 4,
    /// The options do not fit; slip_create() writes why.
    Options = 5,
    /// A text is not UTF-8.
    Text = 6,
    /// A value is outside its range.
    Value = 7,
    /// There is no value: no irregularity, or a number that is not finite.
    NoValue = 8,
    /// The library has failed within; this pipeline is of no more use.
    Panicked = 9,
}

/// The sentences by number.
const SENTENCES: [&CStr; 10] = [
    c"done",
    c"a pointer is NULL that must not be",
    c"a pointer is not aligned to its type",
    c"the memory is too small, or a count is too large",
    c"there is no pipeline at this address: never created, copied, or destroyed",
    c"the options do not fit",
    c"a text is not UTF-8",
    c"a value is outside its range",
    c"there is no value: no irregularity, or a number that is not finite",
    c"the library has failed within; destroy nothing and create this pipeline again",
];

/// The sentence for `status`.
pub(crate) fn sentence(status: i32) -> &'static CStr {
    let place = usize::try_from(status).ok();
    place.and_then(|place| SENTENCES.get(place)).copied().unwrap_or(c"no status of this library")
}
