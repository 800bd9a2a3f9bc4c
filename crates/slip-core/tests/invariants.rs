//! What always holds of the command (docs/control.md, "Invariants"), against any interleaving of samples, gaps, bursts, faults and clocks.
#![expect(clippy::unwrap_used, reason = "test code")]

use proptest::prelude::*;
use slip_core::{
    Arrival, Pipeline, PipelineConfig, Sample,
    grip::{GripConfig, GripController, GripEvent, GripInput, GripState, SlipNow},
    load::Forecast,
    units::{Hertz, Micros},
};

type Bare = Pipeline<&'static [f32]>;

const RATE_HZ: f32 = 1000.0;
const PERIOD_US: u64 = 1000;

/// Some milliseconds of a grasp.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    ms: u16,
    /// Speed of the object (m/s) and vibration of the stylus (m).
    speed_m_s: f32,
    vibration_m: f32,
    /// What the sensors show instead of the truth.
    stylus: Fault,
    travel: Fault,
    force: Fault,
    /// Samples of this stretch arrive together at its end.
    burst: bool,
    /// What the device clock skips before it (ms).
    skip_ms: u16,
}

const CALM: Stretch = Stretch {
    ms: 1,
    speed_m_s: 0.0,
    vibration_m: 0.0,
    stylus: Fault::None,
    travel: Fault::None,
    force: Fault::None,
    burst: false,
    skip_ms: 0,
};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    Missing,
    Stuck,
    Wild,
}

fn any_fault() -> impl Strategy<Value = Fault> {
    prop_oneof![
        4 => Just(Fault::None),
        1 => Just(Fault::Missing),
        1 => Just(Fault::Stuck),
        1 => Just(Fault::Wild)
    ]
}

fn any_stretch() -> impl Strategy<Value = Stretch> {
    let motion = prop_oneof![2 => Just((0.0_f32, 0.0_f32)), 3 => (0.0_f32..0.3, 1e-6_f32..2e-5)];
    let faults = (any_fault(), any_fault(), any_fault());
    (
        1_u16..400,
        motion,
        faults,
        prop::bool::weighted(0.3),
        prop_oneof![4 => Just(0_u16), 1 => 1_u16..500],
    )
        .prop_map(|(ms, (speed_m_s, vibration_m), (stylus, travel, force), burst, skip_ms)| {
            Stretch { ms, speed_m_s, vibration_m, stylus, travel, force, burst, skip_ms }
        })
}

/// A gripper that shows what it is asked to, and the clocks of both sides.
struct Bench {
    pipeline: Bare,
    device_us: u64,
    host_us: u64,
    travel_m: f32,
    applied_n: f32,
    index: u32,
    held: [f32; 3],
}

/// One handled sample.
struct Seen {
    host_us: u64,
    age_us: u64,
    command_n: f32,
    faulty: bool,
}

impl Bench {
    fn holding() -> Self {
        let config = PipelineConfig::gripping(Hertz(RATE_HZ));
        let mut bench = Self {
            pipeline: Bare::new(config, None).unwrap(),
            device_us: 0,
            host_us: 1,
            travel_m: 0.0,
            applied_n: 0.0,
            index: 0,
            held: [0.0; 3],
        };
        while bench.pipeline.grip_state() != Some(GripState::Holding) {
            bench.play(&CALM, &mut |_| ());
            assert!(bench.host_us < 5_000_000, "never holds");
        }
        bench
    }

    fn play(&mut self, stretch: &Stretch, see: &mut dyn FnMut(&Seen)) {
        self.device_us += 1000 * u64::from(stretch.skip_ms);
        self.host_us += 1000 * u64::from(stretch.skip_ms);
        let end_us = self.host_us + PERIOD_US * u64::from(stretch.ms);
        for i in 0..stretch.ms {
            self.device_us += PERIOD_US;
            let taken_us = self.host_us + PERIOD_US * (u64::from(i) + 1);
            let arrived_us = if stretch.burst { end_us } else { taken_us };
            let sample = self.sample(stretch);
            let age_us = arrived_us - taken_us;
            let arrival = Arrival { at: Micros(arrived_us), age: Micros(age_us) };
            let step = self.pipeline.handle(&Sample { arrival: Some(arrival), ..sample });
            let command_n = step.command.unwrap().0;
            self.applied_n += 0.2 * (command_n - self.applied_n);
            let faulty = [stretch.stylus, stretch.travel, stretch.force] != [Fault::None; 3];
            see(&Seen { host_us: arrived_us, age_us, command_n, faulty });
        }
        self.host_us = end_us;
    }

    fn sample(&mut self, stretch: &Stretch) -> Sample {
        self.index = self.index.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let random = self.index as f32 / u32::MAX as f32 - 0.5;
        self.travel_m += 1e-3 * stretch.speed_m_s;
        let phase = self.travel_m / 3e-4 * core::f32::consts::TAU;
        let truth = [
            1e-4 + stretch.vibration_m * phase.sin() + 3e-7 * random,
            self.travel_m + 1e-6 * random,
            self.applied_n + 1e-2 * random,
        ];
        let faults = [stretch.stylus, stretch.travel, stretch.force];
        let mut shown = [0.0; 3];
        for (i, fault) in faults.into_iter().enumerate() {
            shown[i] = match fault {
                Fault::None => truth[i],
                Fault::Missing => f32::NAN,
                Fault::Stuck => self.held[i],
                Fault::Wild => truth[i] + random * [1e-4, 1e-3, 2.0][i],
            };
            if fault != Fault::Stuck {
                self.held[i] = truth[i];
            }
        }
        let some = |value: f32| Some(value).filter(|value| !value.is_nan());
        Sample {
            travel_m: some(shown[1]),
            normal_force_n: some(shown[2]),
            ..Sample::stylus(Micros(self.device_us), shown[0])
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// (a): no rise on evidence that is too old, and a rise within the slew of the host time since the last arrival.
    #[test]
    fn the_command_rises_on_fresh_evidence_and_within_host_time(stretches in prop::collection::vec(any_stretch(), 1..30)) {
        let slew_n_s = GripConfig::default().slew_n_s;
        let mut bench = Bench::holding();
        let (mut at_us, mut before_n) = (bench.host_us, bench.applied_n);
        let mut last_n = bench.applied_n;
        let mut waited_us = 0;
        for stretch in &stretches {
            let mut worst: Result<(), String> = Ok(());
            bench.play(stretch, &mut |seen| {
                if seen.host_us != at_us {
                    waited_us = seen.host_us - at_us;
                    (at_us, before_n) = (seen.host_us, last_n);
                }
                let rise_n = seen.command_n - last_n;
                // 20 ms, a period and the usual delay of the line: none, since arrivals were prompt and some stalls are not usual.
                if seen.age_us > 21_000 && rise_n > 1e-4 {
                    worst = Err(format!("rose by {rise_n} on evidence of {} us", seen.age_us));
                }
                let most_n = slew_n_s * 1e-6 * (waited_us.min(10_000) + 2000) as f32 + 1e-2;
                if seen.command_n - before_n > most_n {
                    worst = Err(format!("{} N after {waited_us} us", seen.command_n - before_n));
                }
                last_n = seen.command_n;
            });
            prop_assert!(worst.is_ok(), "{worst:?} in {stretch:?}");
        }
    }

    /// (d): in a stretch in which a sensor fails, while nothing is answered, the command stays.
    #[test]
    fn no_fault_lowers_the_force(stretches in prop::collection::vec(any_stretch(), 1..20)) {
        let mut bench = Bench::holding();
        for stretch in &stretches {
            bench.play(stretch, &mut |_| ());
            // Stylus and travel are gone: nothing is known any more.
            let blind = Stretch {
                ms: 300, stylus: Fault::Missing, travel: Fault::Missing, force: Fault::None, burst: false, skip_ms: 0, ..*stretch
            };
            let mut commands = Vec::new();
            bench.play(&blind, &mut |seen| {
                assert!(seen.faulty);
                commands.push(seen.command_n);
            });
            // Lone missing readings are no fault yet: 8 in a row are, and 50 ms without travel.
            let after = &commands[120..];
            prop_assert!(after.windows(2).all(|pair| pair[1] >= pair[0]), "{stretch:?}");
            prop_assert!(after.windows(2).all(|pair| pair[1] <= pair[0]), "and nothing raises it: {stretch:?}");
        }
    }

    /// (b): while a trusted travel shows an object that slides on, the command grows by e in 320 ms at least, whatever the posterior states and
    /// whatever the force sensor shows.
    #[test]
    fn what_slides_on_is_answered_at_the_stated_rate(
        [best_n, median_n, p_null] in [0.0_f32..60.0, 0.0..60.0, 0.0..1.0], [known, moves, searched] in any::<[bool; 3]>(),
        applied_n in prop::option::of(0.0_f32..60.0), predicted_n in 0.0_f32..60.0, travel_m_s in 0.013_f32..1.0, ms in 20_u16..400
    ) {
        let config = GripConfig { relax_per_s: if searched { 1.0 } else { 0.0 }, ..GripConfig::default() };
        let mut grip = GripController::holding(config, 2.0);
        for i in 0..ms {
            let since_s = 1e-3 * f32::from(i);
            let forecast = Some(Forecast {
                slips: true, moves, informed: true, trusted: true, known, by_stylus: true, since_s, moved_m: Some(since_s * travel_m_s),
                travel_m_s, speed_m_s: travel_m_s, from_n: 2.0, best_n, median_n, p_null, slips_seen: 1, ..Forecast::default()
            });
            let predicted_n = predicted_n.min(grip.command_n());
            let command_n = grip.step(&GripInput {
                dt_s: 1e-3, slip: SlipNow::Evident, forecast, predicted_n, lag_s: 0.0, travel: true, applied_n, touching: true,
                healthy: true, ..GripInput::default()
            });
            // Without a lag the command is the target.
            let least_n = 2.0 * ((since_s - 0.015).max(0.0) / 0.32).exp();
            prop_assert!(command_n >= (0.999 * least_n).min(config.ceiling_n()), "{command_n} N after {i} ms");
        }
    }

    /// (b) by the whole pipeline: an object that slides on at the same speed, however hard it is held.
    #[test]
    fn an_object_that_nothing_holds_is_pressed_harder_and_harder(speed_m_s in 0.013_f32..0.3) {
        let mut bench = Bench::holding();
        let slides = Stretch { ms: 600, speed_m_s, vibration_m: 1e-5, ..CALM };
        let (mut commands, mut ms) = (Vec::new(), 0_u16);
        bench.play(&slides, &mut |seen| commands.push(seen.command_n));
        // Until it is noticed, and until the first answer should have arrived, less and less may be tried.
        let from_n = commands.iter().take(120).copied().fold(f32::INFINITY, f32::min);
        for command_n in &commands[120..] {
            let least_n = from_n * (f32::from(ms) / 320.0).exp();
            prop_assert!(*command_n >= least_n.min(60.0), "{command_n} N, {ms} ms after {from_n} N");
            ms += 1;
        }
    }
}

/// (f): a slip that does not end is reported once, after two seconds.
#[test]
fn a_slip_that_does_not_end_is_reported() {
    let mut grip = GripController::holding(GripConfig::default(), 2.0);
    let slipping = GripInput {
        dt_s: 1e-3,
        slip: SlipNow::Fading,
        moved_m: Some(1e-3),
        travel: true,
        touching: true,
        healthy: true,
        ..GripInput::default()
    };
    let reports: Vec<u16> = (0..5000)
        .filter(|_| {
            grip.step(&slipping);
            grip.event() == Some(GripEvent::Persistent)
        })
        .collect();
    assert!(matches!(reports[..], [at] if (1999..=2002).contains(&at)), "{reports:?}");
}
