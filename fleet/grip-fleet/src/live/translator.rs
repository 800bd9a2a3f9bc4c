//! Translator of messages of a daemon to (topic, log time, bytes of the message).

use super::time::{Clocks, Source};
use super::{Topic, Wanted, convert};
use grip_link::message::daemon::{Notice, NoticeKind, Rows, SlipReport, ToClient};
use grip_record::mcap::{EventRecord, LinkRecord, Record, SampleRecord};
use serde_json::{Value, json};

/// Takes what a message becomes: its topic, its log time (ns since 1970), and its bytes.
pub type Out<'a> = dyn FnMut(Topic, u64, &[u8]) + 'a;

/// Translates what one daemon reports, over all its starts.
///
/// A message bears the wall time of what it reports: host times count from WELCOME, device times go through the offset that HEALTH reports
/// the clocks (before it the end of a frame, before that the arrival). Of one topic they never go back, and never lie ahead of now.
#[derive(Debug, Default)]
pub struct Translator {
    wanted: Wanted,
    clocks: Clocks,
    /// The last slip that was reported: QUERY reports the last ones again.
    last_slip: u32,
    last_ns: [u64; Topic::ALL.len()],
    taxels: Vec<f32>,
    message: Vec<u8>,
}

impl Translator {
    /// Only these topics are reported from now on.
    pub const fn want(&mut self, wanted: Wanted) {
        self.wanted = wanted;
    }

    /// Takes a message that came at `now_ns` (since 1970, of a clock that never goes back).
    pub fn take(&mut self, message: &ToClient<'_>, now_ns: u64, out: &mut Out<'_>) {
        match message {
            ToClient::Welcome(welcome) => {
                if self.clocks.greeted(welcome.run_id, welcome.host_us, now_ns) {
                    self.last_slip = 0;
                    self.link("daemon", &convert::daemon(welcome), now_ns, now_ns, out);
                }
            }
            ToClient::Gripper(gripper) => {
                self.clocks.meets(gripper);
                self.link("gripper", &convert::gripper(gripper), now_ns, now_ns, out);
            }
            ToClient::Rows(rows) => self.rows(rows, now_ns, out),
            ToClient::State(state) => {
                let offset_us = state.host.0.cast_signed().wrapping_sub(state.t.0.cast_signed());
                self.clocks.learn(offset_us, Source::Frame);
                let at_ns = self.clocks.host_ns(state.host.0, now_ns);
                self.record(&Record::State(*state), at_ns, now_ns, out);
            }
            ToClient::Slip(slip) => self.slip(slip, now_ns, out),
            ToClient::Health(health) => {
                if let Some(clock) = health.appended.and_then(|appended| appended.clock) {
                    self.clocks.learn(clock.offset_us, Source::Clocks);
                }
                let at_ns = self.clocks.host_ns(health.host_us, now_ns);
                let record = convert::health(health);
                self.report(Topic::Health, at_ns, now_ns, out, |ns, to| record.encode(ns, to));
            }
            ToClient::Notice(notice) => self.notice(notice, now_ns, out),
            ToClient::Setup(_) | ToClient::Estimates(_) | ToClient::Ack(_) | ToClient::Nack(_) => {}
        }
    }

    /// The connection to the daemon has ended.
    pub fn lost(&mut self, reason: &str, now_ns: u64, out: &mut Out<'_>) {
        self.link("daemon_lost", &json!({ "reason": reason }), now_ns, now_ns, out);
    }

    fn rows(&mut self, rows: &Rows<'_>, now_ns: u64, out: &mut Out<'_>) {
        if let Some(last) = rows.iter().last() {
            self.clocks.came(last.t_us, now_ns);
        }
        let mut taxels = core::mem::take(&mut self.taxels);
        for row in rows.iter() {
            taxels.clear();
            taxels.extend((0..usize::from(rows.header.taxels)).filter_map(|k| row.taxel(k)));
            let sample = grip_session::status::sample(&row);
            let record = SampleRecord { index: row.index, sample, taxels: &taxels };
            let at_ns = self.clocks.device_ns(row.t_us, now_ns);
            self.record(&Record::Sample(record), at_ns, now_ns, out);
        }
        self.taxels = taxels;
    }

    fn slip(&mut self, slip: &SlipReport, now_ns: u64, out: &mut Out<'_>) {
        if slip.number > self.last_slip && self.wanted.has(Topic::Event) {
            self.last_slip = slip.number;
            let at_ns = self.clocks.host_ns(slip.host.0, now_ns);
            self.record(&Record::Event(EventRecord::of_slip(slip)), at_ns, now_ns, out);
        }
    }

    fn notice(&mut self, notice: &Notice<'_>, now_ns: u64, out: &mut Out<'_>) {
        let at_ns = self.clocks.host_ns(notice.host_us, now_ns);
        if notice.kind == NoticeKind::Sensor {
            self.record(&Record::Event(convert::sensor(notice)), at_ns, now_ns, out);
        } else {
            self.link(notice.kind.name(), &convert::notice(notice), at_ns, now_ns, out);
        }
    }

    fn link(&mut self, kind: &str, detail: &Value, at_ns: u64, now_ns: u64, out: &mut Out<'_>) {
        if self.wanted.has(Topic::Link) {
            self.record(
                &Record::Link(LinkRecord { kind, detail: &detail.to_string() }),
                at_ns,
                now_ns,
                out,
            );
        }
    }

    fn record(&mut self, record: &Record<'_>, at_ns: u64, now_ns: u64, out: &mut Out<'_>) {
        let topic = Topic::ALL.into_iter().find(|topic| topic.recorded() == Some(record.topic()));
        if let Some(topic) = topic {
            self.report(topic, at_ns, now_ns, out, |ns, to| record.encode(ns, to));
        }
    }

    /// Reports one message of (what it reports, now), where somebody looks.
    fn report(
        &mut self,
        topic: Topic,
        at_ns: u64,
        now_ns: u64,
        out: &mut Out<'_>,
        encode: impl FnOnce(u64, &mut Vec<u8>),
    ) {
        if !self.wanted.has(topic) {
            return;
        }
        let last_ns = &mut self.last_ns[topic.index()];
        *last_ns = at_ns.min(now_ns).max(*last_ns);
        self.message.clear();
        encode(*last_ns, &mut self.message);
        out(topic, *last_ns, &self.message);
    }
}
