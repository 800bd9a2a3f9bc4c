//! What a firmware calls, as exported functions: linked without std and alloc.
//!
//! Every function stands for one call of a firmware's loop, so that the check can state from which of them a
//! panic can be reached. Nothing here is ever run.
#![no_std]
#![expect(unsafe_code, reason = "exported names, so that the linker keeps the functions")]

#[cfg(feature = "with-alloc")]
extern crate alloc;
#[cfg(feature = "with-std")]
extern crate std;

mod link;
mod network;
mod pipeline;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
