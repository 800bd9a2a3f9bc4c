//! Enumerations as tables: one row gives a variant, what it is, and its texts.

/// An enumeration without data as a table. A row has a variant, its documentation, and a text for each function of the head; `ALL`
/// follows.
///
/// ```
/// slip_msg::named! {
///     /// A tense.
///     #[derive(Debug, Clone, Copy, PartialEq, Eq)]
///     pub enum Tense {
///         fn name: "As a heading.";
///         fn key: "Its name in JSON.";
///     }
///     Past: "What was.", "The past", "past";
///     Future: "What will be.", "The future", "future";
/// }
/// assert_eq!(Tense::ALL, [Tense::Past, Tense::Future]);
/// assert_eq!((Tense::Past.name(), Tense::Future.key()), ("The past", "future"));
/// ```
#[macro_export]
macro_rules! named {
    (
        $(#[$about:meta])* $vis:vis enum $name:ident { $(fn $text:ident: $what:literal;)+ }
        $($(#[$meta:meta])* $variant:ident: $doc:literal $(, $value:literal)+;)+
    ) => {
        $(#[$about])*
        $vis enum $name {
            $($(#[$meta])* #[doc = $doc] $variant,)+
        }

        impl $name {
            /// Every one, in the order of the table.
            pub const ALL: [Self; [$($doc),+].len()] = [$(Self::$variant),+];
        }

        $crate::named! { @texts $name [$($text $what)+] $($variant [$($value)+])+ }
    };
    (@texts $name:ident [] $($variant:ident [])+) => {};
    (
        @texts $name:ident [$text:ident $what:literal $($rest:tt)*]
        $($variant:ident [$value:literal $($values:literal)*])+
    ) => {
        impl $name {
            #[doc = $what]
            #[must_use]
            pub const fn $text(self) -> &'static str {
                match self {
                    $(Self::$variant => $value,)+
                }
            }
        }

        $crate::named! { @texts $name [$($rest)*] $($variant [$($values)*])+ }
    };
}
