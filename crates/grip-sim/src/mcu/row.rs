//! One row of a sample, in the channels the host asked for, as i16 or f32.

use super::identity::{Reading, scale};
use crate::scene::SceneConfig;
use grip_link::device::{DeviceLink, RowError};
use grip_link::message::{Config, SampleFormat};
use slip_core::sample::Sample;

/// Most channels of the virtual device.
const MOST: usize = 6;

/// The columns in force.
#[derive(Clone, Debug)]
pub(super) struct RowFormat {
    columns: Vec<(Reading, f32)>,
    format: SampleFormat,
}

impl Default for RowFormat {
    fn default() -> Self {
        Self { columns: Vec::new(), format: SampleFormat::F32 }
    }
}

impl RowFormat {
    /// The channels of `offered` whose bit is set in the mask of `config`.
    pub(super) fn new(offered: &[Reading], config: &Config, scene: &SceneConfig) -> Self {
        let chosen =
            offered.iter().enumerate().filter(|(bit, _)| config.channel_mask & (1 << bit) != 0);
        let columns = chosen.map(|(_, &reading)| (reading, scale(reading, scene))).collect();
        Self { columns, format: config.format }
    }

    /// `sample` without the sensors whose channels were not chosen; the stylus stays.
    pub(super) fn shown(&self, sample: &Sample) -> Sample {
        let has = |reading: Reading| self.columns.iter().any(|(column, _)| *column == reading);
        Sample {
            travel_m: sample.travel_m.filter(|_| has(Reading::Travel)),
            tangential_n: sample.tangential_n.filter(|_| has(Reading::TangentialForce)),
            second_stylus: sample.second_stylus.filter(|_| has(Reading::SecondStylus)),
            ..*sample
        }
    }

    /// Hands the row of `sample` to the link.
    pub(super) fn push(
        &self,
        link: &mut DeviceLink,
        tick: u64,
        sample: &Sample,
    ) -> Result<(), RowError> {
        let used = self.columns.len().min(MOST);
        match self.format {
            SampleFormat::I16 => {
                let mut row = [0; MOST];
                for (slot, &(reading, scale)) in row.iter_mut().zip(&self.columns) {
                    *slot = raw(value(reading, sample), scale);
                }
                link.push_i16(tick, row.get(..used).unwrap_or(&row))
            }
            SampleFormat::F32 => {
                let mut row = [0.0; MOST];
                for (slot, &(reading, _)) in row.iter_mut().zip(&self.columns) {
                    *slot = value(reading, sample);
                }
                link.push_f32(tick, row.get(..used).unwrap_or(&row))
            }
        }
    }
}

/// NaN where there is no reading.
fn value(reading: Reading, sample: &Sample) -> f32 {
    match reading {
        Reading::Stylus => Some(sample.stylus),
        Reading::NormalForce => sample.normal_force_n,
        Reading::Travel => sample.travel_m,
        Reading::Reference => sample.reference,
        Reading::SecondStylus => sample.second_stylus,
        Reading::TangentialForce => sample.tangential_n,
    }
    .unwrap_or(f32::NAN)
}

/// Steps of `scale`, saturating at +-32767; -32768 stands for no reading.
#[expect(
    clippy::cast_possible_truncation,
    reason = "clamped to the range first; NaN is handled before"
)]
fn raw(value: f32, scale: f32) -> i16 {
    if value.is_nan() {
        i16::MIN
    } else {
        (value / scale).round().clamp(-32_767.0, 32_767.0) as i16
    }
}

/// Newtons as whole millinewtons, saturating; 0 for NaN.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a float to integer cast saturates, which is wanted here"
)]
pub(super) fn milli(value: f32) -> i32 {
    (value * 1e3).round() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn raw_values_round_saturate_and_mark_the_missing() {
        assert_eq!(
            [raw(1.0, 0.5), raw(-0.26, 0.5), raw(1e9, 0.5), raw(-1e9, 0.5)],
            [2, -1, 32_767, -32_767]
        );
        assert_eq!(raw(f32::NAN, 0.5), i16::MIN);
    }
}
