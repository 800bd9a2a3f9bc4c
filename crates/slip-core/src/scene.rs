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

/// Above the threshold with open fingers once in a day at 10 kHz, for Gaussian noise.
const SIGMAS: f32 = 6.0;
/// Readings of a block, and blocks: the quietest one counts, so that a touch in the others is no noise.
const BLOCK: u16 = 64;
const LEARNED: u16 = 4 * BLOCK;
/// Variance of `a - 2 b + c` over that of each reading. The second difference leaves a force that rises evenly out.
const SECOND: f32 = 6.0;

/// The noise of a force sensor, from its first readings.
#[derive(Clone, Copy, Debug)]
struct ForceNoise {
    last: [f32; 2],
    sum: f32,
    readings: u16,
    /// Smallest mean square of the second differences of a block (N^2).
    least: f32,
}

impl Contact {
    /// A contact that begins open; `contact_n` is the normal force that counts as touch (N).
    #[must_use]
    pub fn new(contact_n: f32) -> Self {
        let noise = ForceNoise { last: [0.0; 2], sum: 0.0, readings: 0, least: f32::INFINITY };
        Self { contact_n, touching: false, noise }
    }

    /// Whether the noise of the force is still being learned.
    #[must_use]
    #[inline]
    pub fn is_learning(&self) -> bool {
        self.noise.readings < LEARNED
    }

    /// Takes a reading of the normal force (N) for its noise, while that is being learned.
    #[inline]
    pub fn learn(&mut self, normal_force_n: Option<f32>) {
        if self.is_learning() && self.noise.push(normal_force_n.unwrap_or(0.0)) {
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
    /// Whether that was the last reading it needs.
    fn push(&mut self, force_n: f32) -> bool {
        let [a, b] = self.last;
        let second = a - 2.0 * b + force_n;
        // The first two have none.
        self.sum += if self.readings < 2 { 0.0 } else { second * second };
        self.last = [b, force_n];
        self.readings += 1;
        if self.readings.is_multiple_of(BLOCK) {
            self.least = self.least.min(self.sum / f32::from(BLOCK));
            self.sum = 0.0;
        }
        self.readings == LEARNED
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
        let mut none = Contact::new(0.05);
        (0..256).for_each(|_| none.learn(None));
        assert!(!none.is_learning() && none.update(None) && none.update(Some(0.06)));
    }
}
