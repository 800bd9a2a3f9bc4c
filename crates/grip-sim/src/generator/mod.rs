//! Generator of training data for the force estimator: rows by configuration and seed.
//!
//! Each row is one trial grasp: an object too heavy for the trial force slips by the micro-displacement d, and
//! what a sensor could know of that slip stands beside the force that would have been adequate. With F the
//! mean normal force over the contact time T and v the speed gained in it, the impulse balance of two
//! fingers gives the needed force and the answer exactly, without mass or friction coefficient:
//!
//! ```text
//! F_req = g F / (g - v / T),   f = kappa F_req
//! ```
//!
//! [`Source::ClosedForm`] computes the slip (a = g (1 - F / F_req), v = sqrt(2 a d), T = v / a);
//! [`Source::Simulated`] plays it with [`crate::Grasp`], pads, friction and drive included, and takes d, T, v and F from
//! the onset of gross slip on; [`Source::Stretch`] draws any stretch of a slip, braking included. Objects: m log-uniform 0.2 to 1 kg, mu_k uniform 0.2 to 0.5, Ra one of the grades
//! N4 to N12 (ISO 1302), surface as in [`crate::surface`].

mod passed;
mod simulated;
mod stretch;

pub use passed::Readings;

use crate::GRAVITY_M_S2;
use crate::random::{self, Purpose};
use crate::scene::{Object, SceneError};
use crate::surface::{Surface, mean_spacing};
use passed::Passed;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Roughness grades N4 to N12: Ra (um).
pub const GRADES_RA_UM: [f64; 9] = [0.2, 0.4, 0.8, 1.6, 3.2, 6.3, 12.5, 25.0, 50.0];
/// Names of the columns in the order of [`Row::values`].
pub const COLUMNS: [&str; 13] = [
    "object",
    "mass_kg",
    "friction",
    "trial_force_n",
    "micro_displacement_m",
    "slip_speed_m_s",
    "contact_time_s",
    "slip_acceleration_m_s2",
    "irregularities",
    "mean_slope",
    "esc_literal_w",
    "needed_force_n",
    "adequate_force_n",
];
/// [`COLUMNS`] as the header line of a CSV file.
pub const CSV_HEADER: &str = "object,mass_kg,friction,trial_force_n,micro_displacement_m,slip_speed_m_s,contact_time_s,\
slip_acceleration_m_s2,irregularities,mean_slope,esc_literal_w,needed_force_n,adequate_force_n";

/// How the trial force is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum TrialForce {
    /// Always this force (N); objects that it holds are drawn anew.
    FixedN(f64),
    /// A uniform share of the needed force between two bounds within 0.02 and 0.98.
    Share([f64; 2]),
}

/// Where the slip comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Constant friction from the first instant.
    #[default]
    ClosedForm,
    /// The simulated grasp.
    Simulated,
    /// A stretch of sliding at any force from far too light to braking, as the pipeline measures it.
    Stretch,
}

/// What to generate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GeneratorConfig {
    /// Where the slip comes from.
    pub source: Source,
    /// Trial force.
    pub trial: TrialForce,
    /// Travel d at which the slip is judged (mm), 0.1 to 20.
    pub micro_displacement_mm: f64,
    /// Adequate over needed force kappa, 1 to 3.
    pub safety: f64,
    /// Relative noise of the slip speed (1 sigma), 0 to 0.5; the acceleration follows it.
    pub speed_noise: f64,
    /// Relative noise of the trial force (1 sigma), 0 to 0.5.
    pub force_noise: f64,
}

impl Default for GeneratorConfig {
    fn default() -> Self {
        Self {
            source: Source::ClosedForm,
            trial: TrialForce::Share([0.1, 0.95]),
            micro_displacement_mm: 2.0,
            safety: 1.2,
            speed_noise: 0.0,
            force_noise: 0.0,
        }
    }
}

/// Why no rows can be generated.
#[derive(Debug, thiserror::Error)]
pub enum GeneratorError {
    /// A value outside its range.
    #[error("{field} = {value} is outside {low} to {high}")]
    OutOfRange {
        /// Field of [`GeneratorConfig`].
        field: &'static str,
        /// The offending value.
        value: f64,
        /// Lowest value allowed.
        low: f64,
        /// Highest value allowed.
        high: f64,
    },
    /// The scene behind the simulated slips was refused.
    #[error("scene of the simulated slips")]
    Scene(#[from] SceneError),
}

/// One trial grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Number of the object, from 0.
    pub object: u32,
    /// Mass (kg).
    pub mass_kg: f64,
    /// Kinetic coefficient of friction.
    pub friction: f64,
    /// Mean normal force of one finger over the contact time (N).
    pub trial_force_n: f64,
    /// Travel from the onset of slip (m).
    pub micro_displacement_m: f64,
    /// Speed at the end of the contact time (m/s).
    pub slip_speed_m_s: f64,
    /// Contact time: from the onset of slip, or the length of the stretch (s).
    pub contact_time_s: f64,
    /// Speed gained over contact time (m/s^2); negative while braking.
    pub slip_acceleration_m_s2: f64,
    /// Irregularities the stylus passed, n.
    pub irregularities: u32,
    /// Mean of delta_i / s_i.
    pub mean_slope: f64,
    /// Scattered energy of vibration as printed, n F v tan(sum cot(delta_i / s_i)) (W), in plain f64.
    pub esc_literal_w: f64,
    /// The other readings of it, which no CSV column holds.
    pub readings: Readings,
    /// True needed force m g / (2 mu_k) (N).
    pub needed_force_n: f64,
    /// kappa times the needed force (N): the target.
    pub adequate_force_n: f64,
}

impl Row {
    /// The values in the order of [`COLUMNS`].
    #[must_use]
    pub fn values(&self) -> [f64; COLUMNS.len()] {
        [
            f64::from(self.object),
            self.mass_kg,
            self.friction,
            self.trial_force_n,
            self.micro_displacement_m,
            self.slip_speed_m_s,
            self.contact_time_s,
            self.slip_acceleration_m_s2,
            f64::from(self.irregularities),
            self.mean_slope,
            self.esc_literal_w,
            self.needed_force_n,
            self.adequate_force_n,
        ]
    }

    /// The values as a line of CSV without its end; every digit that `f64` needs.
    #[must_use]
    pub fn csv(&self) -> String {
        self.values().map(|value| value.to_string()).join(",")
    }
}

/// What a slip looks like before sensors blur it.
#[derive(Clone, Copy, Debug)]
struct Slip {
    travel_m: f64,
    speed_m_s: f64,
    gained_m_s: f64,
    time_s: f64,
    force_n: f64,
    /// Where on the profile the slip began (m).
    start_m: f64,
}

/// `count` rows. Row i depends on `config`, `seed` and i only, so a longer run begins with a shorter one.
///
/// # Errors
/// [`GeneratorError::OutOfRange`] for a configuration outside its ranges.
pub fn rows(
    config: GeneratorConfig,
    seed: u64,
    count: u32,
) -> Result<impl Iterator<Item = Row>, GeneratorError> {
    config.check()?;
    let base = simulated::base_scene()?;
    Ok((0..count).map(move |object| config.row(object, seed, &base)))
}

impl GeneratorConfig {
    fn check(&self) -> Result<(), GeneratorError> {
        within("micro_displacement_mm", self.micro_displacement_mm, 0.1, 20.0)?;
        within("safety", self.safety, 1.0, 3.0)?;
        within("speed_noise", self.speed_noise, 0.0, 0.5)?;
        within("force_noise", self.force_noise, 0.0, 0.5)?;
        match self.trial {
            // The heaviest, most slippery objects need 24 N: up to 20 N there is always one to find.
            TrialForce::FixedN(force) => within("trial.fixed_n", force, 0.1, 20.0),
            TrialForce::Share([low, high]) => {
                within("trial.share", low, 0.02, 0.98)?;
                within("trial.share", high, low, 0.98)
            }
        }
    }

    fn row(&self, index: u32, seed: u64, base: &crate::Scene) -> Row {
        let rng = &mut random::stream(seed, Purpose::TrainingRow);
        // 2^20 words are far more than one row draws.
        rng.set_word_pos(u128::from(index) << 20);
        let (object, trial_n) = self.draw(rng);
        let surface_seed = seed ^ (u64::from(index) << 32).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let surface = Surface::new(object.ra_m, object.rsm_m, surface_seed);
        let slip = match self.source {
            Source::ClosedForm => closed_form(object, trial_n, self.micro_displacement_mm * 1e-3),
            Source::Simulated => {
                simulated::slip(base, object, trial_n, self.micro_displacement_mm * 1e-3)
            }
            Source::Stretch => stretch::slip(object, rng),
        };
        let speed_error = 1.0 + self.speed_noise * random::normal(rng);
        let speed = slip.speed_m_s * speed_error;
        let force = slip.force_n * (1.0 + self.force_noise * random::normal(rng));
        let passed = Passed::between(&surface, slip.start_m, slip.start_m + slip.travel_m);
        Row {
            object: index,
            mass_kg: object.mass_kg,
            friction: object.friction,
            trial_force_n: force,
            micro_displacement_m: slip.travel_m,
            slip_speed_m_s: speed,
            contact_time_s: slip.time_s,
            slip_acceleration_m_s2: slip.gained_m_s * speed_error / slip.time_s,
            irregularities: passed.count,
            mean_slope: passed.slope_sum / f64::from(passed.count.max(1)),
            esc_literal_w: passed.literal_w(force, speed),
            readings: passed.readings(force, speed),
            needed_force_n: object.force_needed_n(),
            adequate_force_n: self.safety * object.force_needed_n(),
        }
    }

    /// An object and a trial force that does not hold it; a stretch of sliding draws its own force.
    fn draw(&self, rng: &mut ChaCha8Rng) -> (Object, f64) {
        if self.source == Source::Stretch {
            return (draw_object(rng, stretch::MASS_KG, stretch::FRICTION), 0.0);
        }
        loop {
            let object = draw_object(rng, [0.2, 1.0], [0.2, 0.5]);
            let needed = object.force_needed_n();
            let trial_n = match self.trial {
                TrialForce::FixedN(force) => force,
                TrialForce::Share([low, high]) => needed * random::uniform(rng, low, high),
            };
            if trial_n < 0.98 * needed {
                return (object, trial_n);
            }
        }
    }
}

fn within(field: &'static str, value: f64, low: f64, high: f64) -> Result<(), GeneratorError> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(GeneratorError::OutOfRange { field, value, low, high })
    }
}

fn draw_object(rng: &mut ChaCha8Rng, mass_kg: [f64; 2], friction: [f64; 2]) -> Object {
    let mass_kg = random::log_uniform(rng, mass_kg[0], mass_kg[1]);
    let friction = random::uniform(rng, friction[0], friction[1]);
    let [finest, coarser @ ..] = &GRADES_RA_UM;
    let ra_m = random::pick(rng, *finest, coarser) * 1e-6;
    let rsm_m = mean_spacing(ra_m, random::normal(rng));
    Object {
        mass_kg,
        friction,
        friction_ratio: 1.0,
        friction_power: 1.0,
        gravity_m_s2: GRAVITY_M_S2,
        viscous_n_s_m: 0.0,
        ra_m,
        rsm_m,
        crush_n: f64::INFINITY,
    }
}

fn closed_form(object: Object, trial_n: f64, travel_m: f64) -> Slip {
    let acceleration = GRAVITY_M_S2 * (1.0 - trial_n / object.force_needed_n());
    let speed_m_s = (2.0 * acceleration * travel_m).sqrt();
    Slip {
        travel_m,
        speed_m_s,
        gained_m_s: speed_m_s,
        time_s: speed_m_s / acceleration,
        force_n: trial_n,
        start_m: 0.0,
    }
}

#[cfg(test)]
mod tests;
