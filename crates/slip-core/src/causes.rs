//! Causes of an alarm other than a slip: which of them were ruled out, and which were possible.
//!
//! A cause that is in neither set could not be judged: the sensor that would show it is missing or not sound. With
//! H = `gate.hold_ms` (300 ms) and W = [`Standing::WAIT`](crate::pressure::Standing::WAIT) (500 ms), at the time of the
//! alarm:
//!
//! | cause | ruled out | possible | needs |
//! |---|---|---|---|
//! | knock | no band of the reference above 250 Hz reached 5 times its mean (10 ms) in the last 40 ms, and motion did not begin then | otherwise | sound reference |
//! | motion | the robot has stood for H; or the stylus alarms at 2.5 times its thresholds over the gated floor, or is certified by the law of motion | it moves, weaker alarm | sound reference, or commanded motion |
//! | grip change | the grip force has stayed within a tenth for W | otherwise | force sensor, or a controller |
//! | closing | the object has been held for W | otherwise | force sensor, or a controller |
//! | arm stop | the robot has stood for H, or is commanded to move, or the command ended more than H ago | the command ended less than H ago, or the last motion that the reference showed is 20 ms to H ago | sound reference, or commanded motion |
//!
//! Grip change and closing are judged once, when the slip is first noticed: what follows may be the answer to it. The
//! others are judged at each event: a slip that outlasts a knock is not that knock. While the reference shows motion
//! and no command is known, a stop cannot be judged.

/// A cause of an alarm other than a slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A blow on robot or object.
    Knock,
    /// The motion of the arm or the fingers.
    Motion,
    /// A change of the grip force.
    GripChange,
    /// The fingers have just closed on the object.
    Closing,
    /// The arm has just stopped.
    ArmStop,
}

impl Cause {
    /// Every cause.
    pub const ALL: [Self; 5] =
        [Self::Knock, Self::Motion, Self::GripChange, Self::Closing, Self::ArmStop];

    /// The name used in output lines.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Knock => "knock",
            Self::Motion => "motion",
            Self::GripChange => "grip_change",
            Self::Closing => "closing",
            Self::ArmStop => "arm_stop",
        }
    }

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// A set of causes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CauseSet(u8);

impl CauseSet {
    /// The set with these bits, in the order of [`Cause::ALL`] from the lowest on; others are left out.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & ((1 << Cause::ALL.len()) - 1))
    }

    /// One bit for each cause, in the order of [`Cause::ALL`] from the lowest on.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether `cause` is in the set.
    #[must_use]
    pub const fn has(self, cause: Cause) -> bool {
        self.0 & cause.bit() != 0
    }

    /// The causes in the set.
    pub fn iter(self) -> impl Iterator<Item = Cause> {
        Cause::ALL.into_iter().filter(move |cause| self.has(*cause))
    }
}

/// What is known of the causes of an alarm. No cause is in both sets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Causes {
    /// Causes that were ruled out.
    pub ruled_out: CauseSet,
    /// Causes that were not.
    pub possible: CauseSet,
}

impl Causes {
    /// The same, where `cause` was ruled out (`Some(true)`), was not (`Some(false)`) or could not be judged.
    #[must_use]
    pub(crate) const fn with(mut self, cause: Cause, ruled_out: Option<bool>) -> Self {
        self.ruled_out.0 &= !cause.bit();
        self.possible.0 &= !cause.bit();
        match ruled_out {
            Some(true) => self.ruled_out.0 |= cause.bit(),
            Some(false) => self.possible.0 |= cause.bit(),
            None => {}
        }
        self
    }

    /// What is known of `cause`: ruled out, possible, or not judged.
    #[must_use]
    pub const fn ruled_out(self, cause: Cause) -> Option<bool> {
        match (self.ruled_out.has(cause), self.possible.has(cause)) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Cause, CauseSet, Causes};

    #[test]
    fn a_cause_is_ruled_out_possible_or_not_judged() {
        for cause in Cause::ALL {
            for stated in [Some(true), Some(false), None] {
                let causes = Causes::default().with(cause, Some(true)).with(cause, stated);
                assert_eq!(causes.ruled_out(cause), stated);
                let known = causes.ruled_out.iter().chain(causes.possible.iter()).count();
                assert_eq!(known, usize::from(stated.is_some()));
            }
        }
        let bit = |cause| Causes::default().with(cause, Some(true)).ruled_out.bits();
        assert_eq!(Cause::ALL.map(bit), [1, 2, 4, 8, 16], "as in SLIP");
        assert_eq!(CauseSet::from_bits(0xff).iter().count(), Cause::ALL.len());
    }
}
