//! Our side of `scripts/network-peers.sh`: writes the data for the other libraries, then prints our times, one a line:
//! `NAME<tab>VALUE<tab>UNIT`; its argument is the folder for the data. Each value is the least of several rounds,
//! because the machine may be busy.

use core::{error::Error, hint::black_box};
use std::{env, fs, path::Path};

use mlp::train::{
    Algorithm, Isa, NetworkObjective, Objective as _, Real,
    trainer::{LevenbergMarquardtConfig, RpropConfig, ScgConfig},
};
use slip_benches::{
    networks,
    peers::{Case, building, kinematics, surface},
    time,
};

/// Least time of a call in `rounds` rounds of `calls` (s).
fn least(rounds: usize, calls: u32, mut call: impl FnMut()) -> f64 {
    let round = |call: &mut dyn FnMut()| {
        let start = time::now();
        for _ in 0..calls {
            call();
        }
        start.elapsed().as_secs_f64() / f64::from(calls)
    };
    (0..rounds).map(|_| round(&mut call)).fold(f64::INFINITY, f64::min)
}

#[expect(clippy::print_stdout, reason = "the script reads these lines")]
fn print(name: &str, value: f64, unit: &str) {
    println!("{name}\t{value:.4}\t{unit}");
}

fn epochs<T: Real>(case: &Case, isa: Isa, epochs: u32) -> Result<(), Box<dyn Error>> {
    let mut objective =
        NetworkObjective::<T>::with_isa(&case.topology, &case.inputs, &case.targets, isa)?;
    let start: Vec<T> = case.weights.iter().map(|&weight| T::of(weight)).collect();
    let rules = [
        ("rprop", Algorithm::Rprop(RpropConfig::default())),
        ("scg", Algorithm::Scg(ScgConfig::default())),
        ("lm", Algorithm::Lm(LevenbergMarquardtConfig::default())),
    ];
    for (name, algorithm) in rules {
        let mut gradients = 0;
        let mut total = 0_u32;
        // A step of lm costs a hundred of the others on the larger net.
        let epochs = if name == "lm" { (epochs / 50).max(1) } else { epochs };
        let seconds = least(9, 1, || {
            let mut trainer = algorithm.trainer::<T>(start.len());
            let mut weights = start.clone();
            for _ in 0..epochs {
                gradients +=
                    black_box(trainer.step(&mut objective, &mut weights)).gradient_evaluations;
            }
            total += epochs;
        });
        let name = format!("{name} {} {} {isa}", case.name, T::NAME);
        print(&name, seconds / f64::from(epochs) * 1e6, "us/epoch");
        if name.starts_with("scg") {
            print(&format!("{name} gradients"), gradients as f64 / f64::from(total), "1/epoch");
        }
    }
    let mut gradient = start.clone();
    let seconds = least(9, epochs, || {
        black_box(objective.gradient(black_box(&start), &mut gradient));
    });
    print(&format!("gradient {} {} {isa}", case.name, T::NAME), seconds * 1e6, "us");
    Ok(())
}

fn forward() -> Result<(), Box<dyn Error>> {
    for sizes in [&[2, 10, 1][..], &[16, 32, 16, 1]] {
        let network = networks::network(sizes)?;
        let name: Vec<String> = sizes.iter().map(ToString::to_string).collect();
        let mut input = vec![0.25; network.inputs()];
        let pass = |input: &Vec<f32>| {
            let mut output = [0.0];
            // Lengths fit; an error would leave the output at zero.
            black_box(network.forward(input, &mut output).is_ok());
            output[0]
        };
        time_forward(&name.join("-"), &mut input, pass);
    }
    Ok(())
}

/// Short rounds, so that on a busy machine some are not interrupted.
fn time_forward<I: AsMut<[f32]>>(name: &str, input: &mut I, pass: impl Fn(&I) -> f32) {
    let seconds = least(3000, 400, || {
        black_box(pass(black_box(input)));
    });
    print(&format!("forward {name} throughput"), seconds * 1e9, "ns");
    let seconds = least(3000, 400, || {
        let output = pass(input);
        input.as_mut()[0] = output * 0.5;
    });
    print(&format!("forward {name} latency"), seconds * 1e9, "ns");
}

fn write(case: &Case, directory: &Path) -> Result<(), Box<dyn Error>> {
    fs::write(directory.join(format!("{}.data", case.name)), case.fann())?;
    let text = case.by_neuron(&case.weights);
    Ok(fs::write(directory.join(format!("{}.weights", case.name)), text)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let cases = [(surface()?, 2000), (building()?, 60), (kinematics()?, 60)];
    let directory =
        env::args_os().nth(1).ok_or("the folder for the data of the others is missing")?;
    for (case, count) in &cases {
        write(case, Path::new(&directory))?;
        for isa in Isa::available() {
            epochs::<f32>(case, isa, *count)?;
            epochs::<f64>(case, isa, *count)?;
        }
    }
    forward()
}
