//! What the posterior makes of objects that are not what they seemed.

use crate::object::{Loop, Object};

/// Invariant (c): an object that gets heavier while it is braked contradicts what was estimated, in the same slip.
#[test]
fn an_estimate_that_the_object_contradicts_loses_its_say() {
    for (first_n, then_n) in [(4.0, 8.0), (4.0, 14.0), (8.0, 20.0), (3.0, 4.5)] {
        let mut grip = Loop::new(Object::new(10_000.0, first_n, 0.7));
        let (mut fastest_m_s, mut need) = (0.0, None);
        while grip.object.speed_m_s >= 0.7 * fastest_m_s {
            grip.step(|sample| sample);
            fastest_m_s = grip.object.speed_m_s.max(fastest_m_s);
            assert!(grip.object.t_s() < 1.0, "{first_n} N: never braked");
        }
        grip.object.needed_n = then_n;
        while grip.object.t_s() < 2.0 {
            need = grip.step(|sample| sample).need;
        }
        let Object { applied_n, travel_m, speed_m_s, .. } = grip.object;
        let case = format!("{first_n} then {then_n} N: {:?}, {need:?}", grip.object);
        assert!(speed_m_s == 0.0 && travel_m < 0.01, "{case}");
        assert!((1.0..2.0).contains(&(applied_n / then_n)), "{case}");
        let median = f64::from(need.unwrap().median_n) / then_n;
        assert!((0.75..1.4).contains(&median), "{case}");
    }
}

/// The quantiles that are reported hold what the object needs, and are in order.
#[test]
fn what_is_reported_to_be_needed_is_needed() {
    for needed_n in [3.0, 6.0, 12.0, 24.0] {
        let mut grip = Loop::new(Object::new(10_000.0, needed_n, 0.7));
        let mut need = None;
        while grip.object.t_s() < 1.2 {
            need = grip.step(|sample| sample).need;
            if let Some(need) = need {
                assert!(need.low_n <= need.median_n && need.median_n <= need.high_n, "{need:?}");
            }
        }
        let need = need.unwrap();
        let (low, high) = (f64::from(need.low_n), f64::from(need.high_n));
        assert!(0.8 * low <= needed_n && needed_n <= 1.25 * high, "{needed_n} N: {need:?}");
    }
}
