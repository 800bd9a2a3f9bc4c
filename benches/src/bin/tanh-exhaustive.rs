//! Check of each single-precision tanh over every `f32` in [-12, 12]: its largest error; fails where a bound is broken.
//!
//! `cargo run --release -p slip-benches --bin tanh-exhaustive [EVERY]`: 2.19e9 arguments, a minute or two a core, or one chunk of EVERY chunks. The reference is
//! the `f64` tanh of the platform's C library, which shares nothing with ours.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::process::ExitCode;

use mlp::{tanh, train::Isa};
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};

/// Arguments handled together.
const CHUNK: usize = 4096;

/// A way to replace values by their tanh, with its name and its bound.
type Way = (String, f64, Box<dyn Fn(&mut [f32]) + Sync>);

/// Worst values of one way.
#[derive(Clone, Copy, Default)]
struct Seen {
    ulp: f64,
    at: f32,
    /// Largest fall between two neighbours.
    fall: f32,
    /// Beyond 1, or not odd.
    wrong: bool,
}

impl Seen {
    fn join(self, other: Self) -> Self {
        let worse = if other.ulp > self.ulp { other } else { self };
        Self { fall: self.fall.max(other.fall), wrong: self.wrong || other.wrong, ..worse }
    }
}

fn ways() -> Vec<Way> {
    let each = |f: fn(f32) -> f32| move |xs: &mut [f32]| xs.iter_mut().for_each(|x| *x = f(*x));
    let mut ways: Vec<Way> = vec![
        ("rational".to_owned(), 3.5, Box::new(each(tanh::rational))),
        ("exact".to_owned(), 0.501, Box::new(each(tanh::exact))),
    ];
    for isa in Isa::available() {
        ways.push((format!("rational, {isa}"), 3.5, Box::new(move |xs| isa.tanh(xs))));
    }
    ways
}

/// Looks at `CHUNK` neighbours from the bits `first` on.
fn look((_, _, tanh): &Way, first: u32, references: &[f64]) -> Seen {
    let mut seen = Seen::default();
    let mut up: Vec<f32> = (first..).take(references.len()).map(f32::from_bits).collect();
    let mut down: Vec<f32> = up.iter().map(|x| -x).collect();
    tanh(&mut up);
    tanh(&mut down);
    let mut last = 0.0;
    for (((bits, &y), &z), &reference) in (first..).zip(&up).zip(&down).zip(references) {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the unit is that of the rounded value"
        )]
        let rounded = reference as f32;
        let unit = f64::from(f32::from_bits(rounded.to_bits() + 1) - rounded);
        let ulp = (f64::from(y) - reference).abs() / unit;
        let wrong = !(0.0..=1.0).contains(&y) || z.to_bits() != (-y).to_bits();
        seen = seen.join(Seen { ulp, at: f32::from_bits(bits), fall: last - y, wrong });
        last = y;
    }
    seen
}

fn main() -> ExitCode {
    let every = match std::env::args().nth(1).map(|text| text.parse::<usize>()) {
        None => 1,
        Some(Ok(every @ 1..=1000)) => every,
        Some(_) => {
            eprintln!("tanh-exhaustive [EVERY]: one chunk of EVERY chunks, 1 to 1000");
            return ExitCode::from(2);
        }
    };
    let ways = ways();
    let end = 12_f32.to_bits();
    let chunks: Vec<u32> = (0..=end).step_by(CHUNK * every).collect();
    let chunk = |first: &u32| {
        let arguments = (*first..=end).take(CHUNK);
        let references: Vec<f64> =
            arguments.map(|bits| f64::from(f32::from_bits(bits)).tanh()).collect();
        ways.iter().map(|way| look(way, *first, &references)).collect::<Vec<_>>()
    };
    let join = |all: Vec<Seen>, more: Vec<Seen>| {
        all.into_iter().zip(more).map(|(one, other)| one.join(other)).collect()
    };
    let all = chunks.par_iter().map(chunk).reduce(|| vec![Seen::default(); ways.len()], join);
    let mut kept = true;
    println!("| tanh | largest error (ulp) | at | largest fall | |");
    for ((name, bound, _), Seen { ulp, at, fall, wrong }) in ways.iter().zip(all) {
        let good = ulp <= *bound && !wrong && fall < 5e-7;
        kept &= good;
        let word = if good { "kept" } else { "BROKEN" };
        println!("| {name} | {ulp:.4} | {at} | {fall:.1e} | bound {bound} {word} |");
    }
    if kept { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
