//! Grippers that press hard from touch on, since they cannot do less.

extern crate std;

use super::{DT_S, calm, holding, slipping};
use crate::{
    grip::{GripConfig, GripController, GripInput, GripState, SlipNow},
    need::Felt,
};
use std::{collections::VecDeque, vec};

const LEAST_N: f32 = 20.0;

/// Closes while the fingers are still on their way; the force comes behind a lag of 15 ms from touch on.
fn grasped() -> GripController {
    let config = GripConfig {
        trial_force_n: LEAST_N,
        least_force_n: LEAST_N,
        close_rate_n_s: 333.0,
        ..GripConfig::default()
    };
    let mut grip = GripController::new(config);
    grip.grasp(None);
    for _ in 0..100 {
        grip.step(&GripInput { touching: false, applied_n: Some(0.0), ..calm() });
    }
    let mut applied_n = 0.0;
    for _ in 0..300 {
        applied_n += (LEAST_N - applied_n) / 15.0;
        grip.step(&GripInput { applied_n: Some(applied_n), ..calm() });
    }
    assert_eq!((grip.state(), grip.command_n()), (GripState::Holding, LEAST_N));
    grip
}

fn pressed(input: GripInput) -> GripInput {
    GripInput { applied_n: Some(LEAST_N), travel: input.moved_m.is_some(), ..input }
}

/// The object moves by `most_m` in 30 ms and stands again; the highest command meanwhile.
fn moves(grip: &mut GripController, most_m: f32) -> f32 {
    let mut highest_n = 0.0_f32;
    for i in 0..30_u8 {
        let moved_m = most_m * f32::from(i) / 29.0;
        highest_n = highest_n.max(grip.step(&pressed(slipping(moved_m, None))));
    }
    for _ in 0..1000 {
        grip.step(&pressed(GripInput { travel: true, ..calm() }));
    }
    highest_n
}

#[test]
fn the_way_to_the_object_is_no_delay_of_the_force() {
    let lag_s = grasped().drive().delay_s();
    assert!((0.03..0.04).contains(&lag_s), "{lag_s}");
}

#[test]
fn pads_that_shear_as_the_load_comes_are_no_slip() {
    let mut grip = grasped();
    let highest_n = moves(&mut grip, 8e-5);
    assert!((24.0..32.0).contains(&highest_n), "{highest_n}");
    assert_eq!((grip.command_n(), grip.trials().trials), (LEAST_N, 1));
    let slid_n = moves(&mut grip, 3e-4);
    assert!(slid_n >= 25.0 && grip.command_n() >= 25.0, "{slid_n} {}", grip.command_n());
}

/// An object that needs a little more stops within what pads shear, and slips again as the force falls.
#[test]
fn what_moves_again_and_again_is_believed() {
    let mut grip = grasped();
    for _ in 0..3 {
        moves(&mut grip, 6e-5);
        assert_eq!(grip.command_n(), LEAST_N);
    }
    moves(&mut grip, 6e-5);
    assert!(grip.command_n() >= 25.0, "{}", grip.command_n());
}

#[test]
fn the_stylus_alone_needs_peaks_that_pass() {
    for (turns, raised) in [(2.0, false), (8.0, true)] {
        let mut grip = grasped();
        let felt = Felt {
            moves: true,
            from_n: LEAST_N,
            first: 1.4,
            since_s: 0.003,
            low_n: 30.0,
            median_n: 40.0,
            vibrates: true,
            turns,
            ..Felt::default()
        };
        let alone = GripInput { slip: SlipNow::Evident, felt: Some(felt), ..calm() };
        for _ in 0..20 {
            grip.step(&pressed(alone));
        }
        assert_eq!(grip.command_n() > 35.0, raised, "{turns} {}", grip.command_n());
        let stopped = Felt { moves: false, held_n: Some(25.0), ..felt };
        for _ in 0..10 {
            grip.step(&pressed(GripInput { felt: Some(stopped), ..alone }));
        }
        for _ in 0..1000 {
            grip.step(&pressed(calm()));
        }
        assert_eq!(grip.command_n() > LEAST_N, raised, "{turns} {}", grip.command_n());
    }
}

/// A slip that only shows, without how far: what an object needs that slips under what `grip` holds it with, with a force that comes `dead_ms` after
/// its command and behind a lag, over a line on which samples and commands come `line_ms` later than when the fingers closed; the highest force
/// over what it needs, and how far it slid (m).
fn stopped(
    mut grip: GripController,
    [dead_ms, lag_ms, line_ms]: [u16; 3],
    need: f32,
) -> (f32, f32) {
    let held_n = grip.command_n();
    let needed_n = need * held_n;
    let mut commands = VecDeque::from(vec![held_n; usize::from(dead_ms + line_ms)]);
    let mut samples = VecDeque::from(vec![(SlipNow::No, held_n); usize::from(line_ms)]);
    let late_s = 1e-3 * f32::from(line_ms);
    let (mut force_n, mut peak_n, mut speed_m_s, mut slid_m, mut seen) =
        (held_n, 0.0_f32, 0.0_f32, 0.0, 0);
    for ms in 0..1000_u16 {
        let load = (f32::from(ms) / 300.0).min(1.0);
        let pull_m_s2 = 9.81 * (load - force_n / needed_n);
        if speed_m_s > 0.0 || pull_m_s2 > 0.5 {
            speed_m_s = (speed_m_s + pull_m_s2 * DT_S).max(0.0);
            slid_m += speed_m_s * DT_S;
        }
        seen = if speed_m_s > 0.0 { 6 } else { seen.max(1) - 1 };
        samples.push_back((if seen > 0 { SlipNow::Evident } else { SlipNow::No }, force_n));
        let (slip, applied_n) = samples.pop_front().unwrap_or((SlipNow::No, held_n));
        let applied_n = Some(applied_n);
        commands.push_back(grip.step(&GripInput { slip, applied_n, age_s: late_s, ..calm() }));
        let lag_ms = f32::from(lag_ms);
        force_n += (commands.pop_front().unwrap_or(held_n) - force_n) / lag_ms;
        peak_n = peak_n.max(force_n);
    }
    assert!(speed_m_s == 0.0, "{needed_n} N, {dead_ms} ms late: it falls");
    (peak_n / needed_n, slid_m)
}

/// What is on its way when the object stops is not asked for again and again.
#[test]
fn a_force_that_comes_late_does_not_grow_to_the_largest_before_it_is_felt() {
    for dead_ms in [1, 10, 20] {
        for need in [1.1, 1.3, 1.6, 2.2] {
            let (peak, slid_m) = stopped(grasped(), [dead_ms, 16, 0], need);
            assert!(peak < 2.5 && slid_m < 2e-3, "{need}, {dead_ms} ms late: {peak}, {slid_m} m");
        }
    }
}

/// Nor over a line that is later than when the fingers closed, which makes each force later by twice of that.
#[test]
fn a_line_that_becomes_late_does_not_let_it_grow_either() {
    for line_ms in [10, 20] {
        for need in [1.1, 1.3, 1.6, 2.2, 4.0] {
            let (peak, slid_m) = stopped(holding(), [1, 3, line_ms], need);
            assert!(peak < 3.2 && slid_m < 3e-3, "{need}, {line_ms} ms late: {peak}, {slid_m} m");
        }
    }
}
