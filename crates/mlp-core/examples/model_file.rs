//! The estimate of a model file for values of its inputs:
//! `cargo run -p mlp-core --features file --example model_file -- MODEL.json VALUE...`
#![expect(clippy::print_stdout, reason = "what it is for")]

use core::error::Error;
use mlp_core::file::ModelFile;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = env::args().skip(1);
    let file = arguments.next().ok_or("MODEL.json is missing")?;
    let values = arguments.map(|value| value.parse()).collect::<Result<Vec<f32>, _>>()?;
    let file = ModelFile::from_json(&fs::read_to_string(file)?)?;
    let names: Vec<_> = file.inputs.iter().map(|input| input.name.as_str()).collect();
    if names.len() != values.len() {
        return Err(format!("the inputs are {}", names.join(", ")).into());
    }
    let estimate = file.model()?.estimate(&values)?;
    let note = if estimate.extrapolated { ", extrapolated" } else { "" };
    println!("{} {} {}{note}", file.targets[0].name, estimate.value, file.targets[0].unit);
    Ok(())
}
