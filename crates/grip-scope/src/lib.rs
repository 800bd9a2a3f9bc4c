//! Everything that a live scope shows of a daemon, a recording, a study or the simulator, without a window.
//!
//! ```text
//! source's thread -> Model -> views that take &Model
//! ```
//!
//! [`SourceHandle`] runs a source on a thread of its own. [`Model`] holds hours of history in bounded memory and never loses a spike
//! of one sample. [`Trigger`] finds what is worth stopping at, [`export`] writes what is seen.

pub mod channel;
mod damage;
mod derive;
pub mod explain;
pub mod export;
pub mod feed;
pub mod format;
pub mod model;
pub mod num;
pub mod report;
pub mod source;
mod span;
pub mod trigger;

pub use channel::Channel;
pub use feed::{EventKind, EventMark, Feed, SourceStatus};
pub use model::{Bucket, Info, Model, Series, Stats};
pub use source::{Refused, SourceHandle, SourceSpec};
pub use span::Span;
pub use trigger::Trigger;
