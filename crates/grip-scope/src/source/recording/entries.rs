//! Conversion of what an MCAP recording holds to items for the model.

use crate::feed::{EventKind, EventMark, Feed, ObserverSettings, StylusInfo};
use crate::source::stream::Stream;

use grip_session::HostEstimator;
use grip_session::model::{default_estimator, parse_estimator};
use grip_session::recording::{MODEL_NAME, UNRECORDED, beginning};

use grip_link::message::Unit;
use grip_record::mcap::{Entry, LinkRecord, PipelineRecord, Record, SampleRecord};
use slip_core::{Signal, units::Micros};

/// What was read and not passed on yet.
#[derive(Default)]
pub(super) struct Entries {
    pub(super) stream: Stream,
    model: Option<HostEstimator>,
}

impl Entries {
    /// Takes one entry.
    pub(super) fn take_entry(&mut self, entry: &Entry<'_>) {
        match entry {
            Entry::Message { record, .. } => self.record(record),
            Entry::Attachment { name, data, .. } if name == MODEL_NAME => {
                match parse_estimator(MODEL_NAME, &String::from_utf8_lossy(data)) {
                    Ok(model) => self.model = Some(model),
                    Err(error) => self.stream.update(Feed::Notice(error.to_string())),
                }
            }
            Entry::Attachment { .. } | Entry::Metadata { .. } => {}
        }
    }

    fn record(&mut self, record: &Record<'_>) {
        match record {
            Record::Sample(row) => self.sample(row),
            Record::State(state) => self.stream.update(Feed::State(*state)),
            Record::Event(event) => {
                // What sensors do is seen in the states.
                event.slip().into_iter().for_each(|slip| self.stream.mark(EventMark::slip(&slip)));
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
        self.stream.number(row.index, 1);
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
                return self.stream.update(none);
            }
        };
        let unit = match begun.config.signal {
            Signal::Displacement => Unit::Metre,
            Signal::Vibration => Unit::None,
        };
        self.stream.update(Feed::Stylus(StylusInfo::one(unit)));
        let interval_s = begun.config.detector.interval_s;
        self.stream.update(Feed::Observes(ObserverSettings::Source { interval_s }));
        let model = self.model.clone().map_or_else(default_estimator, Ok);
        let none = self.stream.observe(begun.config, model);
        none.into_iter().for_each(|none| self.stream.update(none));
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
                self.stream.update(Feed::Notice(text));
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
        let t_s = self.stream.last_us().map_or(f64::NAN, |last_us| Micros(last_us).as_seconds());
        self.stream.mark(EventMark::plain(t_s, kind, text));
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
        assert!(entries.stream.take().contains(&settings));
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
                .stream
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
