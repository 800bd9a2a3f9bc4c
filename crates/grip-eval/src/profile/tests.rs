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
    HeightProfile::new(heights_m, 5e-7)
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
        assert!((38..=40).contains(&line.n) && line.sections == 3, "{line:?}");
        assert_eq!((line.esc.len(), line.esc[0].reading), (5, "literal"));
        assert!((line.contact_time_s - 0.2).abs() < 1e-9);
    }
}

#[test]
fn a_flat_profile_has_no_irregularities() {
    let flat = HeightProfile::new(vec![1e-6; 5000], 1e-6);
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

/// 40 mm at steps of 10 um: a wave of 3 um and `wavelength_m` on a tilted arc.
fn wave(wavelength_m: f64) -> HeightProfile {
    let height = |x: f64| 3e-6 * (TAU * x / wavelength_m).sin() + 2e-3 * x - 0.1 * x * x;
    HeightProfile::new((0..4000).map(|i| height(f64::from(i) * 1e-5)).collect(), 1e-5)
}

/// Share of a sine of `f` cutoffs^-1 that a mean line keeps.
fn transmission(filter: FilterKind, f: f64) -> f64 {
    let x = PI * 0.366_063_256_638_211_9 * f;
    match filter {
        FilterKind::Gaussian => (-PI * (0.469_718_639_349_825_66 * f).powi(2)).exp(),
        FilterKind::MovingAverage => (x.sin() / x).powi(3),
    }
}

#[test]
fn the_waviness_of_a_sine_is_what_the_filters_keep_of_two_amplitudes_over_pi() {
    let close = |got: f64, want: f64, within: f64, what: &str| {
        assert!((got / want - 1.0).abs() < within, "{what}: {got} {want}");
    };
    for filter in [FilterKind::MovingAverage, FilterKind::Gaussian] {
        let options =
            ProfileOptions { filter, form_degree: 2, level: true, ..ProfileOptions::new(0.8e-3) };
        for (wavelength_m, within) in [(0.8e-3, 5e-3), (2e-3, 5e-3), (4e-3, 0.01)] {
            let evaluation = evaluate(&wave(wavelength_m), &options).unwrap();
            let waviness = evaluation.waviness.unwrap();
            let kept = transmission(filter, 0.8e-3 / wavelength_m);
            let what = format!("{filter:?} {wavelength_m}");
            close(waviness.wa_m, kept * 2.0 * 3e-6 / PI, within, &what);
        }
        let at_the_cutoff = evaluate(&wave(0.8e-3), &options).unwrap();
        close(at_the_cutoff.waviness.unwrap().wa_m, 3e-6 / PI, 5e-3, "half of it passes");
        close(at_the_cutoff.parameters.ra_m, 3e-6 / PI, 5e-3, "the other half is roughness");
    }
}

/// Form by normal equations, mean lines by sums over all heights: slow and obvious.
#[test]
fn waviness_is_that_of_the_plain_sums() {
    let heights_m = (0..600_u32)
        .map(|i| f64::from(i * 7919 % 1013) * 1e-9 + 1e-6 * (f64::from(i) / 50.0).sin())
        .map(|z| z + 1e-6)
        .collect();
    let profile = HeightProfile::new(heights_m, 1e-5);
    let options = ProfileOptions {
        filter: FilterKind::Gaussian,
        form_degree: 0,
        long_cutoff_m: Some(4e-3),
        ..ProfileOptions::new(0.8e-3)
    };
    let evaluation = evaluate(&profile, &options).unwrap();
    let n = profile.heights_m.len();
    let mean = profile.heights_m.iter().sum::<f64>() / n as f64;
    let levelled: Vec<f64> = profile.heights_m.iter().map(|z| z - mean).collect();
    let plain_line = |at: usize, cutoff: i32| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for k in -cutoff..=cutoff {
            let u = f64::from(k) / (0.469_718_639_349_825_66 * f64::from(cutoff));
            let weight = (-PI * u * u).exp();
            let i = i32::try_from(at).unwrap() + k;
            sum += weight * levelled[usize::try_from(i.max(0)).unwrap().min(n - 1)];
            weights += weight;
        }
        sum / weights
    };
    let plain: Vec<f64> = (0..n).map(|at| plain_line(at, 80) - plain_line(at, 400)).collect();
    for (got, want) in evaluation.waviness_m.iter().zip(&plain) {
        assert!((got - want).abs() < 1e-17, "{got} {want}");
    }
    let wa_m = plain.iter().map(|z| z.abs()).sum::<f64>() / n as f64;
    assert!((evaluation.waviness.unwrap().wa_m / wa_m - 1.0).abs() < 1e-9);
}

#[test]
fn form_waviness_and_roughness_add_up_to_the_profile() {
    let profile = profile();
    let options =
        ProfileOptions { level: true, short_cutoff_m: 0.0, ..ProfileOptions::new(0.8e-3) };
    let e = evaluate(&profile, &options).unwrap();
    let parts = e.form_m.iter().zip(&e.waviness_m).zip(&e.roughness_m);
    for (z, ((form, waviness), roughness)) in profile.heights_m.iter().zip(parts) {
        assert!((form + waviness + roughness - z).abs() < 1e-17, "{z}");
    }
}

#[test]
fn a_profile_too_short_for_its_waviness_has_none() {
    // 10 mm.
    let line = |options: ProfileOptions| {
        let evaluation = evaluate(&profile(), &options).unwrap();
        ProfileLine::new(&evaluation, &options, &Trial::new(1.0, 0.1))
    };
    let short = line(ProfileOptions::new(2.5e-3));
    assert_eq!((short.wa_um, short.wz_um, short.waviness_sections), (None, None, None));
    assert!((short.waviness_needs_mm - 12.5).abs() < 1e-9);
    let long = line(ProfileOptions::new(2e-3));
    assert!(long.wa_um.is_some() && long.waviness_sections == Some(1));
    let limit =
        |mm: f64| ProfileOptions { long_cutoff_m: Some(mm * 1e-3), ..ProfileOptions::new(0.8e-3) };
    assert_eq!(line(limit(11.0)).wa_um, None);
    assert_eq!(line(limit(1e5)).waviness_needs_mm, 1e5);
    assert_eq!(line(limit(5.0)).waviness_sections, Some(2));
    for mm in [0.8, 0.5, -1.0, f64::NAN, 1e9] {
        let error = evaluate(&profile(), &limit(mm)).unwrap_err();
        assert!(matches!(error, ProfileError::LongCutoff { .. }), "{mm}: {error}");
    }
}

/// A peak is measured over its own two valleys, so what is long against them hardly changes it.
#[test]
fn waviness_hardly_changes_slopes_and_spacings() {
    let options = ProfileOptions::new(0.8e-3);
    let height =
        |x: f64| 2e-6 * (TAU * x / 150e-6).sin() + 5e-6 * (TAU * x / 4e-3).sin() + 1e-3 * x;
    let heights_m = (0..20_000).map(|i| height(f64::from(i) * 1e-6)).collect();
    let evaluation = evaluate(&HeightProfile::new(heights_m, 1e-6), &options).unwrap();
    let line = ProfileLine::new(&evaluation, &options, &Trial::new(1.0, 0.1));
    assert_eq!(line.n, line.primary.n);
    let mean = |spread: Option<Spread>| spread.unwrap().mean;
    assert!((mean(line.primary.delta_um) / mean(line.delta_um) - 1.0).abs() < 0.02, "{line:?}");
    assert!((mean(line.primary.s_um) / mean(line.s_um) - 1.0).abs() < 0.01, "{line:?}");
    let [roughness, primary] = [&line.esc, &line.primary.esc].map(|esc| esc[2].value.unwrap());
    assert_eq!(line.esc[2].reading, "slope_power");
    assert!((primary / roughness - 1.0).abs() < 0.03, "{primary} {roughness}");
}

fn with_warnings(heights_m: Vec<f64>, step_m: f64, cutoff_m: f64) -> ProfileLine {
    let options = ProfileOptions::new(cutoff_m);
    let profile = HeightProfile::new(heights_m, step_m);
    let evaluation = evaluate(&profile, &options).unwrap();
    ProfileLine::new(&evaluation, &options, &Trial::new(1.0, 0.1))
}

/// Waves of 40 to 160 um, as an eroded surface has them: 5.6 mm at steps of 0.25 um.
fn eroded() -> Vec<f64> {
    let wave = |x: f64, k: u32| {
        let wavelength_m = 40e-6 * 4_f64.powf(f64::from(k) / 40.0);
        0.13e-6 * (TAU * (x / wavelength_m + f64::from(k * k % 97) / 97.0)).sin()
    };
    (0..22_400).map(|i| (0..40).map(|k| wave(f64::from(i) * 0.25e-6, k)).sum()).collect()
}

/// With lambda_s at a hundredth of lambda_c, Ra fell by 8 to 15 % as the cutoff rose.
#[test]
fn fine_surfaces_keep_their_ra_at_any_long_cutoff() {
    let heights_m = eroded();
    for (cutoff_m, lambda_s_um, end) in [(0.8e-3, 2.5, 1600), (2.5e-3, 8.0, 5000)] {
        let inner = &heights_m[end..22_400 - end];
        let ra_um = 1e6 * inner.iter().map(|z| z.abs()).sum::<f64>() / inner.len() as f64;
        let line = with_warnings(heights_m.clone(), 0.25e-6, cutoff_m);
        assert!((line.lambda_s_um - lambda_s_um).abs() < 1e-9, "{}", line.lambda_s_um);
        assert!((line.ra_um / ra_um - 1.0).abs() < 0.015, "{cutoff_m}: {} {ra_um}", line.ra_um);
        assert!((line.ends_mm - 500.0 * cutoff_m).abs() < 1e-9, "{}", line.ends_mm);
        let named = line.warnings.iter().any(|text| text.contains("--cutoff-mm 0.8"));
        assert_eq!(
            (line.warnings.len(), named),
            if cutoff_m > 1e-3 { (1, true) } else { (0, false) }
        );
    }
    let short = with_warnings(heights_m, 0.25e-6, 8e-3);
    assert!(
        short.ends_mm == 0.0 && short.warnings[0].contains("less than one cutoff"),
        "{short:?}"
    );
    for (cutoff_m, lambda_s_m) in
        [(0.08e-3, 2.5e-6), (0.25e-3, 2.5e-6), (8e-3, 25e-6), (2e-3, 8e-6)]
    {
        assert_eq!(ProfileOptions::new(cutoff_m).short_cutoff_m, lambda_s_m);
    }
}

/// At the ends the mean line of a profile that is held there is not that of the waves.
#[test]
fn the_ends_are_not_in_the_parameters() {
    let square = |i: u32| if (i / 200).is_multiple_of(2) { 1e-6 } else { -1e-6 };
    let heights_m: Vec<f64> = (0..11_200).map(|i| square(i) + 1e-9 * f64::from(i)).collect();
    let options = ProfileOptions { short_cutoff_m: 0.0, ..ProfileOptions::new(0.8e-3) };
    let profile = HeightProfile::new(heights_m, 0.5e-6);
    let inner = evaluate(&profile, &options).unwrap();
    let range = |z: &[f64]| {
        z.iter().fold(f64::MIN, |m, z| m.max(*z)) - z.iter().fold(f64::MAX, |m, z| m.min(*z))
    };
    let rz_um = 1e6 * inner.parameters.rz_m;
    assert!((rz_um / 2.0 - 1.0).abs() < 0.03, "{rz_um}");
    assert!(1e6 * range(&inner.roughness_m) > 2.3, "{}", range(&inner.roughness_m));
}

#[test]
fn spikes_are_named_and_structure_is_not() {
    let clean = eroded();
    let spiky = |places: &[usize], width: usize, height_m: f64| {
        let mut heights_m = clean.clone();
        for place in places {
            heights_m[*place..place + width].iter_mut().for_each(|z| *z += height_m);
        }
        let line = with_warnings(heights_m, 0.25e-6, 0.8e-3);
        line.warnings.into_iter().filter(|text| text.contains("spikes")).collect::<Vec<_>>()
    };
    for (width, height_m) in [(1, 500e-6), (3, -20e-6), (5, 10e-6)] {
        let found = spiky(&[400, 8000, 12_000, 20_000], width, height_m);
        assert!(found[0].starts_with("spikes: 4, up to"), "{found:?}");
        assert!(found[0].contains("at 0.1, 2, 3 mm and on"), "{found:?}");
    }
    assert!(spiky(&[], 1, 0.0).is_empty() && spiky(&[8000], 40, 5e-6).is_empty(), "a groove");
    let random = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 8) * 1e-12;
    let coarse = with_warnings((0..5000).map(random).collect(), 5e-6, 8e-3);
    assert!(!coarse.warnings.iter().any(|text| text.contains("spikes")), "{:?}", coarse.warnings);
}

#[test]
fn gaps_are_bridged_up_to_a_twentieth_of_the_cutoff() {
    let gap = |width: usize| HeightProfile {
        filled: core::iter::once(5000..5000 + width).collect(),
        ..HeightProfile::new(eroded(), 0.25e-6)
    };
    let options = ProfileOptions::new(0.8e-3);
    let warnings = evaluate(&gap(160), &options).unwrap().warnings;
    assert!(warnings[0].contains("gaps: 1, the widest 40 um at 1.25 mm"), "{warnings:?}");
    let error = evaluate(&gap(161), &options).unwrap_err();
    assert!(error.to_string().starts_with("no heights from 1.25"), "{error}");
}
