//! Rows of a frame in, steps of the pipeline out.

use super::{News, SessionCounters, time_base::TimeBase};
use crate::{motion::OwnMotion, report::EventLog};
use grip_link::{
    clock::ClockRelation,
    message::{ChannelKind, MAX_ELEMENTS, Row, Samples},
};
use slip_core::{Arrival, Pipeline, Sample, Step, units::Micros};
use std::sync::Arc;

/// The part of a session that samples run through.
pub(super) struct Path<'a> {
    pub(super) pipeline: &'a mut Pipeline<Arc<[f32]>>,
    pub(super) log: &'a mut EventLog,
    pub(super) latest: &'a mut Option<Step>,
    pub(super) applied_n: &'a mut Option<f32>,
    pub(super) time: &'a mut TimeBase,
    pub(super) motion: OwnMotion,
    /// Host time at which the frame was complete (us), and the relation of the clocks, where it is known.
    pub(super) now_us: u64,
    pub(super) clock: Option<ClockRelation>,
}

impl Path<'_> {
    /// Handles a batch; gives the number of its last row.
    pub(super) fn batch(
        &mut self,
        samples: &Samples<'_>,
        counters: &mut SessionCounters,
        tell: &mut dyn FnMut(News<'_>),
    ) -> u32 {
        let mut last = 0;
        self.time.frame(self.now_us);
        for row in samples {
            let motion = self.motion.now(self.pipeline.grip_state());
            // A row that is not usable has the time of the last one, which the pipeline counts and ignores.
            let t = self.time.row(row.index, row.tick).t;
            let arrival = Some(self.arrival(row.tick));
            let sample = Sample { motion, arrival, ..sample_of(&row, t) };
            let mut frame = [f32::NAN; MAX_ELEMENTS as usize];
            let taxels = taxels_of(&row, &mut frame);
            let step = self.pipeline.handle_with(&sample, taxels);
            counters.samples += 1;
            for line in self.log.lines(&step).into_iter().flatten() {
                tell(News::Event(line));
            }
            tell(News::Step { index: row.index, sample: &sample, taxels, step: &step });
            *self.latest = Some(step);
            *self.applied_n = sample.normal_force_n;
            last = row.index;
        }
        last
    }

    /// When a row of this device time was taken in, and how old it was; 0 where its clock is not related to the host's.
    fn arrival(&self, tick: u64) -> Arrival {
        let clock = self.clock.filter(|_| self.time.follows_ticks());
        let taken_us = clock.and_then(|clock| clock.host_us(tick)).unwrap_or(self.now_us);
        Arrival { at: Micros(self.now_us), age: Micros(self.now_us.saturating_sub(taken_us)) }
    }
}

/// The sample of a row; `NaN` in an optional channel means that there is no reading.
fn sample_of(row: &Row<'_>, t: Micros) -> Sample {
    let channel = |kind| row.read(kind).filter(|value| !value.is_nan());
    Sample {
        t,
        stylus: row.read(ChannelKind::Stylus).unwrap_or(f32::NAN),
        normal_force_n: channel(ChannelKind::NormalForce),
        tangential_n: channel(ChannelKind::TangentialForce),
        travel_m: channel(ChannelKind::Travel),
        velocity_m_s: channel(ChannelKind::Velocity),
        second_stylus: channel(ChannelKind::SecondStylus),
        reference: channel(ChannelKind::Reference),
        pressure: channel(ChannelKind::Pressure),
        ..Sample::default()
    }
}

/// The frame of the taxel array in a row; empty where there is none, or where no taxel has a reading.
fn taxels_of<'a>(row: &Row<'_>, frame: &'a mut [f32]) -> &'a [f32] {
    let taxels = row.read_all(ChannelKind::PressureArray, frame);
    if taxels.iter().all(|value| value.is_nan()) { &[] } else { taxels }
}
