//! The quiet part of a stillness in which something happened: what is as quiet as its quietest quarter.

use super::{PART_S, PARTS, RestMeter, Vector, measure};
use slip_core::{ConfigError, PipelineConfig, detector::BANDS};

/// A motion is there before the reference shows it, and rings on after: rest this near to it (s) is none.
const EDGE_S: f64 = 0.05;
/// Length of the blocks whose energy is compared (s).
const BLOCK_S: f64 = 0.1;
/// A block with more than this times the energy of quiet parts of a band is loud. Blocks of the narrowest band have
/// some 5 degrees of freedom, of which one in a thousand is louder by chance.
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

/// Energies of the parts of `rest`, of which `samples` are used, each band from low to high (signal unit squared).
pub(super) fn parts(
    config: &PipelineConfig,
    rest: &[(Vector, bool)],
    samples: u64,
) -> Result<[Vec<f32>; BANDS], ConfigError> {
    let length = (samples / PARTS as u64).min(samples_in(config, PART_S) as u64).max(1);
    let mut parts: [Vec<f32>; BANDS] = Default::default();
    measure(config, rest.iter().copied(), |meter| {
        let full = if meter.samples() >= length { meter.take() } else { None };
        parts.iter_mut().zip(full.into_iter().flatten()).for_each(|(part, e)| part.push(e));
    })?;
    parts.iter_mut().for_each(|part| part.sort_by(f32::total_cmp));
    Ok(parts)
}

/// Which samples of `rest` lie in a block that is loud in any band, of which `usual` are the energies (signal unit
/// squared).
pub(super) fn loud(
    config: &PipelineConfig,
    rest: &[(Vector, bool)],
    usual: &[f32; BANDS],
) -> Result<Vec<bool>, ConfigError> {
    let length = samples_in(config, BLOCK_S);
    let mut meter = RestMeter::new(&config.detector, config.sample_rate.0)?;
    let mut out = vec![false; rest.len()];
    let mut start = 0;
    for stretch in rest.chunk_by(|a, b| a.1 == b.1) {
        let mut from = start;
        start += stretch.len();
        if !stretch.first().is_some_and(|(_, rests)| *rests) {
            continue;
        }
        meter.start();
        for block in stretch.chunks(length) {
            block.iter().for_each(|(value, _)| meter.push_vector(*value));
            let energy = meter.take().unwrap_or_default();
            if energy.iter().zip(usual).any(|(energy, usual)| *energy > LOUD * usual) {
                out.iter_mut().skip(from).take(block.len()).for_each(|place| *place = true);
            }
            from += block.len();
        }
    }
    Ok(out)
}
