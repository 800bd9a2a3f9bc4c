//! What an MCAP recording holds in, items for the model out.

use crate::feed::{EventKind, EventMark, Feed, Level, NoticeLine, ObserverSettings, StylusInfo};
use crate::source::stream::Stream;

use grip_session::HostEstimator;
use grip_session::model::{default_estimator, parse_estimator};
use grip_session::recording::{MODEL_NAME, UNRECORDED, beginning};

use grip_link::message::Unit;
use grip_record::mcap::{Entry, LinkRecord, PipelineRecord, Record, SampleRecord};
use slip_core::{Signal, units::Micros};

/// Rows of a block.
const BLOCK: usize = 2048;
/// Device time of a block (us): states are placed by the rows around them.
const BLOCK_US: u64 = 500_000;

/// What was read and not passed on yet.
#[derive(Default)]
pub(super) struct Entries {
    stream: Stream,
    updates: Vec<Feed>,
    done: Vec<Feed>,
    model: Option<HostEstimator>,
    next_index: Option<u32>,
    first_us: Option<u64>,
    last_us: u64,
}

impl Entries {
    /// Takes one entry.
    pub(super) fn take_entry(&mut self, entry: &Entry<'_>) {
        match entry {
            Entry::Message { record, .. } => self.record(record),
            Entry::Attachment { name, data, .. } if name == MODEL_NAME => {
                match parse_estimator(MODEL_NAME, &String::from_utf8_lossy(data)) {
                    Ok(model) => self.model = Some(model),
                    Err(error) => self.note(Level::Warning, error.to_string()),
                }
            }
            Entry::Attachment { .. } | Entry::Metadata { .. } => {}
        }
    }

    fn record(&mut self, record: &Record<'_>) {
        match record {
            Record::Sample(row) => self.sample(row),
            Record::State(state) => self.updates.push(Feed::State(*state)),
            Record::Event(event) => {
                // What sensors do is seen in the states.
                self.updates.extend(event.slip().map(|slip| Feed::Event(EventMark::slip(&slip))));
            }
            Record::Client(command) => {
                self.mark(EventKind::Client, format!("a client asks: {command}"))
            }
            Record::Link(link) => self.link(link),
            Record::Pipeline(pipeline) => self.begin(pipeline),
            Record::Command(_) | Record::Wire(_) => {}
        }
    }

    fn sample(&mut self, row: &SampleRecord<'_>) {
        let time_us = row.sample.t.0;
        // Another start of the gripper, or a long gap: states and events before it belong to the rows before it.
        let afar = |first_us| time_us <= self.last_us || time_us - first_us >= BLOCK_US;
        if self.first_us.is_some_and(afar) {
            self.flush();
        }
        if let Some(expected) = self.next_index.filter(|next| *next != row.index) {
            let ahead = row.index.wrapping_sub(expected);
            self.stream.broken(if ahead < 1 << 31 { ahead } else { 0 });
        }
        self.next_index = Some(row.index.wrapping_add(1));
        self.first_us.get_or_insert(time_us);
        self.last_us = time_us;
        self.stream.push(&row.sample, row.taxels);
    }

    /// A pipeline begins: the observer takes its settings.
    fn begin(&mut self, record: &PipelineRecord<'_>) {
        let begun = match beginning(record) {
            Ok(begun) => begun,
            Err(error) => {
                let why =
                    format!("the settings of the pipeline are those of another version ({error})");
                let none = self.stream.spectra_only(record.rate_hz, &why);
                return self.updates.push(none);
            }
        };
        let unit = match begun.config.signal {
            Signal::Displacement => Unit::Metre,
            Signal::Vibration => Unit::None,
        };
        self.updates.push(Feed::Stylus(StylusInfo::one(unit)));
        let interval_s = begun.config.detector.interval_s;
        self.updates.push(Feed::Observes(ObserverSettings::Source { interval_s }));
        let model = self.model.clone().map_or_else(default_estimator, Ok);
        self.updates.extend(self.stream.observe(begun.config, model));
        let rate_hz = record.rate_hz;
        let how = if record.continued { "goes on from the file before" } else { "begins" };
        self.mark(EventKind::Reload, format!("a pipeline {how}, {rate_hz:.0} Hz"));
    }

    fn link(&mut self, link: &LinkRecord<'_>) {
        match link.kind {
            UNRECORDED => {
                self.stream.broken(0);
                let text = format!("items were not recorded here: {}", link.detail);
                self.mark(EventKind::Gap, text.clone());
                self.note(Level::Warning, text);
            }
            "identified" | "rebooted" | "other_gripper" | "closed" | "port_lost" => {
                let text = format!("{} {}", link.kind.replace('_', " "), link.detail);
                self.mark(EventKind::Link, text);
            }
            _ => {}
        }
    }

    /// A part of the recording cannot be read: what comes next does not join.
    pub(super) fn damaged(&mut self, at_byte: u64) {
        self.stream.broken(0);
        let text = format!("the recording is damaged at byte {at_byte}: passed over");
        self.mark(EventKind::Gap, text);
    }

    fn mark(&mut self, kind: EventKind, text: String) {
        let t_s = self.first_us.map_or(f64::NAN, |_| Micros(self.last_us).as_seconds());
        self.updates.push(Feed::Event(EventMark::plain(t_s, kind, text)));
    }

    fn note(&mut self, level: Level, text: String) {
        self.updates.push(Feed::Notice(NoticeLine { level, text }));
    }

    /// Whether what waits makes a block.
    pub(super) fn is_due(&self) -> bool {
        let since_us = self.first_us.map_or(0, |first_us| self.last_us.saturating_sub(first_us));
        self.stream.len() >= BLOCK || since_us >= BLOCK_US || self.updates.len() >= BLOCK
    }

    /// Rows first: states and events are placed by the rows around them.
    fn flush(&mut self) {
        self.done.extend(self.stream.take());
        self.done.append(&mut self.updates);
        self.first_us = None;
    }

    /// What waits, in order.
    pub(super) fn take(&mut self) -> Vec<Feed> {
        self.flush();
        core::mem::take(&mut self.done)
    }
}

#[cfg(test)]
mod tests {
    use super::Entries;
    use crate::feed::{Feed, ObserverSettings};
    use grip_record::mcap::{Record, SampleRecord};
    use grip_session::{recording::pipeline_record, session::Beginning};
    use slip_core::units::{Hertz, Micros};
    use slip_core::{ClientCommand, PipelineConfig, Sample};

    #[test]
    fn the_interval_is_the_one_of_the_recording() {
        let mut config = PipelineConfig::gripping(Hertz(10_000.0));
        config.detector.interval_s = 60.0;
        let (carried_n, released, mut json) = (None, true, Vec::new());
        let begun = Beginning { config, carried_n, least_n: 0.1, released, taxels: 0 };
        let mut entries = Entries::default();
        entries.record(&Record::Pipeline(pipeline_record(&begun, &mut json).unwrap()));
        let settings = Feed::Observes(ObserverSettings::Source { interval_s: 60.0 });
        assert!(entries.take().contains(&settings));
    }

    #[test]
    fn what_happened_before_a_long_gap_or_another_start_is_reported_before_the_rows_behind_it() {
        for next_us in [5_000_000, 3] {
            let mut entries = Entries::default();
            for (index, time_us) in [(0, 5), (1, next_us)] {
                let sample = Sample::stylus(Micros(time_us), 1e-6);
                entries.record(&Record::Sample(SampleRecord { index, sample, taxels: &[] }));
                entries.record(&Record::Client(ClientCommand::Release));
            }
            let kinds: Vec<&str> = entries
                .take()
                .iter()
                .map(|feed| match feed {
                    Feed::Rows(_) => "rows",
                    Feed::Event(_) => "event",
                    _ => "other",
                })
                .collect();
            assert_eq!(kinds, ["rows", "event", "rows", "event"], "{next_us} us");
        }
    }
}
