use super::*;

fn generate(config: GeneratorConfig, count: u32) -> Vec<Row> {
    rows(config, 5, count).unwrap().collect()
}

#[test]
fn closed_form_rows_obey_the_impulse_balance_exactly() {
    for row in generate(GeneratorConfig::default(), 500) {
        let found = GRAVITY_M_S2 * row.trial_force_n
            / (GRAVITY_M_S2 - row.slip_speed_m_s / row.contact_time_s);
        assert!((found / row.needed_force_n - 1.0).abs() < 1e-12, "{row:?}");
        assert!((row.adequate_force_n / row.needed_force_n - 1.2).abs() < 1e-12);
        assert!((0.2..1.0).contains(&row.mass_kg) && (0.2..0.5).contains(&row.friction));
        let travel = 0.5 * row.slip_acceleration_m_s2 * row.contact_time_s.powi(2);
        assert!((travel / 2e-3 - 1.0).abs() < 1e-12);
    }
}

#[test]
fn simulated_rows_obey_it_within_two_percent() {
    let config = GeneratorConfig { source: Source::Simulated, ..GeneratorConfig::default() };
    let mut errors: Vec<f64> = generate(config, 100)
        .iter()
        .map(|row| {
            let found =
                GRAVITY_M_S2 * row.trial_force_n / (GRAVITY_M_S2 - row.slip_acceleration_m_s2);
            (found / row.needed_force_n - 1.0).abs()
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    println!(
        "impulse balance on simulated slips: p50 {:.4} p95 {:.4} max {:.4}",
        errors[50], errors[95], errors[99]
    );
    assert!(errors[50] < 0.01 && errors[99] < 0.02);
}

#[test]
fn a_fixed_trial_force_never_holds() {
    let config = GeneratorConfig { trial: TrialForce::FixedN(2.0), ..GeneratorConfig::default() };
    for row in generate(config, 500) {
        assert!((row.trial_force_n - 2.0).abs() < 1e-12 && row.needed_force_n > 2.0);
    }
}

#[test]
fn irregularities_match_travel_over_spacing() {
    let rows = generate(GeneratorConfig::default(), 300);
    let mean = rows.iter().map(|row| f64::from(row.irregularities)).sum::<f64>() / 300.0;
    // 2 mm over RSm of 71 um to 1.1 mm: 28 to 2 irregularities.
    assert!((5.0..20.0).contains(&mean), "{mean}");
    assert!(rows.iter().all(|row| row.esc_literal_w.is_finite() && row.mean_slope < 0.5));
}

/// Shallow, equal irregularities: slope power over n times contact time is twice the lift work, and the sum of
/// the listed asperities is what the row holds.
#[test]
fn readings_are_those_of_the_listed_irregularities() {
    let surface = Surface::new(1.6e-6, 200e-6, 9);
    let passed = Passed::between(&surface, 0.0, 2e-3);
    let (force, speed) = (2.0, 0.1);
    let mut begin = 0.0;
    let mut sums = slip_core::esc::EscSums::default();
    for asperity in (0..u64::from(passed.count)).map(|index| surface.asperity(index)) {
        assert!(begin + 0.5 * asperity.spacing_m <= 2e-3);
        begin += asperity.spacing_m;
        assert!(sums.push(asperity.delta_m, asperity.spacing_m));
    }
    let readings = passed.readings(force, speed);
    let own = [
        passed.literal_w(force, speed),
        readings.arc_cot_w,
        readings.slope_power_w,
        readings.lift_work_j,
        readings.viscous_work_j,
    ];
    let trial = slip_core::esc::Trial::new(force, speed);
    for (reading, own) in slip_core::esc::Reading::ALL.into_iter().zip(own) {
        let exact = sums.value(reading, &trial).unwrap().value;
        assert!((own / exact - 1.0).abs() < 1e-6, "{}: {own} {exact}", reading.name());
    }
}

#[test]
fn speed_noise_has_the_size_asked_for() {
    let clean = generate(GeneratorConfig::default(), 2000);
    let noisy = generate(GeneratorConfig { speed_noise: 0.03, ..GeneratorConfig::default() }, 2000);
    let squares: f64 = clean
        .iter()
        .zip(&noisy)
        .map(|(c, n)| (n.slip_speed_m_s / c.slip_speed_m_s - 1.0).powi(2))
        .sum();
    let sigma = (squares / 2000.0).sqrt();
    assert!((sigma / 0.03 - 1.0).abs() < 0.05, "{sigma}");
}

#[test]
fn rows_are_seeded_and_a_longer_run_begins_with_a_shorter_one() {
    let config = GeneratorConfig::default();
    assert_eq!(generate(config, 20), generate(config, 40)[..20]);
    let other: Vec<Row> = rows(config, 6, 20).unwrap().collect();
    assert!(
        generate(config, 20)
            .iter()
            .zip(&other)
            .all(|(a, b)| a.needed_force_n.to_bits() != b.needed_force_n.to_bits())
    );
}

#[test]
fn csv_has_one_value_for_each_column_and_reads_back() {
    assert_eq!(CSV_HEADER, COLUMNS.join(","));
    let row = generate(GeneratorConfig::default(), 1)[0];
    let read: Vec<f64> = row.csv().split(',').map(|field| field.parse().unwrap()).collect();
    assert_eq!(read, row.values());
}

#[test]
fn ranges_are_checked() {
    let bad = GeneratorConfig { safety: 0.5, ..GeneratorConfig::default() };
    assert_eq!(rows(bad, 0, 1).err().unwrap().to_string(), "safety = 0.5 is outside 1 to 3");
    let bad =
        GeneratorConfig { trial: TrialForce::Share([0.9, 0.5]), ..GeneratorConfig::default() };
    assert!(rows(bad, 0, 1).is_err());
}

#[test]
fn stretches_obey_the_impulse_balance_whether_the_slip_grows_or_is_braked() {
    let rows =
        generate(GeneratorConfig { source: Source::Stretch, ..GeneratorConfig::default() }, 500);
    let mut braked = 0;
    for row in &rows {
        let found = GRAVITY_M_S2 * row.trial_force_n / (GRAVITY_M_S2 - row.slip_acceleration_m_s2);
        assert!((found / row.needed_force_n - 1.0).abs() < 1e-12, "{row:?}");
        let first = row.slip_speed_m_s - row.slip_acceleration_m_s2 * row.contact_time_s;
        assert!(first >= 0.0 && row.slip_speed_m_s > 0.0, "slides forward all the time: {row:?}");
        let travel = 0.5 * (first + row.slip_speed_m_s) * row.contact_time_s;
        assert!((travel - row.micro_displacement_m).abs() < 1e-12);
        braked += u32::from(row.slip_acceleration_m_s2 < 0.0);
    }
    assert!((50..450).contains(&braked), "{braked} of 500");
}
