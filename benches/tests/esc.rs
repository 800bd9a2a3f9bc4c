//! Every enclosure of E_sc holds the exact value, on random inputs and on inputs steered onto poles and zeros.
//!
//! Exact values come from `dashu-float` with 67 digits and share no formula with the evaluators: cot is cos/sin of the ratio.
#![cfg(test)]
#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "test data")]

use dashu_float::{FBig, round::mode::HalfEven};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng as _, SeedableRng as _};
use slip_core::esc::{Esc, LiteralSum, Real, Trial as Conditions, literal::PreciseSum, readings};

type Exact = FBig<HalfEven, 2>;
type Lengths = (f64, f64);
/// Lower end, value, upper end.
type Enclosure = Option<[f64; 3]>;

/// 67 decimal digits.
const BITS: usize = 224;

fn exact(value: f64) -> Exact {
    Exact::try_from(value).unwrap().with_precision(BITS).value()
}

fn to_f64(value: &Exact) -> f64 {
    value.to_f64().value()
}

fn ratio((delta, spacing): Lengths) -> Exact {
    exact(delta) / exact(spacing)
}

struct Draw(ChaCha8Rng);

impl Draw {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly on a logarithmic scale.
    fn log(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    fn below(&mut self, count: usize) -> usize {
        (self.0.next_u64() % count as u64) as usize
    }

    fn sign(&mut self) -> f64 {
        if self.below(2) == 0 { -1.0 } else { 1.0 }
    }

    /// Ratio log-uniform from 0.002 to 0.5, spacing from 20 um to 2 mm.
    fn machined(&mut self) -> Lengths {
        let spacing = self.log(20e-6, 2e-3);
        (spacing * self.log(0.002, 0.5), spacing)
    }

    /// Ratios from 1e-24 to 1e24, beside multiples of pi/2, at the seams of the evaluators; lengths down to subnormal and up to the
    /// largest numbers.
    fn wide(&mut self, most: f64) -> Lengths {
        let spacing = self.log(20e-6, 2e-3);
        let turns = self.log(1.0, 600.0).floor();
        let near = 1.0 + self.sign() * self.log(1e-17, 1e-2);
        let r = match self.below(10) {
            0..3 => self.log(1e-9, 1e3),
            3 => self.log(1e-24, 1e24),
            4 => self.log(1e-3, 1.0),
            5 => turns * core::f64::consts::PI * near,
            6 => (turns - 0.5) * core::f64::consts::PI * near,
            7 => [0.6, core::f64::consts::FRAC_PI_4, 1.0][self.below(3)] * near,
            8 => (self.below(64) + 1) as f64 / 64.0,
            _ => self.log(1e-4, 2.0),
        };
        let many = 10_f64.powf(self.sign() * self.unit() * most);
        let scale = if self.below(8) > 0 { 1.0 } else { many };
        (spacing * r * scale, spacing * scale)
    }
}

/// An irregularity with its exact terms: cot and arccot of delta/s.
#[derive(Clone)]
struct Known {
    lengths: Lengths,
    cot: Exact,
    arc_cot: Exact,
}

impl Known {
    fn new(lengths: Lengths) -> Self {
        let (sin, cos) = ratio(lengths).sin_cos();
        let arc_cot = (exact(lengths.1) / exact(lengths.0)).atan();
        Self { lengths, cot: cos / sin, arc_cot }
    }
}

fn narrowed(lengths: Lengths, single: bool) -> Lengths {
    let narrow = |x: f64| if single { f64::from(x as f32) } else { x };
    (narrow(lengths.0), narrow(lengths.1))
}

fn pool(wide: bool, single: bool, count: usize, seed: u64) -> Vec<Known> {
    let mut draw = Draw::new(seed);
    let most = if single { 36.0 } else { 300.0 };
    let drawn = || if wide { draw.wide(most) } else { draw.machined() };
    core::iter::repeat_with(drawn)
        .map(|lengths| narrowed(lengths, single))
        .filter(|(delta, spacing)| [*delta, *spacing].iter().all(|x| *x > 0.0 && x.is_finite()))
        .take(count)
        .map(Known::new)
        .collect()
}

/// The irregularities of one trial and their exact sums.
#[derive(Clone)]
struct Trial {
    lengths: Vec<Lengths>,
    cots: Exact,
    arc_cots: Exact,
}

impl Trial {
    fn random(pool: &[Known], n: usize, draw: &mut Draw) -> Self {
        let mut trial = Self { lengths: Vec::new(), cots: exact(0.0), arc_cots: exact(0.0) };
        (0..n).for_each(|_| trial.push(&pool[draw.below(pool.len())]));
        trial
    }

    fn push(&mut self, known: &Known) {
        self.lengths.push(known.lengths);
        self.cots += &known.cot;
        self.arc_cots += &known.arc_cot;
    }

    /// One more irregularity, chosen so that the sum comes as close as the format allows to a multiple of pi/2, or just beside it.
    fn steered(mut self, path: &Path, draw: &mut Draw) -> Self {
        let half_pi = Exact::pi(BITS) / exact(2.0);
        let beside = match draw.below(3) {
            0 => exact(0.0),
            1 => exact(draw.sign() * draw.log(1e-26, 1e-14)),
            _ => exact(draw.sign() * draw.log(1e-15, 1e-6)),
        };
        let ratio = if path.of_arc_cots {
            // The last arccotangent lies within 0 and pi/2.
            let j = (&self.arc_cots / &half_pi).floor() + exact(1.0);
            exact(1.0) / (j * half_pi + beside - &self.arc_cots).tan()
        } else {
            let wanted = draw.log(0.01, 500.0);
            let j = ((exact(wanted) + &self.cots) / &half_pi).round();
            let last = j * &half_pi + beside - &self.cots;
            let last = if to_f64(&last) > 1e-3 { last } else { last + half_pi };
            (exact(1.0) / last).atan()
        };
        if to_f64(&ratio) > 0.0 {
            self.push(&Known::new(nearest(&ratio, path.single, draw)));
        }
        self
    }
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
    let sum = |term: &dyn Fn(Lengths) -> Exact| {
        t.lengths.iter().fold(exact(0.0), |sum, lengths| sum + term(*lengths))
    };
    let (f, v) = (exact(force), exact(speed));
    let damper = exact(Conditions::<f64>::new(force, speed).damping_n_s_m);
    let squares = sum(&|lengths| exact(lengths.0) * ratio(lengths));
    let pi = Exact::pi(BITS);
    vec![
        (
            summed!(readings::SlopePowerSum, t, force, speed),
            &f * &v * sum(&|lengths| exact(2.0) * ratio(lengths)),
        ),
        (summed!(readings::LiftWorkSum, t, force, speed), f * sum(&|lengths| exact(lengths.0))),
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
            for steered in [false, true] {
                let mut draw = Draw::new(seed);
                let (mut open, mut all) = (0, 0);
                for _ in 0..400 {
                    let most = if draw.below(100) == 0 { 1000.0 } else { 40.0 };
                    let n = draw.log(1.0, most) as usize;
                    let trial = Trial::random(&known, n, &mut draw);
                    let trial = if steered { trial.steered(path, &mut draw) } else { trial };
                    let speed = draw.sign() * draw.log(1e-4, 10.0);
                    let (force, speed) = narrowed((draw.log(1e-3, 1e3), speed), single);
                    for (enclosure, wanted) in (path.values)(&trial, force, speed) {
                        open += u32::from(is_open(path, enclosure, &wanted));
                        all += 1;
                    }
                }
                println!("{} wide {wide} steered {steered}: {open} of {all} open", path.name);
                assert!(open < all * 4 / 5, "{} wide {wide}", path.name);
                let reaches = matches!(path.name, "split f64" | "split f32" | "arc_cot");
                assert!(!(steered && reaches) || open > 0, "no pole: {} wide {wide}", path.name);
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

#[test]
fn the_stated_accuracy_is_reached_on_machined_surfaces() {
    let known = pool(false, false, 4000, 31);
    let mut draw = Draw::new(32);
    let relative = |got: f64, wanted: &Exact| to_f64(&((exact(got) - wanted) / wanted)).abs();
    for (n, trials, limit) in [(10, 1500, 1e-16), (100, 500, 1e-15)] {
        let mut errors: Vec<f64> = (0..trials)
            .map(|_| {
                let trial = Trial::random(&known, n, &mut draw);
                // Force and speed of 1: nothing else is rounded.
                let [split, precise] = [&PATHS[0], &PATHS[1]].map(|path| {
                    let (enclosure, wanted) = (path.values)(&trial, 1.0, 1.0).remove(0);
                    relative(enclosure.unwrap()[1], &wanted)
                });
                assert!(precise <= 1e-15, "{precise}");
                split
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        let median = errors[errors.len() / 2];
        println!("n = {n}: median relative error {median:e}");
        assert!(median <= limit, "n = {n}: {median:e}");
    }
}
