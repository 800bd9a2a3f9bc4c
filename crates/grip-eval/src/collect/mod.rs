//! Rows for a learner of the adequate force, from recordings of many grippers.
//!
//! A recording does not know the adequate force. It knows the force F1 of one finger at which an object began to slip, which was too little,
//! and the force F2 at which it then stayed for a stated time, which was enough. So
//!
//! ```text
//! kappa F1 <= adequate force <= kappa F2,    label = kappa sqrt(F1 F2)
//! ```
//!
//! and the label is off by `sqrt(F2 / F1)` at most, as far as the bounds hold. They hold for a load that does not change in between. What was
//! hit or pulled needs less than F1 afterwards; what stands is held by static friction, so F2 may lie below what would stop a slip, by the
//! ratio of both frictions at most. Neither acceleration nor an estimate goes into the label: a model that is trained on it does not learn
//! what another one has answered. What states too little is left out, and counted by its reason ([`Fate`]). How far labels of simulated
//! grasps are from the truth: `tests/collect.rs`, and `docs/results.md`.
//!
//! [`collect`] reads files, [`SlipWatch`] is the rule without any, [`divide`] keeps objects or grippers apart, [`Row::csv`] writes.

mod divide;
mod files;
mod origin;
mod read;
mod row;
mod watch;

pub use divide::{DivideError, Divided, Keep, divide};
pub use files::CollectError;
pub use origin::UNKNOWN;
pub use read::{Collected, Request, collect};
pub use row::{COLUMNS, Row};
pub use watch::{Fate, MeasuredSlip, SlipWatch, WatchConfig};
