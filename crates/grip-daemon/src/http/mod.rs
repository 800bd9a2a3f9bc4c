//! HTTP/1.1 server with one answer to a connection: as much of the protocol as a scraper and one page need.
//!
//! Sans-IO, but for [`HttpServer`]. GET and HEAD of a path; every answer states `Connection: close`. Sources: RFC 9110 (methods,
//! status codes), RFC 9112 (request line, field lines).

mod exchange;
mod request;
mod server;

pub use exchange::{Exchange, Limits};
pub use request::{Content, Page, Parsed, Refusal, parse};
pub use server::{HttpServer, Interest, ServeError};
