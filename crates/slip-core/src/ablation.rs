//! Rules of the force controller that can be left out, to measure what each one buys. Only with the feature `ablation`; without it every rule
//! holds, and the compiler removes the question.

slip_msg::named! {
    /// A rule that can be left out.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Rule {
        fn name: "Its name in `gripctl grasp --without`.";
    }
    Reflex: "The rise at once when a slip begins.", "reflex";
    Sought: "The gentle first answer, and the larger step after it, where a falling force lets the object slip.", "sought";
    Estimate: "The force by the network or the tangential sensor.", "estimate";
    Growth: "The growth of the force where nothing is estimated.", "growth";
    Blows: "The load of a known weight, F + w a/g.", "blows";
    Judge: "An estimate that the object contradicts is refuted.", "judge";
    Envelope: "The least growth while an object slides on.", "envelope";
    Confirm: "Only what has moved by a distance is a slip.", "confirm";
    Swings: "What comes back swings on its pads.", "swings";
    Ebbing: "Alarms while the force is on its way back do not add up.", "ebbing";
    Yielding: "The bound of the estimate while pads give way.", "yielding";
    Giving: "What holds a known object may give way before it slides.", "giving";
    Need: "The needed force by the stylus alone.", "need";
    Search: "Less and less is held until the object slips.", "search";
    SearchAgain: "The second search where an object slipped while its weight was put on.", "search-again";
    Lead: "The command leads the measured force.", "lead";
    Response: "... further where the drive is seen to be slow.", "response";
    DeadTime: "... but not by what is dead time.", "dead-time";
    Frozen: "A force reading that stands while the command moves is none.", "frozen";
    Doubted: "A force reading that contradicts the command is none.", "doubted";
    Ratio: "A force sensor is scaled to the command that held the object.", "ratio";
    HostTime: "Old samples raise nothing, and a rise counts the time of the computer.", "host-time";
    Tangential: "The tangential force shows the needed one.", "tangential";
    TravelAside: "A travel that the stylus contradicts is set aside.", "travel-aside";
    StylusAside: "A stylus that the travel contradicts is set aside.", "stylus-aside";
    Drift: "A movement that only the travel shows is weighed against the force, and bounded meanwhile.", "drift";
    Late: "A sensor that shows what is over is set aside.", "late";
    Fades: "The force is bounded while the travel gets faster and the stylus fades.", "fades";
    Undecided: "The force is bounded while it is open which of both is wrong.", "undecided";
    Coarse: "A coarse travel gives way to the stylus alone.", "coarse";
    White: "A stylus that shows white noise is set aside.", "white";
    Sink: "What the pads give way under the force is taken from the stylus.", "sink";
}

#[cfg(feature = "ablation")]
static WITHOUT: core::sync::atomic::AtomicU32 = core::sync::atomic::AtomicU32::new(0);

#[cfg(feature = "ablation")]
impl Rule {
    const fn bit(self) -> u32 {
        1 << self as u32
    }
}

/// Leaves out exactly these rules from now on, in every controller of this process.
#[cfg(feature = "ablation")]
pub fn leave_out(rules: &[Rule]) {
    let bits = rules.iter().fold(0, |bits, rule| bits | rule.bit());
    WITHOUT.store(bits, core::sync::atomic::Ordering::Relaxed);
}

/// Whether `rule` is left out.
#[cfg(feature = "ablation")]
#[inline]
pub(crate) fn without(rule: Rule) -> bool {
    WITHOUT.load(core::sync::atomic::Ordering::Relaxed) & rule.bit() != 0
}

/// Whether `rule` is left out: never.
#[cfg(not(feature = "ablation"))]
#[inline(always)]
pub(crate) const fn without(_: Rule) -> bool {
    false
}
