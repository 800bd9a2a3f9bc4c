//! Sets of bits in a field, as tables: one row gives a bit its number, name and meaning.

/// A set of bits and its place in a payload.
macro_rules! bits {
    ($(#[$about:meta])* $name:ident($type:ty) { $($bit:literal $flag:ident $doc:literal,)+ }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Default)]
        pub struct $name(pub $type);

        impl $name {
            $(#[doc = concat!("b", stringify!($bit), ": ", $doc)] pub const $flag: Self = Self(1 << $bit);)+
            /// Number, name and meaning of each bit.
            pub const BITS: &[(u8, &str, &str)] = &[$(($bit, stringify!($flag), $doc)),+];

            /// Whether all bits of `other` are set.
            #[must_use]
            pub const fn has(self, other: Self) -> bool {
                self.0 & other.0 == other.0
            }

            /// With the bits of `other` too.
            #[must_use]
            pub const fn and(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }

            /// With the bits of `other` too, where `applies`.
            #[must_use]
            pub const fn with(self, other: Self, applies: bool) -> Self {
                if applies { self.and(other) } else { self }
            }
        }

        impl From<$name> for i64 {
            fn from(set: $name) -> Self {
                Self::from(set.0)
            }
        }

        impl<'a> slip_msg::Wire<'a> for $name {
            const SIZE: usize = <$type as slip_msg::Wire<'_>>::SIZE;
            const TYPE: &'static str = <$type as slip_msg::Wire<'_>>::TYPE;
            fn read(r: &mut slip_msg::wire::Reader<'a>) -> Result<Self, slip_msg::PayloadError> {
                <$type as slip_msg::Wire<'_>>::read(r).map(Self)
            }
            fn append(self, w: slip_msg::wire::Writer<'_>) -> slip_msg::wire::Writer<'_> {
                slip_msg::Wire::append(self.0, w)
            }
        }
    };
}

pub(crate) use bits;
