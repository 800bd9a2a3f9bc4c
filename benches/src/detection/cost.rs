//! Warm detectors and samples in, the time each takes for a sample out.

use super::trials::Alarm;
use crate::accuracy::Clock;
use core::hint::black_box;
use slip_core::Sample;

/// Time per sample (ns) of each of `warm`, copied anew for each round: the shortest of `rounds` in turns, so that a busy moment
/// strikes all of them.
pub fn cost<A: Alarm + Clone>(
    warm: &[A],
    samples: &[Sample],
    rounds: u32,
    clock: Clock<'_>,
) -> Vec<f64> {
    let mut shortest = vec![f64::INFINITY; warm.len()];
    for _ in 0..rounds {
        for (alarm, shortest) in warm.iter().zip(&mut shortest) {
            let mut alarm = alarm.clone();
            let start = clock();
            let alarms = samples.iter().filter(|sample| alarm.step(sample)).count();
            let ns = (clock() - start) / samples.len() as f64;
            black_box(alarms);
            *shortest = shortest.min(ns);
        }
    }
    shortest
}
