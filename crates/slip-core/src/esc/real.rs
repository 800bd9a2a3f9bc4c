//! What the evaluators of E_sc need of a number format: `f64`, or `f32` for processors without doubles.

use core::{
    fmt::Debug,
    ops::{Add, Div, Mul, Neg, Sub},
};

use super::double::{Double, two_sum};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A binary floating-point format with the constants of the reciprocal split. Implemented by `f32` and `f64` only.
pub trait Real:
    sealed::Sealed
    + Copy
    + Debug
    + Default
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Half the distance from 1 to the next number: the largest relative error of one operation.
    const ROUNDOFF: Self;
    /// The smallest positive number.
    const TINIEST: Self;
    /// The largest finite number.
    const LARGEST: Self;
    /// 2^ceil(p/2) + 1 for p digits: splits a number into halves (Veltkamp).
    const SPLITTER: Self;
    /// 2^(p-1) for p digits: from here on every number is an integer, and adding it to a smaller one rounds that to one.
    const ROUNDER: Self;
    /// pi in three parts.
    const PI: [Self; 3];
    /// 1/pi.
    const INV_PI: Self;
    /// From this ratio on, and below its inverse, r keeps no digit of S mod pi.
    const HOPELESS: Self;
    /// Lengths within this range and its inverse need no scaling.
    const ORDINARY: Self;
    /// Powers of two that bring shorter and longer lengths into a range where products are exact.
    const RESCALE: [Self; 2];
    /// The sum is reduced mod pi when it exceeds this.
    const REDUCE_ABOVE: Self;
    /// Coefficients of h in two parts; the first [`Self::SINGLE_TERMS`] suffice for one digit width.
    const H: [[Self; 2]; 24];
    /// Terms of h for r <= 0.6 in one digit width.
    const SINGLE_TERMS: usize;
    /// Terms of h for r <= 0.6 in two digit widths.
    const DOUBLE_TERMS: usize;

    /// `value` in this format.
    fn of(value: f32) -> Self;
    /// `value` in this format, rounded.
    fn from_count(value: u32) -> Self;
    /// Magnitude.
    #[must_use]
    fn abs(self) -> Self;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// The next number towards plus infinity.
    #[must_use]
    fn next_up(self) -> Self;
    /// The next number towards minus infinity.
    #[must_use]
    fn next_down(self) -> Self;
    /// sum over k of c_k r^(2k-1) for 0 <= r <= 0.6, within 6 roundoffs.
    #[must_use]
    fn h(self) -> Self;
    /// tan of `hi + lo` for sizes up to pi/4, within 4 roundoffs.
    #[must_use]
    fn tan_first(hi: Self, lo: Self) -> Self;
    /// Adds a non-negative number to a running bound `hi + lo` without losing the small ones.
    fn tally(hi: &mut Self, lo: &mut Self, value: Self);
}

/// c_k of h(r) = sum c_k r^(2k-1) in two parts: c_1 = 1/3, c_k = sum over i < k of c_i c_(k-i) / (2k + 1).
const COEFFICIENTS: [[f64; 2]; 24] = [
    [0.3333333333333333, 1.850371707708594e-17],
    [0.022222222222222223, -8.480870326997723e-19],
    [0.0021164021164021165, -1.4272460344676906e-19],
    [0.00021164021164021165, -8.851449482249383e-21],
    [2.1377799155576935e-5, -1.2363213405319781e-21],
    [2.1644042808063972e-6, -1.4406027968224744e-23],
    [2.1925947851873778e-7, -4.633975226217266e-25],
    [2.2214608789979678e-8, 9.8218334027542e-25],
    [2.2507846516808994e-9, -1.586632784299882e-25],
    [2.2805151204592183e-10, -5.2026333279551446e-27],
    [2.3106432599002624e-11, -6.28420623757996e-29],
    [2.3411706819824882e-12, 1.7365409250001553e-28],
    [2.3721017400233653e-13, 1.2711970013895883e-29],
    [2.4034415333307705e-14, 1.5378003549195334e-30],
    [2.4351954029183367e-15, 1.4005306880921365e-31],
    [2.4673688045172075e-16, -7.143574177377665e-34],
    [2.499967277122081e-17, -9.643517068634457e-34],
    [2.532996435740635e-18, -7.406761408658804e-35],
    [2.566461970282629e-19, -1.0815887694020841e-35],
    [2.6003696460137274e-20, -2.2371951031565802e-37],
    [2.63472530441538e-21, 7.153628108650625e-38],
    [2.669534864157395e-22, -9.663413140925675e-39],
    [2.704804322109031e-23, -2.5931255859831553e-39],
    [2.7405397543699514e-24, -6.355871509327006e-41],
];

#[expect(clippy::cast_possible_truncation, reason = "the second part holds what the first loses")]
const fn in_singles(wide: [[f64; 2]; 24]) -> [[f32; 2]; 24] {
    let mut narrow = [[0.0; 2]; 24];
    let mut k = 0;
    while k < narrow.len() {
        narrow[k][0] = wide[k][0] as f32;
        narrow[k][1] = (wide[k][0] - narrow[k][0] as f64) as f32;
        k += 1;
    }
    narrow
}

/// 2^exponent, -1022 to 1023.
#[expect(clippy::cast_sign_loss, reason = "positive within the range")]
const fn power(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// 2^exponent, -126 to 127.
#[expect(clippy::cast_sign_loss, reason = "positive within the range")]
const fn power_f32(exponent: i32) -> f32 {
    f32::from_bits(((127 + exponent) as u32) << 23)
}

const fn first(parts: &[[f64; 2]; 24], k: usize) -> f64 {
    parts[k][0]
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const ROUNDOFF: Self = power(-53);
    const TINIEST: Self = Self::from_bits(1);
    const LARGEST: Self = Self::MAX;
    const SPLITTER: Self = 134_217_729.0;
    const ROUNDER: Self = power(52);
    const PI: [Self; 3] = [core::f64::consts::PI, 1.2246467991473532e-16, -2.9947698097183397e-33];
    const INV_PI: Self = core::f64::consts::FRAC_1_PI;
    const HOPELESS: Self = power(90);
    const ORDINARY: Self = power(400);
    const RESCALE: [Self; 2] = [power(600), power(-600)];
    const REDUCE_ABOVE: Self = 8192.0;
    const H: [[Self; 2]; 24] = COEFFICIENTS;
    const SINGLE_TERMS: usize = 12;
    const DOUBLE_TERMS: usize = 24;

    fn of(value: f32) -> Self {
        Self::from(value)
    }
    fn from_count(value: u32) -> Self {
        Self::from(value)
    }
    fn abs(self) -> Self {
        self.abs()
    }
    fn is_finite(self) -> bool {
        self.is_finite()
    }
    fn sqrt(self) -> Self {
        libm::sqrt(self)
    }
    fn next_up(self) -> Self {
        self.next_up()
    }
    fn next_down(self) -> Self {
        self.next_down()
    }

    /// Pairs of terms first (Estrin), so that the additions do not wait for each other.
    #[inline]
    fn h(self) -> Self {
        const C: [f64; 12] = {
            let mut c = [0.0; 12];
            let mut k = 0;
            while k < 12 {
                c[k] = first(&COEFFICIENTS, k);
                k += 1;
            }
            c
        };
        let z = self * self;
        let z2 = z * z;
        let z4 = z2 * z2;
        let low = (C[0] + C[1] * z) + (C[2] + C[3] * z) * z2;
        let middle = (C[4] + C[5] * z) + (C[6] + C[7] * z) * z2;
        let high = (C[8] + C[9] * z) + (C[10] + C[11] * z) * z2;
        self * (low + z4 * (middle + z4 * high))
    }

    fn tan_first(hi: Self, lo: Self) -> Self {
        let t = libm::tan(hi);
        t + lo * (1.0 + t * t)
    }

    #[inline]
    fn tally(hi: &mut Self, _: &mut Self, value: Self) {
        *hi += value;
    }
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const ROUNDOFF: Self = power_f32(-24);
    const TINIEST: Self = Self::from_bits(1);
    const LARGEST: Self = Self::MAX;
    const SPLITTER: Self = 4097.0;
    const ROUNDER: Self = power_f32(23);
    const PI: [Self; 3] = [core::f32::consts::PI, -8.742278e-8, -3.430249e-15];
    const INV_PI: Self = core::f32::consts::FRAC_1_PI;
    const HOPELESS: Self = power_f32(36);
    const ORDINARY: Self = power_f32(40);
    const RESCALE: [Self; 2] = [power_f32(100), power_f32(-60)];
    const REDUCE_ABOVE: Self = 64.0;
    const H: [[Self; 2]; 24] = in_singles(COEFFICIENTS);
    const SINGLE_TERMS: usize = 6;
    const DOUBLE_TERMS: usize = 12;

    fn of(value: f32) -> Self {
        value
    }
    fn from_count(value: u32) -> Self {
        value as Self
    }
    fn abs(self) -> Self {
        self.abs()
    }
    fn is_finite(self) -> bool {
        self.is_finite()
    }
    fn sqrt(self) -> Self {
        libm::sqrtf(self)
    }
    fn next_up(self) -> Self {
        self.next_up()
    }
    fn next_down(self) -> Self {
        self.next_down()
    }

    #[inline]
    fn h(self) -> Self {
        let z = self * self;
        let [first, ..] = Self::H;
        let mut p = Self::ZERO;
        for term in Self::H.iter().take(Self::SINGLE_TERMS).skip(1).rev() {
            p = (p + term[0]) * z;
        }
        self * (p + first[0])
    }

    /// libm's `tanf` computes in doubles, which is what this format must do without.
    fn tan_first(hi: Self, lo: Self) -> Self {
        Double { hi, lo }.tan_first().hi
    }

    #[inline]
    fn tally(hi: &mut Self, lo: &mut Self, value: Self) {
        let (sum, rest) = two_sum(*hi, value);
        *hi = sum;
        *lo += rest;
    }
}
