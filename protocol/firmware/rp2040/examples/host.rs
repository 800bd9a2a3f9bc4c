//! The detector of the board on this computer: 16-bit little-endian codes of each FILE in, its slips out, one a line.
//!
//! `cargo run --release --example host -- FILE...`
#![expect(clippy::print_stdout, reason = "a program for the check")]

use slip_rp2040::{detector::Detector, notice};
use std::{env, fs, io};

fn main() -> Result<(), io::Error> {
    for file in env::args().skip(1) {
        let mut detector = Detector::new().map_err(io::Error::other)?;
        let bytes = fs::read(&file)?;
        for (index, code) in (0..).zip(bytes.chunks_exact(2)) {
            let code = u16::from_le_bytes([code[0], code[1]]);
            let sample = detector.reading(index, code);
            if let Some(slip) = sample.and_then(|sample| detector.sample(&sample)) {
                println!("{}", notice::line(&slip).text());
            }
        }
        println!("end of {file}");
    }
    Ok(())
}
