//! The example holds its object.

#[path = "../examples/grip.rs"]
mod grip;

#[test]
fn the_object_of_the_example_is_held() {
    grip::main().unwrap();
}
