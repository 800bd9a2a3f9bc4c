//! The paths from bytes and samples to commands run without the heap.
#![expect(clippy::unwrap_used, reason = "test code")]

use core::hint::black_box;
use grip_link::{
    decoder::{Decoder, Role, Verdict},
    frame::MAX_WIRE,
};
use grip_session::{HostConfig, Session, SessionOptions, Update, model};
use grip_sim::{VirtualMcu, scene};
use slip_benches::{frames, networks, scenes, signals::Signals};
use slip_core::{
    Phase, Sample, Step,
    health::SensorHealth,
    sample::Scene,
    units::{Micros, Newtons},
};

/// Allocations and frees of this thread while `work` runs.
fn heap_calls(work: impl FnOnce()) -> u64 {
    let seen = allocation_counter::measure(work);
    seen.count_total + seen.count_current.unsigned_abs()
}

#[test]
fn the_counter_sees_what_it_has_to() {
    assert_eq!(heap_calls(|| drop(black_box(Box::new(7_u64)))), 1, "allocated and freed");
    let kept = Box::new(7_u64);
    assert_eq!(heap_calls(|| drop(black_box(kept))), 1, "freed");
    let mut growing: Vec<u8> = Vec::with_capacity(1);
    assert_ne!(heap_calls(|| growing.resize(black_box(100), 0)), 0, "grown");
    let mut reported = 0;
    let mut report: Box<dyn FnMut(&str)> = Box::new(|text| reported += text.len());
    assert_ne!(heap_calls(|| report(&format!("{}", black_box(1.5)))), 0, "formatted");
    assert_eq!(heap_calls(|| report("nothing")), 0);
}

/// What was seen on the way, without the heap.
#[derive(Debug, Default)]
struct Seen {
    scenes: [bool; 4],
    first: bool,
    ended: bool,
    estimates: u32,
    health: [bool; 5],
}

impl Seen {
    fn note(&mut self, step: &Step) {
        let scene = scenes::SCENES.iter().position(|scene| *scene == step.scene).unwrap();
        self.scenes[scene] = true;
        self.first |= step.event.is_some_and(|slip| slip.first);
        self.ended |= step.event.is_some_and(|slip| slip.phase == Phase::Ended);
        self.estimates += u32::from(step.estimate.is_some());
        let healths = [
            SensorHealth::Good,
            SensorHealth::Frozen,
            SensorHealth::Saturated,
            SensorHealth::Failed,
            SensorHealth::Drifting,
        ];
        self.health[healths.iter().position(|health| *health == step.sensors[0]).unwrap()] = true;
    }
}

/// A gripper that holds something and whose stylus fails in every way, recovering in between.
fn failing_stylus() -> Vec<Sample> {
    let mut signals = Signals::new(9);
    let mut samples = signals.stretch(6_000, 3.0, 0.0);
    for fault in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0, -1.0, 2e-3, 1e-6] {
        samples.extend(
            signals.stretch(1_000, 3.0, 0.0).iter().map(|s| Sample { stylus: fault, ..*s }),
        );
        samples.extend(signals.stretch(300, 3.0, 0.0));
    }
    // 100 um/s.
    let drift = signals.stretch(40_000, 3.0, 0.0);
    samples.extend(
        (0_u16..)
            .zip(drift)
            .map(|(at, sample)| Sample { stylus: sample.stylus + 1e-8 * f32::from(at), ..sample }),
    );
    let spikes = signals.stretch(500, 3.0, 0.0);
    samples.extend(spikes.iter().enumerate().map(|(at, sample)| match at % 4 {
        0 => Sample { stylus: sample.stylus + 2e-3, ..*sample },
        1 => Sample { normal_force_n: Some(f32::NAN), ..*sample },
        2 => Sample { travel_m: Some(f32::INFINITY), ..*sample },
        _ => Sample { t: Micros(sample.t.0 - 200), ..*sample },
    }));
    samples
}

#[test]
fn the_pipeline_allocates_nothing_in_any_scene() {
    for no_skip in [false, true] {
        let mut seen = Seen::default();
        let mut pipeline = scenes::pipeline(no_skip).unwrap();
        let samples = scenes::whole_grasp();
        let heap = heap_calls(|| samples.iter().for_each(|s| seen.note(&pipeline.handle(s))));
        assert_eq!(heap, 0, "no_skip {no_skip}");
        assert_eq!(seen.scenes, [true; 4], "{seen:?}");
        assert!(seen.first && seen.ended && seen.estimates > 50, "{seen:?}");
    }
}

#[test]
fn the_pipeline_allocates_nothing_where_the_stylus_is_alone() {
    let mut run = scenes::SceneRun::stylus_alone().unwrap();
    let before = run.pipeline.clone().handle(&run.samples[0]).command;
    let mut after = None;
    let heap = heap_calls(|| {
        for sample in &run.samples {
            after = run.pipeline.handle(sample).command;
        }
    });
    assert_eq!(heap, 0);
    assert!(after > before, "a slip that goes on is answered: {before:?} {after:?}");
}

#[test]
fn the_pipeline_allocates_nothing_on_sensor_faults() {
    for no_skip in [false, true] {
        let mut seen = Seen::default();
        let mut pipeline = scenes::pipeline(no_skip).unwrap();
        let samples = failing_stylus();
        let heap = heap_calls(|| samples.iter().for_each(|s| seen.note(&pipeline.handle(s))));
        assert_eq!(heap, 0, "no_skip {no_skip}");
        assert_eq!(seen.health, [true; 5], "{seen:?}");
        let faults = pipeline.health_counters();
        assert!(faults.not_finite > 0 && faults.saturated > 0, "{faults:?}");
        assert!(faults.glitches > 0 && faults.other_channels > 0, "{faults:?}");
        assert!(faults.time_faults > 0, "{faults:?}");
    }
}

/// Good frames with damaged, cut, doubled and endless ones among them.
fn noisy_line() -> Vec<u8> {
    let mut line = Vec::new();
    for (at, mut frame) in frames::samples(700, frames::ROWS).unwrap().into_iter().enumerate() {
        let middle = frame.len() / 2;
        match at % 7 {
            1 => frame[middle] ^= 0x10,
            2 => frame.truncate(middle),
            3 => frame.extend_from_within(..),
            4 => frame.extend([0xA5; 2 * MAX_WIRE]),
            5 => frame[middle] = 0,
            6 => line.extend([2, 0x41, 0]),
            _ => {}
        }
        line.extend(frame);
    }
    line
}

#[test]
fn the_decoder_allocates_nothing_on_good_and_bad_frames() {
    let line = noisy_line();
    let mut decoder = Decoder::new(Role::Host);
    decoder.open_session(frames::SESSION, None);
    let (mut good, mut bad) = (0, 0);
    let heap = heap_calls(|| {
        for mut chunk in line.chunks(64) {
            while let Some(verdict) = decoder.next(&mut chunk) {
                match verdict {
                    Verdict::Frame(_) => good += 1,
                    Verdict::Bad(_) => bad += 1,
                }
            }
        }
    });
    assert_eq!(heap, 0);
    let counters = decoder.counters();
    assert!(good > 200 && bad > 300, "{counters:?}");
    assert!(counters.crc > 0 && counters.cobs > 0 && counters.too_long > 0, "{counters:?}");
    assert!(counters.length > 0 && counters.duplicate > 0 && counters.gap > 0, "{counters:?}");
}

#[test]
fn encoding_a_command_allocates_nothing() {
    let mut out = [0; MAX_WIRE];
    let heap = heap_calls(|| {
        frames::grip(1, 12_345, black_box(&mut out)).unwrap();
    });
    assert_eq!(heap, 0);
}

#[test]
fn forward_passes_allocate_nothing() {
    let network = networks::network(&[16, 32, 16, 1]).unwrap();
    let model = networks::model().unwrap();
    let (mut fast, mut exact, mut double) = ([f32::NAN], [f32::NAN], [f64::NAN]);
    let heap = heap_calls(|| {
        let input = black_box([0.25; 16]);
        network.forward(&input, &mut fast).unwrap();
        network.forward_exact(&input, &mut exact).unwrap();
        network.forward_double(&input.map(f64::from), &mut double).unwrap();
        black_box(model.estimate(&[3.0, 2.0]).unwrap());
        black_box(model.estimate(&[1e3, 2.0]).unwrap());
        black_box(model.estimate(&[f32::NAN, -2.0]).unwrap_err());
    });
    assert_eq!(heap, 0);
    for output in [fast[0], exact[0]] {
        assert!((f64::from(output) - double[0]).abs() < 2e-5, "{output} {double:?}");
    }
}

/// A simulated grasp: heap calls and calls of `Session::receive` once force commands flow, and what was reported.
fn grasp(seed: u64) -> (u64, u32, [bool; 4]) {
    let scene = scene::load("default").unwrap().reseeded(seed).unwrap();
    let mut mcu = VirtualMcu::new(&scene, 1).unwrap();
    let estimator = model::default_estimator().unwrap();
    let mut session =
        Session::new(HostConfig::default(), estimator, SessionOptions::default()).unwrap();
    session.open(0, 1).unwrap();
    let (mut bytes, mut out) = (Vec::new(), [0; MAX_WIRE]);
    let (mut heap, mut calls, mut seen) = (0, 0, Seen::default());
    loop {
        let now = mcu.next_due();
        if now > Micros(1_500_000) {
            return (heap, calls, seen.scenes);
        }
        mcu.advance(now);
        bytes.clear();
        mcu.transmit(now, &mut bytes);
        let steady = session.latest().is_some_and(|step| step.command > Some(Newtons(0.0)));
        let mut command = None;
        let used = heap_calls(|| {
            let mut left = bytes.as_slice();
            while let Some(updates) = session.receive(now.0, &mut left).unwrap() {
                if let Update::Step { step, .. } = updates {
                    seen.note(step);
                }
            }
            command = session.command(now.0, &mut out);
        });
        if steady {
            heap += used;
            calls += 1;
        }
        if let Some(len) = command {
            mcu.receive(now, &out[..len]);
        }
        while let Some(len) = session.poll_transmit(now.0, &mut out) {
            mcu.receive(now, &out[..len]);
        }
    }
}

#[test]
fn a_session_allocates_nothing_once_commands_flow() {
    let mut slips = 0;
    for seed in 0..4 {
        let (heap, calls, scenes) = grasp(seed);
        assert_eq!(heap, 0, "seed {seed}");
        assert!(calls > 1_000, "{calls}");
        let slipping = scenes::SCENES.iter().position(|scene| *scene == Scene::Slipping).unwrap();
        slips += u32::from(scenes[slipping]);
    }
    assert!(slips > 0, "no object slipped");
}
