//! Rest in which something happened in, the part of it that is as quiet as most of it out.

use super::{RestMeter, Vector};
use slip_core::{ConfigError, PipelineConfig, detector::BANDS};

/// A motion is there before the reference shows it, and rings on after: rest this near to it (s) is none.
const EDGE_S: f64 = 0.05;
/// Length of the blocks whose energy is compared (s).
const BLOCK_S: f64 = 0.1;
/// Longer than a knock (s).
const KNOCK_S: f64 = 0.25;
/// A block with more than this times the median energy of a band is loud. Blocks of the narrowest band have some 5
/// degrees of freedom, of which one in a thousand is louder by chance.
const LOUD: f32 = 4.0;

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 5000")]
fn samples_in(config: &PipelineConfig, seconds: f64) -> usize {
    (seconds * f64::from(config.sample_rate.0)).ceil() as usize
}

/// `rest` without what is next to motion.
pub(super) fn without_edges(
    config: &PipelineConfig,
    rest: &[(Vector, bool)],
) -> Vec<(Vector, bool)> {
    let edge = samples_in(config, EDGE_S);
    let mut out = rest.to_vec();
    let mut since = edge;
    for (place, &(_, rests)) in out.iter_mut().zip(rest) {
        since = if rests { since + 1 } else { 0 };
        place.1 &= since > edge;
    }
    let mut until = edge;
    for (place, &(_, rests)) in out.iter_mut().zip(rest).rev() {
        until = if rests { until + 1 } else { 0 };
        place.1 &= until > edge;
    }
    out
}

/// Which samples of `rest` lie in a block that is loud in any band.
pub(super) fn loud(
    config: &PipelineConfig,
    rest: &[(Vector, bool)],
) -> Result<Vec<bool>, ConfigError> {
    let length = samples_in(config, BLOCK_S);
    let mut blocks: Vec<([f32; BANDS], core::ops::Range<usize>)> = Vec::new();
    let mut meter = RestMeter::new(&config.detector, config.sample_rate.0)?;
    let mut start = 0;
    for stretch in rest.chunk_by(|a, b| a.1 == b.1) {
        let range = start..start + stretch.len();
        start = range.end;
        if !stretch.first().is_some_and(|(_, rests)| *rests) {
            continue;
        }
        meter.start();
        for (nth, block) in stretch.chunks(length).enumerate() {
            block.iter().for_each(|(value, _)| meter.push_vector(*value));
            let from = range.start + nth * length;
            blocks.extend(meter.take().map(|energy| (energy, from..from + block.len())));
        }
    }
    let median: [f32; BANDS] = core::array::from_fn(|band| {
        let mut energies: Vec<f32> = blocks.iter().map(|(energy, _)| energy[band]).collect();
        energies.sort_by(f32::total_cmp);
        energies.get(energies.len() / 2).copied().unwrap_or(f32::INFINITY)
    });
    let mut out = vec![false; rest.len()];
    for (energy, range) in blocks {
        if energy.iter().zip(&median).any(|(energy, median)| *energy > LOUD * median) {
            out.get_mut(range).into_iter().flatten().for_each(|place| *place = true);
        }
    }
    Ok(out)
}

/// Whether something loud that is longer than a knock begins or ends in motion, so that how much of it lies there is not known.
pub(super) fn goes_on(config: &PipelineConfig, rest: &[(Vector, bool)], loud: &[bool]) -> bool {
    let least = samples_in(config, KNOCK_S);
    let mut start = 0;
    rest.chunk_by(|a, b| a.1 == b.1).any(|stretch| {
        let range = start..start + stretch.len();
        start = range.end;
        let (begins, ends) = (range.start > 0, range.end < rest.len());
        let part = loud.get(range).unwrap_or(&[]);
        // Where all is motion nothing is loud.
        let leading = part.iter().take_while(|loud| **loud).count();
        let trailing = part.iter().rev().take_while(|loud| **loud).count();
        (begins && leading >= least) || (ends && trailing >= least)
    })
}
