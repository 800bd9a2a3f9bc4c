//! Tests of the blocks that are made of travel readings.

extern crate std;
use super::*;
use std::vec::Vec;

const DT_S: f32 = 1e-4;
const BLOCK_S: f32 = 3e-4;

fn begun(sensor: TravelSensor, moved_m: f32) -> Travel {
    let mut travel = Travel::NEW;
    travel.begin(Some(sensor), moved_m, BLOCK_S);
    travel
}

fn fine() -> TravelSensor {
    TravelSensor { rest_m: 1.0, sigma_m: 1e-6, step_m: 0.0, read_s: None, equal: 0 }
}

/// The blocks of these readings, three each.
fn blocks(
    travel: &mut Travel,
    readings: impl IntoIterator<Item = Option<f32>>,
) -> Vec<Option<f32>> {
    let readings: Vec<Option<f32>> = readings.into_iter().collect();
    let block = |three: &[Option<f32>]| {
        three.iter().for_each(|reading| travel.push(*reading, DT_S));
        travel.block().map(|block| block.y)
    };
    readings.chunks(3).map(block).collect()
}

#[test]
fn a_block_is_the_mean_since_the_rest_with_the_variance_of_a_mean() {
    let mut travel = begun(fine(), 0.0);
    for x in [1.0, 1.000_003, 1.000_006] {
        travel.push(Some(x), DT_S);
    }
    let block = travel.block().unwrap();
    assert!((block.y - 3e-6).abs() < 2e-7, "{block:?}");
    let wanted = 1e-12 / 3.0 + LEAST_M * LEAST_M;
    assert!((block.variance / wanted - 1.0).abs() < 1e-3, "{block:?}");
    // Rounding without noise does not average out.
    let mut coarse = begun(TravelSensor { sigma_m: 1e-6, step_m: 2e-5, ..fine() }, 0.0);
    (0..3).for_each(|_| coarse.push(Some(1.0), DT_S));
    let variance = coarse.block().unwrap().variance;
    assert!(variance > 0.99 * 4e-10 / 12.0, "{variance}");
    assert!(travel.is_fine() && !coarse.is_fine());
}

#[test]
fn a_reading_that_is_held_counts_once() {
    let held = TravelSensor { read_s: Some(1e-3), ..fine() };
    let mut travel = begun(held, 0.0);
    let readings = (0..40_u8).map(|i| Some(1.0 + 1e-5 * f32::from(i / 10)));
    let seen = blocks(&mut travel, readings);
    assert_eq!(seen.iter().flatten().count(), 4, "{seen:?}");
    assert!((seen.iter().flatten().last().unwrap() - 3e-5).abs() < 2e-7, "{seen:?}");
    let mut asked = begun(fine(), 0.0);
    let seen = blocks(&mut asked, core::iter::repeat_n(Some(1.0), 30));
    assert_eq!(seen.iter().flatten().count(), 10, "one that is read as often as asked counts");
}

#[test]
fn the_distance_is_positive_the_way_the_object_goes() {
    for (moved_m, way) in [(1e-4, 1.0), (-1e-4, -1.0), (0.0, 1.0), (0.0, -1.0)] {
        let mut travel = begun(fine(), moved_m);
        let seen = blocks(&mut travel, (0..60_u8).map(|i| Some(1.0 + way * 2e-6 * f32::from(i))));
        let last = seen.last().unwrap().unwrap();
        assert!((last - 1.16e-4).abs() < 1e-6, "{moved_m} {way}: {last}");
        assert!(!travel.stands());
    }
}

#[test]
fn a_sensor_that_is_missing_is_not_there_until_it_is_read_again() {
    let mut travel = begun(fine(), 0.0);
    blocks(&mut travel, core::iter::repeat_n(Some(1.0), 9));
    assert!(travel.is_there());
    let seen = blocks(&mut travel, core::iter::repeat_n(None, 18));
    assert!(!travel.is_there() && seen.iter().all(Option::is_none), "{seen:?}");
    blocks(&mut travel, core::iter::repeat_n(Some(1.0), 3));
    assert!(travel.is_there());
    let mut none = Travel::NEW;
    none.begin(None, 0.0, BLOCK_S);
    assert!(!none.is_there());
}

#[test]
fn what_has_moved_stands_after_six_milliseconds_and_its_distance_begins_anew() {
    let mut travel = begun(fine(), 0.0);
    let mut bits = 1_u32;
    let mut noise = || {
        bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        2e-6 * (f32::from(u16::try_from(bits >> 16).unwrap()) / 65_536.0 - 0.5)
    };
    blocks(&mut travel, (0..60_u8).map(|i| Some(1.0 + 1e-5 * f32::from(i) + noise())));
    assert!(!travel.stands());
    blocks(&mut travel, (0..75).map(|_| Some(1.0 + 6e-4 + noise())));
    assert!(travel.stands() && travel.is_fine());
    travel.rest(1.0);
    let seen = blocks(&mut travel, (0..12).map(|_| Some(1.0 + 6e-4 + noise())));
    assert!(seen.iter().flatten().all(|y| y.abs() < 3e-6), "{seen:?}");
    assert!(travel.is_fine(), "the step back to zero is no noise: {} m", travel.sigma_m());
}

#[test]
fn noise_that_comes_later_is_noticed_and_a_slip_is_none() {
    let mut travel = begun(fine(), 0.0);
    let fall = |i: u8| 4.9 * (1e-4 * f32::from(i)).powi(2);
    blocks(&mut travel, (0..180_u8).map(|i| Some(1.0 + fall(i))));
    assert!(travel.is_fine(), "{}", travel.sigma_m());
    let mut noisy = begun(fine(), 0.0);
    blocks(&mut noisy, (0..180_u8).map(|i| Some(1.0 + if i % 6 < 3 { 2e-5 } else { -2e-5 })));
    assert!(noisy.sigma_m() > 1e-5, "{}", noisy.sigma_m());
}
