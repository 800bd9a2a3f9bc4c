//! An alarm: the methods that can raise it, the causes other than a slip that were ruled out, and how sure it is.

// Which of the three classic ways to notice a slip are used.

pub use slip_msg::Method;

/// A set of methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(transparent))]
pub struct Methods(u8);

impl Default for Methods {
    fn default() -> Self {
        Self::ALL
    }
}

impl Methods {
    /// No method: refused by a pipeline.
    pub const NONE: Self = Self(0);
    /// Whatever the gripper has.
    pub const ALL: Self =
        Self::NONE.with(Method::Stylus).with(Method::Travel).with(Method::Pressure);

    /// One method alone.
    #[must_use]
    pub const fn only(method: Method) -> Self {
        Self(bit(method))
    }

    /// The same set and `method`.
    #[must_use]
    pub const fn with(self, method: Method) -> Self {
        Self(self.0 | bit(method))
    }

    /// The same set without `method`.
    #[must_use]
    pub const fn without(self, method: Method) -> Self {
        Self(self.0 & !bit(method))
    }

    /// Whether `method` may speak.
    #[must_use]
    #[inline]
    pub const fn has(self, method: Method) -> bool {
        self.0 & bit(method) != 0
    }

    /// Number of methods in the set.
    #[must_use]
    pub const fn count(self) -> u32 {
        self.0.count_ones()
    }
}

const fn bit(method: Method) -> u8 {
    match method {
        Method::Stylus => 1,
        Method::Travel => 2,
        Method::Pressure => 4,
        Method::None | Method::Other(_) => 0,
    }
}

// Causes of an alarm other than a slip: which of them were ruled out, and which were possible.

slip_msg::named! {
    /// A cause of an alarm other than a slip.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Cause {
        fn name: "The name used in output lines.";
    }
    Knock: "A blow on robot or object.", "knock";
    Motion: "The motion of the arm or the fingers.", "motion";
    GripChange: "A change of the grip force.", "grip_change";
    Closing: "The fingers have just closed on the object.", "closing";
    ArmStop: "The arm has just stopped.", "arm_stop";
}

impl Cause {
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
///
/// A cause that is in neither set could not be judged: the sensor that would show it is missing or not sound. With
/// H = `gate.hold_ms` (300 ms) and W = [`Standing::WAIT`](crate::pressure::Standing::WAIT) (500 ms), at the time of the
/// alarm:
///
/// | cause | ruled out | possible | needs |
/// |---|---|---|---|
/// | knock | no band of the reference above 250 Hz reached 5 times its mean (10 ms) in the last 40 ms, and motion did not begin then | otherwise | sound reference |
/// | motion | the robot has stood for H; or the stylus alarms and shows four times what motion may at most, or is certified by the law of motion | it moves, weaker alarm | sound reference, or commanded motion |
/// | grip change | the grip force has stayed within a tenth for W | otherwise | force sensor, or a controller |
/// | closing | the object has been held for W | otherwise | force sensor, or a controller |
/// | arm stop | the robot has stood for H, or is commanded to move, or the command ended more than H ago | the command ended less than H ago, or the last motion that the reference showed is 20 ms to H ago | sound reference, or commanded motion |
///
/// Grip change and closing are judged once, when the slip is first noticed: what follows may be the answer to it. The
/// others are judged at each event: a slip that outlasts a knock is not that knock. While the reference shows motion
/// and no command is known, a stop cannot be judged.
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

/// Probability (0..=1) that noise alone does not show evidence of `statistic` times the wanted interval A within A. Rises with the statistic; 1/e at 1;
/// 0 for NaN and for what is not positive.
///
/// Evidence M is a time (s): noise reaches it once in M seconds on average or more seldom, so in A seconds A/M = 1/x times. The alarms being
/// independent, it reaches it at least once with probability 1 - exp(-1/x). The confidence is the rest of it:
///
/// ```text
/// confidence = P(noise alone does not reach M within A) = exp(-A/M) = exp(-1/x)
/// ```
///
/// It states how hard the event is to explain by noise, knows nothing of how often objects slip, and is as good as the law of the noise: where
/// the interval does not hold, confidences are too high.
#[must_use]
pub fn confidence(statistic: f32) -> f32 {
    if statistic > 0.0 { libm::expf(-1.0 / statistic) } else { 0.0 }
}

#[cfg(test)]
mod methods_tests {
    use super::{Method, Methods};

    #[test]
    fn a_set_holds_what_was_put_in() {
        for method in Method::ALL {
            let one = Methods::only(method);
            assert_eq!(Method::ALL.map(|other| one.has(other)), Method::ALL.map(|o| o == method));
            assert!(Methods::ALL.has(method) && !Methods::NONE.has(method));
            assert_eq!(one.without(method), Methods::NONE);
        }
        assert_eq!((Methods::ALL.count(), Methods::NONE.count()), (3, 0));
    }
}

#[cfg(test)]
mod causes_tests {
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

#[cfg(test)]
mod confidence_tests {
    use super::confidence;
    use proptest::prelude::{any, proptest};

    #[test]
    fn it_is_one_over_e_at_the_interval_and_rises_to_certainty() {
        for (statistic, wanted) in [(1.0, 0.367_879_45), (0.5, 0.135_335_3), (7.389, 0.873_423)] {
            assert!((confidence(statistic) - wanted).abs() < 1e-6, "{statistic}");
        }
        assert_eq!((confidence(f32::INFINITY), confidence(0.005)), (1.0, 0.0));
        for nothing in [f32::NAN, f32::NEG_INFINITY, -1.0, 0.0, -0.0, f32::MIN_POSITIVE] {
            assert_eq!(confidence(nothing), 0.0, "{nothing}");
        }
    }

    proptest! {
        #[test]
        fn any_input_gives_a_probability(statistic in any::<f32>()) {
            let value = confidence(statistic);
            assert!((0.0..=1.0).contains(&value), "{statistic}: {value}");
        }

        #[test]
        fn it_never_falls_with_the_statistic(a in 0.0_f32..100.0, b in 0.0_f32..100.0) {
            assert!(confidence(a.min(b)) <= confidence(a.max(b)));
        }
    }
}
