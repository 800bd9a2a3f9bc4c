//! The observer against the pipeline it is, and on readings that are none.

use super::Observer;
use crate::channel::Channel;
use crate::feed::DerivedBlock;
use core::ops::Range;
use grip_session::{HostConfig, model::default_estimator};
use proptest::prelude::{Strategy, any, prop_assert, prop_oneof, proptest};
use slip_core::Signal;
use slip_core::units::{Hertz, Micros};
use slip_core::{Pipeline, PipelineConfig, Sample};

const RATE_HZ: f32 = 10_000.0;

fn config() -> PipelineConfig {
    HostConfig::default().pipeline(Signal::Displacement, Hertz(RATE_HZ))
}

/// Noise at rest for a second, then an object that slides over a surface for a tenth.
fn slide() -> Vec<Sample> {
    let mut state = 1_u64;
    let mut noise = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        f32::from(u16::try_from(state >> 48).unwrap()) / 65_536.0 - 0.5
    };
    (0..11_000_u16)
        .map(|k| {
            let t = Micros(100 * u64::from(k));
            let sliding_s = f32::from(k.saturating_sub(10_000)) / RATE_HZ;
            let position_m = 0.05 * sliding_s;
            let wave = 5e-6 * (core::f32::consts::TAU * position_m / 2e-4).sin();
            Sample {
                normal_force_n: Some(3.0),
                travel_m: Some((1e6 * position_m).round() / 1e6),
                ..Sample::stylus(t, wave + 3e-7 * noise())
            }
        })
        .collect()
}

fn derive(samples: &[Sample]) -> DerivedBlock {
    let mut observer = Observer::new(config(), default_estimator().unwrap()).unwrap();
    for sample in samples {
        observer.push(sample, &[]);
    }
    observer.take()
}

/// Values of a channel in a span of time (s).
fn values(block: &DerivedBlock, channel: Channel, span: &Range<f64>) -> Vec<Option<f32>> {
    let of = block.values.iter().filter(|of| of.channel == channel);
    of.filter(|of| span.contains(&of.t_s)).map(|of| of.value).collect()
}

#[test]
fn a_slide_passes_the_interval_and_rest_is_milliseconds() {
    let block = derive(&slide());
    let [rest, slides] = &[0.0..1.0, 1.021..2.0];
    let evidence = |span| values(&block, Channel::OwnStatistic, span);
    assert!(evidence(rest).len() > 200 && evidence(slides).len() > 15);
    let interval_s = config().detector.interval_s;
    assert!(evidence(rest).iter().flatten().all(|evidence_s| (0.0..0.1).contains(evidence_s)));
    assert!(evidence(slides).iter().all(|evidence_s| *evidence_s >= Some(interval_s)));
    assert!(values(&block, Channel::Band1, slides).iter().all(|energy| *energy > Some(10.0)));
    let first = values(&block, Channel::Band0, rest)[0].unwrap();
    assert!(first.is_nan(), "the floor is not known at the start");
}

#[test]
fn peaks_are_found_at_their_times_and_heights() {
    let block = derive(&slide());
    let peaks: Vec<_> = block.turns.iter().filter(|turn| turn.is_peak && turn.t_s > 1.0).collect();
    // 5 mm of a wave of 0.2 mm at 50 mm/s: a peak every 4 ms.
    assert!((22..=26).contains(&peaks.len()), "{}", peaks.len());
    for pair in peaks.windows(2) {
        assert!((pair[1].t_s - pair[0].t_s - 4e-3).abs() < 8e-4, "{pair:?}");
        assert!((pair[0].height - 5e-6).abs() < 1e-6, "{pair:?}");
    }
}

#[test]
fn evidence_holds_its_own_value_and_what_the_network_states_of_it() {
    let block = derive(&slide());
    let curves = [
        Channel::OwnEsc,
        Channel::EscLow,
        Channel::EscHigh,
        Channel::OwnEstimate,
        Channel::EstimateLow,
        Channel::EstimateHigh,
        Channel::SlipSpeed,
        Channel::SlipSpeedSigma,
    ];
    let curves = curves.map(|channel| values(&block, channel, &(0.0..2.0)));
    let points = (0..curves[0].len()).map(|k| curves.each_ref().map(|curve| curve[k]));
    let known: Vec<_> = points.filter(|p| p[0].is_some() && p[3].is_some()).collect();
    assert!(known.len() > 20, "{}", known.len());
    for point in known {
        let [esc, esc_low, esc_high, estimate, low, high, speed, sigma] = point.map(Option::unwrap);
        assert!(esc_low <= esc && esc <= esc_high, "{point:?}");
        assert!(0.0 < low && low <= estimate && estimate <= high, "{point:?}");
        assert!((speed - 0.05).abs() < 0.01 && sigma > 0.0, "{point:?}");
    }
}

#[test]
fn the_observer_states_what_the_pipeline_states() {
    let mut observer = Observer::new(config(), default_estimator().unwrap()).unwrap();
    let bare = PipelineConfig { grip: None, ..config() };
    let mut pipeline = Pipeline::new(bare, Some(default_estimator().unwrap())).unwrap();
    for sample in slide() {
        let (seen, step) = (observer.push(&sample, &[]).unwrap(), pipeline.handle(&sample));
        assert_eq!(seen.event, step.event);
        assert_eq!(seen.features, step.features);
        assert_eq!(seen.estimate, step.estimate);
    }
}

fn reading() -> impl Strategy<Value = f32> {
    let bad = vec![f32::NAN, f32::INFINITY, 1e30, -1e30, 0.0, f32::MIN_POSITIVE];
    prop_oneof![4 => -1e-5_f32..1e-5, 1 => proptest::sample::select(bad), 1 => any::<f32>()]
}

proptest! {
    #![proptest_config(proptest::test_runner::Config::with_cases(40))]

    #[test]
    fn nothing_that_a_sensor_sends_breaks_it(
        rows in proptest::collection::vec((reading(), reading(), reading(), 0_u64..400), 1..3000),
        rate_hz in 100_u32..20_000,
    ) {
        let rate = rate_hz as f32;
        let config = HostConfig::default().pipeline(Signal::Displacement, Hertz(rate));
        let mut observer = Observer::new(config, default_estimator().unwrap())
            .unwrap_or_else(|_| Observer::spectra_only(rate));
        let mut t = 1_000_000;
        for (stylus, force, travel, step) in rows {
            t += step;
            let sample = Sample {
                normal_force_n: Some(force),
                travel_m: Some(travel),
                ..Sample::stylus(Micros(t), stylus)
            };
            observer.push(&sample, &[stylus; 16]);
        }
        let block = observer.take();
        prop_assert!(block.turns.iter().all(|turn| turn.height.is_finite()));
        prop_assert!(block.values.is_sorted_by_key(|value| value.t_s));
        prop_assert!(block.spectra.iter().all(|column| column.span[0] <= column.span[1]));
    }
}

#[test]
fn a_break_is_reported_with_the_first_that_is_behind_it() {
    let mut observer = Observer::new(config(), default_estimator().unwrap()).unwrap();
    let samples = slide();
    samples[..4000].iter().for_each(|sample| {
        observer.push(sample, &[]);
    });
    assert!(!observer.take().broken);
    observer.interrupt();
    let nothing = observer.take();
    assert!(nothing.broken && nothing.values.is_empty());
    samples[4500..5000].iter().for_each(|sample| {
        observer.push(sample, &[]);
    });
    let behind = observer.take();
    assert!(behind.broken && !behind.values.is_empty());
    samples[5000..5500].iter().for_each(|sample| {
        observer.push(sample, &[]);
    });
    assert!(!observer.take().broken);
}
