//! tanh by itself, and forward passes of a 2-10-1 network.

use super::{Candidate, Clock, Panel};
use crate::{
    exact::{Exact, exact, pool::Draw, relative_error},
    networks,
};
use mlp::Activation;

const INPUTS: usize = 4096;

/// The two panels.
pub(super) fn panels(clock: Clock<'_>) -> Vec<Panel> {
    let mut panels = vec![tanh(clock)];
    panels.extend(forward(clock));
    panels
}

#[expect(clippy::cast_possible_truncation, reason = "inputs of a network are f32")]
fn tanh(clock: Clock<'_>) -> Panel {
    let mut draw = Draw::new(61);
    let inputs: Vec<f32> =
        (0..INPUTS).map(|_| (draw.sign() * draw.log(1e-3, 10.0)) as f32).collect();
    let wanted: Vec<Exact> = inputs.iter().map(|x| exact(f64::from(*x)).tanh()).collect();
    type Function = fn(f32) -> f32;
    let functions: [(&'static str, Function); 3] = [
        ("mlp forward pass", |x| Activation::Tanh.value(x)),
        ("std f32", f32::tanh),
        ("libm f64, rounded", |x| libm::tanh(f64::from(x)) as f32),
    ];
    let candidates = functions.map(|(name, run)| Candidate {
        name,
        errors: inputs
            .iter()
            .zip(&wanted)
            .map(|(x, y)| relative_error(f64::from(run(*x)), y))
            .collect(),
        work: {
            let inputs = &inputs;
            Box::new(move || f64::from(inputs.iter().map(|x| run(*x)).sum::<f32>()))
        },
    });
    Panel {
        name: "tanh",
        title: "tanh: run time against error".to_owned(),
        item: "value",
        error: format!("relative, {INPUTS} sizes from 1e-3 to 10, 67 digits"),
        rows: Vec::new(),
    }
    .measure(candidates.into(), INPUTS, clock)
}

/// The 2-10-1 network in exact numbers; weights as [`mlp::Network`] orders them.
fn exact_forward(weights: &[f32], input: &[f32; 2]) -> Exact {
    let at = |i: usize| exact(weights.get(i).copied().map_or(0.0, f64::from));
    let [x, y] = input.map(|v| exact(f64::from(v)));
    (0..10).fold(at(40), |sum, row| {
        let hidden = at(2 * row) * &x + at(2 * row + 1) * &y + at(20 + row);
        sum + at(30 + row) * hidden.tanh()
    })
}

#[expect(clippy::cast_possible_truncation, reason = "inputs of a network are f32")]
fn forward(clock: Clock<'_>) -> Option<Panel> {
    let (small, network) = (networks::small().ok()?, networks::network(&[2, 10, 1]).ok()?);
    let mut draw = Draw::new(62);
    let inputs: Vec<[f32; 2]> =
        (0..1000).map(|_| [0, 1].map(|_| (2.0 * draw.unit() - 1.0) as f32)).collect();
    let weights = networks::weights(41);
    let wanted: Vec<f64> =
        inputs.iter().map(|x| crate::exact::to_f64(&exact_forward(&weights, x))).collect();
    let scale = (wanted.iter().map(|y| y * y).sum::<f64>() / wanted.len() as f64).sqrt();
    type Pass<'a> = Box<dyn Fn(&[f32; 2]) -> f32 + 'a>;
    let passes: [(&'static str, Pass<'_>); 2] = [
        ("Mlp, sizes known", Box::new(|x| small.forward(x)[0])),
        (
            "Network",
            Box::new(|x| {
                let mut y = [f32::NAN];
                let done = network.forward(x, &mut y);
                if done.is_ok() { y[0] } else { f32::NAN }
            }),
        ),
    ];
    let inputs = &inputs;
    let candidates = passes
        .into_iter()
        .map(|(name, run)| Candidate {
            name,
            errors: inputs
                .iter()
                .zip(&wanted)
                .map(|(x, y)| (f64::from(run(x)) - y).abs() / scale)
                .collect(),
            work: Box::new(move || f64::from(inputs.iter().map(&run).sum::<f32>())),
        })
        .collect();
    let panel = Panel {
        name: "forward_2_10_1",
        title: "Forward pass 2-10-1: run time against error".to_owned(),
        item: "pass",
        error: "relative to the rms of the output, 1000 inputs, 67 digits".to_owned(),
        rows: Vec::new(),
    };
    Some(panel.measure(candidates, inputs.len(), clock))
}
