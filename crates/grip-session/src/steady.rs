//! Detector of the steady level of a machine in a running alarm.
//!
//! A slip stops, or its level goes up and down with speed and surface. A machine that began after the floor was learned,
//! or that strikes again and again, keeps one level: the alarm never ends, and only a calibration beside the machine
//! takes it in.

use slip_core::{
    Phase, SlipReport, Step,
    alarm::Method,
    detector::SlipDetector,
    units::Micros,
    velocity::{SpeedSource, Velocity},
};

/// The message about such an alarm.
pub const STEADY: &str = "steady for 2 s: is this the machine? calibrate with it running";

/// The alarm is looked at in stretches of this length: impacts from 8 Hz on have one level.
const STRETCH: Micros = Micros(250_000);
/// As many as 2 s have.
const STRETCHES: usize = 8;
/// No stretch is louder than the quietest by more than this factor in energy.
const RATIO: f32 = 2.0;

/// Follows an alarm from its begin on. It reports once an alarm, about that of the stylus alone, while nothing shows motion.
#[derive(Clone, Copy, Debug, Default)]
pub struct SteadyAlarm {
    /// Where the stretch began; `None` without an alarm, or where it was reported.
    from: Option<Micros>,
    sum: f32,
    count: f32,
    /// Mean energy over the floor, all bands, of the last stretches; the newest last.
    means: [f32; STRETCHES],
}

impl SteadyAlarm {
    /// Takes a step and the detector after it; whether the alarm has been steady for 2 s now.
    #[inline]
    pub fn step(&mut self, step: &Step, detector: &SlipDetector) -> bool {
        if let Some(report) = &step.event {
            self.follow(report);
        }
        let Some(from) = self.from else { return false };
        if step.velocity.is_some_and(|velocity| is_seen(&velocity)) {
            self.from = None;
        }
        !detector.in_block() && self.take(step.t, from, detector.levels().energy.iter().sum())
    }

    fn follow(&mut self, report: &SlipReport) {
        if report.first {
            *self = Self { from: Some(report.t), ..Self::default() };
        }
        if report.phase == Phase::Ended || report.method != Method::Stylus {
            self.from = None;
        }
    }

    fn take(&mut self, t: Micros, from: Micros, energy: f32) -> bool {
        self.sum += energy;
        self.count += 1.0;
        if t.since(from) < STRETCH {
            return false;
        }
        self.means.rotate_left(1);
        if let Some(newest) = self.means.last_mut() {
            *newest = self.sum / self.count;
        }
        (self.from, self.sum, self.count) = (Some(t), 0.0, 0.0);
        let [least, most] = self.means.iter().fold([f32::INFINITY, 0.0], |[least, most], mean| {
            [f32::min(least, *mean), f32::max(most, *mean)]
        });
        let steady = least > 0.0 && most.is_finite() && most <= RATIO * least;
        if steady {
            self.from = None;
        }
        steady
    }
}

/// Whether a sensor of motion has seen the object move.
fn is_seen(velocity: &Velocity) -> bool {
    matches!(velocity.source, SpeedSource::Direct | SpeedSource::Travel | SpeedSource::TwoStyli)
}

#[cfg(test)]
mod tests {
    use super::SteadyAlarm;
    use slip_core::{
        Pipeline, PipelineConfig, Sample, Signal,
        units::{Hertz, Micros},
    };

    /// When alarms of 5 s of noise are steady (s): 1 at first, `level` times as loud at `t_s` from 1 s on; and how long
    /// slips last.
    fn steady(level: impl Fn(f32) -> f32, travel: bool) -> (Vec<f64>, f64) {
        let config = PipelineConfig::observing(Signal::Vibration, Hertz(2000.0));
        let mut pipeline = Pipeline::<Vec<f32>>::new(config, None).unwrap();
        let (mut watch, mut state, mut found, mut slipping) =
            (SteadyAlarm::default(), 7_u32, Vec::new(), 0.0);
        for i in 0..10_000_u16 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (state >> 8) as f32 / (1 << 24) as f32 - 0.5;
            let t_s = f32::from(i) / 2000.0;
            let loud = if t_s < 1.0 { 1.0 } else { level(t_s) };
            let mut sample = Sample::stylus(Micros(500 * u64::from(i)), loud * noise);
            sample.travel_m = travel.then_some(0.01 * (t_s - 1.0).max(0.0));
            let step = pipeline.handle_with(&sample, &[]);
            slipping += f64::from(u8::from(step.scene == slip_core::sample::Scene::Slipping)) / 2e3;
            if watch.step(&step, pipeline.detector()) {
                found.push(step.t.as_seconds());
            }
        }
        (found, slipping)
    }

    #[test]
    fn a_machine_is_named_once_after_2_s_and_a_slip_that_varies_or_ends_is_not() {
        let (found, slips_s) = steady(|_| 6.0, false);
        assert!(matches!(found[..], [at] if (3.0..3.6).contains(&at)), "{found:?}");
        assert!(slips_s > 3.9, "{slips_s}");
        // Impacts, 20 a second.
        let (found, slips_s) = steady(|t| if (20.0 * t).fract() < 0.2 { 20.0 } else { 1.0 }, false);
        assert!(found.len() == 1 && slips_s > 3.9, "{found:?} {slips_s}");
        // Up and down by 6 in energy within each 2 s; over after 1.8 s; moved by the travel sensor.
        let (found, slips_s) = steady(|t| if t.fract() < 0.5 { 6.0 } else { 15.0 }, false);
        assert!(found.is_empty() && slips_s > 3.9, "{found:?} {slips_s}");
        let (found, slips_s) = steady(|t| if t < 2.8 { 6.0 } else { 1.0 }, false);
        assert!(found.is_empty() && (1.5..2.5).contains(&slips_s), "{found:?} {slips_s}");
        let (found, slips_s) = steady(|_| 6.0, true);
        assert!(found.is_empty() && slips_s > 3.9, "{found:?} {slips_s}");
    }
}
