//! What is known of an object before a slip.

extern crate std;
use super::*;
use std::vec::Vec;

/// Probabilities of a fine grid of needed forces from 1 N on, of an object that slips under `force_n` (N).
fn grid(prior: &Prior, force_n: f32) -> Vec<(f32, f32)> {
    let cells: Vec<(f32, f32)> = (0..80_u8)
        .map(|i| {
            let need_ln = 0.05 * f32::from(i);
            let l = prior.ln(need_ln, 0.05, 80, exp(need_ln) / force_n, 1.1);
            (exp(need_ln), exp(l))
        })
        .collect();
    let sum: f32 = cells.iter().map(|(_, p)| p).sum();
    cells.into_iter().map(|(need_n, p)| (need_n, p / sum)).collect()
}

/// Share of the probability within a factor of 1.25 of `need_n` (N).
fn about(cells: &[(f32, f32)], need_n: f32) -> f32 {
    cells.iter().filter(|(n, _)| (n / need_n).max(need_n / n) < 1.25).map(|(_, p)| p).sum()
}

#[test]
fn of_an_unknown_object_more_is_a_little_less_probable() {
    let prior = Prior::NONE;
    assert!(!prior.is_known() && prior.least_ln().is_none());
    let cells = grid(&prior, 1.0);
    assert!(cells.windows(2).all(|pair| pair[1].1 <= pair[0].1), "{cells:?}");
    assert!(about(&cells, 2.0) < 4.0 * about(&cells, 20.0), "no force is ruled out");
}

#[test]
fn what_a_memory_or_a_slip_has_shown_is_expected_and_another_object_is_possible() {
    let mut remembered = Prior::NONE;
    remembered.remember(8.0);
    let mut learned = Prior::NONE;
    learned.learn([(ln(7.5), 0.4), (ln(8.5), 0.6), (ln(40.0), 1e-9)].into_iter());
    for prior in [remembered, learned] {
        assert!(prior.is_known());
        let cells = grid(&prior, 4.0);
        assert!(about(&cells, 8.0) > 0.6, "{cells:?}");
        assert!(about(&cells, 30.0) > 1e-3, "{cells:?}");
        let least_n = exp(prior.least_ln().unwrap());
        assert!((4.0..8.0).contains(&least_n), "{least_n}");
    }
    let mut forgotten = Prior::NONE;
    forgotten.remember(8.0);
    forgotten.forget();
    assert!(!forgotten.is_known() && forgotten.least_ln().is_none());
}

/// Once the load had time to come, a known object breaks away where all of it is there.
#[test]
fn where_an_object_breaks_away_tells_of_its_need_once_the_load_has_come() {
    let mut prior = Prior::NONE;
    prior.learn([(ln(5.0), 0.5), (ln(20.0), 0.5)].into_iter());
    prior.expect(0.0, 0.0, false);
    let early = grid(&prior, 5.0);
    assert!((about(&early, 5.0) / about(&early, 20.0) - 1.0).abs() < 0.1, "{early:?}");
    prior.expect(1.0, 0.0, false);
    let late = grid(&prior, 5.0);
    assert!(about(&late, 5.0) > 20.0 * about(&late, 20.0), "{late:?}");
    prior.expect(1.0, 0.0, true);
    assert!(prior.is_searched());
}

#[test]
fn what_is_no_force_teaches_nothing_or_something_finite() {
    for need_n in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e30] {
        let mut prior = Prior::NONE;
        prior.remember(need_n);
        prior.expect(1.0, 0.0, false);
        assert!(prior.ln(1.0, 0.2, 24, 2.0, 1.1).is_finite(), "{need_n}");
    }
    let mut prior = Prior::NONE;
    prior.learn([(f32::NAN, f32::NAN), (1.0, 0.0)].into_iter());
    assert!(!prior.is_known());
}
