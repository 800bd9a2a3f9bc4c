//! Streams that begin in the middle of a slip or of motion, and rates that carry nothing but motion.

use slip_core::{
    Pipeline, PipelineConfig, Sample, Signal, SlipReport, Step,
    alarm::Method,
    detector::FloorHealth,
    units::{Hertz, Micros},
};

type Bare = Pipeline<&'static [f32]>;

/// White noise of deviation 1, seeded: the sum of twelve uniform numbers.
fn noise(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        let mut sum = -6.0;
        for _ in 0..12 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += f64::from(state) / f64::from(u32::MAX);
        }
        sum as f32
    }
}

/// Steps of `seconds` of a vibration whose deviation is `level` at a time (s), with the travel (m) that `travel` gives.
fn play(
    rate_hz: f32,
    seconds: f32,
    level: impl Fn(f32) -> f32,
    travel: impl Fn(f32) -> Option<f32>,
) -> Vec<Step> {
    let config = PipelineConfig::observing(Signal::Vibration, Hertz(rate_hz));
    let (mut pipeline, mut noise) = (Bare::new(config, None).unwrap(), noise(11));
    let steps = (0..(seconds * rate_hz) as u32).map(|i| {
        let t_s = i as f32 / rate_hz;
        let t = Micros((1e6 * f64::from(i) / f64::from(rate_hz)) as u64);
        let sample = Sample::stylus(t, level(t_s) * noise());
        pipeline.handle(&Sample { travel_m: travel(t_s), ..sample })
    });
    steps.collect()
}

fn slips(steps: &[Step]) -> Vec<(f64, Method)> {
    let first = |step: &Step| match step.event {
        Some(SlipReport { first: true, method, .. }) => Some((step.t.as_seconds(), method)),
        _ => None,
    };
    steps.iter().filter_map(first).collect()
}

/// What slides over a surface: louder and quieter by a factor of 3 within tenths of a second.
fn sliding(t_s: f32) -> f32 {
    (1.1 * (0.6 * (19.0 * t_s).sin() + 0.4 * (7.3 * t_s).sin())).exp()
}

#[test]
fn a_slip_from_the_first_sample_on_is_reported_by_the_travel_and_teaches_no_floor() {
    for rate in [1000.0, 10_000.0] {
        let level = |t: f32| if t < 0.7 { 20.0 } else { 1.0 };
        let travel = |t: f32| Some(0.02 * t.min(0.7));
        let steps = play(rate, 3.0, level, travel);
        let slips_seen = slips(&steps);
        assert!(
            slips_seen[0].0 < 0.05 && slips_seen[0].1 == Method::Travel,
            "at {rate} Hz: {slips_seen:?}"
        );
        assert_eq!(slips_seen.len(), 1, "at {rate} Hz: {slips_seen:?}");
        // The floor is that of the rest after it: a slip a tenth as strong is felt.
        let again = |t: f32| {
            if t < 0.7 {
                20.0
            } else if t < 2.0 {
                1.0
            } else {
                6.0
            }
        };
        let slips_seen = slips(&play(rate, 3.0, again, travel));
        assert!(
            slips_seen.len() == 2 && slips_seen[1].1 == Method::Stylus,
            "at {rate} Hz: {slips_seen:?}"
        );
        assert!((2.0..2.05).contains(&slips_seen[1].0), "at {rate} Hz: {slips_seen:?}");
    }
}

#[test]
fn sliding_from_the_first_sample_on_is_doubted_until_rest_comes() {
    for unit in [1e-6, 1.0, 1e6] {
        let level = |t: f32| unit * if t < 6.0 { 30.0 * sliding(t) } else { 1.0 };
        let steps = play(1000.0, 14.0, level, |_| None);
        let doubted = |step: &Step| step.floor_health == FloorHealth::Doubtful;
        let stated = steps.iter().position(doubted).unwrap();
        assert!(stated < 2500, "times {unit}: {stated}");
        assert!(steps[stated..7000].iter().all(doubted), "times {unit}");
        assert!(!doubted(steps.last().unwrap()), "times {unit}: it rests");
    }
}

#[test]
fn rest_is_never_doubted_whatever_its_rate() {
    for rate in [100.0, 333.0, 1000.0, 2200.0, 10_000.0] {
        let steps = play(rate, 60.0, |_| 1.0, |_| None);
        assert!(steps.iter().all(|step| step.floor_health == FloorHealth::Good), "at {rate} Hz");
        assert_eq!(slips(&steps), [], "at {rate} Hz");
    }
}

#[test]
fn noise_alone_is_no_slip_at_the_rates_of_taxels_and_imus() {
    for rate in [20.0, 40.0, 62.0, 70.0, 100.0, 200.0, 500.0] {
        let slips_seen = slips(&play(rate, 1200.0, |_| 1.0, |_| None));
        assert_eq!(slips_seen, [], "at {rate} Hz");
    }
}

#[test]
fn a_slip_at_rest_is_still_reported_at_low_rates() {
    for (rate, within_s) in [(70.0, 0.2), (100.0, 0.15), (200.0, 0.1), (500.0, 0.05)] {
        let level = |t: f32| if t < 20.0 { 1.0 } else { 8.0 };
        let slips_seen = slips(&play(rate, 21.0, level, |_| None));
        assert!(
            slips_seen.len() == 1 && (20.0..20.0 + within_s).contains(&slips_seen[0].0),
            "{rate}: {slips_seen:?}"
        );
    }
}

#[test]
fn at_40_hz_motion_is_no_slip_and_three_times_its_level_is() {
    let motion = |t: f32| if (t / 2.3) as u32 % 3 == 1 { 5.0 } else { 1.0 };
    for unit in [1.0_f32, 1.0 / 9.81, 1e-6] {
        let quiet = slips(&play(40.0, 600.0, |t| unit * motion(t), |_| None));
        assert_eq!(quiet, [], "times {unit}");
        let slip = |t: f32| unit * if (300.0..302.0).contains(&t) { 15.0 } else { motion(t) };
        let slips_seen = slips(&play(40.0, 600.0, slip, |_| None));
        assert!(
            slips_seen.len() == 1 && (300.0..302.0).contains(&slips_seen[0].0),
            "times {unit}: {slips_seen:?}"
        );
    }
    let steps = play(40.0, 20.0, |_| 1.0, |_| None);
    assert_eq!(steps[200].floor_health, FloorHealth::Doubtful, "no motion was seen yet");
    assert_eq!(steps[600].floor_health, FloorHealth::Good);
}
