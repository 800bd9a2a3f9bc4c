//! Values known to many digits, contracts at the edges. The stress tests stand in the package of the benches, which has
//! arbitrary precision.

use super::{EscSum, EscSums, Flag, LiteralSum, Reading, Trial, literal::PreciseSum};

fn literal(ratios: &[f64]) -> LiteralSum {
    let mut sum = LiteralSum::default();
    for r in ratios {
        sum.push(*r, 1.0);
    }
    sum
}

/// tan(sum cot r) from a 60-digit evaluation.
const KNOWN: [(&[f64], f64); 5] = [
    (&[1.0], 0.747_801_550_829_053_8),
    (&[0.5, 0.25], -0.594_519_831_703_102_1),
    (&[0.125], -9.552_176_398_775_881),
    (&[2.0], -0.492_534_701_186_185_7),
    (&[100.0, 0.0625, 3.0], 1.483_783_548_450_916_3),
];

#[test]
fn values_agree_with_sixty_digits() {
    for (ratios, known) in KNOWN {
        let trial = Trial::new(1.0 / ratios.len() as f64, 1.0);
        let single = literal(ratios).value(&trial).unwrap();
        assert!((single.value / known - 1.0).abs() < 2e-14, "{ratios:?}: {single:?}");
        assert!(single.lo <= known && known <= single.hi, "{ratios:?}: {single:?}");
        let mut precise = PreciseSum::<f64>::default();
        ratios.iter().for_each(|r| _ = precise.push(*r, 1.0));
        let precise = precise.value(&trial).unwrap();
        assert!((precise.value / known - 1.0).abs() < 1e-15, "{ratios:?}: {precise:?}");
        let mut narrow = LiteralSum::<f32>::default();
        #[expect(clippy::cast_possible_truncation, reason = "exact for these numbers")]
        ratios.iter().for_each(|r| _ = narrow.push(*r as f32, 1.0));
        let narrow = narrow.value(&Trial::new(1.0, 1.0)).unwrap();
        let known = known * ratios.len() as f64;
        assert!(f64::from(narrow.lo) <= known && known <= f64::from(narrow.hi), "{narrow:?}");
        assert!((f64::from(narrow.value) / known - 1.0).abs() < 2e-5, "{known} {narrow:?}");
    }
}

#[test]
fn noise_takes_the_information() {
    let trial = Trial::new(1.0, 1.0).with_noise(0.01);
    let few = literal(&[0.5; 3]).value(&trial).unwrap();
    assert!(few.informative() && few.sigma_s > 0.0);
    let many = literal(&[0.005; 100]).value(&trial).unwrap();
    assert!(!many.informative() && many.flags.contains(Flag::NoInformation), "{many:?}");
    // eps r csc^2 r = 2 for each; independent errors add as squares, a common one as it is.
    assert!((many.sigma_s / 20.0 - 1.0).abs() < 1e-4, "{many:?}");
    let common = Trial { noise: super::Noise { independent: 0.0, common: 0.01 }, ..trial };
    let many = literal(&[0.005; 100]).value(&common).unwrap();
    assert!((many.sigma_s / 200.0 - 1.0).abs() < 1e-4, "{many:?}");
}

#[test]
fn degenerate_irregularities_are_counted_not_summed() {
    let mut sum = EscSum::new(Reading::ArcCot);
    let bad = [
        (0.0, 1.0),
        (1.0, 0.0),
        (f64::NAN, 1.0),
        (1.0, f64::INFINITY),
        (f64::INFINITY, 1.0),
        (-1.0, -1.0),
        (-1.0, 1.0),
    ];
    for (delta_m, spacing_m) in bad {
        assert!(!sum.push(delta_m, spacing_m));
    }
    assert_eq!((sum.n(), sum.degenerate()), (0, 7));
    assert_eq!(sum.literal(&Trial::new(1.0, 1.0)), None);
    assert!(sum.push(0.5, 1.0));
    let value = sum.literal(&Trial::new(1.0, 1.0)).unwrap();
    assert!(value.flags.contains(Flag::Degenerate) && value.degenerate == 7);
    assert_eq!(sum.chosen(&Trial::new(1.0, 1.0), Some(value)).unwrap().degenerate, 7);
}

#[test]
fn not_finite_trials_give_no_value() {
    let mut sums = EscSums::default();
    sums.push(0.5, 1.0);
    for reading in Reading::ALL {
        for (force, speed) in [(f64::NAN, f64::NAN), (f64::INFINITY, f64::INFINITY)] {
            let trial = Trial::new(force, speed);
            assert_eq!(sums.value(reading, &trial), None, "{reading:?} {trial:?}");
        }
    }
}

#[test]
fn hopeless_ratios_open_the_enclosure() {
    for (delta, spacing) in [(1e-300, 1e300), (1e300, 1e-300), (f64::MAX, 1.0), (1.0, f64::MAX)] {
        let mut sum = literal(&[0.5]);
        assert!(sum.push(delta, spacing));
        let value = sum.value(&Trial::new(1.0, 1.0)).unwrap();
        assert!(value.lo == f64::NEG_INFINITY && value.hi == f64::INFINITY, "{value:?}");
        assert!(value.flags.contains(Flag::PoleInside) && value.flags.contains(Flag::SignUnknown));
        assert!(!value.informative(), "{value:?}");
        let mut precise = PreciseSum::default();
        assert!(precise.push(delta, spacing));
        assert!(!precise.value(&Trial::new(1.0, 1.0)).unwrap().informative());
    }
}

#[test]
fn readings_have_their_units_and_relations() {
    let trial = Trial::new(2.0, 0.05);
    let mut sums = EscSums::default();
    for _ in 0..20 {
        assert!(sums.push(4e-6, 2e-4));
    }
    let value = |reading| sums.value(reading, &trial).unwrap().value;
    let contact_s = 20.0 * 2e-4 / 0.05;
    let lift = value(Reading::LiftWork);
    assert!((lift / (2.0 * 20.0 * 4e-6) - 1.0).abs() < 1e-15);
    let slope = value(Reading::SlopePower);
    assert!((slope / 20.0 * contact_s / (2.0 * lift) - 1.0).abs() < 1e-14);
    // Flank angle atan(2 delta/s), n F v tan of it.
    assert!((slope / (20.0 * 2.0 * 0.05 * 0.04) - 1.0).abs() < 1e-14);
    let viscous = 0.5 * core::f64::consts::PI.powi(2) * 0.141_421_36 * 0.05 * 20.0 * 8e-8;
    assert!((value(Reading::ViscousWork) / viscous - 1.0).abs() < 1e-7);
    for reading in Reading::ALL {
        assert_eq!(Reading::from_name(reading.name()), Some(reading));
    }
    assert_eq!(Reading::from_name("slope-power"), Some(Reading::SlopePower));
    assert_eq!(Reading::from_name("slopepower"), None);
}
