//! tanh by itself, and forward passes of a 2-10-1 network.
#![expect(clippy::cast_possible_truncation, reason = "f32 is one of the formats compared")]

use super::{Candidate, Clock, Panel};
use crate::{
    exact::{Draw, Exact, exact, to_f64},
    networks,
};
use mlp::{tanh, train::Isa};

/// The two panels.
pub(super) fn panels(few: usize, clock: Clock<'_>) -> Vec<Panel> {
    let mut panels = vec![tanh_panel(4096 / few, clock)];
    panels.extend(forward(1000 / few, clock));
    panels
}

/// Error in units of the last place of the rounded value.
fn ulps(got: f32, wanted: &Exact) -> f64 {
    let wanted = to_f64(wanted);
    let rounded = (wanted as f32).abs();
    let unit = f32::from_bits(rounded.to_bits() + 1) - rounded;
    (f64::from(got) - wanted).abs() / f64::from(unit)
}

/// Replaces values by their tanh.
type Tanh = Box<dyn Fn(&mut [f32])>;

/// One number at a time, which the compiler joins to the vectors every machine has.
fn each(f: impl Fn(f32) -> f32 + 'static) -> Tanh {
    Box::new(move |values| values.iter_mut().for_each(|x| *x = f(*x)))
}

fn functions() -> Vec<(String, Tanh)> {
    let mut functions: Vec<(String, Tanh)> = vec![
        ("rational, a loop".to_owned(), each(tanh::rational)),
        ("exact, a loop".to_owned(), each(tanh::exact)),
        ("std f32".to_owned(), each(f32::tanh)),
        ("libm f64, rounded".to_owned(), each(|x| libm::tanh(f64::from(x)) as f32)),
    ];
    for isa in Isa::available() {
        functions.push((format!("rational, {isa}"), Box::new(move |values| isa.tanh(values))));
    }
    functions
}

fn tanh_panel(count: usize, clock: Clock<'_>) -> Panel {
    let mut draw = Draw::new(61);
    let inputs: Vec<f32> =
        (0..count).map(|_| (draw.sign() * draw.log(1e-3, 10.0)) as f32).collect();
    let wanted: Vec<Exact> = inputs.iter().map(|x| exact(f64::from(*x)).tanh()).collect();
    let inputs = &inputs;
    let candidates = functions()
        .into_iter()
        .map(|(name, run)| {
            let mut values = inputs.clone();
            run(&mut values);
            Candidate {
                name: name.into(),
                errors: values.iter().zip(&wanted).map(|(x, y)| ulps(*x, y)).collect(),
                work: Box::new(move || {
                    values.copy_from_slice(inputs);
                    run(&mut values);
                    f64::from(values[0]) + f64::from(values[count - 1])
                }),
            }
        })
        .collect();
    Panel {
        name: "tanh",
        title: "tanh: run time against error".to_owned(),
        item: "value",
        measure: "error (ulp of f32)",
        error: format!("units in the last place, {count} sizes from 1e-3 to 10, 67 digits"),
        rows: Vec::new(),
    }
    .measure(candidates, count, clock)
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

/// The first output of a pass that writes to a slice; NaN where it refuses.
fn slice<T: Copy + Default + Into<f64>, E>(pass: impl Fn(&mut [T]) -> Result<(), E>) -> f64 {
    let mut output = [T::default()];
    pass(&mut output).map_or(f64::NAN, |()| output[0].into())
}

fn forward(count: usize, clock: Clock<'_>) -> Option<Panel> {
    let network = networks::network(&[2, 10, 1]).ok()?;
    let mut draw = Draw::new(62);
    let inputs: Vec<[f32; 2]> = (0..count)
        .map(|_| [0, 1].map(|_| ((65_536.0 * draw.unit()).floor() / 32_768.0 - 1.0) as f32))
        .collect();
    let weights = networks::weights(41);
    let wanted: Vec<f64> = inputs.iter().map(|x| to_f64(&exact_forward(&weights, x))).collect();
    let scale = (wanted.iter().map(|y| y * y).sum::<f64>() / wanted.len() as f64).sqrt();
    type Pass<'a> = Box<dyn Fn(&[f32; 2]) -> f64 + 'a>;
    let passes: [(&'static str, Pass<'_>); 3] = [
        ("Network, rational tanh", Box::new(|x| slice(|y| network.forward(x, y)))),
        ("Network, exact tanh", Box::new(|x| slice(|y| network.forward_exact(x, y)))),
        ("Network, f64", Box::new(|x| slice(|y| network.forward_double(&x.map(f64::from), y)))),
    ];
    let inputs = &inputs;
    let candidates = passes
        .into_iter()
        .map(|(name, run)| Candidate {
            name: name.into(),
            errors: inputs.iter().zip(&wanted).map(|(x, y)| (run(x) - y).abs() / scale).collect(),
            work: Box::new(move || inputs.iter().map(&run).sum::<f64>()),
        })
        .collect();
    let panel = Panel {
        name: "forward_2_10_1",
        title: "Forward pass 2-10-1: run time against error".to_owned(),
        item: "pass",
        measure: "error relative to the rms output",
        error: format!("relative to the rms of the output, {count} inputs of 16 bits, 67 digits"),
        rows: Vec::new(),
    };
    Some(panel.measure(candidates, inputs.len(), clock))
}
