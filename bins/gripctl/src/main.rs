//! gripctl
fn main() {}
