//! Configuration files that must be accepted or refused, as people write them.

mod documented;
mod files;
mod layering;
