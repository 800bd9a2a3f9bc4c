//! gripd
fn main() {}
