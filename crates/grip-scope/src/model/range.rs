//! What parts of a channel show in, the range that an axis should have out.

use super::series::Bucket;
use grip_record::HUGE_READING;

/// Extremes further from the middle than this many times what nine of ten parts show are left out.
const BEYOND: f32 = 1e5;

/// The least and the greatest value of the parts, impossible ones left out; `None` where nothing is left.
pub(super) fn robust(parts: &[Bucket]) -> Option<(f32, f32)> {
    let possible = |value: &f32| value.abs() < HUGE_READING;
    let mut values: Vec<f32> =
        parts.iter().flat_map(|part| [part.min, part.max]).filter(possible).collect();
    values.sort_by(f32::total_cmp);
    let middle = *values.get(values.len() / 2)?;
    let mut off: Vec<f32> = values.iter().map(|value| (value - middle).abs()).collect();
    off.sort_by(f32::total_cmp);
    let usual = off.get(off.len() * 9 / 10).copied().unwrap_or(0.0);
    let kept = |value: &&f32| usual <= 0.0 || (**value - middle).abs() <= BEYOND * usual;
    let least = values.iter().find(kept)?;
    let greatest = values.iter().rev().find(kept)?;
    Some((*least, *greatest))
}

#[cfg(test)]
mod tests {
    use super::{Bucket, robust};

    fn part(min: f32, max: f32) -> Bucket {
        Bucket { from_s: 0.0, to_s: 1.0, min, max, mean: 0.0, count: 2, broken: false }
    }

    #[test]
    fn a_slip_stays_and_what_no_sensor_sends_goes() {
        let mut parts: Vec<Bucket> = (0..200).map(|_| part(-1e-6, 1e-6)).collect();
        parts.push(part(-1e-6, 2e-3));
        assert_eq!(robust(&parts), Some((-1e-6, 2e-3)));
        parts.push(part(-1e-6, 1e30));
        parts.push(part(-40.0, 1e-6));
        assert_eq!(robust(&parts), Some((-1e-6, 2e-3)));
    }

    #[test]
    fn a_constant_and_nothing_have_a_range_and_none() {
        assert_eq!(robust(&[part(2.0, 2.0)]), Some((2.0, 2.0)));
        assert_eq!(robust(&[part(f32::NAN, f32::NAN)]), None);
        assert_eq!(robust(&[]), None);
    }
}
