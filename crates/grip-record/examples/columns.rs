//! A recording in, what it holds out: `cargo run -p grip-record --example columns -- FILE.csv`
#![expect(clippy::print_stdout, reason = "what it is for")]

use core::error::Error;
use grip_record::{Channel, CsvOptions, read_recording};
use std::{env, path::PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let file = PathBuf::from(env::args_os().nth(1).ok_or("FILE.csv is missing")?);
    let recording = read_recording(&file, &CsvOptions::default())?;
    println!("{} samples at {} Hz", recording.samples.len(), recording.rate_hz);
    println!("stylus: {:?}", recording.channels.stylus);
    println!("normal force: {}", recording.channels.has(Channel::NormalForce));
    let notes = recording.notes.to_string();
    if !notes.is_empty() {
        println!("{notes}");
    }
    Ok(())
}
