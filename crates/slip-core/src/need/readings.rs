//! Power of an accelerometer in a slip, and readings kept until another sensor is lost.

use super::{
    CANDIDATES, FIRST, FORCES, FORGET_S, Felt, Law, Need, RAMPS, SLOW_M_S, STEP, candidate::ln,
};

// Vibration of an accelerometer: its power, and the needed force that follows from its course.

/// A reading counts up to so many deviations of the noise: what is more is no vibration.
const MOST: f32 = 1e6;
/// Time constant of the mean that is taken off (s): gravity and slow motion.
const MEAN_S: f32 = 1.6e-3;
/// Neighbouring blocks state nearly the same: weight of one.
const WEIGHT: f32 = 0.25;
/// Vibration over noise (rms) at this speed (m/s), least and most.
const SPEED_M_S: f32 = 0.1;
const LEVEL: [f32; 2] = [0.2, 1000.0];
/// Distance that the object has moved when the alarm comes (m): slow sliding is below the noise.
const ALARM_M: f32 = 1e-4;
/// What is below this share of the largest power is the finger that rings.
const ECHO: f32 = 0.01;
/// The finger rings on for so long (s).
const RINGS_S: f32 = 2.5e-3;
/// Weight of the last block in the vibration, and in a quicker one.
const SMOOTHING: f32 = 0.1;
const QUICK: f32 = 0.25;
/// Power over that of the noise: of a finger that vibrates, that vibrates much, that is quiet, and that begins to vibrate again.
const VIBRATES: f32 = 2.0;
const LOUD: f32 = 6.0;
const QUIET: f32 = 1.7;
const AGAIN: f32 = 3.4;
/// Power at an alarm.
const ALARMS: f32 = 4.0;
/// It is quiet for so many blocks, and no earlier than this after the alarm (s), where the object has stopped.
const QUIET_BLOCKS: u16 = 8;
const STOPS_AFTER_S: f32 = 6.5e-3;
/// Slowest that an object slides whose finger rings (m/s).
const CREEP_M_S: f32 = 2e-4;

/// The law of a vibration in deviations of its noise, for blocks of `d_s` (s).
pub(super) fn law(d_s: f32) -> Law {
    let slope = LEVEL.map(|level| level / (SPEED_M_S * d_s));
    Law { slope, alarm_m: ALARM_M, turns: false }
}

/// Sums of one candidate that know the ringing.
#[derive(Clone, Copy, Debug, Default)]
struct Ringing {
    /// Smoothed square of the distance in a block (m^2).
    echo: f32,
    squares: f32,
    logs: f32,
    misfit: f32,
}

/// Its power over that of the noise, and what every candidate expects.
///
/// A finger over which an object slides vibrates with a power that grows with the square of the speed, on top of that
/// of the noise. What is believed follows the course of the speed as with a stylus, but there are no peaks to count,
/// and the finger rings on for milliseconds after the object has slowed down. That costs little while the force rises;
/// the force to hold with is found by a second set of sums, which knows the ringing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vibration {
    mean: Option<f32>,
    slow: f32,
    most: f32,
    quick: f32,
    quiet: u16,
    ringing: [Ringing; CANDIDATES],
}

impl Default for Vibration {
    fn default() -> Self {
        let ringing = [Ringing::default(); CANDIDATES];
        Self { mean: None, most: 0.0, slow: 0.0, quick: 0.0, quiet: 0, ringing }
    }
}

impl Vibration {
    /// An alarm: the power is above that of the noise until it is known by how much.
    pub(super) fn begin(&mut self) {
        (self.mean, self.slow, self.quick) = (None, ALARMS, ALARMS);
        self.start();
    }

    /// The object begins to move.
    pub(super) fn start(&mut self) {
        (self.quiet, self.most) = (0, 0.0);
        self.ringing.fill(Ringing::default());
    }

    /// A reading (deviations of the noise) without the mean of the last ones.
    pub(super) fn without_mean(&mut self, x: f32, dt_s: f32) -> f32 {
        let mean = self.mean.get_or_insert(x);
        let without = (x - *mean).clamp(-MOST, MOST);
        *mean += (dt_s / MEAN_S).min(1.0) * without;
        without
    }
}

impl Need {
    /// One block: mean square of the readings over that of the noise, and the force (N).
    pub(super) fn block_of_vibration(&mut self, power: f32, force_n: f32) {
        let vibration = &mut self.vibration;
        vibration.most = vibration.most.max(vibration.slow);
        let noise = (ECHO * vibration.most).max(1.0);
        vibration.slow += SMOOTHING * (power - vibration.slow);
        vibration.quick += QUICK * (power - vibration.quick);
        if !self.felt.moves {
            self.stopped.since_s += self.block_s;
            if self.vibration.quick > AGAIN * noise {
                self.start(force_n, FIRST);
            }
            return;
        }
        self.felt.since_s += self.block_s;
        self.believe(power, noise, WEIGHT, force_n);
        self.ring(power, noise);
        let slow = self.vibration.slow;
        self.felt = Felt {
            vibrates: slow > VIBRATES * noise,
            unexplained: self.speed_m_s < SLOW_M_S && slow > LOUD * noise,
            ..self.felt
        };
        self.vibration.quiet = if slow < QUIET * noise { self.vibration.quiet + 1 } else { 0 };
        if self.vibration.quiet >= QUIET_BLOCKS && self.felt.since_s > STOPS_AFTER_S {
            self.stopped.since_s = 0.0;
            let held_n = Some(self.rung_n().max(self.felt.from_n));
            self.felt = Felt { moves: false, vibrates: false, held_n, ..self.felt };
        }
    }

    /// Weighs a block for a finger that rings.
    fn ring(&mut self, power: f32, noise: f32) {
        let keep = libm::expf(-self.block_s / FORGET_S);
        let rings = libm::expf(-self.block_s / RINGS_S);
        let least = (CREEP_M_S * self.block_s) * (CREEP_M_S * self.block_s);
        let noise = noise / self.signal(noise, WEIGHT);
        let ways = self.rows.iter().flat_map(|row| &row.way_m);
        for (one, way_m) in self.vibration.ringing.iter_mut().zip(ways) {
            one.echo = one.echo * rings + (1.0 - rings) * way_m * way_m;
            let square = one.echo.max(least);
            one.squares = one.squares * keep + WEIGHT * square;
            let variance = square + one.squares * noise;
            one.logs = one.logs * keep + WEIGHT * ln(variance);
            one.misfit = one.misfit * keep + WEIGHT * power / variance;
        }
    }

    /// Needed force (N) by the sums that know the ringing.
    fn rung_n(&self) -> f32 {
        let likelihood = |one: &Ringing| {
            -0.5 * one.logs - (0.5 * self.weight + 0.5) * libm::logf(one.misfit + 1e-30)
        };
        let all = || self.vibration.ringing.chunks_exact(FORCES).zip(RAMPS);
        let best = all()
            .flat_map(|(forces, _)| forces.iter().map(likelihood))
            .fold(f32::NEG_INFINITY, f32::max);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (forces, (_, ramp_ln)) in all() {
            let mut ln = 0.5 * STEP;
            for one in forces {
                let p = libm::expf(likelihood(one) - best + ramp_ln);
                (sum, weights) = (sum + p * ln, weights + p);
                ln += STEP;
            }
        }
        self.felt.from_n * libm::expf(sum / weights)
    }
}

// Buffer of readings of a slip that another sensor measures: it returns them in order once that sensor is lost.

/// Readings that are kept: 0.1 s at 10 kHz. A slip that was measured for longer is not made up for.
const KEPT: usize = 1024;

/// Stylus (m) and force (N) since the alarm.
#[derive(Clone, Copy, Debug)]
pub(super) struct History {
    readings: [(f32, f32); KEPT],
    kept: usize,
    taken: usize,
    lost: bool,
}

impl Default for History {
    fn default() -> Self {
        Self { readings: [(0.0, 0.0); KEPT], kept: 0, taken: 0, lost: false }
    }
}

impl History {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        (self.kept, self.taken, self.lost) = (0, 0, false);
    }

    /// Whether everything that was kept has been taken, and nothing was lost.
    pub(super) fn is_empty(&self) -> bool {
        self.kept == self.taken && !self.lost
    }

    /// Keeps another one; where there is no room the slip cannot be made up for.
    #[inline]
    pub(super) fn keep(&mut self, x_m: f32, force_n: f32) {
        match self.readings.get_mut(self.kept) {
            Some(place) => {
                *place = (x_m, force_n);
                self.kept += 1;
            }
            None => self.lost = true,
        }
    }

    /// The oldest one that was not taken.
    pub(super) fn next(&mut self) -> Option<(f32, f32)> {
        let next = self.readings.get(self.taken).filter(|_| self.taken < self.kept && !self.lost);
        let next = next.copied();
        self.taken += usize::from(next.is_some());
        next
    }
}
