//! Rank correlation of each reading of E_sc with the energy that a simulated stylus turns into heat.
//!
//! `esc-readings [SURFACES]`: stylus of 1 g on 500 N/m, damping ratio 0.1, one-sided contact of 1e5 N/m, on surfaces of
//! Ra 0.2-50 um at 1-300 mm/s, trial force 0.2-20 N, 2 mm of slip. A ride is airborne when the tip is out of contact for
//! more than a tenth of the way.
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use grip_sim::{
    stylus::{Stylus, StylusConfig},
    surface::{Surface, mean_spacing},
};
use rayon::prelude::*;
use slip_benches::exact::pool::Draw;
use slip_core::esc::{EscSums, Reading, Trial};

const TRAVEL_M: f64 = 2e-3;
const PRELOAD_M: f64 = 200e-6;

struct Ride {
    dissipated_j: f64,
    airborne: bool,
    values: [f64; 5],
}

fn main() {
    let surfaces = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(4000_u64);
    let rides: Vec<Ride> = (0..surfaces).into_par_iter().filter_map(ride).collect();
    println!("{} rides, {} airborne", rides.len(), rides.iter().filter(|r| r.airborne).count());
    println!("rank correlation with the dissipated energy: all / in contact / airborne");
    for (i, reading) in Reading::ALL.into_iter().enumerate() {
        let correlation = |wanted: fn(&Ride) -> bool| {
            let (values, energies): (Vec<f64>, Vec<f64>) = rides
                .iter()
                .filter(|ride| wanted(ride))
                .map(|r| (r.values[i], r.dissipated_j))
                .unzip();
            pearson(&ranks(&values), &ranks(&energies))
        };
        println!(
            "{:14} {:5.2} / {:5.2} / {:5.2}",
            reading.name(),
            correlation(|_| true),
            correlation(|r| !r.airborne),
            correlation(|r| r.airborne)
        );
    }
}

fn ride(seed: u64) -> Option<Ride> {
    let mut draw = Draw::new(seed);
    let ra_m = draw.log(0.2e-6, 50e-6);
    let deviate = (0..12).map(|_| draw.unit()).sum::<f64>() - 6.0;
    let mut surface = Surface::new(ra_m, mean_spacing(ra_m, deviate), seed);
    let (speed, force) = (draw.log(1e-3, 0.3), draw.log(0.2, 20.0));
    let shortest = surface.within(TRAVEL_M).map(|a| a.spacing_m).fold(TRAVEL_M, f64::min);
    // Forty steps an irregularity, and never longer than a tenth of the contact's own period.
    let dt = (shortest / speed / 40.0).min(1e-5);
    let mut stylus = Stylus::new(StylusConfig::default(), dt);
    (0..20_000).for_each(|_| stylus.step(PRELOAD_M));
    let start = stylus.dissipated_j();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "some millions at most"
    )]
    let steps = (TRAVEL_M / speed / dt) as u64;
    let mut in_air = 0_u64;
    for k in 0..steps {
        #[expect(clippy::cast_precision_loss, reason = "some millions at most")]
        let level = PRELOAD_M + surface.height(k as f64 * dt * speed);
        stylus.step(level);
        in_air += u64::from(stylus.displacement_m() > level);
    }
    let mut sums = EscSums::default();
    surface.within(TRAVEL_M).for_each(|a| _ = sums.push(a.delta_m, a.spacing_m));
    let trial = Trial::new(force, speed);
    let mut values = [0.0; 5];
    for (value, reading) in values.iter_mut().zip(Reading::ALL) {
        // The sign of a tangent shows nothing of an energy.
        *value = sums.value(reading, &trial)?.value.abs();
    }
    let dissipated_j = stylus.dissipated_j() - start;
    Some(Ride { dissipated_j, airborne: in_air * 10 > steps, values })
}

fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    for (rank, i) in order.into_iter().enumerate() {
        ranks[i] = rank as f64;
    }
    ranks
}

fn pearson(a: &[f64], b: &[f64]) -> f64 {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let pairs = a.iter().zip(b);
    let (mut both, mut square_a, mut square_b) = (0.0, 0.0, 0.0);
    for (x, y) in pairs {
        both += (x - mean_a) * (y - mean_b);
        square_a += (x - mean_a).powi(2);
        square_b += (y - mean_b).powi(2);
    }
    both / (square_a * square_b).sqrt()
}
