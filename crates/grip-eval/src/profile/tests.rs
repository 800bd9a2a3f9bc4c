use super::{Agreement, ProfileError, ProfileLine, ProfileOptions, Spread, evaluate};
use crate::roughness::FilterKind;
use core::f64::consts::{PI, TAU};
use grip_record::HeightProfile;
use slip_core::esc::Trial;

/// A sine of 2 um and 250 um on a long wave and a tilt, at steps of 0.5 um over 10 mm.
fn profile() -> HeightProfile {
    let height =
        |x: f64| 2e-6 * (TAU * x / 250e-6).sin() + 1e-5 * (TAU * x / 12e-3).sin() + 2e-3 * x;
    let heights_m = (0..20_000).map(|i| height(f64::from(i) * 5e-7)).collect();
    HeightProfile { heights_m, step_m: 5e-7 }
}

#[test]
fn a_sine_on_a_wave_has_its_roughness_and_its_irregularities() {
    for filter in [FilterKind::MovingAverage, FilterKind::Gaussian] {
        let options = ProfileOptions { filter, level: true, ..ProfileOptions::new(2.5e-3) };
        let evaluation = evaluate(&profile(), &options).unwrap();
        assert!((evaluation.tilt - 2e-3).abs() < 3e-3, "{}", evaluation.tilt);
        let trial = Trial::new(2.0, 0.05);
        let line = ProfileLine::new(&evaluation, &options, &trial);
        assert!((line.ra_um / (4.0 / PI) - 1.0).abs() < 0.02, "{}", line.ra_um);
        assert!((line.rsm_um.unwrap() / 250.0 - 1.0).abs() < 0.001, "{line:?}");
        assert!((line.period_um.unwrap() / 250.0 - 1.0).abs() < 0.001, "{line:?}");
        let (delta, s) = (line.delta_um.unwrap(), line.s_um.unwrap());
        // The low-pass of 83 um keeps 92.7 % of a wave of 250 um.
        assert!((delta.mean / (4.0 * 0.927) - 1.0).abs() < 0.01, "{delta:?}");
        assert!((s.mean / 250.0 - 1.0).abs() < 0.001, "{s:?}");
        assert!((38..=40).contains(&line.n) && line.sections == 4, "{line:?}");
        assert_eq!((line.esc.len(), line.esc[0].reading), (5, "literal"));
        assert!((line.contact_time_s - 0.2).abs() < 1e-9);
    }
}

#[test]
fn a_flat_profile_has_no_irregularities() {
    let flat = HeightProfile { heights_m: vec![1e-6; 5000], step_m: 1e-6 };
    let options = ProfileOptions::new(2.5e-3);
    let line =
        ProfileLine::new(&evaluate(&flat, &options).unwrap(), &options, &Trial::new(1.0, 0.1));
    assert_eq!((line.n, line.delta_um, line.rsm_um), (0, None, None));
    assert!(line.ra_um < 1e-9 && line.esc.iter().all(|esc| esc.value.is_none()));
}

#[test]
fn a_cutoff_that_does_not_suit_is_refused() {
    for cutoff_m in [0.0, -1.0, f64::NAN, 2e-6, 1e9] {
        let error = evaluate(&profile(), &ProfileOptions::new(cutoff_m)).unwrap_err();
        assert!(matches!(error, ProfileError::Cutoff { .. }), "{cutoff_m}: {error}");
    }
}

#[test]
fn spread_and_agreement_by_hand() {
    let spread = Spread::of([4.0, 1.0, 2.0, 3.0, 10.0]).unwrap();
    assert_eq!((spread.mean, spread.min, spread.p50, spread.max), (4.0, 1.0, 3.0, 10.0));
    assert!((spread.sd - 10.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!(Spread::of([]), None);
    let agreement = Agreement::of(&[1e-6, -2e-6, 3e-6], &[2e-6, -4e-6, 6e-6]).unwrap();
    assert!(
        (agreement.correlation - 1.0).abs() < 1e-12 && (agreement.ra_ratio - 0.5).abs() < 1e-12
    );
    assert!((agreement.rms_um - (14.0_f64 / 3.0).sqrt()).abs() < 1e-9);
    assert_eq!(Agreement::of(&[1.0], &[1.0, 2.0]), None);
}
