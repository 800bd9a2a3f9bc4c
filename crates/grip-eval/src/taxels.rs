//! Readings of the taxels in frames of stillness.

use grip_record::{Channel, Recording};
use grip_session::calibration::TaxelRest;
use slip_core::pressure::{MAX_TAXELS, PatternRest, PressureConfig, Standing};

/// Takes the frames of `recording` whose samples rest by `rests` while the grip force stands, and counts their samples.
pub(crate) fn push_rest(
    meter: &mut PatternRest<MAX_TAXELS>,
    recording: &Recording,
    rests: impl Fn(usize) -> bool,
) -> u64 {
    let Some(taxels) = &recording.taxels else { return 0 };
    let mut standing = Standing::default();
    let mut samples = 0;
    meter.start();
    for (index, sample) in recording.samples.iter().enumerate() {
        if standing.step(sample.t, sample.normal_force_n) && rests(index) {
            meter.push(sample.t, taxels.frame(index));
            samples += 1;
        } else {
            meter.start();
        }
    }
    samples
}

/// What the taxels of `recording` show where it does not move; `None` without taxels, and without a grip force, which shows
/// fingers that close from an object that is held.
pub(crate) fn at_rest(
    recording: &Recording,
    config: &PressureConfig,
    moving: &[bool],
) -> Option<TaxelRest> {
    Some(held(recording, config, moving)?.0).filter(|taxels| taxels.rms > 0.0)
}

/// What the taxels show while the grip force stands and nothing moves, and in how many samples. `None` without a grip force.
pub(crate) fn held(
    recording: &Recording,
    config: &PressureConfig,
    moving: &[bool],
) -> Option<(TaxelRest, u64)> {
    if recording.taxels.is_none() || !recording.channels.has(Channel::NormalForce) {
        return None;
    }
    let mut meter = PatternRest::new(config.follow_ms);
    let samples = push_rest(&mut meter, recording, |index| moving.get(index) == Some(&false));
    let rms = meter.rms(config.threshold).unwrap_or(0.0);
    Some((TaxelRest { rms, range: meter.range() }, samples))
}

#[cfg(test)]
mod tests {
    use super::at_rest;
    use core::fmt::Write as _;
    use grip_record::{CsvOptions, parse_csv};
    use slip_core::pressure::PressureConfig;

    /// 100 frames a second of four taxels: 3 s open, 1 s in which the fingers close, 6 s held.
    fn grasp(force: bool) -> String {
        let mut text = format!(
            "t_s,stylus{},pressure_0,pressure_1,pressure_2,pressure_3\n",
            if force { ",force_n" } else { "" }
        );
        let mut state = 7_u32;
        for i in 0..1000_u32 {
            let closed = (f64::from(i) / 100.0 - 3.0).clamp(0.0, 1.0);
            let mut noise = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state) / f64::from(u32::MAX) - 0.5
            };
            write!(text, "{},0", f64::from(i) / 100.0).unwrap();
            if force {
                write!(text, ",{}", 5.0 * closed).unwrap();
            }
            for taxel in [1.0, 4.0, 2.0, 0.5] {
                write!(text, ",{}", 20.0 + 50.0 * taxel * closed * closed + noise()).unwrap();
            }
            text.push('\n');
        }
        text
    }

    #[test]
    fn what_closing_fingers_show_is_no_rest() {
        let read = |force| {
            parse_csv("a.csv".as_ref(), grasp(force).as_bytes(), &CsvOptions::default()).unwrap()
        };
        let config = PressureConfig::default();
        let still = vec![false; 1000];
        let rest = at_rest(&read(true), &config, &still).unwrap();
        let range = rest.range.unwrap();
        assert!((0.1..1.0).contains(&rest.rms) && (0.2..2.0).contains(&range), "{rest:?}");
        assert_eq!(at_rest(&read(false), &config, &still), None, "nobody knows when they close");
        assert_eq!(at_rest(&read(true), &config, &[true; 1000]), None, "all of it is motion");
    }
}
