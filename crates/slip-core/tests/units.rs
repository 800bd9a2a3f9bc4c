//! The same vibrations, taxels and motion in other units: the same events.
#![expect(clippy::unwrap_used, reason = "test code")]

use slip_core::{
    Phase, Pipeline, PipelineConfig, Sample, Signal, SlipReport,
    units::{Hertz, Micros},
};

const RATE_HZ: f32 = 2000.0;
const TAXELS: usize = 24;

/// Uniform noise of variance 1, from a small generator of its own.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) as f32 / (1_u32 << 23) as f32 - 1.0) * 1.732
    }
}

/// Events of 4 s in this unit: rest, motion of the arm at 1 s, a slip at 2 s. `coarse` readings are whole numbers of the unit.
fn events(unit: f32, coarse: bool) -> Vec<(u64, String)> {
    let config = PipelineConfig::observing(Signal::Vibration, Hertz(RATE_HZ));
    let mut pipeline = Pipeline::<&[f32]>::new(config, None).unwrap();
    let (mut noise, mut out) = (Noise(7), Vec::new());
    for i in 0..8000_u16 {
        let t_s = f32::from(i) / RATE_HZ;
        let arm = if (1.0..1.4).contains(&t_s) { 30.0 * noise.next() } else { 0.0 };
        let slip = if (2.0..2.5).contains(&t_s) { 40.0 * noise.next() } else { 0.0 };
        let round = |x: f32| if coarse { x.round() } else { x };
        let mut taxels = [0.0; TAXELS];
        for (k, taxel) in taxels.iter_mut().enumerate() {
            let shift = if t_s > 3.0 { (t_s - 3.0) * 400.0 * (k as f32 - 12.0) } else { 0.0 };
            *taxel = unit * round(3000.0 + shift.clamp(-900.0, 900.0) + 4.0 * noise.next());
        }
        let sample = Sample {
            reference: Some(unit * round(arm + 2.0 * noise.next())),
            ..Sample::stylus(
                Micros(500 * (u64::from(i) + 1)),
                unit * round(2000.0 + arm + slip + 3.0 * noise.next()),
            )
        };
        let frame = if i % 20 == 0 { &taxels[..] } else { &[] };
        let step = pipeline.handle_with(&sample, frame);
        if let Some(event) = step.event {
            let name = match event {
                SlipReport { phase: Phase::Ended, .. } => "end".to_owned(),
                SlipReport { phase, method, .. } => format!("{phase:?} {method:?}"),
            };
            out.push((step.t.0, name));
        }
    }
    out
}

#[test]
fn a_unit_changes_no_event() {
    for coarse in [false, true] {
        let expected = events(1.0, coarse);
        assert!(expected.iter().any(|(t, _)| (2_000_000..2_020_000).contains(t)), "{expected:?}");
        assert!(
            expected.iter().any(|(t, name)| *t > 3_000_000 && name.contains("Pressure")),
            "{expected:?}"
        );
        assert!(expected.iter().all(|(t, _)| *t >= 2_000_000), "{expected:?}");
        for power in [-30, -20, -10, 10, 20, 30] {
            assert_eq!(events(2.0_f32.powi(power), coarse), expected, "2^{power}");
        }
        for power in [-9, -6, -3, -1, 1, 3, 6, 9] {
            let got = events(10.0_f32.powi(power), coarse);
            let pairs = got.iter().zip(&expected);
            let same = |((a, one), (b, other)): (&(u64, String), &(u64, String))| {
                one == other && a.abs_diff(*b) <= 500
            };
            assert!(
                got.len() == expected.len() && pairs.clone().all(same),
                "1e{power}: {got:?} {expected:?}"
            );
        }
    }
}
