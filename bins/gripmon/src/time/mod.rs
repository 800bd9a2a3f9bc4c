//! What part of the time axis is seen: pure arithmetic on spans of seconds, no window.

mod ticks;
mod window;

pub use ticks::{Ticks, decades, label, number, ticks};
pub use window::{Following, TimeWindow};
