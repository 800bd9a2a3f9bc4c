//! The table of a code: one row gives the variant, its number, its name and its meaning.

/// A row of a table of codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Number on the wire and in files.
    pub code: u8,
    /// Name of the variant, as in `LossAction`.
    pub variant: &'static str,
    /// Name in output lines, JSON and metrics.
    pub name: &'static str,
    /// What it means.
    pub about: &'static str,
}

impl Row {
    /// Name of its constant in other languages, as in `LOSS_ACTION`, letter by letter.
    pub fn constant(&self) -> impl Iterator<Item = char> {
        let mut after_small = false;
        self.variant.chars().flat_map(move |letter| {
            let begins = letter.is_ascii_uppercase() && after_small;
            after_small = !letter.is_ascii_uppercase();
            begins.then_some('_').into_iter().chain([letter.to_ascii_uppercase()])
        })
    }
}

/// An enumeration whose codes go on the wire. `open` ones keep a code of a later protocol as `Other`, `closed` ones refuse it. An `absent`
/// row stands for nothing known; it is not in `ALL`.
macro_rules! codes {
    ($($(#[$about:meta])* open $name:ident {
        $(absent $(#[$zero_meta:meta])* $zero:literal => $none:ident $zero_name:literal $zero_doc:literal,)?
        $($(#[$meta:meta])* $code:literal => $variant:ident $text:literal $doc:literal,)+
    })+) => { $(
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name {
            $($(#[$zero_meta])* #[doc = concat!(stringify!($zero), ": ", $zero_doc)] $none,)?
            $($(#[$meta])* #[doc = concat!(stringify!($code), ": ", $doc)] $variant,)+
            /// A code of a later protocol.
            Other(u8),
        }

        impl $name {
            /// From the wire.
            #[must_use]
            pub const fn from_code(code: u8) -> Self {
                match code {
                    $($zero => Self::$none,)?
                    $($code => Self::$variant,)+
                    other => Self::Other(other),
                }
            }

            /// To the wire.
            #[must_use]
            pub const fn code(self) -> u8 {
                match self {
                    $(Self::$none => $zero,)?
                    $(Self::$variant => $code,)+
                    Self::Other(code) => code,
                }
            }

            /// Its name in output lines and JSON; `other` for a code of a later protocol.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$none => $zero_name,)?
                    $(Self::$variant => $text,)+
                    Self::Other(_) => "other",
                }
            }
        }
        codes!(@wire $name, |r| r.u8().map(Self::from_code));
        codes!(@common $name { $(absent $zero => $none $zero_name $zero_doc,)? $($code => $variant $text $doc,)+ });
    )+ };
    ($($(#[$about:meta])* closed $name:ident {
        $($code:literal => $variant:ident $text:literal $doc:literal,)+
    })+) => { $(
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name {
            $(#[doc = concat!(stringify!($code), ": ", $doc)] $variant,)+
        }

        impl $name {
            /// From the wire.
            #[must_use]
            pub const fn from_code(code: u8) -> Option<Self> {
                match code {
                    $($code => Some(Self::$variant),)+
                    _ => None,
                }
            }

            /// To the wire.
            #[must_use]
            pub const fn code(self) -> u8 {
                match self {
                    $(Self::$variant => $code,)+
                }
            }

            /// Its name in output lines and JSON.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)+
                }
            }
        }
        codes!(@wire $name, |r| r.coded(Self::from_code));
        codes!(@common $name { $($code => $variant $text $doc,)+ });
    )+ };
    (@wire $name:ident, |$r:ident| $read:expr) => {
        impl<'a> $crate::Wire<'a> for $name {
            const SIZE: usize = 1;
            const TYPE: &'static str = "u8";
            fn read($r: &mut $crate::wire::Reader<'a>) -> Result<Self, $crate::PayloadError> {
                $read
            }
            fn append(self, w: $crate::wire::Writer<'_>) -> $crate::wire::Writer<'_> {
                w.u8(self.code())
            }
        }
    };
    (@common $name:ident {
        $(absent $zero:literal => $none:ident $zero_name:literal $zero_doc:literal,)?
        $($code:literal => $variant:ident $text:literal $doc:literal,)+
    }) => {
        impl $name {
            /// Every value that means something, in the order of the table.
            pub const ALL: [Self; [$($code),+].len()] = [$(Self::$variant),+];
            /// The table.
            pub const TABLE: &[$crate::Row] = &[
                $($crate::Row { code: $zero, variant: stringify!($none), name: $zero_name, about: $zero_doc },)?
                $($crate::Row { code: $code, variant: stringify!($variant), name: $text, about: $doc },)+
            ];

            /// The value of [`Self::ALL`] with that name; `-` counts as `_`.
            #[must_use]
            pub fn from_name(name: &str) -> Option<Self> {
                let is_dash = |own, given| own == given || (own == b'_' && given == b'-');
                Self::ALL.into_iter().find(|value| {
                    let own = value.name();
                    own.len() == name.len()
                        && own.bytes().zip(name.bytes()).all(|(own, given)| is_dash(own, given))
                })
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(self.name())
            }
        }

        #[cfg(feature = "serde")]
        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        #[cfg(feature = "serde")]
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Named;
                impl serde::de::Visitor<'_> for Named {
                    type Value = $name;
                    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                        f.write_str(concat!("one of", $(" `", $text, "`"),+))
                    }
                    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<$name, E> {
                        let names: &'static [&'static str] = &[$($text),+];
                        let known = $name::ALL.into_iter().find(|value| value.name() == text);
                        known.ok_or_else(|| E::unknown_variant(text, names))
                    }
                }
                deserializer.deserialize_str(Named)
            }
        }
    };
}

pub(crate) use codes;
