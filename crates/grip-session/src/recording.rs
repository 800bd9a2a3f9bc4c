//! Conversion of events and beginnings to the records of an MCAP file and back: what daemon and toolbox must agree on.

use crate::{config::THRESHOLDS, report::Event, session::Beginning, tape::TapeError};
use grip_record::{
    Channel, ChannelSet, MOST_HELD, Notes, Recording, Taxels,
    mcap::{Entry, EventRecord, McapReader, PipelineRecord, Record},
};
use slip_core::Sample;
use std::path::Path;

/// Name of the configuration among the attachments, with all layers merged.
pub const CONFIG_NAME: &str = "gripd.toml";
/// Name of the model.
pub const MODEL_NAME: &str = "model.json";
/// Name of the calibration.
pub const CALIBRATION_NAME: &str = "calibration.toml";
/// Title of the metadata that report where a file came from.
pub const ABOUT: &str = "recording";
/// Name in [`ABOUT`] that is the same in all files of one recording.
pub const RUN: &str = "run";
/// Name in [`ABOUT`] that counts these files from 0.
pub const PART: &str = "part";
/// Name in [`ABOUT`] of what was held, where somebody has said so.
pub const OBJECT: &str = "object";
/// Kind of a link record that reports items that were not recorded; its detail has their `items`.
pub const UNRECORDED: &str = "unrecorded";

/// The record of an event; `json` is written over with its line.
///
/// # Errors
/// Never: a line is numbers and names.
pub fn event_record<'a>(
    line: &Event,
    json: &'a mut Vec<u8>,
) -> Result<EventRecord<'a>, serde_json::Error> {
    json.clear();
    serde_json::to_writer(&mut *json, line)?;
    let json = core::str::from_utf8(json).map_err(serde::ser::Error::custom)?;
    let nothing = EventRecord { json, ..EventRecord::default() };
    Ok(match *line {
        Event::Slip(slip) => EventRecord { json, ..EventRecord::of_slip(&slip) },
        Event::Grip { t, event, command_n } => {
            let (t_s, phase) = (t.as_seconds(), event.name());
            let command_n = command_n.unwrap_or(f32::NAN);
            EventRecord { t_s, kind: "grip", phase, command_n, ..nothing }
        }
        Event::Health { t, condition } => {
            let (channel, health) = (condition.channel(), condition.name());
            EventRecord { t_s: t.as_seconds(), kind: "health", channel, health, ..nothing }
        }
    })
}

/// The record of a pipeline that begins; `json` is written over with its settings.
///
/// # Errors
/// Never, for settings that a pipeline accepts.
pub fn pipeline_record<'a>(
    beginning: &Beginning,
    json: &'a mut Vec<u8>,
) -> Result<PipelineRecord<'a>, serde_json::Error> {
    let Beginning { config, carried_n, least_n, released, taxels } = beginning;
    json.clear();
    serde_json::to_writer(&mut *json, config)?;
    let text = core::str::from_utf8(json).map_err(serde::ser::Error::custom)?;
    Ok(PipelineRecord {
        continued: false,
        carried_n: *carried_n,
        least_n: *least_n,
        released: *released,
        taxels: u32::try_from(*taxels).unwrap_or(u32::MAX),
        rate_hz: config.sample_rate.0,
        grips: config.grip.is_some(),
        config: text,
    })
}

/// What a recorded pipeline began with. Thresholds of an older version are left out: its samples are what counts.
///
/// # Errors
/// Where its settings are not those of this version.
pub fn beginning(record: &PipelineRecord<'_>) -> Result<Beginning, serde_json::Error> {
    let mut config: serde_json::Value = serde_json::from_str(record.config)?;
    if let Some(detector) = config.get_mut("detector") {
        leave_out(detector);
    }
    Ok(Beginning {
        config: serde_json::from_value(config)?,
        carried_n: record.carried_n,
        least_n: record.least_n,
        released: record.released,
        taxels: usize::try_from(record.taxels).unwrap_or(usize::MAX),
    })
}

fn leave_out(value: &mut serde_json::Value) {
    match value {
        serde_json::Value::Object(keys) => {
            keys.retain(|key, _| !THRESHOLDS.contains(&key.as_str()));
            keys.values_mut().for_each(leave_out);
        }
        serde_json::Value::Array(values) => values.iter_mut().for_each(leave_out),
        _ => {}
    }
}

/// The samples of an MCAP recording with one pipeline, with the channels that have a reading.
///
/// # Errors
/// Where the file cannot be read to its end, is no recording of this program or of gripd, has no samples, more than one
/// pipeline, or more samples than are held in memory.
pub fn read_mcap(file: &Path) -> Result<Recording, TapeError> {
    let unusable = |what| TapeError::Unusable { file: file.to_owned(), what };
    let mut reader = McapReader::open(file)?.read_ahead()?;
    let mut held: Option<Recording> = None;
    while let Some(entry) = reader.next_entry()? {
        let Entry::Message { record, .. } = entry else { continue };
        match (record, &mut held) {
            (Record::Pipeline(begun), Some(recording)) if !recording.samples.is_empty() => {
                let what = "it has several pipelines; choose one with `gripctl csv --pipeline N`";
                begun.continued.then_some(()).ok_or_else(|| unusable(what))?;
            }
            (Record::Pipeline(begun), _) => {
                let begun = beginning(&begun)
                    .map_err(|source| TapeError::Settings { file: file.to_owned(), source })?;
                held = Some(empty(file, &begun));
            }
            (Record::Sample(record), Some(recording)) => {
                recording.samples.push(record.sample);
                for channel in Channel::ALL {
                    if channel.reading(&record.sample).is_some() {
                        let name = || channel.column().to_owned();
                        recording.channels.optional.entry(channel).or_insert_with(name);
                    }
                }
                let taxels = recording.channels.taxels;
                if let Some(frames) = &mut recording.taxels {
                    frames.push(record.taxels);
                }
                let row = size_of::<Sample>() + taxels * size_of::<f32>();
                if recording.samples.len() > MOST_HELD / row {
                    return Err(unusable("it has more samples than are held in memory"));
                }
            }
            _ => {}
        }
    }
    held.filter(|recording| !recording.samples.is_empty())
        .ok_or_else(|| unusable("it has no samples"))
}

/// A recording of what begins so, without samples.
fn empty(file: &Path, begun: &Beginning) -> Recording {
    Recording {
        name: file.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        channels: ChannelSet::new(begun.stylus()).with_taxels(begun.taxels),
        samples: Vec::new(),
        taxels: Some(Taxels::new(begun.taxels)).filter(|taxels| taxels.count() > 0),
        rate_hz: begun.config.sample_rate.0,
        notes: Notes::default(),
    }
}
#[cfg(test)]
mod tests {
    use super::{beginning, event_record, pipeline_record};
    use crate::{report::Event, session::Beginning};
    use grip_record::mcap::PipelineRecord;
    use slip_core::{
        PipelineConfig, Signal, SlipReport,
        units::{Hertz, Micros},
    };

    #[test]
    fn the_settings_come_back_bit_by_bit() {
        let mut config = PipelineConfig::gripping(Hertz(9_999.95));
        config.known_floor =
            Some([1.0e-13, 1.0 / 3.0, 2.5e-9, f32::MIN_POSITIVE, 7.7e-8, 16_777_215.0]);
        config.detector.interval_s = 600.000_1;
        let mut json = Vec::new();
        let begun = Beginning { config, carried_n: None, least_n: 0.1, released: true, taxels: 0 };
        let record = pipeline_record(&begun, &mut json).unwrap();
        let older = record
            .config
            .replacen("\"low_hz\"", "\"threshold\":25.0,\"low_hz\"", 1)
            .replacen("\"gross\"", "\"tail\":4.0,\"test\":\"fused\",\"gross\"", 1);
        assert_ne!(older, record.config);
        assert_eq!(beginning(&PipelineRecord { config: &older, ..record }).unwrap(), begun);
        for config in [config, PipelineConfig::observing(Signal::Vibration, Hertz(2200.0))] {
            for (carried_n, released) in [(None, true), (Some(7.25), false)] {
                let begun = Beginning { config, carried_n, least_n: 0.1, released, taxels: 16 };
                let record = pipeline_record(&begun, &mut json).unwrap();
                assert_eq!(record.grips, config.grip.is_some());
                assert_eq!(beginning(&record).unwrap(), begun);
            }
        }
    }

    #[test]
    fn an_event_has_its_numbers_and_its_line() {
        let line = Event::Slip(SlipReport {
            t: Micros(1_250_000),
            duration_s: Some(0.5),
            estimate_n: Some(3.5),
            ..SlipReport::UNKNOWN
        });
        let mut json = Vec::new();
        let record = event_record(&line, &mut json).unwrap();
        assert_eq!((record.kind, record.duration_s, record.estimate_n), ("slip_end", 0.5, 3.5));
        assert!(record.speed_m_s.is_nan() && record.phase.is_empty());
        assert_eq!(record.json, serde_json::to_string(&line).unwrap());
    }
}
