//! Comparisons of learners on training data: the study of the four nets, and what lies beyond them.
//!
//! ```text
//! grip_sim rows -> Condition::sets -> a learner -> Sets::score -> a Report: JSON, one page, figures
//! ```
//! [`study`] trains the four nets of the source study and three more under every [`Condition`] and measures how far each is
//! from the published figures. Any other learner is scored on the same rows:
//!
//! ```
//! use grip_study::Condition;
//!
//! let condition = Condition::named("paper").ok_or("no such condition")?;
//! let sets = condition.sets(1, 0)?;
//! // A learner that always answers 10 N.
//! let scores = sets.score(|_features| 10.0);
//! assert!(scores.unseen.within_10pct() < 0.5);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//! Nothing here reads a clock or a file; randomness comes from seeds, and the number of threads changes no result.

pub mod chapter;
pub mod condition;
pub mod error;
pub mod outlook;
pub mod score;
pub mod sets;
pub mod study;

pub use condition::{Condition, Features};
pub use error::StudyError;
pub use grip_plot::report;
pub use report::{Cell, Figure, Report, Section, Table};
pub use score::{Score, Tolerance, score};
pub use sets::{Scores, Sets};
pub use study::{Study, StudyConfig};
