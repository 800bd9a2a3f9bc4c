//! A hot function by name in; that function, run a number of times that is printed, for a program that counts its instructions.
//!
//! `instructions CASE` works within `measured`, and prepares outside of it. `instructions` alone lists the cases. `scripts/instructions.sh` counts them
//! and compares them with `benches/instructions.toml`.
#![expect(clippy::print_stdout, reason = "a program that prints a list")]

use core::hint::black_box;
use std::process::ExitCode;

use anyhow::{Result, bail};
use grip_link::{
    decoder::{Decoder, Role, Verdict},
    frame::MAX_WIRE,
};
use mlp::train::{Algorithm, NetworkObjective, trainer::RpropConfig};
use slip_benches::{
    frames::{self, ROWS, SESSION},
    networks, peers,
    scenes::{STRETCH, SceneRun},
};
use slip_core::{
    esc::{EscSums, Reading, Trial},
    sample::Scene,
};

const CASES: [&str; 12] = [
    "idle",
    "closing",
    "holding",
    "slipping",
    "slipping, no skip",
    "slipping, stylus alone",
    "frame of samples read",
    "command written",
    "estimate 2-10-1",
    "forward pass 16-32-16-1",
    "E_sc of a surface",
    "epoch of RPROP, building1",
];

/// Frames, passes and sums of a case.
const TIMES: u16 = 1000;
const EPOCHS: usize = 3;

fn main() -> ExitCode {
    let mut names = std::env::args().skip(1);
    let Some(name) = names.next() else {
        CASES.iter().for_each(|name| println!("{name}"));
        return ExitCode::SUCCESS;
    };
    match run(&name) {
        Ok(times) => {
            println!("{times}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("instructions: {error}");
            ExitCode::from(2)
        }
    }
}

/// What is counted.
#[inline(never)]
fn measured<T>(work: impl FnOnce() -> T) -> T {
    work()
}

/// Runs a case; how many samples, frames, passes or epochs that were.
fn run(name: &str) -> Result<usize> {
    match name {
        "idle" => Ok(samples(&SceneRun::new(Scene::Idle, false)?)),
        "closing" => Ok(samples(&SceneRun::new(Scene::Moving, false)?)),
        "holding" => Ok(samples(&SceneRun::new(Scene::Holding, false)?)),
        "slipping" => Ok(samples(&SceneRun::new(Scene::Slipping, false)?)),
        "slipping, no skip" => Ok(samples(&SceneRun::new(Scene::Slipping, true)?)),
        "slipping, stylus alone" => Ok(samples(&SceneRun::stylus_alone()?)),
        "frame of samples read" => frames_read(),
        "command written" => {
            let mut out = [0; MAX_WIRE];
            times(|| {
                black_box(frames::grip(black_box(500), black_box(12_345), &mut out)?);
                Ok(())
            })
        }
        "estimate 2-10-1" => {
            let model = networks::model()?;
            times(|| {
                black_box(black_box(&model).estimate(black_box(&[3.0, 2.0]))?);
                Ok(())
            })
        }
        "forward pass 16-32-16-1" => {
            let (network, mut output) = (networks::network(&[16, 32, 16, 1])?, [0.0]);
            times(|| {
                black_box(&network).forward(black_box(&[0.25; 16]), black_box(&mut output))?;
                Ok(())
            })
        }
        "E_sc of a surface" => {
            let trial = Trial::new(3.0, 0.05);
            times(|| {
                let mut sums = EscSums::default();
                for i in 1..=64_u16 {
                    sums.push(1e-6 * f64::from(i), 1e-4 + 1e-6 * f64::from(i % 7));
                }
                black_box(sums.value(Reading::Literal, black_box(&trial)));
                Ok(())
            })
        }
        "epoch of RPROP, building1" => {
            let case = peers::building()?;
            let mut objective =
                NetworkObjective::<f32>::new(&case.topology, &case.inputs, &case.targets)?;
            #[expect(clippy::cast_possible_truncation, reason = "weights of a bench")]
            let mut weights: Vec<f32> = case.weights.iter().map(|&weight| weight as f32).collect();
            let mut trainer =
                Algorithm::Rprop(RpropConfig::default()).trainer::<f32>(weights.len());
            measured(|| {
                for _ in 0..EPOCHS {
                    black_box(trainer.step(&mut objective, &mut weights));
                }
            });
            Ok(EPOCHS)
        }
        _ => bail!("no case is called {name:?}"),
    }
}

fn times(mut work: impl FnMut() -> Result<()>) -> Result<usize> {
    measured(|| (0..TIMES).try_for_each(|_| work()))?;
    Ok(usize::from(TIMES))
}

fn samples(run: &SceneRun) -> usize {
    let mut pipeline = run.pipeline.clone();
    measured(|| {
        for sample in &run.samples {
            black_box(&pipeline.handle(black_box(sample)));
        }
    });
    STRETCH
}

fn frames_read() -> Result<usize> {
    let wire = frames::samples(TIMES, ROWS)?;
    let mut decoder = Decoder::new(Role::Host);
    decoder.open_session(SESSION, None);
    let mut bad = 0;
    measured(|| {
        for frame in &wire {
            let mut input = black_box(frame.as_slice());
            while let Some(verdict) = decoder.next(&mut input) {
                bad += usize::from(!matches!(verdict, Verdict::Frame(_)));
            }
        }
    });
    if bad > 0 {
        bail!("{bad} of {} frames were refused", wire.len());
    }
    Ok(wire.len())
}
