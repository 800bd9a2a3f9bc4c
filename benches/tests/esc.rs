//! Every enclosure of E_sc holds the exact value, on random inputs and on inputs steered onto poles and zeros.

use slip_benches::{
    containment::{Path, check, one},
    exact::{
        pool::{Draw, Kind, Width, pool},
        relative_error,
        trial::Trial,
    },
};
use slip_core::esc::{LiteralSum, Trial as Conditions, literal::PreciseSum};

#[test]
fn enclosures_hold_the_exact_value() {
    for (width, kind, seed) in [
        (Width::Double, Kind::Machined, 11),
        (Width::Double, Kind::Wide, 12),
        (Width::Single, Kind::Machined, 13),
        (Width::Single, Kind::Wide, 14),
    ] {
        let known = pool(kind, width, 1500, seed);
        for path in Path::ALL.into_iter().filter(|path| path.width() == width) {
            for steered in [false, true] {
                let tally = check(path, &known, 400, steered, seed);
                println!("{path:?} {kind:?} steered {steered}: {tally:?}");
                assert_eq!((tally.failures, tally.missing), (0, 0), "{path:?} {kind:?} {tally:?}");
                assert!(tally.open < tally.trials * 4 / 5, "{path:?} {kind:?} {tally:?}");
                let reaches = matches!(path, Path::SplitF64 | Path::SplitF32 | Path::ArcCot);
                assert!(
                    !(steered && reaches) || tally.open > 0,
                    "nothing met a pole: {path:?} {kind:?}"
                );
            }
        }
    }
}

#[test]
fn a_million_irregularities_in_any_order_stay_within_the_bound() {
    let known = pool(Kind::Machined, Width::Single, 2000, 21);
    let trial = Trial::random(&known, 1_000_000, &mut Draw::new(22));
    let mut orders = vec![trial.clone()];
    let mut sorted = trial.clone();
    sorted.lengths.sort_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)));
    let mut reversed = sorted.clone();
    reversed.lengths.reverse();
    // The steepest beside the shallowest: small terms onto large sums all the way.
    let mut alternating = sorted.clone();
    alternating.lengths = sorted
        .lengths
        .iter()
        .zip(&reversed.lengths)
        .take(500_000)
        .flat_map(|(a, b)| [*a, *b])
        .collect();
    orders.extend([sorted, reversed, alternating]);
    for order in orders {
        for path in Path::ALL {
            let mut tally = Default::default();
            one(path, &order, 2.0, 0.0625, &mut tally);
            assert_eq!((tally.failures, tally.missing), (0, 0), "{path:?}");
        }
    }
}

#[test]
fn the_stated_accuracy_is_reached_on_machined_surfaces() {
    let known = pool(Kind::Machined, Width::Double, 4000, 31);
    let mut draw = Draw::new(32);
    for (n, trials, limit) in [(10, 1500, 1e-16), (100, 500, 1e-15)] {
        let mut errors: Vec<f64> = (0..trials)
            .map(|_| {
                let trial = Trial::random(&known, n, &mut draw);
                let wanted = trial.cots.tan();
                let mut split = LiteralSum::<f64>::default();
                let mut precise = PreciseSum::<f64>::default();
                for (delta, spacing) in &trial.lengths {
                    split.push(*delta, *spacing);
                    precise.push(*delta, *spacing);
                }
                // A power of two apart from tan S, so that nothing else is rounded.
                let conditions = Conditions::new(1.0, 1.0);
                let per = wanted.clone() * slip_benches::exact::exact(n as f64);
                let precise = precise.value(&conditions).unwrap();
                assert!(relative_error(precise.value, &per) <= 1e-15, "{precise:?}");
                relative_error(split.value(&conditions).unwrap().value, &per)
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        let median = errors[errors.len() / 2];
        println!("n = {n}: median relative error {median:e}");
        assert!(median <= limit, "n = {n}: {median:e}");
    }
}
