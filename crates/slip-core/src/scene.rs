//! Contact with an object; the [`Scene`] says which stages of the pipeline are needed.

pub use slip_msg::Scene;

/// Contact with hysteresis: on above `contact_n`, off below half of it. Without a force sensor there is
/// always contact, so that nothing is missed.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    contact_n: f32,
    touching: bool,
}

impl Contact {
    /// A contact that begins open; `contact_n` is the normal force that counts as touch (N).
    #[must_use]
    pub fn new(contact_n: f32) -> Self {
        Self { contact_n, touching: false }
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
}
