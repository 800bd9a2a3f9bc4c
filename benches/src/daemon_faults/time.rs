//! The clock of the fault run: a daemon lives in real time, and so do its gripper and whoever kills it.

use core::time::Duration;
use std::time::Instant;

/// Now.
#[expect(clippy::disallowed_methods, reason = "a real daemon lives in real time")]
pub(super) fn now() -> Instant {
    Instant::now()
}

/// Waits.
#[expect(clippy::disallowed_methods, reason = "a real daemon lives in real time")]
pub(super) fn wait_ms(ms: u64) {
    std::thread::sleep(Duration::from_millis(ms));
}

/// Asks every 2 ms until `done` or `patience_s` is over; whether it was done.
pub(super) fn until(patience_s: u64, mut done: impl FnMut() -> bool) -> bool {
    let end = now() + Duration::from_secs(patience_s);
    loop {
        if done() {
            return true;
        }
        if now() >= end {
            return false;
        }
        wait_ms(2);
    }
}

/// Waits.
#[expect(clippy::disallowed_methods, reason = "a real daemon lives in real time")]
pub(super) fn wait_us(us: u64) {
    std::thread::sleep(Duration::from_micros(us));
}
