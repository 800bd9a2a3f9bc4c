//! An angle in, sine and cosine to [`BITS`] digits out, ten times as fast as the general functions.
//!
//! A table of sines and cosines every 1/512 rad, made by the general functions, and a short power series between
//! them. Absolute error below 2^-215; a test compares with the general functions.

use super::{BITS, Exact, exact, to_f64};
use std::sync::LazyLock;

const STEPS: f64 = 512.0;
/// Digits of pi: reduces angles up to 2^90.
const WIDE_BITS: usize = BITS + 96;
const TERMS: usize = 20;

struct Tables {
    pi: Exact,
    sin_cos: Vec<(Exact, Exact)>,
    inverse_factorials: Vec<Exact>,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let sin_cos = (0..=810_u16).map(|k| exact(f64::from(k) / STEPS).sin_cos()).collect();
    let mut factorial = exact(1.0);
    let inverse_factorials = (0..TERMS)
        .map(|k| {
            if k > 0 {
                factorial *= exact(k as f64);
            }
            exact(1.0) / &factorial
        })
        .collect();
    Tables { pi: Exact::pi(WIDE_BITS), sin_cos, inverse_factorials }
});

/// sin and cos of the angle less the nearest multiple of pi: both with the same sign changed or not, so that tan and
/// cot are those of the angle.
#[must_use]
pub fn sin_cos_mod_pi(angle: &Exact) -> (Exact, Exact) {
    let tables = &*TABLES;
    let rest = if to_f64(angle).abs() < 1.5 {
        angle.clone()
    } else {
        let wide = angle.clone().with_precision(WIDE_BITS).value();
        let turns = (&wide / &tables.pi).round().with_precision(WIDE_BITS).value();
        (wide - turns * &tables.pi).with_precision(BITS).value()
    };
    let negative = to_f64(&rest) < 0.0;
    let rest = if negative { -rest } else { rest };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 805")]
    let k = (to_f64(&rest) * STEPS).round() as usize;
    let Some((table_sin, table_cos)) = tables.sin_cos.get(k) else { return rest.sin_cos() };
    let d = rest - exact(k as f64 / STEPS);
    let (sin, cos) = series(&d, &tables.inverse_factorials);
    let both = (table_sin * &cos + table_cos * &sin, table_cos * cos - table_sin * sin);
    if negative { (-both.0, both.1) } else { both }
}

fn series(d: &Exact, inverse_factorials: &[Exact]) -> (Exact, Exact) {
    let z = -(d * d);
    let mut sin = exact(0.0);
    let mut cos = exact(0.0);
    for pair in inverse_factorials.chunks_exact(2).rev() {
        cos = cos * &z + &pair[0];
        sin = sin * &z + &pair[1];
    }
    (sin * d, cos)
}

/// tan of an angle.
#[must_use]
pub fn tan(angle: &Exact) -> Exact {
    let (sin, cos) = sin_cos_mod_pi(angle);
    sin / cos
}

/// cot of an angle.
#[must_use]
pub fn cot(angle: &Exact) -> Exact {
    let (sin, cos) = sin_cos_mod_pi(angle);
    cos / sin
}

/// The angle from 0 to pi/2 whose tangent is the positive `t`: that of the nearest `f64`, corrected by
/// tan(a - b) = (tan a - tan b) / (1 + tan a tan b).
#[must_use]
pub fn arc_tan(t: &Exact) -> Exact {
    let start = to_f64(t).atan();
    if !(1e-280..=1.57).contains(&start) {
        return t.atan();
    }
    let (sin, cos) = sin_cos_mod_pi(&exact(start));
    let e = (t * &cos - &sin) / (cos + t * sin);
    let third = &e * &e * &e / exact(3.0);
    exact(start) + e - third
}

#[cfg(test)]
mod tests {
    use super::{arc_tan, sin_cos_mod_pi, tan};
    use crate::exact::{exact, pool::Draw, to_f64};

    #[test]
    fn agrees_with_the_general_functions() {
        let mut draw = Draw::new(5);
        for _ in 0..300 {
            let x = exact(draw.sign() * draw.log(1e-12, 1e12));
            let (sin, cos) = sin_cos_mod_pi(&x);
            let (general_sin, general_cos) = x.sin_cos();
            let same = (&sin * &general_cos - &cos * &general_sin).with_precision(53).value();
            assert!(to_f64(&same).abs() < 1e-60, "{x}");
            let norm = &sin * &sin + &cos * &cos - exact(1.0);
            assert!(to_f64(&norm).abs() < 1e-60, "{x}");
            let off = tan(&x) / x.tan() - exact(1.0);
            assert!(to_f64(&off).abs() < 1e-45, "{x}");
            let t = exact(draw.log(1e-12, 1e12));
            let off = arc_tan(&t) / t.atan() - exact(1.0);
            assert!(to_f64(&off).abs() < 1e-50, "{t}");
        }
    }
}
