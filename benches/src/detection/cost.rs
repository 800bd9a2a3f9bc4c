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

#[cfg(test)]
mod tests {
    use super::cost;
    use crate::detection::{Hand, Peer, RobotConfig};
    use core::cell::Cell;

    #[test]
    fn the_shortest_round_counts() {
        let mut hand = Hand::new(RobotConfig::default(), 1.6, 1);
        let samples: Vec<_> = (0..100).map(|_| hand.sample()).collect();
        let now = Cell::new(0.0);
        let round = Cell::new(0.0);
        // Each look at the clock advances it by 1000 ns in the first round, by 500, 333, ... ns later.
        let clock = || {
            round.set(round.get() + 0.5);
            now.set(now.get() + 1000.0 / f64::ceil(round.get()));
            now.get()
        };
        let ns = cost(&[Peer::single(1e4, 1.0)], &samples, 4, &clock);
        assert!((ns[0] - 1000.0 / 4.0 / 100.0).abs() < 1e-9, "{ns:?}");
    }
}
