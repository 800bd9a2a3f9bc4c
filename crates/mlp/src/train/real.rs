//! A precision in, its arithmetic one number at a time and one vector at a time out.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use super::lanes::Lanes;

/// A precision of training: `f32` or `f64`.
pub trait Real:
    Lanes
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
{
    /// Its name: `f32` or `f64`.
    const NAME: &'static str;

    /// Nearest value; what is too large becomes infinite.
    fn of(value: f64) -> Self;

    /// The same value in double precision, exactly.
    fn double(self) -> f64;

    /// Size without sign.
    #[must_use]
    fn abs(self) -> Self;

    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
}

macro_rules! real {
    ($real:ident, $of:expr) => {
        impl Real for $real {
            const NAME: &'static str = stringify!($real);

            #[inline(always)]
            fn of(value: f64) -> Self {
                $of(value)
            }

            #[inline(always)]
            fn double(self) -> f64 {
                self.into()
            }

            #[inline(always)]
            fn abs(self) -> Self {
                Self::abs(self)
            }

            #[inline(always)]
            fn is_finite(self) -> bool {
                Self::is_finite(self)
            }
        }
    };
}

real!(f32, super::rounded);
real!(f64, core::convert::identity);
