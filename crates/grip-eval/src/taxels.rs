//! Frames of rest in, what the taxels show there out.

use grip_record::{Channel, Recording};
use grip_session::calibration::TaxelRest;
use slip_core::pressure::{MAX_TAXELS, PatternRest, PressureConfig, Standing};

/// Takes the frames of `recording` for whose samples `rests` says so and the grip force stands.
pub(crate) fn push_rest(
    meter: &mut PatternRest<MAX_TAXELS>,
    recording: &Recording,
    rests: impl Fn(usize) -> bool,
) {
    let Some(taxels) = &recording.taxels else { return };
    let mut standing = Standing::default();
    meter.start();
    for (index, sample) in recording.samples.iter().enumerate() {
        if standing.step(sample.t, sample.normal_force_n) && rests(index) {
            meter.push(sample.t, taxels.frame(index));
        } else {
            meter.start();
        }
    }
}

/// What the taxels of `recording` show where it does not move; `None` without taxels, and without a grip force, which tells
/// fingers that close from an object that is held.
pub(crate) fn at_rest(
    recording: &Recording,
    config: &PressureConfig,
    moving: &[bool],
) -> Option<TaxelRest> {
    if !recording.channels.has(Channel::NormalForce) {
        return None;
    }
    let mut meter = PatternRest::new(config.follow_ms);
    push_rest(&mut meter, recording, |index| moving.get(index) == Some(&false));
    let rms = meter.rms(config.threshold).filter(|rms| *rms > 0.0)?;
    Some(TaxelRest { rms, range: meter.range() })
}
