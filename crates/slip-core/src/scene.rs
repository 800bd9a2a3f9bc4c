//! Contact with an object; the [`Scene`] says which stages of the pipeline are needed.

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

    /// What [`Contact::update`] would say, which is then still to be told.
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
mod tests {
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
