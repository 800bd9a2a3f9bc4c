//! Window for a network of grippers: a table of all of them, and the ordinary view of the one that is opened.
//!
//! ```text
//! thread of the network -> Hall { Roster } -> views, Table -> Request
//! ```

pub mod cli;
pub mod grippers;
mod hall;
mod lobby;
mod opened;
pub mod source;
mod table;
mod views;
mod window;

pub use hall::{FRAME, Hall};
pub use lobby::{Lobby, Request};
pub use opened::{Lead, opened};
pub use table::Table;
pub use window::run;
