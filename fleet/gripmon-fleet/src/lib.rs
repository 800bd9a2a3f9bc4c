//! A network of grippers in; a window with a table of all of them, and the ordinary view of the one that is opened, out.
//!
//! ```text
//! thread of the network -> ring -> pump -> Hall { Roster } -> views -> Vec<TableAction> -> Table -> Request
//! ```

pub mod cli;
pub mod grippers;
mod hall;
mod lobby;
mod opened;
mod pump;
pub mod source;
mod table;
pub mod views;
mod window;

pub use hall::Hall;
pub use lobby::{Lobby, Request};
pub use opened::{Lead, opened};
pub use pump::{FRAME, FleetPump};
pub use table::{Table, TableAction};
pub use window::run;
