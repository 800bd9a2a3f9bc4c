//! Settings as tables: a row gives a key its type, default, range and meaning.

use crate::ConfigError;
use core::ops::RangeInclusive;

/// A table of the configuration. Keys that are not written have their defaults, unknown ones are refused; a key without a range is
/// checked elsewhere, or takes every value of its type. `c` in a range is the table itself, whose keys are checked from the first to the
/// last. Tables within it stand last, in brackets.
macro_rules! settings {
    ($(#[$about:meta])* pub struct $name:ident as $c:ident in $table:literal {
        $($field:ident: $type:ty = $default:expr $(, $range:expr)? => $($doc:literal)+;)+
        $([$inner:ident]: $kind:ty = $inner_default:expr => $($inner_doc:literal)+;)*
    }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(
            feature = "serde",
            derive(serde::Serialize, serde::Deserialize),
            serde(default, deny_unknown_fields)
        )]
        pub struct $name {
            $(
                $(#[doc = $doc])+
                $(#[doc = ""] #[doc = concat!("Range: `", stringify!($range), "`; `c` is this table.")])?
                pub $field: $type,
            )+
            $($(#[doc = $inner_doc])+ pub $inner: $kind,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)+ $($inner: $inner_default,)* }
            }
        }

        impl $name {
            /// # Errors
            /// The first value outside its range, those of the tables within this one included.
            pub fn check(&self) -> Result<(), $crate::ConfigError> {
                let $c = self;
                $($(
                    let name = concat!($table, ".", stringify!($field));
                    $crate::settings::Ranged::within($c.$field, name, &$range)?;
                )?)+
                $($c.$inner.check()?;)*
                Ok(())
            }
        }
    };
}
pub(crate) use settings;

type Checked = Result<(), ConfigError>;

/// A value that has a range.
pub(crate) trait Ranged {
    /// Refuses the value of the key `name` outside of a range.
    fn within(self, name: &'static str, range: &RangeInclusive<f32>) -> Checked;
}

impl Ranged for f32 {
    fn within(self, name: &'static str, range: &RangeInclusive<f32>) -> Checked {
        ConfigError::within(name, self, *range.start(), *range.end())
    }
}

impl Ranged for u16 {
    fn within(self, name: &'static str, range: &RangeInclusive<f32>) -> Checked {
        f32::from(self).within(name, range)
    }
}

impl Ranged for u32 {
    fn within(self, name: &'static str, range: &RangeInclusive<f32>) -> Checked {
        (self as f32).within(name, range)
    }
}

impl<T: Ranged> Ranged for Option<T> {
    fn within(self, name: &'static str, range: &RangeInclusive<f32>) -> Checked {
        self.map_or(Ok(()), |value| value.within(name, range))
    }
}

impl<T: Ranged, const N: usize> Ranged for [T; N] {
    fn within(self, name: &'static str, range: &RangeInclusive<f32>) -> Checked {
        self.into_iter().try_for_each(|value| value.within(name, range))
    }
}
