//! Rows of data in, learners beyond one net trained by one rule out, compared on the same rows.
//!
//! | module | learner |
//! |---|---|
//! | [`search`](mod@search) | the net whose shape, activation, trainer and weight decay a genetic algorithm chose |
//! | [`svr`] | support vector regression with a Gaussian kernel |
//! | [`ensemble`] | several nets from other starts or other rows; their spread is an uncertainty |
//! | [`learners`](mod@learners) | all of them, and plain nets with every activation and trainer |
//!
//! [`compare`](mod@compare) puts them side by side on given rows, [`chapter`](mod@chapter) under conditions of the study.
//!
//! Everything is seeded: equal rows and settings give equal results on any number of threads.

pub mod chapter;
pub mod compare;
pub mod ensemble;
pub mod genome;
pub mod learners;
pub mod score;
pub mod search;
pub mod svr;
#[cfg(test)]
mod testing;

pub use chapter::chapter;
pub use compare::{Comparison, Sets, compare};
pub use ensemble::{Ensemble, EnsembleConfig, Sampling};
pub use genome::Genome;
pub use learners::{Learner, LearnersConfig, learners};
pub use score::{OutlookError, Predict, Score, Spread, answers, score};
pub use search::{Candidate, Search, SearchConfig, search};
pub use svr::{Svr, SvrConfig};
