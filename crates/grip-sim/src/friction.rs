//! Friction of one finger: the tangential force at a relative speed and normal force.
//!
//! LuGre model (C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A new model for control of
//! systems with friction", IEEE Trans. Automatic Control 40(3), 1995): the pad's elastic shear is a bristle
//! deflection z with
//!
//! ```text
//! z' = v - |v| z sigma0 / g,   F = sigma0 z + sigma1 z',   g = N (mu_k + (mu_s - mu_k) exp(-(v / v_s)^2))
//! ```
//!
//! For v and N constant over a step the first equation is linear and is integrated exactly:
//! z tends to g sgn(v) / sigma0 as exp(-|v| sigma0 dt / g). The step is therefore stable for every dt.
//! When the normal force falls, z is limited to what the smaller force can hold, so that unloading makes a
//! stuck object slip. The contact itself has no viscous friction: sliding force is mu_k N, which is what the impulse balance
//! of the trial grasp assumes. A scene may add some to the object as a whole ([`crate::scene::Object::viscous_n_s_m`]).
//!
//! Under an oscillating load below break-away the LuGre bristle drifts; a constant load does not. The elasto-plastic model
//! (P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, "Single state elastoplastic friction models", IEEE Trans. Automatic
//! Control 47(5), 2002) keeps shear below a share of the break-away shear elastic: z' = v - alpha |v| z sigma0 / g, where alpha
//! rises from 0 at that share to 1 at break-away as half a sine wave, and is 0 while the pad is unloaded. A share of 0 is LuGre.
//!
//! Limits: both fingers of a grasp share one state because they see the same load.

/// Pad and contact parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LuGreConfig {
    /// Tangential stiffness sigma0 of one pad (N/m). A 3 mm pad of 1 MPa shear modulus and 3 cm^2 has 1e5.
    pub stiffness_n_m: f64,
    /// Bristle damping sigma1 (N s/m).
    pub damping_n_s_m: f64,
    /// Kinetic coefficient mu_k.
    pub kinetic: f64,
    /// mu_s / mu_k, at least 1.
    pub static_ratio: f64,
    /// Stribeck speed v_s (m/s).
    pub stribeck_m_s: f64,
    /// Share of the break-away shear below which the pad only deforms: 0 (LuGre) to 0.99.
    pub elastic_share: f64,
}

/// The contact of one finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LuGre {
    config: LuGreConfig,
    bristle_m: f64,
    saturation: f64,
}

impl LuGre {
    /// A contact without shear.
    #[must_use]
    pub fn new(config: LuGreConfig) -> Self {
        Self { config, bristle_m: 0.0, saturation: 0.0 }
    }

    /// Advances by `dt` (s) at relative speed `speed` (m/s) under normal force `normal` (N); returns the
    /// friction force (N), positive against positive speed. Without normal force there is no friction.
    pub fn step(&mut self, speed: f64, normal: f64, dt: f64) -> f64 {
        let c = self.config;
        let limit = normal.max(0.0) * c.kinetic * self.stribeck(speed);
        if limit <= 0.0 {
            self.bristle_m = 0.0;
            self.saturation = 1.0;
            return 0.0;
        }
        let largest = normal * c.kinetic * c.static_ratio / c.stiffness_n_m;
        let old = self.bristle_m.clamp(-largest, largest);
        let steady = limit / c.stiffness_n_m;
        let alpha = self.plasticity(old, speed, steady);
        let new = if alpha > 0.0 {
            old - exp_m1(-alpha * speed.abs() * dt / steady)
                * ((steady / alpha).copysign(speed) - old)
        } else {
            old + speed * dt
        };
        let new = new.clamp(-largest, largest);
        self.bristle_m = new;
        self.saturation = alpha * new * speed.signum() / steady;
        c.stiffness_n_m * new + c.damping_n_s_m * (new - old) / dt
    }

    /// The kinetic coefficient from now on: a contact that gets wet, or dries.
    pub fn set_kinetic(&mut self, kinetic: f64) {
        self.config.kinetic = kinetic;
    }

    /// Elastic shear of the pad (m).
    #[must_use]
    pub fn shear_m(&self) -> f64 {
        self.bristle_m
    }

    /// Share of the present motion that is slip rather than elastic shear: 0 sticking, 1 sliding.
    #[must_use]
    pub fn slip_share(&self) -> f64 {
        self.saturation
    }

    /// alpha of the elasto-plastic model, 0 - 1: the share of a motion at `speed` that is sliding once the shear is `steady` (m).
    fn plasticity(&self, shear: f64, speed: f64, steady: f64) -> f64 {
        let elastic = self.config.elastic_share;
        if elastic <= 0.0 {
            return 1.0;
        }
        let loaded = shear * speed.signum() / steady;
        let way = ((loaded - elastic) / (1.0 - elastic)).clamp(0.0, 1.0);
        0.5 - 0.5 * (core::f64::consts::PI * way).cos()
    }

    fn stribeck(&self, speed: f64) -> f64 {
        let ratio = speed / self.config.stribeck_m_s;
        let faded = ratio * ratio;
        let share = if faded < STILL { 1.0 } else { (-faded).exp() };
        1.0 + (self.config.static_ratio - 1.0) * share
    }
}

/// Below it exp(-x) rounds to 1.
const STILL: f64 = 1e-17;
/// Below it five terms of the series of exp(x) - 1 leave less than half a last digit: x^5 / 720 = 1.4e-18.
const SERIES_BELOW: f64 = 1e-3;

/// exp(x) - 1, faster where x is small: an object that is held creeps by 1e-12 m/s.
#[inline]
fn exp_m1(x: f64) -> f64 {
    if x.abs() < SERIES_BELOW {
        x * (1.0 + x * (1.0 / 2.0 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x * (1.0 / 120.0)))))
    } else {
        x.exp_m1()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAD: LuGreConfig = LuGreConfig {
        stiffness_n_m: 1e5,
        damping_n_s_m: 50.0,
        kinetic: 0.3,
        static_ratio: 1.2,
        stribeck_m_s: 5e-3,
        elastic_share: 0.0,
    };

    #[test]
    fn fast_sliding_gives_kinetic_friction_both_ways() {
        for speed in [0.1, -0.1] {
            let mut contact = LuGre::new(PAD);
            let force = (0..10_000).map(|_| contact.step(speed, 4.0, 1e-5)).last().unwrap();
            assert!((force - 1.2_f64.copysign(speed)).abs() < 1e-9, "{force}");
        }
    }

    #[test]
    fn the_series_is_the_function_to_the_last_digits() {
        let mut worst: f64 = 0.0;
        for exponent in -2000..-100 {
            for sign in [1.0, -1.0] {
                let x = sign * 10f64.powf(f64::from(exponent) * 0.03);
                worst = worst.max((exp_m1(x) / x.exp_m1() - 1.0).abs());
            }
        }
        assert!(worst <= 2.0 * f64::EPSILON, "{worst}");
        let contact = LuGre::new(PAD);
        for speed in [0.0, 1e-12, 1e-11, 1e-9] {
            let ratio: f64 = speed / PAD.stribeck_m_s;
            let plain = 1.0 + (PAD.static_ratio - 1.0) * (-ratio * ratio).exp();
            assert_eq!(contact.stribeck(speed), plain, "{speed}");
        }
    }

    #[test]
    fn slow_sliding_gives_static_friction() {
        let mut contact = LuGre::new(PAD);
        let force = (0..400_000).map(|_| contact.step(1e-4, 4.0, 1e-5)).last().unwrap();
        assert!((force - 1.44).abs() < 1e-3, "{force}");
    }

    #[test]
    fn any_step_is_stable() {
        for exponent in -7..4 {
            let dt = 10f64.powi(exponent);
            let mut contact = LuGre::new(LuGreConfig { damping_n_s_m: 0.0, ..PAD });
            for k in 0..1000 {
                let speed = 3.0 * (f64::from(k) * 0.7).sin();
                let force = contact.step(speed, 4.0, dt);
                assert!(force.abs() <= 1.44 + 1e-12, "dt {dt}: {force}");
            }
        }
    }

    #[test]
    fn one_exact_step_equals_a_thousand_small_ones() {
        let slide = |steps: u32| {
            let mut contact = LuGre::new(PAD);
            (0..steps).for_each(|_| {
                contact.step(0.02, 4.0, 1e-3 / f64::from(steps));
            });
            contact.shear_m()
        };
        assert!((slide(1) - slide(1000)).abs() < 1e-15);
    }

    /// How far (m) a held object of 0.1 kg creeps in 10 s when its load swings between half and nine tenths of what friction holds.
    fn creep(elastic_share: f64) -> f64 {
        let mut contact = LuGre::new(LuGreConfig { elastic_share, static_ratio: 1.0, ..PAD });
        let (dt, mass, held_n) = (1e-5, 0.1, 1.2);
        let (mut speed, mut place, mut settled) = (0.0, 0.0, 0.0);
        for k in 0..1_100_000 {
            let t = f64::from(k) * dt;
            let load = held_n * (0.7 + 0.2 * (core::f64::consts::TAU * 10.0 * t).sin());
            speed += dt / mass * (load - contact.step(speed, 4.0, dt));
            place += speed * dt;
            if k == 100_000 {
                settled = place;
            }
        }
        place - settled
    }

    #[test]
    fn an_elastic_pad_does_not_creep_under_a_load_that_swings_below_break_away() {
        assert!(creep(0.0) > 5e-5, "{}", creep(0.0));
        assert!(creep(0.95).abs() < 1e-6, "{}", creep(0.95));
    }

    #[test]
    fn an_elastic_pad_slides_with_the_same_friction() {
        let mut contact = LuGre::new(LuGreConfig { elastic_share: 0.7, ..PAD });
        let force = (0..10_000).map(|_| contact.step(0.1, 4.0, 1e-5)).last().unwrap();
        assert!((force - 1.2).abs() < 1e-6, "{force}");
    }

    #[test]
    fn unloading_limits_the_shear() {
        let mut contact = LuGre::new(PAD);
        (0..10_000).for_each(|_| {
            contact.step(0.1, 4.0, 1e-5);
        });
        contact.step(0.0, 1.0, 1e-5);
        assert!(contact.shear_m() <= 1.2 * 0.3 / 1e5 + 1e-15);
        assert!(contact.step(0.1, 0.0, 1e-5).abs() < f64::EPSILON);
    }
}
