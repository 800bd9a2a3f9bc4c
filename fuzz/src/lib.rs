//! Arbitrary bytes in; a panic where the link breaks one of its promises.
//!
//! The targets are ordinary functions: `cargo fuzz` calls them with what it invents, `cargo test -p grip-link` with the files
//! under `seeds`, on a stable compiler.

pub mod targets;
