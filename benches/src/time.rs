//! The clock of what lives in real time: a daemon, its gripper and whoever measures or kills it; and the machine it runs on.

use core::time::Duration;
use std::{fs, time::Instant};

/// Now.
#[must_use]
#[expect(clippy::disallowed_methods, reason = "a real daemon lives in real time")]
pub fn now() -> Instant {
    Instant::now()
}

/// Nanoseconds since now.
pub fn clock() -> impl Fn() -> u64 + Sync {
    let start = now();
    move || u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX)
}

/// Waits.
pub fn wait_ms(ms: u64) {
    wait_us(1000 * ms);
}

/// Waits.
#[expect(clippy::disallowed_methods, reason = "a real daemon lives in real time")]
pub fn wait_us(us: u64) {
    std::thread::sleep(Duration::from_micros(us));
}

/// Asks every 2 ms until `done` or `patience_s` is over; whether it was done.
pub fn until(patience_s: u64, mut done: impl FnMut() -> bool) -> bool {
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

/// The processor's name and how busy the machine is.
#[must_use]
pub fn machine() -> String {
    let text = |file| fs::read_to_string(file).unwrap_or_default();
    let (processors, load) = (text("/proc/cpuinfo"), text("/proc/loadavg"));
    let name =
        processors.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let name = name.map_or("unknown", |(_, name)| name);
    format!("{name}, load {}", load.split_whitespace().take(3).collect::<Vec<_>>().join(" "))
}
