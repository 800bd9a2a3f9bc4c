//! The link of the example comes up.

#[path = "../examples/handshake.rs"]
mod handshake;

#[test]
fn the_link_of_the_example_comes_up() {
    handshake::main();
}
