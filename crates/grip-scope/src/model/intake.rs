//! Intake of the items of a source into the model.

use super::axis::Placed;
use super::events::Doing;
use super::series::Series;
use super::timeline::{Room, TaxelFrame};
use super::{MOST_NOTICES, Model};
use crate::channel::Channel;
use crate::feed::{
    DerivedBlock, DerivedValue, EventKind, EventMark, Feed, RowBlock, StylusInfo, TaxelBlock, Turn,
};
use crate::span::Span;
use grip_link::device::{Fate, Truth};
use grip_link::message::{
    FaultCode,
    daemon::{GripState, Scene, SensorHealth},
};
use slip_core::{PipelineState, units::Micros};
use std::collections::BTreeMap;

/// Peaks and valleys kept.
const TURNS: Room = Room::Items(500_000);
/// Frames of the pressure array kept.
const FRAMES: Room = Room::Bytes(16 << 20);
/// Frames closer together than this (s) are not all kept: nobody sees them.
const FRAME_S: f64 = 0.01;

impl Model {
    /// Takes one item.
    pub fn take(&mut self, feed: Feed) {
        self.revision += 1;
        match feed {
            Feed::Status(status) => {
                self.revision -= u64::from(status == self.status);
                if matches!(status, crate::SourceStatus::Complete { .. }) {
                    self.series.values_mut().for_each(Series::forget_preview);
                }
                self.status = status;
            }
            Feed::Welcome(info) => self.info.daemon = Some(info),
            Feed::Restart => self.restart(),
            Feed::Rows(block) => self.take_rows(&block),
            Feed::Preview(block) => self.take_preview(&block),
            Feed::State(state) => self.take_state(state),
            Feed::Truth(truth) => self.truth = Some(truth),
            Feed::Observes(settings) => self.info.observer = Some(settings),
            Feed::Derived(block) => self.take_derived(*block),
            Feed::Event(mark) => {
                let t_s = self.axis.event(mark.t_s);
                self.events.push(EventMark { t_s, ..mark });
            }
            Feed::Health(point) => self.health.latest = Some(point),
            Feed::Stylus(info) => self.info.stylus = Some(info),
            Feed::Gripper(info) => {
                // Before a pipeline begins nothing is known of it.
                if info.rate_hz > 0 {
                    self.info.stylus = Some(StylusInfo::one(info.stylus));
                }
                self.info.gripper = Some(info);
            }
            Feed::Notice(line) if self.notices.back() == Some(&line) => {}
            Feed::Notice(line) => {
                self.notices.push_back(line);
                if self.notices.len() > MOST_NOTICES {
                    self.notices.pop_front();
                }
            }
            Feed::Study(study) => self.study = Some(*study),
            Feed::Extent { from_s, to_s, file } => {
                self.info.recording = Some((file, Span::new(from_s, to_s)));
            }
        }
        self.shed();
    }

    fn restart(&mut self) {
        self.restarted = true;
        self.afresh = true;
        self.events.interrupt();
    }

    fn take_rows(&mut self, block: &RowBlock) {
        let (was_s, leaps) = (self.axis.end_s(), self.axis.leaps());
        let row_s = self.axis.row_s();
        let times = self.place_rows(block, row_s.is_some());
        let first_s = times.iter().flatten().next().map(|(at_s, _)| *at_s);
        // A leap of the device's time is reported as such.
        let joined = leaps == self.axis.leaps();
        if let Some(first_s) = first_s.filter(|_| block.broken && row_s.is_some() && joined) {
            self.report_gap(Span::new(was_s, first_s), block.lost);
        }
        for (channel, values) in &block.columns {
            let series = entry(&mut self.series, *channel);
            // What the rows before did not have begins anew.
            let mut begins = row_s.is_some_and(|row_s| series.is_before(row_s));
            for (time, value) in times.iter().zip(values) {
                if let Some((at_s, broken)) = time {
                    series.push(*at_s, *value, *broken || core::mem::take(&mut begins));
                }
            }
        }
        if let Some(taxels) = &block.taxels {
            for (row, time) in times.iter().enumerate() {
                if let Some((at_s, _)) = time {
                    self.take_frame(*at_s, taxels, row);
                }
            }
        }
        self.events.reach(self.axis.end_s());
        let rows = self.series.values().filter(|series| series.channel().is_row());
        // Other channels may lack readings: they are NaN there.
        self.health.nan = self.series.get(&Channel::Stylus).map_or(0, |series| series.nan);
        self.health.misplaced = self.series.values().map(|series| series.misplaced).sum();
        self.health.huge = rows.map(|series| series.huge).sum();
    }

    /// Takes the frame of the array of row `row`.
    fn take_frame(&mut self, t_s: f64, block: &TaxelBlock, row: usize) {
        let near = |last: &TaxelFrame| t_s - last.t_s < FRAME_S;
        if self.taxels.iter().next_back().is_some_and(near) {
            return;
        }
        let from = row * block.count;
        let values = block.values.get(from..from + block.count).unwrap_or_default();
        if values.iter().any(|value| !value.is_nan()) {
            self.taxels.append(TaxelFrame { t_s, values: values.to_vec() }, FRAMES);
        }
    }

    /// Where the rows of a block go, and which of them do not join the one before; `known`: whether there is one before the first.
    fn place_rows(&mut self, block: &RowBlock, known: bool) -> Vec<Option<(f64, bool)>> {
        let mut times = Vec::with_capacity(block.times_us.len());
        let mut broken = core::mem::take(&mut self.restarted) || block.broken;
        for time_us in &block.times_us {
            let placed = self.place_row(*time_us);
            let joined = |(at_s, leapt)| (at_s, leapt || core::mem::take(&mut broken));
            let placed = placed.map(joined);
            if let Some((at_s, true)) = placed.filter(|_| known) {
                self.gaps.push(at_s);
            }
            times.push(placed);
        }
        // Where no row of the block can be shown, the next one that can does not join either.
        self.restarted = broken;
        times
    }

    /// Where a row goes, and whether the device's time leapt before it.
    fn place_row(&mut self, time_us: u64) -> Option<(f64, bool)> {
        let device_s = Micros(time_us).as_seconds();
        match self.axis.row(device_s) {
            Placed::At(at_s) => Some((at_s, false)),
            Placed::Late => {
                self.health.late_rows += 1;
                None
            }
            Placed::Leapt { at_s, before_s } => {
                self.events.interrupt();
                self.afresh = true;
                let text = format!(
                    "the device's time went from {before_s:.3} s to {device_s:.3} s: shown here from {at_s:.3} s on"
                );
                self.events.push(EventMark::plain(at_s, EventKind::Clock, text));
                Some((at_s, true))
            }
        }
    }

    fn report_gap(&mut self, span: Span, lost: u32) {
        let text = match lost {
            0 => format!("samples are missing for {:.1} ms", 1e3 * span.length_s()),
            1 => "1 row is missing".to_owned(),
            _ => format!("{lost} rows are missing, {:.1} ms", 1e3 * span.length_s()),
        };
        self.events.gap(span);
        self.events.push(EventMark::plain(span.from_s, EventKind::Gap, text));
    }

    fn take_preview(&mut self, block: &RowBlock) {
        if !self.axis.is_plain() {
            return;
        }
        for (channel, values) in &block.columns {
            let series = entry(&mut self.series, *channel);
            let mut broken = block.broken;
            for (time_us, value) in block.times_us.iter().zip(values) {
                series.push_preview(
                    Micros(*time_us).as_seconds(),
                    *value,
                    core::mem::take(&mut broken),
                );
            }
        }
    }

    fn take_state(&mut self, state: PipelineState) {
        let before = self.info.state.replace(state);
        let truth = self.truth.take();
        let Some(t_s) = self.axis.state(state.t.as_seconds()) else {
            self.health.stray_states += 1;
            return;
        };
        let restarted = core::mem::take(&mut self.afresh);
        let from_s = if restarted { f64::INFINITY } else { self.gaps.before(t_s) };
        for mark in changes(before.filter(|_| !restarted).as_ref(), &state, t_s) {
            self.events.push(mark);
        }
        // A quiet sensor alone says nothing of an object.
        let grips = state.command_n.is_some()
            || state.applied_n.is_some()
            || self.series(Channel::NormalForce).is_some();
        self.events.state(t_s, doing(&state, truth, grips), !restarted);
        let limit_n = self.info.gripper.and_then(|gripper| gripper.force_max_n);
        let values = [
            (Channel::Statistic, state.statistic.map(|times| times * self.info.interval_s())),
            (Channel::Command, state.command_n),
            (Channel::Applied, state.applied_n),
            (Channel::Estimate, state.estimate_n),
            (Channel::Need, state.need_n),
            (Channel::NeedLow, state.need_low_n),
            (Channel::NeedHigh, state.need_high_n),
            (Channel::NeedTruth, truth.map(|truth| truth.needed_n)),
            (Channel::ForceLimit, limit_n),
            (Channel::Esc, state.esc),
            (Channel::EscFlags, state.esc.map(|_| f32::from(state.esc_flags))),
        ];
        for (channel, value) in values {
            self.put(channel, t_s, value, from_s);
        }
    }

    fn take_derived(&mut self, block: DerivedBlock) {
        let first = block.values.first().filter(|_| block.broken);
        if let Some(t_s) = first.and_then(|first| self.axis.state(first.t_s)) {
            self.gaps.derive_from(t_s);
        }
        for DerivedValue { t_s, channel, value } in block.values {
            if let Some(t_s) = self.axis.state(t_s) {
                self.put(channel, t_s, value, self.gaps.derived_before(t_s));
            }
        }
        for turn in block.turns {
            self.turns.insert(Turn { t_s: self.axis.event(turn.t_s), ..turn }, TURNS);
        }
        let room = Room::Bytes(self.limit_bytes / 16);
        for mut column in block.spectra.into_iter().filter(|column| !column.bins.is_empty()) {
            column.span = column.span.map(|t_s| self.axis.event(t_s));
            self.spectrogram.insert(column, room);
        }
    }

    /// Puts a value, or that there is none where there was one before; it does not join one before `from_s`.
    fn put(&mut self, channel: Channel, t_s: f64, value: Option<f32>, from_s: f64) {
        if value.is_some() || self.series.contains_key(&channel) {
            let series = entry(&mut self.series, channel);
            series.push(t_s, value.unwrap_or(f32::NAN), series.is_before(from_s));
        }
    }
}

/// What happens to the object: what a simulator knows, else what the pipeline thinks.
fn doing(state: &PipelineState, truth: Option<Truth>, grips: bool) -> Doing {
    match (truth.and_then(|truth| truth.fate), state.scene) {
        (Some(Fate::Crushed), _) => Doing::Crushed,
        (Some(Fate::Dropped), _) => Doing::Dropped,
        (Some(Fate::Slipping), _) | (None, Scene::Slipping) => Doing::Slipping,
        (Some(Fate::Held), _) => Doing::Held,
        (None, Scene::Holding) if grips => Doing::Held,
        (None, Scene::Moving) => Doing::Moving,
        (None, _) => Doing::Idle,
    }
}

/// What a state shows that the one before it did not: sensors that fail and recover, faults, and the answer to a slip.
fn changes(before: Option<&PipelineState>, now: &PipelineState, t_s: f64) -> Vec<EventMark> {
    let mut marks = Vec::new();
    let well = |health| matches!(health, SensorHealth::Good | SensorHealth::Absent);
    let sensors = before.map_or([SensorHealth::Good; 4], |before| before.sensors);
    for ((name, was), is) in SENSORS.iter().zip(sensors).zip(now.sensors) {
        if was != is && !well(is) {
            let text = format!("{name}: {}", is.name());
            marks.push(EventMark::plain(t_s, EventKind::Fault, text));
        }
    }
    let fault = before.map_or(FaultCode::NONE, |before| before.fault);
    if now.fault != fault && now.fault.is_fault() {
        let text = format!("the gripper has stopped with fault {:04x}", now.fault.0);
        marks.push(EventMark::plain(t_s, EventKind::Fault, text));
    }
    let ailed = !sensors.into_iter().all(well) || fault.is_fault();
    if ailed && now.sensors.into_iter().all(well) && now.fault == FaultCode::NONE {
        marks.push(EventMark::plain(t_s, EventKind::Recovered, "sensors and gripper are well"));
    }
    let answers = |state: &PipelineState| state.grip == GripState::Slipping;
    if answers(now) && before.is_some_and(|before| !answers(before)) {
        let force = |state: &PipelineState| state.command_n.unwrap_or(f32::NAN);
        let from_n = before.map_or(f32::NAN, force);
        let text = format!("force raised from {from_n:.2} N to {:.2} N", force(now));
        marks.push(EventMark::plain(t_s, EventKind::Reflex, text));
    }
    marks
}

/// Names of the sensors, in the order of [`PipelineState::sensors`].
const SENSORS: [&str; 4] = ["stylus", "travel", "pressure", "reference"];

fn entry(series: &mut BTreeMap<Channel, Series>, channel: Channel) -> &mut Series {
    series.entry(channel).or_insert_with(|| Series::new(channel))
}
