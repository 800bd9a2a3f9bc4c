//! The compiler's calls for sums and products of f32, answered by [`slip_rp2040::float`].
//!
//! These names belong to the run-time ABI of Arm; those of the compiler are weak.

use slip_rp2040::float::{add, mul};

// SAFETY: the name and the signature are those of the ABI, and no other crate of this image has them.
#[unsafe(no_mangle)]
extern "aapcs" fn __aeabi_fadd(a: f32, b: f32) -> f32 {
    f32::from_bits(add(a.to_bits(), b.to_bits()))
}

// SAFETY: as above.
#[unsafe(no_mangle)]
extern "aapcs" fn __aeabi_fsub(a: f32, b: f32) -> f32 {
    f32::from_bits(add(a.to_bits(), b.to_bits() ^ 0x8000_0000))
}

// SAFETY: as above.
#[unsafe(no_mangle)]
extern "aapcs" fn __aeabi_fmul(a: f32, b: f32) -> f32 {
    f32::from_bits(mul(a.to_bits(), b.to_bits()))
}
