//! A checked scene with its drawn object, from its name or TOML text.
//!
//! [`SceneConfig`] is the text as written; a quantity may be a number or a distribution. [`Scene::new`] checks
//! every range and draws the distributed quantities with the seed, so one file stands for many objects.

mod builtin;
mod check;
mod draw;
mod file;
mod load;
mod part;
mod sensing;
mod table;
mod texture;

pub use builtin::{BUILT_IN, load};
pub use check::SceneError;
pub use draw::Draw;
pub use file::{SceneFileError, open};
pub(crate) use load::{Acting, Load};
pub use load::{ArmConfig, BumpConfig, FillConfig, TugConfig, WetConfig};
pub use part::{GRIPPERS, Part, SENSORS};
pub(crate) use sensing::{ACCELERATION_SPAN_M_S2, Gains, STYLUS_SPAN_M};
pub use sensing::{ChannelConfig, GainConfig, NoiseConfig, ReadingConfig, VibrationConfig};
pub use texture::{FormConfig, WavinessConfig};

use crate::GRAVITY_M_S2;
use crate::actuator::ActuatorConfig;
use crate::random::{self, Purpose};
use crate::shape::Shape;
use crate::surface::{self, Surface};
use serde::{Deserialize, Serialize};
use table::settings;

/// A grasp scene as written in TOML. Unknown keys are refused; all but `name` have defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneConfig {
    /// Name for reports.
    pub name: String,
    /// Seed of the object, its surface, the sensor noise and what happens.
    #[serde(default)]
    pub seed: u64,
    /// Samples a second where nobody asks for others, 1000 to 20000.
    #[serde(default = "defaults::sample_rate_hz")]
    pub sample_rate_hz: u32,
    /// Largest internal time step (us), 1 to 50.
    #[serde(default = "defaults::step_us")]
    pub step_us: f64,
    /// Mass of the object (kg), 0.005 to 20.
    #[serde(default = "defaults::mass_kg")]
    pub mass_kg: Draw,
    /// Kinetic coefficient of friction of the dry pad on the object, 0.02 to 2.
    #[serde(default = "defaults::friction")]
    pub friction: Draw,
    /// Static over kinetic friction, 1 to 2.
    #[serde(default = "defaults::friction_ratio")]
    pub friction_ratio: Draw,
    /// Power of the normal force that friction grows with, 0.5 to 1: 1 is Coulomb's law, 2/3 a soft ball on a plane (Hertz). The coefficients are
    /// those at 10 N.
    #[serde(default = "defaults::friction_power")]
    pub friction_power: f64,
    /// Viscous friction of both fingers together (N s/m), 0 to 1000, as of grease: a load of that many newtons for each m/s of sliding.
    #[serde(default)]
    pub viscous_n_s_m: f64,
    /// Roughness Ra (um), 0.02 to 100.
    #[serde(default = "defaults::roughness_ra_um")]
    pub roughness_ra_um: Draw,
    /// Waviness of the surface.
    #[serde(default)]
    pub waviness: WavinessConfig,
    /// Form of the surface.
    #[serde(default)]
    pub form: FormConfig,
    /// Angle between the fingers' slip and the vertical (deg), 0 to 80: gravity along the fingers is g cos(tilt), the rest presses on one pad and
    /// relieves the other.
    #[serde(default)]
    pub tilt_deg: f64,
    /// Crush limit (N) of one finger's force, 0.1 to 10000. Excludes `crush_ratio`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crush_n: Option<Draw>,
    /// Crush limit over the force that the weight needs, 1 to 100; 2.5 where neither is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crush_ratio: Option<Draw>,
    /// From touch of the fingers to the lift (s), 0 to 60. Counted from touch, so that a host
    /// may connect at any time.
    #[serde(default = "defaults::lift_at_s")]
    pub lift_at_s: f64,
    /// Time over which the support hands the weight to the fingers (s), 0 to 5.
    #[serde(default = "defaults::lift_ramp_s")]
    pub lift_ramp_s: f64,
    /// Travel after which the object leaves the fingers (mm), 1 to 500.
    #[serde(default = "defaults::finger_length_mm")]
    pub finger_length_mm: f64,
    /// The gripper's drive.
    #[serde(default)]
    pub drive: DriveConfig,
    /// Optional sensors.
    #[serde(default)]
    pub channels: ChannelConfig,
    /// A second stylus this far behind the first, along the slip (mm), 0.05 to 20; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_stylus_mm: Option<f64>,
    /// An accelerometer in the finger instead of the stylus, without the motion of the robot; absent where there is a stylus.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vibration: Option<VibrationConfig>,
    /// White Gaussian noise of the sensors, rms.
    #[serde(default)]
    pub noise: NoiseConfig,
    /// When and in which steps the sensors are read; between two readings a sensor shows the last one.
    #[serde(default)]
    pub reading: ReadingConfig,
    /// What the sensors show over what there is.
    #[serde(default)]
    pub gain: GainConfig,
    /// Elastic finger pads.
    #[serde(default)]
    pub pad: PadConfig,
    /// Vertical shaking of the robot after the lift.
    #[serde(default)]
    pub shake: ShakeConfig,
    /// The robot's own motion as the stylus feels it.
    #[serde(default)]
    pub motion: MotionConfig,
    /// Something is poured into the object, evenly.
    #[serde(default)]
    pub fill: FillConfig,
    /// Somebody pulls the object out of the fingers.
    #[serde(default)]
    pub tug: TugConfig,
    /// Something hits the hand from below: half a sine of acceleration.
    #[serde(default)]
    pub bump: BumpConfig,
    /// The arm lifts and lowers the hand in turn; each move is one period of a sine of acceleration.
    #[serde(default)]
    pub arm: ArmConfig,
    /// A liquid creeps into the contact: friction of two phases.
    #[serde(default)]
    pub wet: WetConfig,
}

settings! {
    /// Limits of the gripper's drive.
    pub struct DriveConfig in "drive" {
        force_max_n: f64 = 60.0, 0.5 to 1000.0 => "Largest force of one finger (N)";
        slew_max_n_s: f64 = 2000.0, 1.0 to 100_000.0 => "Largest slew rate (N/s)";
        lag_ms: f64 = 5.0, 0.1 to 200.0 => "Lag of the drive (ms)";
        approach_ms: f64 = 100.0, 1.0 to 5000.0 => "Time to close the fingers (ms)";
        force_min_n: f64 = 0.0 => "Smallest force of one finger but none (N), 0 to the largest; a smaller command is raised to it";
        step_n: f64 = 0.0, 0.0 to 100.0 => "Steps of the force from the smallest one on (N; 0: none)";
        command_hz: f64 = 0.0, 0.0 to 1000.0 => "Commands taken a second (0: each one)";
        delay_ms: f64 = 0.0, 0.0 to 500.0 => "Dead time of a command (ms)";
        dead_band_n: f64 = 0.0, 0.0 to 100.0 => "Change that a drive at rest does not answer (N); once it moves it goes all the way";
        hysteresis: f64 = 0.0, 0.0 to 0.9 =>
            "Share by which friction of the tendons holds the force behind or above what the drive pulls with";
    }
}

impl DriveConfig {
    /// The drive in SI.
    pub(crate) fn actuator(&self) -> ActuatorConfig {
        ActuatorConfig {
            force_max_n: self.force_max_n,
            slew_max_n_s: self.slew_max_n_s,
            lag_s: self.lag_ms * 1e-3,
            approach_s: self.approach_ms * 1e-3,
            force_min_n: self.force_min_n,
            step_n: self.step_n,
            command_s: if self.command_hz > 0.0 { 1.0 / self.command_hz } else { 0.0 },
            delay_s: self.delay_ms * 1e-3,
            dead_band_n: self.dead_band_n,
            hysteresis: self.hysteresis,
        }
    }
}

impl Default for ActuatorConfig {
    fn default() -> Self {
        DriveConfig::default().actuator()
    }
}

settings! {
    /// Elastic finger pads under shear and compression.
    pub struct PadConfig in "pad" {
        shear_n_mm: f64 = 100.0, 1.0 to 10_000.0 => "Shear stiffness of one pad (N/mm)";
        damping_n_s_m: f64 = 50.0, 0.0 to 500.0 => "Shear damping of one pad (N s/m)";
        stribeck_mm_s: f64 = 5.0, 0.1 to 100.0 => "Speed over which static friction fades (Stribeck; mm/s)";
        elastic_share: f64 = 0.0, 0.0 to 0.99 =>
            "Share of the break-away shear below which a pad only deforms (0: it creeps under every swing of the load)";
        sink_um_n: f64 = 0.0, 0.0 to 100.0 => "How far the stylus is pushed in as the pad gives way (um/N)";
    }
}

settings! {
    /// Vertical sinusoidal acceleration of the hand; it adds to gravity once the object is lifted.
    pub struct ShakeConfig in "shake" {
        amplitude_m_s2: f64 = 0.0, 0.0 to 50.0 => "Amplitude (m/s^2)";
        frequency_hz: f64 = 0.0, 0.0 to 200.0 => "Frequency (Hz)";
    }
}

settings! {
    /// Vibration of the robot's own motion; see [`crate::disturbance`].
    pub struct MotionConfig in "motion" {
        level: f64 = 0.0, 0.0 to 10.0 => "Size of the vibration; 1 is a robot arm at full motion";
        taps_per_s: f64 = 0.0, 0.0 to 20.0 => "Taps a second";
    }
}

mod defaults {
    use super::Draw;

    pub(super) fn sample_rate_hz() -> u32 {
        10_000
    }
    pub(super) fn step_us() -> f64 {
        10.0
    }
    pub(super) fn mass_kg() -> Draw {
        Draw::LogUniform { log_uniform: [0.2, 1.0] }
    }
    pub(super) fn friction() -> Draw {
        Draw::Uniform { uniform: [0.2, 0.5] }
    }
    pub(super) fn friction_ratio() -> Draw {
        Draw::Uniform { uniform: [1.0, 1.2] }
    }
    pub(super) fn friction_power() -> f64 {
        1.0
    }
    pub(super) fn roughness_ra_um() -> Draw {
        Draw::LogUniform { log_uniform: [0.4, 6.3] }
    }
    pub(super) fn lift_at_s() -> f64 {
        0.3
    }
    pub(super) fn lift_ramp_s() -> f64 {
        0.05
    }
    pub(super) fn finger_length_mm() -> f64 {
        30.0
    }
}

/// Normal force at which the coefficients of friction are as written where it does not grow in proportion (N).
pub(crate) const POWER_AT_N: f64 = 10.0;

/// The object as drawn, in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Mass (kg).
    pub mass_kg: f64,
    /// Kinetic coefficient of friction.
    pub friction: f64,
    /// Static over kinetic friction.
    pub friction_ratio: f64,
    /// Power p of the normal force that friction grows with: mu_k N (N / 10 N)^(p - 1) for each finger.
    pub friction_power: f64,
    /// Gravity along the fingers (m/s^2): g cos(tilt). The rest of it presses the object on one pad and relieves the other, which leaves the sum of
    /// Coulomb friction as it is; with another power that is left out.
    pub gravity_m_s2: f64,
    /// Viscous friction of both fingers together (N s/m).
    pub viscous_n_s_m: f64,
    /// Roughness Ra (m).
    pub ra_m: f64,
    /// Mean spacing of the asperities (m).
    pub rsm_m: f64,
    /// Force of one finger above which the object breaks (N).
    pub crush_n: f64,
}

impl Object {
    /// Force of each of two fingers at which sliding friction just balances the weight (N):
    /// `m g / (2 mu_k)` for Coulomb friction. Above it a slip decelerates; an object that never moved needs less, by mu_s / mu_k.
    #[must_use]
    pub fn force_needed_n(&self) -> f64 {
        self.force_against_n(self.mass_kg * self.gravity_m_s2, 1.0)
    }

    /// Normal force (N) whose Coulomb friction is that of a finger that presses with `force_n`.
    pub(crate) fn coulomb_n(&self, force_n: f64) -> f64 {
        if self.friction_power == 1.0 {
            return force_n;
        }
        POWER_AT_N * (force_n / POWER_AT_N).max(0.0).powf(self.friction_power)
    }

    /// Force of each of two fingers at which sliding friction, `share` of the dry one, just balances `load_n` (N); 0 for a load below 0.
    pub(crate) fn force_against_n(&self, load_n: f64, share: f64) -> f64 {
        let coulomb_n = (load_n / (2.0 * self.friction * share)).max(0.0);
        if self.friction_power == 1.0 {
            return coulomb_n;
        }
        POWER_AT_N * (coulomb_n / POWER_AT_N).powf(1.0 / self.friction_power)
    }
}

/// A checked scene: configuration, seed and the object drawn with it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    config: SceneConfig,
    object: Object,
    load: Load,
    gains: Gains,
    shape: Option<Shape>,
}

impl Scene {
    /// Checks `config` and draws its object with `config.seed`.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`] and [`SceneError::TwoCrushLimits`] name the field.
    pub fn new(config: SceneConfig) -> Result<Self, SceneError> {
        check::check(&config)?;
        let rng = &mut random::stream(config.seed, Purpose::Object);
        let mass_kg = config.mass_kg.sample(rng);
        let friction = config.friction.sample(rng);
        let friction_ratio = config.friction_ratio.sample(rng);
        let ra_m = config.roughness_ra_um.sample(rng) * 1e-6;
        let rsm_m = surface::mean_spacing(ra_m, random::normal(rng));
        let viscous_n_s_m = config.viscous_n_s_m;
        let mut object = Object {
            mass_kg,
            friction,
            friction_ratio,
            friction_power: config.friction_power,
            gravity_m_s2: GRAVITY_M_S2 * config.tilt_deg.to_radians().cos(),
            viscous_n_s_m,
            ra_m,
            rsm_m,
            crush_n: 0.0,
        };
        object.crush_n = match config.crush_n {
            Some(limit) => limit.sample(rng),
            None => {
                config.crush_ratio.unwrap_or(Draw::Fixed(2.5)).sample(rng) * object.force_needed_n()
            }
        };
        let load = Load::draw(&config, mass_kg, &mut random::stream(config.seed, Purpose::Load));
        let gains = Gains::draw(&config.gain, &mut random::stream(config.seed, Purpose::Gain));
        let shape = texture::draw(&config, &mut random::stream(config.seed, Purpose::Texture));
        Ok(Self { config, object, load, gains, shape })
    }

    /// Parses TOML, then as [`Scene::new`].
    ///
    /// # Errors
    /// Those of [`SceneConfig::from_toml`] and [`Scene::new`].
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        Self::new(SceneConfig::from_toml(text)?)
    }

    /// The same scene with another seed: another object where the scene has distributions.
    ///
    /// # Errors
    /// None in practice, since the ranges do not depend on the seed; the type states what [`Scene::new`] states.
    pub fn reseeded(&self, seed: u64) -> Result<Self, SceneError> {
        Self::new(SceneConfig { seed, ..self.config.clone() })
    }

    /// The same object once more, at another place of its surface and with other noise.
    ///
    /// # Errors
    /// As [`Scene::reseeded`].
    pub fn regrasped(&self, seed: u64) -> Result<Self, SceneError> {
        Ok(self.reseeded(seed)?.with_object(self.object))
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &SceneConfig {
        &self.config
    }

    /// The drawn object.
    #[must_use]
    pub fn object(&self) -> Object {
        self.object
    }

    /// Largest force of each of two fingers (N) at which sliding friction balances the load, over the first `hold_s` seconds after the
    /// lift: the weight of the object, and all that happens to it. Looked at each millisecond.
    #[must_use]
    pub fn force_needed_n(&self, hold_s: f64) -> f64 {
        let weight_n = self.object.force_needed_n();
        if self.load.is_still() {
            return weight_n;
        }
        let times = (0_u32..).map(|ms| 1e-3 * f64::from(ms)).take_while(|t| *t <= hold_s);
        times.map(|t| self.load.at(t).force_needed_n(&self.object)).fold(weight_n, f64::max)
    }

    /// The surface of the object, as drawn.
    #[must_use]
    pub fn surface(&self) -> Surface {
        let surface = Surface::new(self.object.ra_m, self.object.rsm_m, self.config.seed);
        match self.shape {
            Some(shape) => surface.with_shape(shape),
            None => surface,
        }
    }

    pub(crate) fn load(&self) -> Load {
        self.load
    }

    pub(crate) fn gains(&self) -> Gains {
        self.gains
    }

    /// The same scene around another object, which is not checked.
    pub(crate) fn with_object(self, object: Object) -> Self {
        Self { object, load: self.load.with_mass(object.mass_kg), ..self }
    }
}

impl SceneConfig {
    /// Parses TOML without checking ranges.
    ///
    /// # Errors
    /// [`SceneError::Parse`] with line and column.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        toml::from_str(text).map_err(|source| SceneError::Parse(Box::new(source)))
    }
}
