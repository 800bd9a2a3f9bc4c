//! The embedded model of the host as constants: ranges and weights out of its JSON text.

use std::{env, fs, path::Path};

/// Numbers that follow `key` in the text, one for each time it occurs.
fn after(text: &str, key: &str) -> Vec<f32> {
    text.split(key).skip(1).filter_map(|rest| numbers(rest).next()).collect()
}

fn numbers(text: &str) -> impl Iterator<Item = f32> + '_ {
    text.split(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)))
        .filter(|word| word.contains(|c: char| c.is_ascii_digit()))
        .filter_map(|word| word.parse().ok())
}

fn main() {
    let model = Path::new("../../crates/grip-session/models/default.json");
    println!("cargo:rerun-if-changed={}", model.display());
    println!("cargo:rerun-if-changed=memory.x");
    let text = fs::read_to_string(model).expect("the embedded model");
    let (ranges, layers) = text.split_once("\"layers\"").expect("layers");
    let (low, high) = (after(ranges, "\"min\":"), after(ranges, "\"max\":"));
    assert_eq!((low.len(), high.len()), (3, 3), "two inputs and a target");
    // 2-10-1: weights, then biases, layer by layer.
    let weights: Vec<f32> = numbers(layers).take(41).collect();
    assert_eq!(weights.len(), 41);
    let out = format!(
        "/// Smallest and largest acceleration, force and adequate force.\npub const RANGES: [[f32; 2]; 3] = [[{:?}, {:?}], [{:?}, {:?}], [{:?}, {:?}]];\n\
         /// Weights and biases, 2-10-1.\npub static WEIGHTS: [f32; 41] = {weights:?};\n",
        low[0], high[0], low[1], high[1], low[2], high[2]
    );
    let folder = env::var("OUT_DIR").expect("OUT_DIR");
    fs::write(Path::new(&folder).join("embedded.rs"), out).expect("write");
    println!("cargo:rustc-link-search={}", env::var("CARGO_MANIFEST_DIR").expect("manifest"));
}
