//! Stylus readings and grip forces in; whether the mean of the stylus drifts further than a change of grip force explains, out.
//!
//! While an object is held still, the mean of the stylus may move only as far as the pads give way under a change of force. In
//! seconds (stylus mean m, force mean F; one reading a millisecond):
//!
//! ```text
//! drifting when |m - m0| > limit + per_newton |F - F0|                       m0, F0: the first second of the hold
//! good again when the same is below half of it for 3 s in a row, or with a new anchor
//! ```
//!
//! The anchor (m0, F0) never follows the signal: that would be to re-baseline. It is taken anew only where the stylus does stand on
//! another place: when an object is taken, when a slip has ended, and when a failed stylus has come back. Then the state is good again and told as such, so a stylus that goes
//! on drifting is found again. Nothing is judged in an open hand, during a slip, or without a force reading, where drift cannot be told from
//! a change of grip. A drift below limit / length of the hold is not seen; it ends as saturation.

use crate::units::Micros;

/// How far a hold may move the stylus.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct DriftConfig {
    /// Shift of the mean at constant force that is drift (signal unit); beyond creep of the pads and temperature.
    pub limit: f32,
    /// What a change of grip force may add to it (signal unit per newton).
    pub per_newton: f32,
}

impl Default for DriftConfig {
    fn default() -> Self {
        Self { limit: 1e-4, per_newton: 5e-5 }
    }
}

/// What the hand does, as far as the stylus is concerned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hold {
    /// Nothing is held, it is just being taken, or the readings are not to be believed.
    #[default]
    None,
    /// An object is held and does not slip.
    Still,
    /// The object slips.
    Slipping,
}

/// Length of the stretches that are compared (us).
const SECOND: u64 = 1_000_000;
/// Time between two readings that count (us).
const EVERY: u64 = 1000;
/// Seconds below half of the limit after which a drift is over.
const CALM: u8 = 3;

/// Sums of a stretch.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    stylus: f32,
    force: f32,
    count: u16,
}

/// The watch and its memory.
#[derive(Clone, Copy, Debug)]
pub struct DriftWatch {
    config: DriftConfig,
    hold: Hold,
    next: Micros,
    end: Micros,
    /// The readings are summed about this one, so that a large offset costs no digits.
    first: f32,
    sums: Sums,
    anchor: Option<(f32, f32)>,
    calm: u8,
    drifting: bool,
}

impl DriftWatch {
    /// A watch that has seen nothing yet.
    #[must_use]
    pub fn new(config: DriftConfig) -> Self {
        Self {
            config,
            hold: Hold::None,
            next: Micros(0),
            end: Micros(0),
            first: 0.0,
            sums: Sums::default(),
            anchor: None,
            calm: 0,
            drifting: false,
        }
    }

    /// Whether the stylus drifts. Takes the next reading (finite) at `t` with the force of a finger (N).
    #[inline]
    pub fn step(&mut self, t: Micros, reading: (f32, Option<f32>), hold: Hold) -> bool {
        if hold != self.hold {
            self.turn(t, hold);
        }
        if hold == Hold::Still && t >= self.next {
            self.take(t, reading);
        }
        self.drifting
    }

    /// Another hold: a new place under the stylus. During a slip the last word stands.
    #[cold]
    fn turn(&mut self, t: Micros, hold: Hold) {
        self.hold = hold;
        self.anchor = None;
        self.calm = 0;
        self.drifting &= hold != Hold::Still;
        self.next = t;
        self.begin(t);
    }

    fn begin(&mut self, t: Micros) {
        self.sums = Sums::default();
        self.end = t.plus(Micros(SECOND));
    }

    fn take(&mut self, t: Micros, (stylus, force_n): (f32, Option<f32>)) {
        self.next = t.plus(Micros(EVERY));
        let Some(force_n) = force_n else { return };
        if self.sums.count == 0 {
            self.first = stylus;
        }
        self.sums.stylus += stylus - self.first;
        self.sums.force += force_n;
        self.sums.count = self.sums.count.saturating_add(1);
        if t >= self.end {
            self.end_stretch(t);
        }
    }

    fn end_stretch(&mut self, t: Micros) {
        let count = f32::from(self.sums.count.max(1));
        let mean = (self.first + self.sums.stylus / count, self.sums.force / count);
        self.begin(t);
        let anchor = *self.anchor.get_or_insert(mean);
        let allowed = self.config.limit + self.config.per_newton * (mean.1 - anchor.1).abs();
        let shift = (mean.0 - anchor.0).abs();
        if shift > allowed {
            self.drifting = true;
            self.calm = 0;
        } else if shift < 0.5 * allowed {
            self.calm = self.calm.saturating_add(1);
            self.drifting &= self.calm < CALM;
        } else {
            self.calm = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DriftConfig, DriftWatch, Hold};
    use crate::units::Micros;

    /// Runs from second `from` to `to` at 2 kHz and says after which seconds the watch said that it drifts.
    fn run(
        watch: &mut DriftWatch,
        (from, to): (u16, u16),
        hold: Hold,
        signal: impl Fn(f32) -> (f32, Option<f32>),
    ) -> [bool; 64] {
        let mut stated = [false; 64];
        for i in u32::from(from) * 2000..u32::from(to) * 2000 {
            #[expect(clippy::cast_precision_loss, reason = "test signal")]
            let t_s = i as f32 / 2000.0;
            let drifts = watch.step(Micros(u64::from(i) * 500), signal(t_s), hold);
            stated[i as usize / 2000] = drifts;
        }
        stated
    }

    fn watch() -> DriftWatch {
        DriftWatch::new(DriftConfig::default())
    }

    /// 20 um/s, with vibration: 100 um are passed between the 6th and the 7th second.
    #[test]
    fn a_slow_drift_is_found_and_reported_until_it_is_gone() {
        let mut watch = watch();
        let wave = |t: f32| 5e-6 * libm::sinf(900.0 * t);
        let stated =
            run(&mut watch, (0, 12), Hold::Still, |t| (3e-4 + 2e-5 * t + wave(t), Some(5.0)));
        assert!(!stated[4] && stated[6] && stated[11], "{stated:?}");
        // It stays where it is: nothing is re-baselined.
        assert!(run(&mut watch, (12, 30), Hold::Still, |_| (5.4e-4, Some(5.0)))[29]);
        // Back at its place: three seconds of it, then good.
        let stated = run(&mut watch, (30, 40), Hold::Still, |t| (3.1e-4 + wave(t), Some(5.0)));
        assert!(stated[31] && !stated[35], "{stated:?}");
    }

    #[test]
    fn a_change_of_grip_force_is_no_drift() {
        let mut watch = watch();
        // Pads that give way by 30 um/N, from 2 to 30 N and back, with 10 um of creep.
        let force = |t: f32| if t < 25.0 { 2.0 + 1.12 * t } else { 30.0 - 1.5 * (t - 25.0) };
        let stated = run(&mut watch, (0, 40), Hold::Still, |t| {
            (3e-5 * force(t) + 2.5e-7 * t, Some(force(t)))
        });
        assert!(!stated.contains(&true), "{stated:?}");
        // The same way without the force is one.
        let stated =
            run(&mut self::watch(), (0, 40), Hold::Still, |t| (3e-5 * force(t), Some(2.0)));
        assert!(stated[10], "{stated:?}");
    }

    #[test]
    fn another_object_and_the_end_of_a_slip_are_another_place() {
        let mut watch = watch();
        let at = |level: f32| move |_: f32| (level, Some(5.0));
        run(&mut watch, (0, 3), Hold::Still, at(0.0));
        let slip = run(&mut watch, (3, 5), Hold::Slipping, at(1e-3));
        let after = run(&mut watch, (5, 9), Hold::Still, at(1e-3));
        assert!(!slip[4] && !after[8]);
        let stated = run(&mut watch, (9, 13), Hold::Still, at(2e-3));
        assert!(stated[12]);
        // The hand opens: still told. The next hold begins good and is judged by itself.
        assert!(run(&mut watch, (13, 15), Hold::None, at(0.0))[14]);
        assert!(!run(&mut watch, (15, 18), Hold::Still, at(2e-3))[17]);
        assert!(run(&mut watch, (18, 22), Hold::Still, at(3e-3))[21]);
    }

    #[test]
    fn without_force_nothing_is_judged() {
        let mut watch = watch();
        let stated = run(&mut watch, (0, 30), Hold::Still, |t| (1e-4 * t, None));
        assert!(!stated.contains(&true), "drift cannot be told from a change of grip");
    }
}
