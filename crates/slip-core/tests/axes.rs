//! Vibration sensors and motion references with three axes: the same events however they are mounted.
#![expect(clippy::unwrap_used, reason = "test code")]

use slip_core::{
    Phase, Pipeline, PipelineConfig, Sample, Signal, SlipReport,
    sample::Vector,
    units::{Hertz, Micros},
};

const RATE_HZ: f32 = 4000.0;
const STEP_US: u64 = 250;
/// Gravity and offsets, which no turn may show as vibration.
const STATIC: Vector = [1.0, -7.0, 6.0];

type Turn = [Vector; 3];

const STRAIGHT: Turn = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn turned(turn: &Turn, v: Vector) -> Vector {
    turn.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
}

/// The turn about `axis` (not 0) by `angle` (rad).
fn about(axis: Vector, angle: f32) -> Turn {
    let length = axis.iter().map(|x| x * x).sum::<f32>().sqrt();
    let [x, y, z] = axis.map(|a| a / length);
    let (s, c) = angle.sin_cos();
    let d = 1.0 - c;
    [
        [c + x * x * d, x * y * d - z * s, x * z * d + y * s],
        [y * x * d + z * s, c + y * y * d, y * z * d - x * s],
        [z * x * d - y * s, z * y * d + x * s, c + z * z * d],
    ]
}

/// Uniform noise of variance 1, from a small generator of its own.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 40) as f32 / (1_u32 << 23) as f32 - 1.0) * 1.732
    }
    fn vector(&mut self, rms: f32) -> Vector {
        core::array::from_fn(|_| rms * self.next())
    }
}

fn sum(a: Vector, b: Vector) -> Vector {
    core::array::from_fn(|i| a[i] + b[i])
}

/// A slip of 2 to 2.5 s that vibrates along `slip`, after motion of the arm along `arm` from 1 to 1.4 s.
struct Scene {
    arm: Vector,
    slip: Vector,
}

impl Scene {
    /// Samples with the sensor and the reference turned, each in its own way.
    fn samples(&self, sensor: &Turn, reference: &Turn) -> Vec<Sample> {
        let mut noise = Noise(11);
        let along = |v: Vector, by: f32| v.map(|x| x * by);
        (0..12_000_u16)
            .map(|i| {
                let t_s = f32::from(i) / RATE_HZ;
                let arm = if (1.0..1.4).contains(&t_s) { noise.next() } else { 0.0 };
                let slip = if (2.0..2.5).contains(&t_s) { noise.next() } else { 0.0 };
                let moved = along(self.arm, 0.5 * arm);
                let felt = sum(sum(STATIC, moved), along(self.slip, slip));
                let felt = turned(sensor, sum(felt, noise.vector(0.01)));
                let seen = sum(sum(STATIC, along(self.arm, arm)), noise.vector(0.01));
                let seen = turned(reference, seen);
                Sample {
                    stylus_axes: [felt[1], felt[2]],
                    reference: Some(seen[0]),
                    reference_axes: [seen[1], seen[2]],
                    ..Sample::stylus(Micros(STEP_US * (u64::from(i) + 1)), felt[0])
                }
            })
            .collect()
    }
}

fn events(samples: &[Sample]) -> Vec<(u64, String)> {
    let config = PipelineConfig::observing(Signal::Vibration, Hertz(RATE_HZ));
    let mut pipeline = Pipeline::<&[f32]>::new(config, None).unwrap();
    let name = |event| match event {
        SlipReport { phase: Phase::Ended, .. } => "end".to_owned(),
        SlipReport { phase, method, .. } => format!("{phase:?} {method:?}"),
    };
    let steps = samples.iter().map(|sample| pipeline.handle(sample));
    steps.filter_map(|step| Some((step.t.0, name(step.event?)))).collect()
}

fn assert_same(got: &[(u64, String)], expected: &[(u64, String)], what: &str) {
    let same = |((a, one), (b, other)): (&(u64, String), &(u64, String))| {
        one == other && a.abs_diff(*b) <= 500
    };
    let all = got.len() == expected.len() && got.iter().zip(expected).all(same);
    assert!(all, "{what}: {got:?}, straight: {expected:?}");
}

#[test]
fn a_turn_of_the_axes_changes_no_event() {
    let scene = Scene { arm: [0.0, 1.0, 0.3], slip: [0.08, 0.02, 0.0] };
    let expected = events(&scene.samples(&STRAIGHT, &STRAIGHT));
    let (first, _) = &expected[0];
    assert!((2_000_000..2_010_000).contains(first), "the motion is none: {expected:?}");
    let turns = [
        about([0.0, 0.0, 1.0], core::f32::consts::FRAC_PI_2),
        about([0.0, 1.0, 0.0], core::f32::consts::FRAC_PI_2),
        about([1.0, 1.0, 1.0], 0.7),
        about([-0.3, 2.0, 0.9], 2.9),
        about([5.0, -1.0, 0.1], 4.1),
    ];
    for (k, turn) in turns.iter().enumerate() {
        for (sensor, reference) in [(turn, &STRAIGHT), (&STRAIGHT, turn), (turn, turn)] {
            assert_same(
                &events(&scene.samples(sensor, reference)),
                &expected,
                &format!("turn {k}"),
            );
        }
    }
}

#[test]
fn a_slip_across_the_first_axis_is_found_as_one_along_it() {
    for slip in [[0.06, 0.0, 0.0], [0.0, 0.06, 0.0], [0.0, 0.0, 0.06]] {
        let found = events(&Scene { arm: [0.0; 3], slip }.samples(&STRAIGHT, &STRAIGHT));
        let (first, _) = &found[0];
        assert!((2_000_000..2_010_000).contains(first), "{slip:?}: {found:?}");
    }
}

#[test]
fn a_motion_that_only_a_further_axis_of_the_reference_shows_is_no_slip() {
    let quiet = [0.0; 3];
    for arm in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        let samples = Scene { arm, slip: quiet }.samples(&STRAIGHT, &STRAIGHT);
        assert_eq!(events(&samples), [], "{arm:?}");
        let one_axis: Vec<Sample> =
            samples.iter().map(|s| Sample { reference_axes: [0.0; 2], ..*s }).collect();
        assert_eq!(events(&one_axis).is_empty(), arm[0] != 0.0, "{arm:?}");
    }
}

#[test]
fn one_bad_component_spoils_no_other_reading() {
    let scene = Scene { arm: [0.0; 3], slip: [0.0, 0.06, 0.0] };
    let mut samples = scene.samples(&STRAIGHT, &STRAIGHT);
    for (i, sample) in samples.iter_mut().enumerate() {
        match i % 400 {
            100 => sample.stylus_axes[0] = f32::NAN,
            200 => sample.stylus_axes[1] = f32::INFINITY,
            300 => sample.stylus_axes[0] = 5e5,
            350 => sample.reference_axes[1] = f32::NAN,
            _ => {}
        }
    }
    let config = PipelineConfig::observing(Signal::Vibration, Hertz(RATE_HZ));
    let mut pipeline = Pipeline::<&[f32]>::new(config, None).unwrap();
    let mut first = None;
    for sample in &samples {
        let step = pipeline.handle(sample);
        assert!(step.statistic.is_finite());
        first = first.or(step.event.map(|_| step.t.0));
    }
    assert!(first.is_some_and(|t| (2_000_000..2_010_000).contains(&t)), "{first:?}");
    let counters = pipeline.health_counters();
    assert_eq!((counters.not_finite, counters.glitches, counters.other_channels), (60, 30, 30));
}
