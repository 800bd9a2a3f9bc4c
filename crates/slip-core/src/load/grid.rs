//! The hypotheses: needed forces, times in which the load comes, and contacts, with their probabilities before any reading.

/// How the fingers hold the object.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Shear of one pad by a newton of needed force (m): friction over the shear stiffness.
    pub shear_m_n: f32,
    /// Static over kinetic friction.
    pub ratio: f32,
    /// Its probability.
    pub p: f32,
}

/// A time in which the whole load comes.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    /// The time (s); 0: it is there.
    pub s: f32,
    /// Its probability.
    pub p: f32,
}

/// The hypotheses of one size: `forces` needed forces, each larger than the one before by `step` in the logarithm, with each ramp and each contact.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// How many needed forces.
    pub forces: usize,
    /// Logarithm from one to the next.
    pub step: f32,
    /// Times in which the load may come.
    pub ramps: &'static [Ramp],
    /// In their place where the load is there, and the force has fallen until the object slips: static over kinetic friction.
    pub ratios: &'static [f32],
    /// How the fingers may hold it.
    pub contacts: &'static [Contact],
}

const fn contact(shear_m_n: f32, ratio: f32, p: f32) -> Contact {
    Contact { shear_m_n, ratio, p }
}

const fn ramp(s: f32, p: f32) -> Ramp {
    Ramp { s, p }
}

impl Grid {
    /// How many hypotheses.
    #[must_use]
    pub const fn cells(&self) -> usize {
        self.forces * self.ramps.len() * self.contacts.len()
    }

    /// 96 hypotheses.
    pub const MICRO: Self = Self {
        forces: 16,
        step: 0.28,
        ramps: &[ramp(0.0, 0.4), ramp(0.05, 0.3), ramp(0.25, 0.3)],
        ratios: &[1.05, 1.25, 1.5],
        contacts: &[contact(11e-6, 1.1, 0.5), contact(50e-6, 1.1, 0.5)],
    };
}
