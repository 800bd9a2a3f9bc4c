//! Every enclosure of E_sc holds the exact value, on random inputs and on inputs steered onto poles and zeros.
//!
//! Exact values come from `dashu-float` with 67 digits and share no formula with the evaluators: cot is cos/sin of the ratio.
#![cfg(test)]
#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "test data")]

use slip_benches::exact::{
    BITS, Draw, Exact, Known, Lengths, Trial, exact, narrowed, pool, ratio, sum, to_f64,
};
use slip_core::esc::{Esc, LiteralSum, Real, Trial as Conditions, literal::PreciseSum, readings};

/// Lower end, value, upper end.
type Enclosure = Option<[f64; 3]>;

/// One more irregularity, chosen so that the sum comes as close as the format allows to a multiple of pi/2, or just beside it.
fn steered(mut trial: Trial, path: &Path, draw: &mut Draw) -> Trial {
    let half_pi = Exact::pi(BITS) / exact(2.0);
    let beside = match draw.below(3) {
        0 => exact(0.0),
        1 => exact(draw.sign() * draw.log(1e-26, 1e-14)),
        _ => exact(draw.sign() * draw.log(1e-15, 1e-6)),
    };
    let ratio = if path.of_arc_cots {
        // The last arccotangent lies within 0 and pi/2.
        let j = (&trial.arc_cots / &half_pi).floor() + exact(1.0);
        exact(1.0) / (j * half_pi + beside - &trial.arc_cots).tan()
    } else {
        let wanted = draw.log(0.01, 500.0);
        let j = ((exact(wanted) + &trial.cots) / &half_pi).round();
        let last = j * &half_pi + beside - &trial.cots;
        let last = if to_f64(&last) > 1e-3 { last } else { last + half_pi };
        (exact(1.0) / last).atan()
    };
    if to_f64(&ratio) > 0.0 {
        trial.push(&Known::new(nearest(&ratio, path.single, draw)));
    }
    trial
}

/// The lengths, of eight that are tried, whose ratio comes closest to `wanted`.
fn nearest(wanted: &Exact, single: bool, draw: &mut Draw) -> Lengths {
    let tries = (0..8).map(|_| {
        let (_, spacing) = narrowed((1.0, draw.log(20e-6, 2e-3)), single);
        let lengths = narrowed((to_f64(&(wanted * exact(spacing))), spacing), single);
        (to_f64(&(ratio(lengths) - wanted)).abs(), lengths)
    });
    tries.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
}

/// One way to compute E_sc.
struct Path {
    name: &'static str,
    single: bool,
    of_arc_cots: bool,
    /// Each enclosure with the exact value, for a force and a speed.
    values: fn(&Trial, f64, f64) -> Vec<(Enclosure, Exact)>,
}

fn ends<T: Real + Into<f64>>(esc: Option<Esc<T>>) -> Enclosure {
    esc.map(|esc| [esc.lo.into(), esc.value.into(), esc.hi.into()])
}

fn scale(trial: &Trial, force: f64, speed: f64) -> Exact {
    exact(trial.lengths.len() as f64) * exact(force) * exact(speed)
}

macro_rules! summed {
    ($sum:ty, $trial:ident, $force:ident, $speed:ident) => {{
        let mut sum = <$sum>::default();
        $trial.lengths.iter().for_each(|(delta, spacing)| _ = sum.push(*delta as _, *spacing as _));
        ends(sum.value(&Conditions::new($force as _, $speed as _)))
    }};
}

const PATHS: [Path; 5] = [
    Path {
        name: "split f64",
        single: false,
        of_arc_cots: false,
        values: |t, force, speed| {
            vec![(summed!(LiteralSum<f64>, t, force, speed), scale(t, force, speed) * t.cots.tan())]
        },
    },
    Path {
        name: "split double-double",
        single: false,
        of_arc_cots: false,
        values: |t, force, speed| {
            vec![(summed!(PreciseSum<f64>, t, force, speed), scale(t, force, speed) * t.cots.tan())]
        },
    },
    Path {
        name: "split f32",
        single: true,
        of_arc_cots: false,
        values: |t, force, speed| {
            vec![(summed!(LiteralSum<f32>, t, force, speed), scale(t, force, speed) * t.cots.tan())]
        },
    },
    Path {
        name: "arc_cot",
        single: false,
        of_arc_cots: true,
        values: |t, force, speed| {
            let exactly = scale(t, force, speed) * t.arc_cots.tan();
            vec![(summed!(readings::ArcCotSum, t, force, speed), exactly)]
        },
    },
    Path {
        name: "slope_power, lift_work, viscous_work",
        single: false,
        of_arc_cots: false,
        values: proportional,
    },
];

fn proportional(t: &Trial, force: f64, speed: f64) -> Vec<(Enclosure, Exact)> {
    let sum = |term: fn(Lengths) -> Exact| sum(&t.lengths, term);
    let (f, v) = (exact(force), exact(speed));
    let damper = exact(Conditions::<f64>::new(force, speed).damping_n_s_m);
    let squares = sum(|lengths| exact(lengths.0) * ratio(lengths));
    let pi = Exact::pi(BITS);
    vec![
        (
            summed!(readings::SlopePowerSum, t, force, speed),
            &f * &v * sum(|lengths| exact(2.0) * ratio(lengths)),
        ),
        (summed!(readings::LiftWorkSum, t, force, speed), f * sum(|lengths| exact(lengths.0))),
        (
            summed!(readings::ViscousWorkSum, t, force, speed),
            &pi * &pi / exact(2.0) * damper * v * squares,
        ),
    ]
}

/// Whether it is open: holds every number, because a pole is possible or a ratio is hopeless. Panics where it misses the exact value.
fn is_open(path: &Path, enclosure: Enclosure, wanted: &Exact) -> bool {
    let Some([lo, value, hi]) = enclosure else {
        // A value that the format cannot hold is none, nor one whose sum passes the largest number before it is scaled.
        let largest = exact(1e-8 * if path.single { f64::from(f32::MAX) } else { f64::MAX });
        assert!(*wanted >= largest || -wanted >= largest, "{}: no value for {wanted}", path.name);
        return false;
    };
    let above = lo == f64::NEG_INFINITY || exact(lo) <= *wanted;
    let below = hi == f64::INFINITY || *wanted <= exact(hi);
    let holds = above && below && lo <= value && value <= hi;
    assert!(holds, "{}: {wanted} is not in {lo} to {hi}, {value}", path.name);
    lo == f64::NEG_INFINITY && hi == f64::INFINITY
}

#[test]
fn enclosures_hold_the_exact_value() {
    for (single, wide, seed) in
        [(false, false, 11), (false, true, 12), (true, false, 13), (true, true, 14)]
    {
        let known = pool(wide, single, 1500, seed);
        for path in PATHS.iter().filter(|path| path.single == single) {
            for steering in [false, true] {
                let mut draw = Draw::new(seed);
                let (mut open, mut all) = (0, 0);
                for _ in 0..400 {
                    let most = if draw.below(100) == 0 { 1000.0 } else { 40.0 };
                    let n = draw.log(1.0, most) as usize;
                    let trial = Trial::random(&known, n, &mut draw);
                    let trial = if steering { steered(trial, path, &mut draw) } else { trial };
                    let speed = draw.sign() * draw.log(1e-4, 10.0);
                    let (force, speed) = narrowed((draw.log(1e-3, 1e3), speed), single);
                    for (enclosure, wanted) in (path.values)(&trial, force, speed) {
                        open += u32::from(is_open(path, enclosure, &wanted));
                        all += 1;
                    }
                }
                println!("{} wide {wide} steered {steering}: {open} of {all} open", path.name);
                assert!(open < all * 4 / 5, "{} wide {wide}", path.name);
                let reaches = matches!(path.name, "split f64" | "split f32" | "arc_cot");
                assert!(!(steering && reaches) || open > 0, "no pole: {} wide {wide}", path.name);
            }
        }
    }
}

#[test]
fn a_million_irregularities_in_any_order_stay_within_the_bound() {
    let known = pool(false, true, 2000, 21);
    let trial = Trial::random(&known, 1_000_000, &mut Draw::new(22));
    let mut sorted = trial.lengths.clone();
    sorted.sort_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let reversed: Vec<Lengths> = sorted.iter().rev().copied().collect();
    // The steepest beside the shallowest: small terms onto large sums all the way.
    let pairs = sorted.iter().zip(&reversed).take(500_000);
    let alternating = pairs.flat_map(|(a, b)| [*a, *b]).collect();
    for lengths in [trial.lengths.clone(), sorted, reversed, alternating] {
        let trial = Trial { lengths, ..trial.clone() };
        for path in &PATHS {
            for (enclosure, wanted) in (path.values)(&trial, 2.0, 0.0625) {
                is_open(path, enclosure, &wanted);
            }
        }
    }
}
