//! What is wrong with a value of E_sc, as a set of named flags.

slip_msg::named! {
    /// One thing that is wrong.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Flag {
        fn name: "Its name in JSON and tables.";
    }
    PoleInside: "A pole of the tangent lies within the error bound of S: every value is possible.", "pole_inside";
    SignUnknown: "The enclosure holds values of both signs, or zero.", "sign_unknown";
    NoInformation:
        "sigma_S exceeds 1: at this sensor noise the value does not depend on the surface.",
        "no_information";
    Degenerate: "Irregularities without positive finite height and spacing were left out.", "degenerate";
}

impl Flag {
    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// A set of [`Flag`]s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags(u8);

impl Flags {
    /// With `flag` too where `applies`.
    #[must_use]
    pub fn with(self, flag: Flag, applies: bool) -> Self {
        Self(self.0 | if applies { flag.bit() } else { 0 })
    }

    /// The flags as bits: b0 pole inside, b1 sign unknown, b2 no information, b3 degenerate.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The flags of these bits.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// Whether `flag` is set.
    #[must_use]
    pub fn contains(self, flag: Flag) -> bool {
        self.0 & flag.bit() != 0
    }

    /// Whether nothing is wrong.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The flags that are set, in the order of [`Flag::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Flag> {
        Flag::ALL.into_iter().filter(move |flag| self.contains(*flag))
    }
}
