//! Enums whose variants have names: all of them, the name of one, and the variant of a name.

/// A text that is none of the names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("unknown {what} (known: {known})")]
pub struct Unknown {
    /// What it should name.
    pub what: &'static str,
    /// The names there are.
    pub known: &'static str,
}

/// Declares such an enum: what its variants are called together, then each variant with its name.
#[macro_export]
macro_rules! named {
    (
        $what:literal, $(#[$meta:meta])* $vis:vis enum $type:ident {
            $(#[$first_meta:meta])* $first:ident = $first_name:literal,
            $($(#[$other_meta:meta])* $other:ident = $other_name:literal,)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        $vis enum $type {
            $(#[$first_meta])* $first,
            $($(#[$other_meta])* $other,)*
        }

        impl $type {
            /// All of them.
            pub const ALL: [Self; [$first_name, $($other_name),*].len()] =
                [Self::$first, $(Self::$other),*];

            /// Its name in files and options.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    Self::$first => $first_name,
                    $(Self::$other => $other_name,)*
                }
            }
        }

        impl core::fmt::Display for $type {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl core::str::FromStr for $type {
            type Err = $crate::named::Unknown;

            fn from_str(text: &str) -> Result<Self, Self::Err> {
                let unknown = $crate::named::Unknown {
                    what: $what,
                    known: concat!($first_name, $(", ", $other_name),*),
                };
                Self::ALL.into_iter().find(|known| known.name() == text).ok_or(unknown)
            }
        }
    };
}
