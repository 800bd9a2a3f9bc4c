//! A scene in; the samples of one grasp, in which the object slips as it is lifted and is caught, out.

use anyhow::Context as _;
use grip_sim::Scene;
use grip_sim::grasp::Grasp;
use grip_sim::scene::load;
use slip_core::{Sample, units::Micros};

/// Samples a second.
pub(crate) const RATE_HZ: u32 = 1000;
/// Samples of a tape: seven seconds.
pub(crate) const LENGTH: u32 = 7 * RATE_HZ;

/// The grasp of a seed, from closing fingers to the object held.
pub(crate) fn record(seed: u64) -> anyhow::Result<Vec<Sample>> {
    let scene: Scene = load("default")?.reseeded(seed)?;
    let mut grasp = Grasp::new(&scene);
    grasp.set_sample_rate(RATE_HZ);
    let mut since_slip = None;
    let mut tape = Vec::new();
    for k in 0..LENGTH {
        let truth = grasp.truth();
        if truth.slipping && truth.lifted() {
            since_slip.get_or_insert(k);
        }
        // Too little for a lift, and enough some milliseconds after it began to slip.
        let force_n = match since_slip {
            Some(begun) if k > begun + 60 => 1.4 * truth.force_needed_n,
            _ => 0.5 * truth.force_needed_n,
        };
        tape.push(grasp.step_sample(force_n));
    }
    since_slip.context("nothing has slipped")?;
    Ok(tape)
}

/// The sample of a tape that is played again and again, at its time since the start.
pub(crate) fn sample(tape: &[Sample], number: u64) -> Option<Sample> {
    let length = u64::try_from(tape.len()).ok().filter(|length| *length > 0)?;
    let place = usize::try_from(number % length).ok()?;
    let t = Micros((number + 1) * 1_000_000 / u64::from(RATE_HZ));
    tape.get(place).map(|sample| Sample { t, ..*sample })
}
