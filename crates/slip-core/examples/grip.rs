//! A control loop at 1 kHz: each sample leads to a force. The gripper is a toy whose object slips until it is held by 5 N:
//! `cargo run -p slip-core --example grip`.
#![expect(clippy::print_stdout, reason = "what it is for")]

use slip_core::{Pipeline, PipelineConfig, Sample, units::Hertz, units::Micros};

pub(crate) fn main() -> Result<(), slip_core::ConfigError> {
    let mut pipeline = Pipeline::<[f32; 0]>::new(PipelineConfig::gripping(Hertz(1000.0)), None)?;
    let (mut applied_n, mut travel_m, mut command_n) = (0.0_f32, 0.0_f32, 0.0);
    let mut bits = 1_u32;
    let mut noise = || {
        bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f32::from(bits.to_be_bytes()[0]) / 128.0 - 1.0
    };
    for ms in 0..5000 {
        applied_n += 0.1 * (command_n - applied_n); // a drive with a lag of 10 ms
        let slides = ms > 1500 && applied_n < 5.0;
        travel_m += if slides { 10e-6 } else { 0.0 };
        let sample = Sample {
            normal_force_n: Some(applied_n + 0.002 * noise()),
            travel_m: Some(travel_m),
            ..Sample::stylus(Micros(1000 * ms), noise() * if slides { 5e-6 } else { 5e-8 })
        };
        let step = pipeline.handle(&sample);
        if let Some(slip) = step.event {
            println!("{ms} ms: slip ({}), command {command_n:.2} N", slip.phase);
        }
        command_n = step.command.map_or(0.0, |command| command.0);
    }
    println!("held with {applied_n:.2} N, moved {:.2} mm", 1e3 * travel_m);
    assert!(applied_n >= 5.0 && travel_m > 0.0, "the object was not held");
    Ok(())
}
