//! A finger of 16 capacitive taxels over boards with ridges at a known speed, 35.6 samples per second.

use crate::{name, recordings};
use grip_eval::profile::{ProfileOptions, evaluate};
use grip_record::{CsvOptions, HeightProfile, read_csv};
use std::path::Path;

/// The sum of all taxels as a profile (in counts, not metres) along the way moved.
fn pressed(file: &Path, speed_m_s: f64) -> HeightProfile {
    let mut heights_m: Vec<f64> = Vec::new();
    for taxel in 1..=16 {
        let map = vec![("vibration".to_owned(), format!("channel{taxel}"))];
        let recording =
            read_csv(file, &CsvOptions { rate_hz: Some(35.6), map, ..CsvOptions::default() })
                .unwrap();
        heights_m.resize(recording.samples.len(), 0.0);
        heights_m.iter_mut().zip(&recording.samples).for_each(|(h, s)| *h += f64::from(s.stylus));
    }
    HeightProfile::new(heights_m, speed_m_s / 35.6)
}

/// The strongest wave below twice the nominal period, which is what a person would choose as cutoff.
#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn the_period_of_a_board_follows_from_the_speed() {
    println!("run: period (mm), over the nominal one; mean spacing of n irregularities (mm)");
    let mut off = Vec::new();
    let files = recordings("fabricslide", ".csv");
    for file in &files {
        let name = name(file);
        let nominal_m = if name.starts_with("Board2mm") { 4.0e-3 } else { 19.0e-3 };
        let speed = name.split("_V-").nth(1).unwrap().split("mmps").next().unwrap();
        let speed_m_s = 1e-3 * speed.parse::<f64>().unwrap();
        let cutoff_m = 2.0 * nominal_m;
        let options =
            ProfileOptions { low_pass_m: nominal_m / 4.0, ..ProfileOptions::new(cutoff_m) };
        let evaluation = evaluate(&pressed(file, speed_m_s), &options).unwrap();
        let period_m = evaluation.period_m.unwrap();
        let spacings = evaluation.irregularities.iter().map(|i| f64::from(i.spacing_m));
        let n = spacings.len();
        println!(
            "{name}: {:.3}, {:+.1} %; {:.2} of {n}",
            1e3 * period_m,
            100.0 * (period_m / nominal_m - 1.0),
            1e3 * spacings.sum::<f64>() / n as f64
        );
        if (period_m / nominal_m - 1.0).abs() > 0.05 {
            off.push(name);
        }
    }
    assert!(off.len() * 18 <= files.len(), "beyond 5 %: {off:?}");
}
