//! Model of the stylus: its displacement over the height of the surface under it.
//!
//! A point mass m on a spring k and damper c towards the finger, and a one-sided contact k_c with its own
//! damper c_c towards the surface (Kelvin-Voigt, no adhesion: the contact only pushes):
//!
//! ```text
//! m y'' = -k y - c y' + [h > y] (k_c (h - y) + c_c (h' - y'))
//! ```
//!
//! Defaults: m = 1 g, k = 500 N/m, damping ratio 0.1 of the free stylus, k_c = 1e5 N/m with damping ratio 0.1 of
//! the loaded one. Within a step the surface moves at constant speed and the contact does not change, so
//! the equation is linear and is solved in closed form (damped oscillator; see W. T. Thomson, "Theory of
//! Vibration"): stable for every step, exact but for the instant at which contact changes.
//!
//! A step that changed nothing, over a surface that stood still, is not computed again until the surface moves (test
//! `resting_changes_no_bit`): most of a grasp is that.

/// Slower than this is at rest (m/s): far below the last bit of any displacement, and far above the numbers that processors are slow with.
const REST_M_S: f64 = 1e-100;

/// Mass, springs and dampers; all positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StylusConfig {
    /// Moving mass (kg).
    pub mass_kg: f64,
    /// Stiffness of the suspension (N/m).
    pub stiffness_n_m: f64,
    /// Damping ratio of the free stylus, below 1.
    pub damping_ratio: f64,
    /// Stiffness of the contact (N/m).
    pub contact_n_m: f64,
    /// Damping ratio of the contact, below 1.
    pub contact_damping_ratio: f64,
}

impl Default for StylusConfig {
    fn default() -> Self {
        Self {
            mass_kg: 1e-3,
            stiffness_n_m: 500.0,
            damping_ratio: 0.1,
            contact_n_m: 1e5,
            contact_damping_ratio: 0.1,
        }
    }
}

/// Closed-form step of y'' + 2 a y' + w0^2 y = 0 over a fixed time.
#[derive(Clone, Copy, Debug)]
struct Propagator {
    yy: f64,
    yv: f64,
    vy: f64,
    vv: f64,
}

impl Propagator {
    /// For mass `m`, damper `c` and spring `k` with c^2 < 4 k m.
    fn new(m: f64, c: f64, k: f64, dt: f64) -> Self {
        let a = 0.5 * c / m;
        let w = (k / m - a * a).sqrt();
        let (sin, cos) = (w * dt).sin_cos();
        let decay = (-a * dt).exp();
        Self {
            yy: decay * (cos + a / w * sin),
            yv: decay * sin / w,
            vy: -decay * (w + a * a / w) * sin,
            vv: decay * (cos - a / w * sin),
        }
    }

    fn apply(&self, y: f64, v: f64) -> (f64, f64) {
        (self.yy * y + self.yv * v, self.vy * y + self.vv * v)
    }
}

/// The stylus of one finger, advanced in steps of fixed length.
#[derive(Clone, Copy, Debug)]
pub struct Stylus {
    config: StylusConfig,
    dt: f64,
    damper: f64,
    contact_damper: f64,
    free: Propagator,
    touching: Propagator,
    y: f64,
    v: f64,
    level: f64,
    /// The last step changed nothing.
    rests: bool,
    dissipated_j: f64,
}

impl Stylus {
    /// A stylus at rest, out of contact, advanced `dt` (s) a step.
    #[must_use]
    pub fn new(config: StylusConfig, dt: f64) -> Self {
        let StylusConfig { mass_kg: m, stiffness_n_m: k, contact_n_m: kc, .. } = config;
        let damper = 2.0 * config.damping_ratio * (k * m).sqrt();
        let contact_damper = 2.0 * config.contact_damping_ratio * (kc * m).sqrt();
        Self {
            config,
            dt,
            damper,
            contact_damper,
            free: Propagator::new(m, damper, k, dt),
            touching: Propagator::new(m, damper + contact_damper, k + kc, dt),
            y: 0.0,
            v: 0.0,
            level: f64::NEG_INFINITY,
            rests: false,
            dissipated_j: 0.0,
        }
    }

    /// Goes on with steps of `dt` (s).
    pub fn set_step(&mut self, dt: f64) {
        let Self { y, v, level, dissipated_j, config, .. } = *self;
        *self = Self { y, v, level, dissipated_j, ..Self::new(config, dt) };
    }

    /// Advances one step while the surface moves to `level` (m) above the free position of the tip;
    /// minus infinity where there is no surface.
    #[inline]
    pub fn step(&mut self, level: f64) {
        if !(self.rests && level == self.level) {
            self.advance(level);
        }
    }

    fn advance(&mut self, level: f64) {
        let start = if self.level.is_finite() { self.level } else { level };
        let (y, v) = (self.y, self.v);
        let rate = if level.is_finite() { (level - start) / self.dt } else { 0.0 };
        let before = self.loss_rate(start, rate);
        if self.contact_force(start, rate) > 0.0 {
            self.step_touching(start, rate);
        } else {
            (self.y, self.v) = self.free.apply(self.y, self.v);
        }
        if self.v.abs() < REST_M_S {
            self.v = 0.0;
        }
        self.dissipated_j += 0.5 * self.dt * (before + self.loss_rate(level, rate));
        self.rests = level == self.level && self.y == y && self.v == v;
        self.level = level;
    }

    /// Displacement of the tip (m), positive into the finger.
    #[must_use]
    pub fn displacement_m(&self) -> f64 {
        self.y
    }

    /// Energy turned into heat so far by suspension and contact (J).
    #[must_use]
    pub fn dissipated_j(&self) -> f64 {
        self.dissipated_j
    }

    /// Energy of motion and of the springs (J).
    #[must_use]
    pub fn stored_j(&self) -> f64 {
        let depth = (self.level - self.y).max(0.0);
        let c = self.config;
        0.5 * (c.mass_kg * self.v * self.v
            + c.stiffness_n_m * self.y * self.y
            + c.contact_n_m * depth * depth)
    }

    /// Force of the surface on the tip (N) for a surface at `level` moving at `rate`.
    fn contact_force(&self, level: f64, rate: f64) -> f64 {
        let depth = level - self.y;
        if depth <= 0.0 {
            return 0.0;
        }
        (self.config.contact_n_m * depth + self.contact_damper * (rate - self.v)).max(0.0)
    }

    fn loss_rate(&self, level: f64, rate: f64) -> f64 {
        let suspension = self.damper * self.v * self.v;
        if self.contact_force(level, rate) > 0.0 {
            suspension + self.contact_damper * (rate - self.v) * (rate - self.v)
        } else {
            suspension
        }
    }

    /// The surface is a ramp within the step: y follows the straight line that solves the forced equation,
    /// plus a free oscillation about it.
    fn step_touching(&mut self, start: f64, rate: f64) {
        let c = self.config;
        let k = c.stiffness_n_m + c.contact_n_m;
        let line_rate = c.contact_n_m * rate / k;
        let offset = (c.contact_n_m * start + self.contact_damper * rate
            - (self.damper + self.contact_damper) * line_rate)
            / k;
        let (y, v) = self.touching.apply(self.y - offset, self.v - line_rate);
        self.y = offset + line_rate * self.dt + y;
        self.v = line_rate + v;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rests_at_the_balance_of_both_springs() {
        let mut stylus = Stylus::new(StylusConfig::default(), 1e-5);
        (0..200_000).for_each(|_| stylus.step(200e-6));
        let expected = 200e-6 * 1e5 / 100_500.0;
        assert!((stylus.displacement_m() - expected).abs() < 1e-12);
    }

    #[test]
    fn slow_ride_follows_the_profile_and_fast_ride_leaves_it() {
        let ride = |speed: f64| {
            let mut stylus = Stylus::new(StylusConfig::default(), 1e-5);
            let level =
                |t: f64| 200e-6 + 5e-6 * (core::f64::consts::TAU * speed * t / 200e-6).sin();
            let mut worst: f64 = 0.0;
            for k in 0..50_000 {
                let t = f64::from(k) * 1e-5;
                stylus.step(level(t));
                if k > 40_000 {
                    worst = worst.max((stylus.displacement_m() - level(t)).abs());
                }
            }
            worst
        };
        // The static indentation of 1 um remains.
        assert!(ride(1e-3) < 1.2e-6, "{}", ride(1e-3));
        assert!(ride(0.2) > 3e-6, "{}", ride(0.2));
    }

    #[test]
    fn free_swing_loses_exactly_what_it_stored() {
        let mut stylus = Stylus::new(StylusConfig::default(), 1e-6);
        (0..100_000).for_each(|_| stylus.step(200e-6));
        let (stored, spent) = (stylus.stored_j(), stylus.dissipated_j());
        (0..2_000_000).for_each(|_| stylus.step(f64::NEG_INFINITY));
        let depth_energy = 0.5 * 1e5 * (200e-6 / 201.0_f64).powi(2);
        let lost = stylus.dissipated_j() - spent;
        assert!((lost / (stored - depth_energy) - 1.0).abs() < 1e-3, "{lost} {stored}");
    }

    #[test]
    fn resting_changes_no_bit() {
        // Touch, rest for 3 s, ride, rest again, leave.
        let level = |k: u32| match k {
            0..300_000 => 200e-6,
            300_000..320_000 => 200e-6 + 5e-6 * (f64::from(k) * 1e-3).sin(),
            320_000..600_000 => 203e-6,
            _ => f64::NEG_INFINITY,
        };
        let mut fast = Stylus::new(StylusConfig::default(), 1e-5);
        let mut slow = fast;
        let mut rested = 0;
        for k in 0..900_000 {
            rested += u32::from(fast.rests);
            fast.step(level(k));
            slow.advance(level(k));
            assert_eq!(fast.y.to_bits(), slow.y.to_bits(), "step {k}");
        }
        assert!(rested > 400_000, "{rested} steps at rest");
        assert!((fast.dissipated_j / slow.dissipated_j - 1.0).abs() < 1e-12);
    }

    #[test]
    fn displacement_does_not_depend_on_the_step() {
        // Touch at 10 mm/s, then 5 um asperities at a speed that keeps contact.
        let level = |t: f64| {
            let rest = (0.01 * t - 2e-5).min(200e-6);
            rest + 2.5e-6 * (1.0 - (core::f64::consts::TAU * 150.0 * t).cos())
        };
        let run = |steps_per_sample: u32| {
            let dt = 1e-4 / f64::from(steps_per_sample);
            let mut stylus = Stylus::new(StylusConfig::default(), dt);
            let mut path = Vec::new();
            for k in 0..3000 * steps_per_sample {
                stylus.step(level(f64::from(k + 1) * dt));
                if (k + 1) % steps_per_sample == 0 {
                    path.push(stylus.displacement_m());
                }
            }
            path
        };
        let (coarse, fine) = (run(10), run(20));
        let apart = |range: core::ops::Range<usize>| {
            coarse[range.clone()]
                .iter()
                .zip(&fine[range])
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        println!(
            "halving the step: {:.1e} m while it bounces, {:.1e} m once it rides",
            apart(0..500),
            apart(500..3000)
        );
        assert!(apart(0..500) < 2e-6 && apart(500..3000) < 1e-9);
    }
}
