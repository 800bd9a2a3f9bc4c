//! A taxel array without noise, in whole counts, beside a vibration: its frames repeat bit by bit wherever the force stands.

use slip_core::{
    Pipeline, PipelineConfig, Sample, Signal, SlipReport,
    grip::GripConfig,
    units::{Hertz, Micros},
};

/// Counts of 28 taxels under a round object, `off` taxels from the middle, that is pressed with `force_n`.
fn frame(force_n: f32, off: f32) -> [f32; 28] {
    core::array::from_fn(|i| {
        let (x, y) = ((i % 4) as f32 - 1.5 - off, (i / 4) as f32 - 3.0);
        (200.0 + 8.0 * force_n * (-(x * x + y * y) / 3.0).exp()).round()
    })
}

/// An object slips for 50 ms from 3 s on, and is pressed with more and more in answer: until when that is reported (s).
fn reported_until(off: Option<f32>) -> f64 {
    let config = PipelineConfig {
        grip: Some(GripConfig::default()),
        ..PipelineConfig::observing(Signal::Vibration, Hertz(1000.0))
    };
    let mut pipeline = Pipeline::<&[f32]>::new(config, None).unwrap();
    let (mut state, mut ends) = (7_u32, f64::NAN);
    for i in 0..5000_u32 {
        let t_s = 1e-3 * i as f32;
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = (f64::from(state) / f64::from(u32::MAX) - 0.5) as f32;
        let level = if (3.0..3.05).contains(&t_s) { 300.0 } else { 10.0 };
        let risen = 1.0 - (-(t_s - 3.02).max(0.0) / 0.06).exp();
        let force_n = if t_s < 0.5 { 0.0 } else { 20.0 + 130.0 * risen };
        let sample = Sample {
            normal_force_n: Some(force_n),
            ..Sample::stylus(Micros(1000 * u64::from(i)), (level * noise).round())
        };
        let frame = off.map(|off| frame(force_n, off));
        let step = pipeline.handle_with(&sample, frame.as_ref().map_or(&[], |frame| frame));
        if let Some(SlipReport { first: false, t, .. }) = step.event {
            ends = t.as_seconds();
        }
    }
    ends
}

#[test]
fn coarse_taxels_do_not_draw_out_a_slip_that_is_answered() {
    let without = reported_until(None);
    assert!(without < 3.15, "{without}");
    for tenths in 0..10_u8 {
        let with = reported_until(Some(0.1 * f32::from(tenths)));
        assert!(with < without + 0.01, "{with} s, without taxels {without} s");
    }
}
