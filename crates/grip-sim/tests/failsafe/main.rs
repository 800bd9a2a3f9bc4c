//! The failsafe rules R1 to R9 against the virtual microcontroller, in simulated time.
//!
//! | rule | against the virtual microcontroller | elsewhere |
//! |---|---|---|
//! | R1 never raise force without a fresh command | `commands::r1_*` | benches `daemon_faults` (SIGSTOP, noise); grip-link `force::force_keeps_its_bounds`, `session::degraded_host_keeps_the_force_it_sent_before`; fuzz targets `device`, `host` |
//! | R2 link loss: hold, at most the hold cap; open only if configured | `loss::r2_*` | benches `daemon_faults` (kill -9) |
//! | R3 ttl 20..=100 ms, then the loss action | `loss::r3_*` | grip-link `force::each_loss_action` |
//! | R4 limits live in the MCU; clamp and report; negative = reject | `commands::r4_*` | grip-link `session::forces_in_newtons_become_millinewtons` (NaN), `force::travel_end_stops_the_rise` |
//! | R5 passive at start; release is never implicit | `start::r5_*` | benches `daemon_faults` (reboot under the daemon) |
//! | R6 faults latch; an unknown fault is major | `faults::r6_*` | grip-link `force::every_fault_code_latches` |
//! | R7 no usable slip sensor left (stylus dead, frozen or saturated, and no other): hold and report | `faults::r7_*` | slip-core `pipeline::faults` (the reflex stops); benches `daemon_faults` |
//! | R8 object lost: torque off, never back by itself | `faults::r8_*` | |
//! | R9 watchdog fed only if control, link and sampling ran | `faults::r9_*` | grip-link `force::watchdog_needs_every_task` |
#![expect(clippy::unwrap_used, reason = "test code")]

mod commands;
mod faults;
mod loss;
mod rig;
mod start;
