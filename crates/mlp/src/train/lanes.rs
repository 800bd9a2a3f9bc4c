//! The precisions of training and their arithmetic, one number and one vector of the machine's width at a time.

use core::fmt::{self, Debug};
use core::ops::{Add, AddAssign, Mul, Neg, Sub};

use pulp::{Arch, Simd, WithSimd};

use crate::tanh;

/// The instructions the kernel runs on.
///
/// Results of different instruction sets differ by rounding (fused multiply-add, order of sums); on one
/// of them equal inputs give equal bits.
#[derive(Clone, Copy, Debug)]
pub struct Isa(Kind);

#[derive(Clone, Copy, Debug)]
enum Kind {
    Native(Arch),
    /// One number at a time; the compiler joins those of a panel to what every machine of the target has.
    Portable,
}

impl Isa {
    /// The widest vectors this machine has.
    #[must_use]
    pub fn detect() -> Self {
        match Arch::new() {
            Arch::Scalar => Self(Kind::Portable),
            native => Self(Kind::Native(native)),
        }
    }

    /// All that this machine has, widest first, for tests and benches.
    #[must_use]
    pub fn available() -> Vec<Self> {
        let mut all = vec![Self::detect()];
        #[cfg(target_arch = "x86_64")]
        if let (Kind::Native(Arch::V4(_)), Some(avx2)) = (all[0].0, pulp::x86::V3::try_new()) {
            all.push(Self(Kind::Native(Arch::V3(avx2))));
        }
        if matches!(all[0].0, Kind::Native(_)) {
            all.push(Self(Kind::Portable));
        }
        all
    }

    /// Replaces every value by its hyperbolic tangent, as the objective computes it on this instruction set:
    /// [`rational`](crate::tanh::rational) in `f32`, fused where the machine can, [`double`](crate::tanh::double) in
    /// `f64`.
    pub fn tanh<T: Real>(self, values: &mut [T]) {
        struct Op<'a, T>(&'a mut [T]);
        impl<T: Real> WithSimd for Op<'_, T> {
            type Output = ();

            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) {
                // In whole vectors of any machine, the last ones filled up with zeros.
                for some in self.0.chunks_mut(64) {
                    let mut vectors = [T::default(); 64];
                    vectors[..some.len()].copy_from_slice(some);
                    T::tanh(simd, &mut vectors);
                    some.copy_from_slice(&vectors[..some.len()]);
                }
            }
        }
        self.dispatch(Op(values));
    }

    /// Runs `op` with vectors of this kind.
    #[inline]
    pub(crate) fn dispatch<Op: WithSimd>(self, op: Op) -> Op::Output {
        match self.0 {
            Kind::Native(arch) => arch.dispatch(op),
            Kind::Portable => pulp::Scalar::new().vectorize(op),
        }
    }

    /// Numbers in one vector.
    pub(crate) fn width<T: Real>(self) -> usize {
        struct Width<T>(core::marker::PhantomData<T>);
        impl<T: Real> WithSimd for Width<T> {
            type Output = usize;

            #[inline(always)]
            fn with_simd<S: Simd>(self, _: S) -> usize {
                size_of::<T::Vector<S>>() / size_of::<T>()
            }
        }
        self.dispatch(Width::<T>(core::marker::PhantomData))
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            #[cfg(target_arch = "x86_64")]
            Kind::Native(Arch::V4(_)) => "AVX-512",
            #[cfg(target_arch = "x86_64")]
            Kind::Native(Arch::V3(_)) => "AVX2",
            Kind::Native(_) => "native",
            Kind::Portable => "portable",
        })
    }
}

/// A precision of training, `f32` or `f64`, and arithmetic on whole vectors, all of it inlined into a function compiled for the
/// machine's vectors.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + Into<f64>
{
    /// Its name: `f32` or `f64`.
    const NAME: &'static str;

    /// Nearest value; what is too large becomes infinite.
    fn of(value: f64) -> Self;

    /// The same value in double precision, exactly.
    #[inline(always)]
    fn double(self) -> f64 {
        self.into()
    }

    /// Vector of this type.
    type Vector<S: Simd>: Copy;

    /// Whole vectors of a slice, the rest left out.
    fn vectors<S: Simd>(slice: &[Self]) -> &[Self::Vector<S>];
    /// The same to be written to.
    fn vectors_mut<S: Simd>(slice: &mut [Self]) -> &mut [Self::Vector<S>];
    /// All lanes equal to `x`.
    fn splat<S: Simd>(simd: S, x: Self) -> Self::Vector<S>;
    /// `a + b`.
    fn sum<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// `a - b`.
    fn difference<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// `a b`.
    fn product<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// `a b + c`, fused where the machine can.
    fn mul_add<S: Simd>(
        simd: S,
        a: Self::Vector<S>,
        b: Self::Vector<S>,
        c: Self::Vector<S>,
    ) -> Self::Vector<S>;
    /// `x` where `v > 0`, otherwise 0.
    fn where_positive<S: Simd>(simd: S, v: Self::Vector<S>, x: Self::Vector<S>) -> Self::Vector<S>;
    /// 0 where `v < 0`, otherwise `v`: NaN stays.
    fn ramp<S: Simd>(simd: S, v: Self::Vector<S>) -> Self::Vector<S>;
    /// Sum of all lanes.
    fn total<S: Simd>(simd: S, v: Self::Vector<S>) -> Self;
    /// Hyperbolic tangent of every number of whole vectors.
    fn tanh<S: Simd>(simd: S, values: &mut [Self]);
}

/// The same operations of either precision, by their names in `pulp`.
macro_rules! lanes {
    (
        $real:ident, $of:expr, $vector:ident, $tanh:ident, $slice:ident, $slice_mut:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident,
        $mul_add:ident, $greater:ident, $less:ident, $select:ident, $total:ident
    ) => {
        impl Real for $real {
            const NAME: &'static str = stringify!($real);
            type Vector<S: Simd> = S::$vector;

            #[inline(always)]
            fn of(value: f64) -> Self {
                $of(value)
            }

            #[inline(always)]
            fn vectors<S: Simd>(slice: &[Self]) -> &[S::$vector] {
                S::$slice(slice).0
            }

            #[inline(always)]
            fn vectors_mut<S: Simd>(slice: &mut [Self]) -> &mut [S::$vector] {
                S::$slice_mut(slice).0
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, x: Self) -> S::$vector {
                simd.$splat(x)
            }

            #[inline(always)]
            fn sum<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$add(a, b)
            }

            #[inline(always)]
            fn difference<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$sub(a, b)
            }

            #[inline(always)]
            fn product<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$mul(a, b)
            }

            #[inline(always)]
            fn mul_add<S: Simd>(
                simd: S,
                a: S::$vector,
                b: S::$vector,
                c: S::$vector,
            ) -> S::$vector {
                simd.$mul_add(a, b, c)
            }

            #[inline(always)]
            fn where_positive<S: Simd>(simd: S, v: S::$vector, x: S::$vector) -> S::$vector {
                let zero = simd.$splat(0.0);
                simd.$select(simd.$greater(v, zero), x, zero)
            }

            #[inline(always)]
            fn ramp<S: Simd>(simd: S, v: S::$vector) -> S::$vector {
                let zero = simd.$splat(0.0);
                simd.$select(simd.$less(v, zero), zero, v)
            }

            #[inline(always)]
            fn total<S: Simd>(simd: S, v: S::$vector) -> Self {
                simd.$total(v)
            }

            #[inline(always)]
            fn tanh<S: Simd>(simd: S, values: &mut [Self]) {
                $tanh(simd, values);
            }
        }
    };
}

#[rustfmt::skip]
lanes!(
    f32, super::rounded, f32s, tanh_f32, as_simd_f32s, as_mut_simd_f32s, splat_f32s, add_f32s, sub_f32s, mul_f32s, mul_add_e_f32s, greater_than_f32s,
    less_than_f32s, select_f32s, reduce_sum_f32s
);
#[rustfmt::skip]
lanes!(
    f64, core::convert::identity, f64s, tanh_f64, as_simd_f64s, as_mut_simd_f64s, splat_f64s, add_f64s, sub_f64s, mul_f64s, mul_add_e_f64s, greater_than_f64s,
    less_than_f64s, select_f64s, reduce_sum_f64s
);

/// [`tanh::rational`] of whole vectors.
#[inline(always)]
fn tanh_f32<S: Simd>(simd: S, values: &mut [f32]) {
    for value in S::as_mut_simd_f32s(values).0 {
        *value = rational(simd, *value);
    }
}

#[inline(always)]
fn tanh_f64<S: Simd>(_: S, values: &mut [f64]) {
    // Vectors longer than a number come with fused multiply-add; elsewhere it would be a call.
    let fused = size_of::<S::f64s>() > size_of::<f64>();
    for value in values {
        *value = if fused { tanh::double_by(*value, f64::mul_add) } else { tanh::double(*value) };
    }
}

/// [`tanh::rational`] of a vector.
#[inline(always)]
fn rational<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |x: f32| simd.splat_f32s(x);
    let limit = splat(tanh::LIMIT);
    // Selected by comparison and not by `min` and `max`: NaN has to stay.
    let clamped = simd.select_f32s(simd.greater_than_f32s(x, limit), limit, x);
    let low = simd.neg_f32s(limit);
    let clamped = simd.select_f32s(simd.less_than_f32s(clamped, low), low, clamped);
    let square = simd.mul_f32s(clamped, clamped);
    let [p0, p1, p2] = tanh::NUMERATOR;
    let [q0, q1, q2, q3] = tanh::DENOMINATOR;
    let p = simd.mul_add_e_f32s(splat(p2), square, splat(p1));
    let q = simd.mul_add_e_f32s(splat(q3), square, splat(q2));
    let p = simd.mul_add_e_f32s(p, square, splat(p0));
    let q = simd.mul_add_e_f32s(q, square, splat(q1));
    let n = simd.mul_f32s(clamped, p);
    let q = simd.mul_add_e_f32s(q, square, splat(q0));
    let above = simd.mul_f32s(n, simd.add_f32s(q, q));
    let below = simd.mul_add_e_f32s(n, n, simd.mul_f32s(q, q));
    let y = simd.div_f32s(above, below);
    let one = splat(1.0);
    let y = simd.select_f32s(simd.greater_than_f32s(y, one), one, y);
    let minus = splat(-1.0);
    simd.select_f32s(simd.less_than_f32s(y, minus), minus, y)
}
