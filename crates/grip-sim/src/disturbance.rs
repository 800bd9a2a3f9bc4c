//! Disturbance by the robot's own motion at a scene's motion level: what it adds to the stylus and to the motion reference.
//!
//! Sources, all in metres at the stylus and at level 1:
//! - structural resonances at 14, 31, 72, 155, 420, 850 Hz (damping ratios 0.04 to 0.02; rms 3, 2, 1.2, 0.6,
//!   0.25, 0.1 um) as second-order autoregressive noise of exactly that rms;
//! - a gear tone of 0.56 um rms that wanders within 260 +- 40 Hz; broadband noise of 0.15 um rms;
//! - taps: decaying oscillations of 250 to 900 Hz, 2 to 8 ms, 0.5 to 10 um, at random times.
//!
//! All but the taps move under an envelope that is drawn anew each second: off for half of the seconds,
//! else 0.3 to 1, smoothed at 6 Hz. The reference sees the same sources, each with its own gain of 0.7 to 1.5, through a
//! short filter (0.15, 0.5, 0.6, 0.25, -0.05), plus noise of 0.05 um: alike, never equal.

use crate::random::{self, Purpose};
use core::f64::consts::TAU;
use rand_chacha::ChaCha8Rng;

/// Frequency (Hz), damping ratio, rms (m) of each resonance.
const RESONANCES: [(f64, f64, f64); 6] = [
    (14.0, 0.04, 3e-6),
    (31.0, 0.03, 2e-6),
    (72.0, 0.03, 1.2e-6),
    (155.0, 0.02, 0.6e-6),
    (420.0, 0.02, 0.25e-6),
    (850.0, 0.02, 0.1e-6),
];
const TONE_HZ: f64 = 260.0;
const TONE_SPAN_HZ: f64 = 40.0;
const TONE_RMS_M: f64 = 0.56e-6;
const BROADBAND_RMS_M: f64 = 0.15e-6;
const REFERENCE_RMS_M: f64 = 0.05e-6;
const REFERENCE_FIR: [f64; 5] = [0.15, 0.5, 0.6, 0.25, -0.05];
const ENVELOPE_HZ: f64 = 6.0;

/// What one sample gets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Added to the stylus (m).
    pub stylus_m: f64,
    /// Shown by the reference (m).
    pub reference_m: f64,
}

/// Unit-rms noise with one resonance: `y_k = p y_{k-1} + q y_{k-2} + g e_k`.
#[derive(Clone, Copy, Debug)]
struct Resonance {
    p: f64,
    q: f64,
    gain: f64,
    last: [f64; 2],
}

impl Resonance {
    fn new(frequency_hz: f64, damping: f64, rate_hz: f64) -> Self {
        let w = TAU * frequency_hz / rate_hz;
        let radius = (-damping * w).exp();
        let p = 2.0 * radius * (w * (1.0 - damping * damping).sqrt()).cos();
        let q = -radius * radius;
        // Stationary variance of an AR(2) process driven by unit noise.
        let variance = (1.0 - q) / ((1.0 + q) * ((1.0 - q) * (1.0 - q) - p * p));
        Self { p, q, gain: 1.0 / variance.sqrt(), last: [0.0; 2] }
    }

    fn next(&mut self, noise: f64) -> f64 {
        let [first, second] = self.last;
        let y = self.p * first + self.q * second + self.gain * noise;
        self.last = [y, first];
        y
    }
}

/// One decaying oscillation.
#[derive(Clone, Copy, Debug, Default)]
struct Tap {
    amplitude_m: f64,
    phase: f64,
    turn: f64,
    decay: f64,
}

impl Tap {
    fn draw(rng: &mut ChaCha8Rng, rate_hz: f64) -> Self {
        Self {
            amplitude_m: random::log_uniform(rng, 0.5e-6, 10e-6),
            phase: 0.0,
            turn: TAU * random::uniform(rng, 250.0, 900.0) / rate_hz,
            decay: (-1.0 / (rate_hz * random::uniform(rng, 2e-3, 8e-3))).exp(),
        }
    }

    fn next(&mut self) -> f64 {
        self.phase += self.turn;
        self.amplitude_m *= self.decay;
        self.amplitude_m * self.phase.sin()
    }
}

/// The moving robot, one sample at a time.
#[derive(Clone, Debug)]
pub struct Disturbance {
    rng: ChaCha8Rng,
    rate_hz: f64,
    level: f64,
    taps_per_s: f64,
    resonances: [(Resonance, f64, f64); RESONANCES.len()],
    /// Gain of tone, broadband and taps in the reference.
    gains: [f64; 3],
    tone_phase: f64,
    tone_hz: f64,
    envelope: f64,
    goal: f64,
    left_in_second: f64,
    tap: Tap,
    history: [f64; REFERENCE_FIR.len()],
}

impl Disturbance {
    /// Motion at `level` (1 as above) with `taps_per_s` taps, sampled at `rate_hz`. Resonances above 0.45 of the
    /// rate are left out, since they could only alias.
    #[must_use]
    pub fn new(level: f64, taps_per_s: f64, rate_hz: f64, seed: u64) -> Self {
        let mut rng = random::stream(seed, Purpose::Motion);
        let resonances = RESONANCES.map(|(hz, damping, rms)| {
            let rms = if hz < 0.45 * rate_hz { rms } else { 0.0 };
            (
                Resonance::new(hz.min(0.45 * rate_hz), damping, rate_hz),
                rms,
                random::uniform(&mut rng, 0.7, 1.5),
            )
        });
        let gains = [(); 3].map(|()| random::uniform(&mut rng, 0.7, 1.5));
        Self {
            rng,
            rate_hz,
            level,
            taps_per_s,
            resonances,
            gains,
            tone_phase: 0.0,
            tone_hz: TONE_HZ,
            envelope: 0.0,
            goal: 0.0,
            left_in_second: 0.0,
            tap: Tap::default(),
            history: [0.0; REFERENCE_FIR.len()],
        }
    }

    /// The motion during the next sample.
    pub fn next_sample(&mut self) -> Motion {
        let envelope = self.level * self.next_envelope();
        let mut stylus = 0.0;
        let mut seen = 0.0;
        for (resonance, rms, gain) in &mut self.resonances {
            let part = envelope * *rms * resonance.next(random::normal(&mut self.rng));
            stylus += part;
            seen += *gain * part;
        }
        let tone = envelope * self.next_tone();
        let broadband = envelope * BROADBAND_RMS_M * random::normal(&mut self.rng);
        let tap = self.next_tap();
        for (part, gain) in [tone, broadband, tap].into_iter().zip(self.gains) {
            stylus += part;
            seen += gain * part;
        }
        Motion { stylus_m: stylus, reference_m: self.filter_reference(seen) }
    }

    /// How strongly the robot moves now: 0 still, up to 1 times the level it was made with.
    #[must_use]
    pub fn envelope(&self) -> f64 {
        self.envelope
    }

    fn next_envelope(&mut self) -> f64 {
        if self.left_in_second <= 0.0 {
            self.left_in_second = 1.0;
            let moves = random::uniform(&mut self.rng, 0.0, 1.0) < 0.5;
            let amplitude = random::uniform(&mut self.rng, 0.3, 1.0);
            self.goal = if moves { amplitude } else { 0.0 };
        }
        self.left_in_second -= 1.0 / self.rate_hz;
        let follow = -(-TAU * ENVELOPE_HZ / self.rate_hz).exp_m1();
        self.envelope += follow * (self.goal - self.envelope);
        self.envelope
    }

    /// The frequency walks at random (about 40 Hz in a second) between its bounds.
    fn next_tone(&mut self) -> f64 {
        let walk = TONE_SPAN_HZ / self.rate_hz.sqrt() * random::normal(&mut self.rng);
        self.tone_hz = (self.tone_hz + walk).clamp(TONE_HZ - TONE_SPAN_HZ, TONE_HZ + TONE_SPAN_HZ);
        self.tone_phase = (self.tone_phase + TAU * self.tone_hz / self.rate_hz) % TAU;
        TONE_RMS_M * core::f64::consts::SQRT_2 * self.tone_phase.sin()
    }

    fn next_tap(&mut self) -> f64 {
        if random::uniform(&mut self.rng, 0.0, self.rate_hz) < self.taps_per_s {
            self.tap = Tap::draw(&mut self.rng, self.rate_hz);
        }
        self.tap.next()
    }

    fn filter_reference(&mut self, seen: f64) -> f64 {
        self.history.rotate_right(1);
        if let Some(newest) = self.history.first_mut() {
            *newest = seen;
        }
        let filtered: f64 =
            self.history.iter().zip(REFERENCE_FIR).map(|(value, tap)| value * tap).sum();
        filtered + REFERENCE_RMS_M * random::normal(&mut self.rng)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resonances_have_unit_rms() {
        for (hz, damping, _) in RESONANCES {
            let mut resonance = Resonance::new(hz, damping, 10_000.0);
            let mut rng = random::stream(1, Purpose::Motion);
            let squares: f64 =
                (0..2_000_000).map(|_| resonance.next(random::normal(&mut rng)).powi(2)).sum();
            let rms = (squares / 2e6).sqrt();
            // 200 s hold about 2 pi f zeta 200 / 2 independent stretches, 350 at 14 Hz: 4 % at two sigma.
            assert!((rms - 1.0).abs() < 0.06, "{hz} Hz: {rms}");
        }
    }

    #[test]
    fn it_moves_for_about_half_of_the_time() {
        let mut robot = Disturbance::new(1.0, 0.0, 10_000.0, 3);
        let (mut quiet, mut squares) = (0, 0.0);
        for _ in 0..2_000_000 {
            let motion = robot.next_sample();
            quiet += i32::from(robot.envelope < 0.02);
            squares += motion.stylus_m.powi(2);
        }
        let share = f64::from(quiet) / 2e6;
        assert!((0.3..0.6).contains(&share), "{share}");
        // Full motion has 3.9 um rms; envelope squared averages 0.5 * 0.47.
        let rms = (squares / 2e6).sqrt();
        assert!((1.4e-6..2.4e-6).contains(&rms), "{rms}");
    }

    #[test]
    fn reference_is_alike_but_not_equal() {
        let mut robot = Disturbance::new(1.0, 0.2, 10_000.0, 4);
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for _ in 0..500_000 {
            let Motion { stylus_m: x, reference_m: y } = robot.next_sample();
            xx += x * x;
            yy += y * y;
            xy += x * y;
        }
        let correlation = xy / (xx * yy).sqrt();
        assert!((0.8..0.995).contains(&correlation), "{correlation}");
    }

    #[test]
    fn taps_come_at_their_rate() {
        let mut robot = Disturbance::new(0.0, 5.0, 10_000.0, 5);
        let mut starts = 0;
        let mut loud_before = 0.0;
        for _ in 0..1_000_000 {
            robot.next_sample();
            starts += i32::from(robot.tap.amplitude_m > loud_before);
            loud_before = robot.tap.amplitude_m;
        }
        assert!((420..580).contains(&starts), "{starts}");
    }
}
