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

/// Replaces values by their tanh.
type Tanh = Box<dyn Fn(&mut [f32]) + Sync>;

/// One way to compute tanh, its bound and what was seen of it.
struct Way {
    name: String,
    bound: f64,
    tanh: Tanh,
}

/// Worst values of one way.
#[derive(Clone, Copy, Default)]
struct Seen {
    ulp: f64,
    at: f32,
    /// Largest fall between two neighbours.
    fall: f32,
    beyond_one: bool,
    not_odd: bool,
}

impl Seen {
    fn join(self, other: Self) -> Self {
        let worse = if other.ulp > self.ulp { other } else { self };
        Self {
            ulp: worse.ulp,
            at: worse.at,
            fall: self.fall.max(other.fall),
            beyond_one: self.beyond_one || other.beyond_one,
            not_odd: self.not_odd || other.not_odd,
        }
    }
}

fn ways() -> Vec<Way> {
    let each = |f: fn(f32) -> f32| move |xs: &mut [f32]| xs.iter_mut().for_each(|x| *x = f(*x));
    let mut ways = vec![
        Way { name: "rational".to_owned(), bound: 3.5, tanh: Box::new(each(tanh::rational)) },
        Way { name: "exact".to_owned(), bound: 0.501, tanh: Box::new(each(tanh::exact)) },
    ];
    for isa in Isa::available() {
        let name = format!("rational, {isa}");
        ways.push(Way { name, bound: 3.5, tanh: Box::new(move |xs| isa.tanh(xs)) });
    }
    ways
}

/// Looks at `CHUNK` neighbours from the bits `first` on.
fn look(way: &Way, first: u32, references: &[f64]) -> Seen {
    let mut seen = Seen::default();
    let mut up: Vec<f32> = (first..).take(references.len()).map(f32::from_bits).collect();
    let mut down: Vec<f32> = up.iter().map(|x| -x).collect();
    (way.tanh)(&mut up);
    (way.tanh)(&mut down);
    let mut last = 0.0;
    for (((bits, &y), &z), &reference) in (first..).zip(&up).zip(&down).zip(references) {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "the unit is that of the rounded value"
        )]
        let rounded = reference as f32;
        let unit = f64::from(f32::from_bits(rounded.to_bits() + 1) - rounded);
        let ulp = (f64::from(y) - reference).abs() / unit;
        if ulp > seen.ulp {
            (seen.ulp, seen.at) = (ulp, f32::from_bits(bits));
        }
        seen.fall = seen.fall.max(last - y);
        seen.beyond_one |= !(0.0..=1.0).contains(&y);
        seen.not_odd |= z.to_bits() != (-y).to_bits();
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
    for (way, seen) in ways.iter().zip(all) {
        let good = seen.ulp <= way.bound && !seen.beyond_one && !seen.not_odd && seen.fall < 5e-7;
        kept &= good;
        let word = if good { "kept" } else { "BROKEN" };
        println!(
            "| {} | {:.4} | {} | {:.1e} | bound {} {word} |",
            way.name, seen.ulp, seen.at, seen.fall, way.bound
        );
    }
    if kept { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
