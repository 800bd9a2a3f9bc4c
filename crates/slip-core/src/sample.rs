//! What the gripper's microcontroller measured at one instant: the sample, the resolution of a sensor, and the scene that the sample belongs to.

use crate::units::Micros;

/// No reading in an unknown unit is beyond this: its square is a number.
pub(crate) const ANY: f32 = 1e18;

/// What the stylus channel holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "lowercase")
)]
pub enum Signal {
    /// Displacement (m): heights, spacings and E_sc have a meaning.
    #[default]
    Displacement,
    /// Vibration in units of the sensor, signed or rectified: slips are found, heights are not known.
    ///
    /// The bands act on a rectified signal as it is: rectification moves its vibration towards lower and doubled
    /// frequencies, but the noise floor is measured on the same rectified signal, so the evidence keeps
    /// its meaning.
    Vibration,
}

/// Axes that a vector has beside its first one.
pub const FURTHER_AXES: usize = 2;

/// Every component of a vibration or of a motion reference.
pub type Vector = [f32; 1 + FURTHER_AXES];

/// When the computer took a reading in, by its own clock. Part of the input, so that a replay gives the same steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Arrival {
    /// Host time of arrival (monotonic).
    pub at: Micros,
    /// Age of the reading on arrival: host time minus the device time mapped to the host's clock; 0 where the clocks are not related yet.
    pub age: Micros,
}

/// One row of sensor readings. Only the stylus is required; a channel the gripper does not have is `None`.
///
/// Values may be anything a broken sensor sends, NaN and infinities included: the pipeline counts such
/// readings and never lets them into its state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Device time of the reading.
    pub t: Micros,
    /// Stylus displacement along its axis (m); for an uncalibrated vibration sensor its own units (counts).
    pub stylus: f32,
    /// Normal force of one finger on the object (N).
    pub normal_force_n: Option<f32>,
    /// Tangential (load) force on one finger (N).
    pub tangential_n: Option<f32>,
    /// Moved distance of the object against the finger (m), from a roller, an encoder or an optical sensor.
    pub travel_m: Option<f32>,
    /// Slip speed measured directly (m/s).
    pub velocity_m_s: Option<f32>,
    /// Second and third component of a vibration sensor that measures along several axes, the first being `stylus` (same units);
    /// 0 where there is none.
    pub stylus_axes: [f32; FURTHER_AXES],
    /// Second stylus (m), a known distance behind the first along the slip direction.
    pub second_stylus: Option<f32>,
    /// Motion reference: an accelerometer or a stylus that does not touch the object (own units).
    pub reference: Option<f32>,
    /// Second and third component of a motion reference with several axes, the first being `reference`; 0 where there is none.
    pub reference_axes: [f32; FURTHER_AXES],
    /// Static pressure of the fingertip (own units).
    pub pressure: Option<f32>,
    /// Commanded motion of arm or fingers: 0 while they are commanded to stand still, anything else while they are commanded to move.
    pub motion: Option<f32>,
    /// When the computer took the row in; `None` where that is not known, as in a table of readings: then device time stands for host time.
    pub arrival: Option<Arrival>,
}

impl Sample {
    /// A sample of the stylus alone.
    #[must_use]
    pub fn stylus(t: Micros, stylus: f32) -> Self {
        Self { t, stylus, ..Self::default() }
    }

    /// Every component of the stylus or vibration sensor (its unit).
    #[must_use]
    pub const fn vibration(&self) -> Vector {
        let [y, z] = self.stylus_axes;
        [self.stylus, y, z]
    }

    /// Whether arm or fingers were commanded to move.
    #[must_use]
    #[inline]
    pub fn commands_motion(&self) -> bool {
        self.motion.is_some_and(|motion| motion != 0.0)
    }

    /// Every component of the motion reference (its unit), where it has a reading.
    #[must_use]
    pub const fn reference_vector(&self) -> Option<Vector> {
        let [y, z] = self.reference_axes;
        match self.reference {
            Some(x) => Some([x, y, z]),
            None => None,
        }
    }

    /// The readings of one value each in the order of the fields above, without the time.
    #[must_use]
    pub const fn readings(&self) -> [Option<f32>; 9] {
        [
            Some(self.stylus),
            self.normal_force_n,
            self.tangential_n,
            self.travel_m,
            self.velocity_m_s,
            self.second_stylus,
            self.reference,
            self.pressure,
            self.motion,
        ]
    }
}

// Resolution of a sensor: the smallest step between two of its readings, in whatever unit.

/// The deviation of readings that are rounded to this step: 1 / sqrt(12) of it.
pub(crate) fn rounding(step: f32) -> f32 {
    0.288_675_13 * step
}

/// After so many steps the smallest one is the resolution.
const KNOWN: u32 = 64;

/// A step is a multiple of the smallest one where the ratio is this close to a whole number; only ratios below the second bound show that. On a grid one of
/// so many is none.
const ODD: f32 = 0.1;
const MULTIPLES: f32 = 30.0;
const MOST_ODD: u32 = 8;

/// The smallest step seen so far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Resolution {
    last: Option<f32>,
    step: f32,
    /// Readings that differ from the one before, those of them that are no multiple of the smallest step, and readings that are equal to the one before.
    steps: u32,
    odd: u32,
    same: u32,
}

impl Default for Resolution {
    fn default() -> Self {
        Self { last: None, step: f32::INFINITY, steps: 0, odd: 0, same: 0 }
    }
}

impl Resolution {
    /// Takes the next reading of the sensor.
    pub(crate) fn push(&mut self, x: f32) {
        if let Some(last) = self.last.replace(x) {
            self.compare(x, last);
        }
    }

    /// Takes two readings of one sensor that follow each other.
    pub(crate) fn compare(&mut self, x: f32, last: f32) {
        let step = (x - last).abs();
        self.steps = self.steps.saturating_add(u32::from(step > 0.0));
        let multiple = step.max(self.step) / step.min(self.step);
        let odd = multiple < MULTIPLES && (multiple - libm::roundf(multiple)).abs() > ODD;
        self.odd = self.odd.saturating_add(u32::from(step > 0.0 && odd));
        self.same = self.same.saturating_add(u32::from(step == 0.0));
        if step > 0.0 && step < self.step {
            // What was compared with a larger one shows nothing.
            self.odd = if step < 0.9 * self.step { 0 } else { self.odd };
            self.step = step;
        }
    }

    /// Whether enough readings have differed.
    pub(crate) fn is_known(&self) -> bool {
        self.steps >= KNOWN
    }

    /// That of a sensor of which it is not asked.
    pub(crate) fn settled() -> Self {
        Self { steps: KNOWN, ..Self::default() }
    }

    /// Whether the readings lie on a grid that is coarser than what they show: most are equal to the one before, and the others differ by multiples of the
    /// smallest step.
    pub(crate) fn is_coarse(&self) -> bool {
        self.steps > 0 && self.same > self.steps && MOST_ODD * self.odd <= self.steps
    }

    /// The noise that rounding to this step makes (rms); 0 while all readings were the same.
    pub(crate) fn rms(&self) -> f32 {
        if self.step < f32::INFINITY { rounding(self.step) } else { 0.0 }
    }
}

// Contact with an object; the [`Scene`] states which stages of the pipeline are needed.

pub use slip_msg::Scene;

/// Contact with hysteresis: on above `contact_n` or six times the noise of the force, whichever is more, off below half of
/// it. Without a force sensor there is always contact, so that nothing is missed.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    contact_n: f32,
    touching: bool,
    noise: ForceNoise,
}

/// Gaussian noise passes six standard deviations once in a day at 10 kHz. The quietest of the blocks shows some 15 % less
/// than one.
const SIGMAS: f32 = 6.0;
/// Samples of a block, and blocks: the quietest one counts, so that a touch in the others is no noise.
const BLOCK: u16 = 64;
const BLOCKS: u16 = 4;
/// A block has so many differences at least. Where the force is read with few of the samples, or repeated until it is read again, it is longer.
const LEAST: u16 = BLOCK / 4;
/// More samples than this are not waited for.
const LONGEST: u16 = 300 * BLOCK;
/// Variance of `a - 2 b + c` over that of each reading. The second difference leaves a force that rises evenly out.
const SECOND: f32 = 6.0;

/// The noise of a force sensor, from the first samples.
#[derive(Clone, Copy, Debug)]
struct ForceNoise {
    samples: u16,
    last: [Option<f32>; 2],
    /// Squares of the second differences of this block (N^2), and how many there are.
    sum: f32,
    differences: u16,
    /// Blocks that have ended; all of them where nothing changes in the time of so many.
    blocks: u16,
    /// Smallest mean square of a block (N^2).
    least: f32,
}

impl Contact {
    /// A contact that begins open; `contact_n` is the normal force that counts as touch (N).
    #[must_use]
    pub fn new(contact_n: f32) -> Self {
        let noise = ForceNoise {
            samples: 0,
            last: [None; 2],
            sum: 0.0,
            differences: 0,
            blocks: 0,
            least: f32::INFINITY,
        };
        Self { contact_n, touching: false, noise }
    }

    /// Whether the noise of the force is still being learned.
    #[must_use]
    #[inline]
    pub fn is_learning(&self) -> bool {
        self.noise.blocks < BLOCKS && self.noise.samples < LONGEST
    }

    /// Takes the normal force (N) of a sample for its noise, while that is being learned.
    #[inline]
    pub fn learn(&mut self, normal_force_n: Option<f32>) {
        if !self.is_learning() {
            return;
        }
        self.noise.push(normal_force_n);
        if !self.is_learning() && self.noise.least.is_finite() {
            let sigma_n = libm::sqrtf(self.noise.least / SECOND);
            self.contact_n = self.contact_n.max(SIGMAS * sigma_n);
        }
    }

    /// Takes the measured normal force (N) of the next sample.
    #[inline]
    pub fn update(&mut self, normal_force_n: Option<f32>) -> bool {
        self.touching = self.would_touch(normal_force_n);
        self.touching
    }

    /// Normal force that counts as touch (N).
    #[must_use]
    #[inline]
    pub fn touch_n(&self) -> f32 {
        self.contact_n
    }

    /// What [`Contact::update`] has said last.
    #[must_use]
    #[inline]
    pub fn is_touching(&self) -> bool {
        self.touching
    }

    /// What [`Contact::update`] would give, which is then still to be reported.
    #[must_use]
    #[inline]
    pub fn would_touch(&self, normal_force_n: Option<f32>) -> bool {
        let limit = if self.touching { 0.5 * self.contact_n } else { self.contact_n };
        normal_force_n.is_none_or(|force| force > limit)
    }
}

impl ForceNoise {
    fn push(&mut self, normal_force_n: Option<f32>) {
        // A reading that is repeated is none.
        if let Some(force_n) = normal_force_n.filter(|_| normal_force_n != self.last[1]) {
            if let [Some(a), Some(b)] = self.last {
                let second = a - 2.0 * b + force_n;
                self.sum += second * second;
                self.differences += 1;
            }
            self.last = [self.last[1], Some(force_n)];
        }
        self.samples += 1;
        if !self.samples.is_multiple_of(BLOCK) {
            return;
        }
        if self.differences >= LEAST {
            self.least = self.least.min(self.sum / f32::from(self.differences));
            (self.sum, self.differences) = (0.0, 0);
            self.blocks += 1;
        } else if self.last[0].is_none() && self.samples >= BLOCKS * BLOCK {
            // A force that never changes has no noise.
            self.blocks = BLOCKS;
        }
    }
}

#[cfg(test)]
mod resolution_tests {
    use super::{Resolution, rounding};

    #[test]
    fn the_smallest_step_is_the_resolution_in_any_unit() {
        let mut resolution = Resolution::default();
        for x in [5.0, 5.0, 5.0] {
            resolution.push(x);
        }
        assert_eq!(resolution.rms(), 0.0);
        for x in [7.0, 4.0, 5.0, f32::NAN, 5.5, 9.0] {
            resolution.push(x);
        }
        assert!((resolution.rms() * 12.0_f32.sqrt() - 1.0).abs() < 1e-6);
        assert!(!resolution.is_coarse(), "few readings are the same");
        let mut small = Resolution::default();
        for x in [7e-9, 4e-9, 5e-9] {
            small.push(x);
        }
        assert!((small.rms() / resolution.rms() - 1e-9).abs() < 1e-14);
    }

    #[test]
    fn readings_on_a_grid_are_coarse_and_a_tone_after_a_silence_is_not() {
        let (mut grid, mut tone) = (Resolution::default(), Resolution::default());
        for _ in 0..1000 {
            grid.push(0.0);
            tone.push(0.0);
        }
        assert!(!grid.is_coarse(), "nothing has stepped");
        for i in 0..200_u16 {
            grid.push(4.9e-7 * [3.0, 5.0, 2.0, 0.0, 1.0, 0.0, 2.0][usize::from(i % 7)]);
            tone.push(3e-6 * libm::sinf(core::f32::consts::FRAC_PI_4 * f32::from(i)));
        }
        assert!(grid.is_coarse() && !tone.is_coarse());
        assert!((grid.rms() / rounding(4.9e-7) - 1.0).abs() < 1e-3);
    }
}

#[cfg(test)]
mod scene_tests {
    use super::Contact;

    #[test]
    fn contact_has_hysteresis() {
        let mut contact = Contact::new(0.4);
        let seen = [0.3, 0.5, 0.3, 0.1, 0.3].map(|force| contact.update(Some(force)));
        assert_eq!(seen, [false, true, true, false, false]);
        assert!(contact.update(None));
    }

    /// Readings of noise alone pass a threshold of 2.5 standard deviations now and then, and one of six never.
    #[test]
    fn the_noise_of_the_force_is_no_touch_and_a_force_that_rises_is_no_noise() {
        let mut state = 1_u32;
        let mut noise = move || {
            let mut uniform = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f32::from((state >> 16) as u16) / 65_535.0 - 0.5
            };
            (0..12).map(|_| uniform()).sum::<f32>()
        };
        let [mut open, mut rising] = [Contact::new(0.05); 2];
        for i in 0..20_000_u16 {
            let noise_n = 0.02 * noise();
            open.learn(Some(noise_n));
            rising.learn(Some(0.01 * f32::from(i)));
            let touches = open.update(Some(noise_n));
            assert!(i < 256 || !touches, "{i}: {noise_n} N");
        }
        assert!(open.update(Some(0.2)) && rising.update(Some(0.051)));
        let [mut none, mut slower] = [Contact::new(0.05); 2];
        for i in 0..256_u16 {
            none.learn(None);
            // A force of 5 N that is read with every fifth sample has no noise either.
            slower.learn((i % 5 == 0).then_some(5.0));
        }
        assert!(!none.is_learning() && none.update(None) && none.update(Some(0.06)));
        assert!(!slower.is_learning() && slower.update(Some(0.06)));
        // A sensor of 250 Hz at 10 kHz: each reading is repeated 40 times.
        let (mut held, mut held_n) = (Contact::new(0.05), 0.0);
        for i in 0..20_000_u16 {
            held_n = if i % 40 == 0 { 0.03 * noise() } else { held_n };
            held.learn(Some(held_n));
            let touches = held.update(Some(held_n));
            assert!(i < 2600 || !touches, "{i}: {held_n} N");
        }
        assert!(!held.is_learning() && held.update(Some(0.3)));
    }
}
