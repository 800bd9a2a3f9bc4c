//! The detector of the board on this computer: it prints the slips, one a line, of each FILE of 16-bit
//! little-endian codes of the converter (or, after `--adxl345`, steps of that sensor).
//!
//! `cargo run --release --example host -- [--adxl345] FILE...`
#![expect(clippy::print_stdout, reason = "a program for the check")]

use slip_rp2040::{
    detector::{Detector, centred},
    notice,
    sensor::{ADXL345, PIEZO},
};
use std::{env, fs, io};

fn main() -> Result<(), io::Error> {
    let mut acceleration = false;
    for file in env::args().skip(1) {
        if file == "--adxl345" {
            acceleration = true;
            continue;
        }
        let mut detector = Detector::new(if acceleration { &ADXL345 } else { &PIEZO })
            .map_err(io::Error::other)?;
        let bytes = fs::read(&file)?;
        for (index, code) in (0..).zip(bytes.chunks_exact(2)) {
            let code = [code[0], code[1]];
            let value = if acceleration {
                i16::from_le_bytes(code)
            } else {
                centred(u16::from_le_bytes(code))
            };
            let sample = detector.reading(index, value);
            if let Some(slip) = sample.and_then(|sample| detector.sample(&sample)) {
                println!("{}", notice::line(&slip).text());
            }
        }
        println!("end of {file}");
    }
    Ok(())
}
