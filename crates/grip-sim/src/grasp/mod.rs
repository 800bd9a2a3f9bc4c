//! Simulation of a grasp, driven by a force target for each sample period: sensor samples and the truth of a scene.
//!
//! Two equal fingers press an object of mass m with force N each. A support carries it until the lift and then
//! hands its weight over in a ramp r(t) from 0 to 1. Both fingers see the same load, so one friction
//! state stands for both:
//!
//! ```text
//! m x'' = r(t) m (g + a(t)) + P(t) + m' (u - x') - 2 F_t(x', N) - c x'
//! ```
//!
//! x is the travel of the object along the fingers, elastic shear of the pads included, a(t) the acceleration of the hand upwards, P(t) a
//! pull, c x' the viscous friction of both fingers, and m' (u - x') what is poured in at the speed u ([`crate::scene`]); mass and friction may change while it is held. Sliding gives F_t = mu_k N, hence g (t1 - t0) - (v1 - v0) = (2 mu_k / m) * integral of N, the impulse
//! balance from which a trial grasp learns the needed force m g / (2 mu_k).
//!
//! With viscous friction an object under too little force ends at the steady speed (load - 2 mu_k N) / c; the needed force stays what it is.
//!
//! Integration is semi-implicit (Euler-Cromer) in x, implicit in c x' (stable for every c) and exact in bristle, drive lag and stylus. Halving the
//! default step of 10 us moves the travel of a slip by less than 0.2 % (test `halving_the_step`).

mod clairvoyant;
mod clock;
mod sensors;
mod world;

pub use clairvoyant::{Clairvoyant, perfect_controller_can_hold};

use crate::actuator::Actuator;
use crate::friction::LuGre;
use crate::scene::Scene;
use crate::stylus::{Stylus, StylusConfig};
use crate::surface::Surface;
use clock::SampleClock;
pub(crate) use sensors::narrow;
use sensors::{Readings, Sensors};
use slip_core::sample::Sample;
use slip_core::units::Micros;
use world::World;

/// How far the stylus stands out of the pad (m): its depth of pre-load once the fingers touch.
const STYLUS_PRELOAD_M: f64 = 200e-6;
/// Where on the profile the stylus lands (m); leaves room for elastic travel to both sides.
pub(crate) const LANDING_M: f64 = 1e-3;
/// Slower motion is not called slip (m/s).
const SLIP_SPEED_M_S: f64 = 1e-4;

/// What becomes of the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// The fingers are open or closing.
    #[default]
    Open,
    /// Touched; the support carries the object.
    Supported,
    /// The support is being lowered or gone.
    Lifted,
    /// The object left the fingers, for good.
    Dropped,
}

/// What no sensor knows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Time since the start (s).
    pub time_s: f64,
    /// Largest force of each finger, so far, at which sliding friction balances the load: m g / (2 mu_k) for a weight alone (N). A slip
    /// stops decelerating below it; an object that never slipped is held by less, by mu_s / mu_k.
    pub force_needed_n: f64,
    /// The same, as of now (N).
    pub needed_now_n: f64,
    /// Force of each finger (N).
    pub applied_n: f64,
    /// Largest force of a finger so far (N).
    pub force_peak_n: f64,
    /// Travel of the object since the lift, elastic shear included (m).
    pub travel_m: f64,
    /// Part of the travel that the pads would take back (m).
    pub shear_m: f64,
    /// Speed of the object against the fingers (m/s).
    pub speed_m_s: f64,
    /// Where the object is.
    pub phase: Phase,
    /// The force exceeded the crush limit at some time.
    pub crushed: bool,
    /// The object slips now: faster than 0.1 mm/s, and more than half of the motion is not elastic.
    pub slipping: bool,
    /// From the lift to the end of the last slip (s); 0 where nothing slipped.
    pub stable_after_s: f64,
}

impl Truth {
    /// Travel that is slip (mm).
    #[must_use]
    pub fn slip_mm(&self) -> f64 {
        (self.travel_m - self.shear_m) * 1e3
    }

    /// The object left the fingers.
    #[must_use]
    pub fn dropped(&self) -> bool {
        self.phase == Phase::Dropped
    }

    /// The support has been lowered, whatever came of it.
    #[must_use]
    pub fn lifted(&self) -> bool {
        matches!(self.phase, Phase::Lifted | Phase::Dropped)
    }
}

/// The second stylus, with its own place on the same surface.
#[derive(Clone, Debug)]
struct Second {
    stylus: Stylus,
    surface: Surface,
    spacing_m: f64,
}

/// One grasp from open fingers to the end of the object.
#[derive(Clone, Debug)]
pub struct Grasp {
    world: World,
    drive: Actuator,
    contact: LuGre,
    surface: Surface,
    stylus: Stylus,
    second: Option<Second>,
    sensors: Sensors,
    /// Tangential force of one finger (N).
    friction_n: f64,
    truth: Truth,
    clock: SampleClock,
    phase_since_s: f64,
}

impl Grasp {
    /// Open fingers over the supported object of `scene`.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let world = World::of(scene);
        let object = scene.object();
        let config = scene.config();
        Self {
            world,
            drive: Actuator::new(world::drive_of(scene)),
            contact: LuGre::new(world::contact_of(scene)),
            surface: scene.surface(),
            stylus: Stylus::new(StylusConfig::default(), world.step_s),
            second: config.second_stylus_mm.map(|spacing_mm| Second {
                stylus: Stylus::new(StylusConfig::default(), world.step_s),
                surface: scene.surface(),
                spacing_m: 1e-3 * spacing_mm,
            }),
            sensors: Sensors::new(config, scene.gains()),
            friction_n: 0.0,
            truth: Truth {
                force_needed_n: object.force_needed_n(),
                needed_now_n: object.force_needed_n(),
                ..Truth::default()
            },
            clock: SampleClock::new(config.sample_rate_hz),
            phase_since_s: 0.0,
        }
    }

    /// Advances one sample period towards `force_target_n` (N) and reads the sensors at its end.
    ///
    /// Targets are limited to 0..=F_max; NaN holds the last set point. The fingers start to close at
    /// the first positive target.
    pub fn step_sample(&mut self, force_target_n: f64) -> Sample {
        self.step_sample_with(|_| force_target_n)
    }

    /// As [`Grasp::step_sample`] with a target that may change within the period: `target_n` is asked at its
    /// begin and then each millisecond.
    pub fn step_sample_with(&mut self, mut target_n: impl FnMut(Micros) -> f64) -> Sample {
        let begin = self.clock.last();
        let mut force_target_n = 0.0;
        for step in 0..self.world.steps_per_sample {
            if step % self.world.steps_per_ms == 0 {
                let ms = step / self.world.steps_per_ms;
                force_target_n = target_n(begin.plus(Micros::from_millis(ms)));
            }
            self.step(begin, step + 1, force_target_n);
        }
        self.clock.count();
        let readings = Readings {
            t: self.clock.last(),
            slides_m_s: self.truth.speed_m_s * self.contact.slip_share().clamp(0.0, 1.0),
            stylus_m: self.stylus.displacement_m(),
            second_m: self.second.as_ref().map(|second| second.stylus.displacement_m()),
            force_n: self.truth.applied_n,
            travel_m: self.truth.travel_m,
            tangential_n: self.friction_n,
        };
        self.sensors.read(readings)
    }

    /// The truth at the end of the last sample period.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.truth
    }

    /// Takes the support away with the next sample, whenever the scene would.
    pub fn lift(&mut self) {
        self.world.lift_after_s = 0.0;
    }

    /// Whether the fingers travel while the force aimed at is `target_n` (N); pressing on the object is no travel.
    #[must_use]
    pub fn fingers_travel(&self, target_n: f64) -> bool {
        self.drive.travels(target_n)
    }

    /// Limits the slew of the force (N/s); the drive's own limit stays.
    pub fn set_slew(&mut self, slew_n_s: f64) {
        self.drive.set_slew(slew_n_s);
    }

    /// The sample period (s).
    #[must_use]
    pub fn period_s(&self) -> f64 {
        1.0 / f64::from(self.clock.rate_hz())
    }

    /// Time stamp of the last sample; zero before the first.
    #[must_use]
    pub fn now(&self) -> Micros {
        self.clock.last()
    }

    /// Goes on with another sample rate (Hz), limited to 1 to 20000; the motion of the robot begins anew.
    pub fn set_sample_rate(&mut self, rate_hz: u32) {
        let rate_hz = rate_hz.clamp(1, 20_000);
        if rate_hz != self.clock.rate_hz() {
            self.clock = self.clock.at_rate(rate_hz);
            self.world.set_rate(rate_hz);
            self.stylus.set_step(self.world.step_s);
            if let Some(second) = &mut self.second {
                second.stylus.set_step(self.world.step_s);
            }
            self.sensors.set_rate(rate_hz);
        }
    }

    /// Time stamp the next sample will carry.
    #[must_use]
    pub fn next_sample_at(&self) -> Micros {
        self.clock.ahead(1)
    }

    /// Energy the stylus has turned into heat so far (J).
    #[must_use]
    pub fn stylus_dissipated_j(&self) -> f64 {
        self.stylus.dissipated_j()
    }

    /// The surface, for its true irregularities.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The `count`-th step after `begin`.
    fn step(&mut self, begin: Micros, count: u32, force_target_n: f64) {
        let dt = self.world.step_s;
        let time = begin.as_seconds() + f64::from(count) * dt;
        self.truth.time_s = time;
        if self.truth.phase != Phase::Dropped {
            self.drive.step(force_target_n, dt);
            self.truth.applied_n = self.drive.applied_n();
            self.truth.force_peak_n = self.truth.force_peak_n.max(self.truth.applied_n);
            self.truth.crushed |= self.truth.applied_n > self.world.object.crush_n;
        }
        self.advance_phase(time);
        if self.truth.phase == Phase::Lifted {
            self.move_object(time);
        }
        let depth = self.surface_depth();
        // The second stylus stands on the profile where the first landed; both read the same places.
        let behind = self.second.as_ref().map_or(0.0, |second| second.spacing_m);
        let place = LANDING_M + behind + self.truth.travel_m;
        self.stylus.step(self.surface.height(place) + depth);
        if let Some(second) = &mut self.second {
            second.stylus.step(second.surface.height(place - behind) + depth);
        }
    }

    fn advance_phase(&mut self, time: f64) {
        let next = match self.truth.phase {
            Phase::Open if self.drive.gap_m() <= 0.0 => Phase::Supported,
            Phase::Supported if time - self.phase_since_s >= self.world.lift_after_s => {
                Phase::Lifted
            }
            Phase::Lifted if self.truth.travel_m > self.world.finger_m => Phase::Dropped,
            _ => return,
        };
        self.truth.phase = next;
        self.phase_since_s = time;
        if next == Phase::Dropped {
            self.drive.lose_object();
            self.friction_n = 0.0;
            self.truth = Truth {
                applied_n: 0.0,
                shear_m: 0.0,
                speed_m_s: 0.0,
                slipping: false,
                ..self.truth
            };
        }
    }

    fn move_object(&mut self, time: f64) {
        let dt = self.world.step_s;
        let speed = self.truth.speed_m_s;
        let since_lift = time - self.phase_since_s;
        let pressed_n = self.world.object.coulomb_n(self.truth.applied_n);
        let (mass_kg, acceleration) = match self.world.acting(since_lift) {
            None => {
                self.friction_n = self.contact.step(speed, pressed_n, dt);
                let mass_kg = self.world.object.mass_kg;
                (mass_kg, self.world.weight(since_lift) - 2.0 * self.friction_n / mass_kg)
            }
            Some(acting) => {
                self.contact.set_kinetic(self.world.object.friction * acting.friction_share);
                self.friction_n = self.contact.step(speed, pressed_n, dt);
                let needed_n = acting.force_needed_n(&self.world.object);
                self.truth.needed_now_n = needed_n;
                self.truth.force_needed_n = self.truth.force_needed_n.max(needed_n);
                let lost_n = 2.0 * self.friction_n + acting.flow_kg_s * speed;
                let carried = self.world.share(since_lift)
                    * (self.world.object.gravity_m_s2 + acting.acceleration_m_s2);
                (acting.mass_kg, carried + (acting.pull_n - lost_n) / acting.mass_kg)
            }
        };
        let mut speed = speed + acceleration * dt;
        let viscous_n_s_m = self.world.object.viscous_n_s_m;
        if viscous_n_s_m > 0.0 {
            speed /= 1.0 + viscous_n_s_m * dt / mass_kg;
            self.friction_n += 0.5 * viscous_n_s_m * speed;
        }
        self.truth.speed_m_s = speed;
        self.truth.travel_m += speed * dt;
        self.truth.shear_m = self.contact.shear_m();
        self.truth.slipping = speed.abs() > SLIP_SPEED_M_S && self.contact.slip_share() > 0.5;
        if self.truth.slipping {
            self.truth.stable_after_s = since_lift;
        }
    }

    /// Level of the valleys above the free stylus tip (m).
    fn surface_depth(&self) -> f64 {
        if self.truth.phase == Phase::Dropped {
            return f64::NEG_INFINITY;
        }
        let sink = self.world.sink_m_n * self.truth.applied_n;
        STYLUS_PRELOAD_M + sink - self.drive.gap_m()
    }
}

#[cfg(test)]
mod tests;
