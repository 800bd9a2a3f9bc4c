extern crate std;
use super::{Drives, Expected, FALLS_M, Losses, fall};

/// An object that needs `need_n` (N) and moves with `v` (m/s) under its whole weight.
fn object(need_n: f32, v: f32) -> Expected {
    let need_ln = need_n.ln();
    Expected { v, load: 1.0, most: 1.0, rate: 0.0, per_n: 1.0 / need_n, need_ln }
}

fn best(delay_s: f32, objects: &[(f32, Expected)]) -> f32 {
    let drives = Drives { delay_s, on_way_n: 1.0, from_n: 1.0, most_n: 40.0 };
    let mut losses = Losses::new(drives);
    for (w, object) in objects {
        losses.add(*w, object);
    }
    losses.best_n()
}

#[test]
fn what_is_known_is_held_with_a_margin_and_a_fall_is_braked_harder() {
    let slow = best(0.005, &[(1.0, object(4.0, 0.01))]);
    let late = best(0.04, &[(1.0, object(4.0, 0.3))]);
    assert!((1.05..1.5).contains(&(slow / 4.0)), "{slow}");
    assert!(late > 1.05 * slow && late < 2.2 * 4.0, "{late} {slow}");
}

#[test]
fn what_is_hardly_known_is_answered_with_what_crushes_nothing() {
    let light = best(0.005, &[(0.3, object(1.5, 0.005)), (0.7, object(8.0, 0.005))]);
    assert!(light < 2.2 * 1.5, "{light}");
    // The same where it falls through the dead time of the drive: more, since there is no later.
    let late = best(0.04, &[(0.3, object(1.5, 0.2)), (0.7, object(8.0, 0.2))]);
    assert!(late > light, "{late} {light}");
}

#[test]
fn a_pull_on_an_object_is_no_reason_to_let_it_go() {
    // It bears twice its weight: the same force over what it bears.
    let pulled = Expected { load: 2.0, most: 2.0, ..object(4.0, 0.05) };
    let heavy = best(0.005, &[(1.0, object(8.0, 0.05))]);
    let pulled = best(0.005, &[(1.0, pulled)]);
    assert!((pulled / heavy - 1.0).abs() < 0.25, "{pulled} {heavy}");
}

#[test]
fn the_best_of_a_fine_grid_is_no_better() {
    // A slow reference in double precision: the stated loss at a thousand forces.
    let objects = [(0.4, object(2.0, 0.02)), (0.6, object(5.0, 0.03))];
    let delay_s = 0.01;
    let loss = |force_n: f64| {
        let of = |(w, object): &(f32, Expected)| {
            let (need_n, g) = (1.0 / f64::from(object.per_n), 9.806_65);
            let (v, delay_s) = (f64::from(object.v), f64::from(delay_s));
            let arrives = (v + g * (1.0 - 1.0 / need_n) * delay_s).max(0.0);
            let comes_m = 0.5 * (v + arrives) * delay_s;
            let (over, next_s) = (force_n / need_n - 1.0, 0.7 * delay_s);
            let stops_m = if over > 0.02 { arrives.powi(2) / (2.0 * g * over) } else { 1e9 };
            let left = (arrives - g * over * next_s).max(0.0);
            let again_m = 0.5 * (arrives + left) * next_s + left * left / (2.0 * g * 0.8);
            let s = comes_m + stops_m.min(again_m);
            let c = (1.0 + (s / 0.01).powi(4)).ln();
            let crush = (force_n / need_n / 2.3).powi(16);
            let much = ((force_n / need_n).ln() - 0.2).max(0.0);
            let fall = c / (1.0 + c / 2.0);
            f64::from(*w)
                * (fall + crush / (1.0 + crush) + 0.15 * s / (s + 1e-3) + 0.5 * much * much)
        };
        objects.iter().map(of).sum::<f64>()
    };
    let found = f64::from(best(delay_s, &objects));
    let least =
        (0..1000).map(|k| loss(0.9 * (f64::from(k) * 0.004).exp())).fold(f64::MAX, f64::min);
    assert!(loss(found) < least + 0.004, "{found}: {} for {least}", loss(found));
}

#[test]
fn a_fall_costs_the_more_the_further_and_no_more_than_twice_a_crushed_object() {
    assert!(fall(0.0) == 0.0 && fall(FALLS_M) > 0.4 && fall(10.0) < 2.0);
    assert!(fall(0.02) > fall(0.01));
    let none = best(0.01, &[]);
    assert!(none.is_finite() && none > 0.0, "{none}");
}
