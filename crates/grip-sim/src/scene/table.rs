//! Settings as tables: one row gives a key its type, default, range and meaning.

use super::{Draw, SceneError};

/// A table of a scene. Keys that are not written have their defaults, unknown ones are refused; a key without a range is checked
/// elsewhere.
macro_rules! settings {
    ($(#[$about:meta])* pub struct $name:ident in $table:literal {
        $($field:ident: $type:ty = $default:expr $(, $low:literal to $high:literal)? => $doc:literal;)+
    }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $name {
            $(#[doc = concat!($doc $(, ", ", stringify!($low), " to ", stringify!($high))?, ".")] pub $field: $type,)+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)+ }
            }
        }

        impl $name {
            /// The first value that is out of its range.
            pub(crate) fn check(&self) -> Result<(), crate::scene::SceneError> {
                $($(
                    let name = concat!($table, ".", stringify!($field));
                    crate::scene::table::Ranged::within(self.$field, name, $low, $high)?;
                )?)+
                Ok(())
            }
        }
    };
}
pub(super) use settings;

/// A value that has a range.
pub(super) trait Ranged {
    /// Refuses the value of `field` outside `low` to `high`.
    fn within(self, field: &'static str, low: f64, high: f64) -> Result<(), SceneError>;
}

impl Ranged for f64 {
    fn within(self, field: &'static str, low: f64, high: f64) -> Result<(), SceneError> {
        if (low..=high).contains(&self) {
            Ok(())
        } else {
            Err(SceneError::OutOfRange { field, value: self, low, high })
        }
    }
}

impl Ranged for u8 {
    fn within(self, field: &'static str, low: f64, high: f64) -> Result<(), SceneError> {
        f64::from(self).within(field, low, high)
    }
}

impl Ranged for Draw {
    fn within(self, field: &'static str, low: f64, high: f64) -> Result<(), SceneError> {
        let [first, second] = self.bounds();
        first.within(field, low, high)?;
        second.within(field, low, high)?;
        if first > second {
            return Err(SceneError::BoundsSwapped { field, low: first, high: second });
        }
        match self {
            // A logarithm of 0 is none.
            Self::LogUniform { .. } => first.within(field, low.max(f64::MIN_POSITIVE), high),
            Self::LogNormal { log_normal: [median, spread], .. } => {
                median.within(field, low.max(f64::MIN_POSITIVE), high)?;
                spread.within(field, 0.0, 3.0)
            }
            Self::Fixed(_) | Self::Uniform { .. } => Ok(()),
        }
    }
}
