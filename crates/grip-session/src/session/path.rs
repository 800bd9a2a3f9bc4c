//! Path of a frame's rows through the pipeline, one step at a time; with what clients set and what the gripper reports of its own motion.

use super::{Session, Update};
use crate::report::Event;
use grip_link::{
    clock::{ClockRelation, ClockSync},
    message::{ChannelKind, DeviceState, MAX_ELEMENTS, Row, SamplesHeader, Status, StatusFlags},
};
use slip_core::{Arrival, ClientCommand, Pipeline, Sample, Step, grip::GripState, units::Micros};

/// The frame whose rows go through the pipeline, and what the last of them led to.
#[derive(Debug)]
pub(super) struct Path {
    /// The frame, while rows of it are left, and the number of the next one.
    frame: Option<SamplesHeader>,
    next: u8,
    /// The relation of the clocks at that frame, where it is known.
    clock: Option<ClockRelation>,
    /// The last row: its number on the device, its sample, its taxels, as many as there are, and what it led to.
    pub(super) index: u32,
    pub(super) sample: Sample,
    taxels: ([f32; MAX_ELEMENTS as usize], usize),
    pub(super) step: Option<Step>,
    /// Events of that step, and how many of them were returned.
    events: [Option<Event>; Event::MOST],
    events_returned: usize,
    /// Whether the step is still to be returned.
    waits: bool,
}

impl Default for Path {
    fn default() -> Self {
        Self {
            frame: None,
            next: 0,
            clock: None,
            index: 0,
            sample: Sample::default(),
            taxels: ([f32::NAN; MAX_ELEMENTS as usize], 0),
            step: None,
            events: [None; Event::MOST],
            events_returned: Event::MOST,
            waits: false,
        }
    }
}

impl Path {
    /// Rows that were not handled, and what was not returned, are gone with the line.
    pub(super) fn forget_frame(&mut self) {
        (self.frame, self.events_returned, self.waits) = (None, Event::MOST, false);
    }

    /// Whether the last row led to something that was not returned yet.
    #[inline]
    pub(super) fn has_updates(&self) -> bool {
        self.waits
    }

    /// What the last row led to and was not returned yet: its events, then its step.
    #[inline]
    pub(super) fn updates(&mut self) -> Option<Update<'_>> {
        while let Some(event) = self.events.get(self.events_returned) {
            self.events_returned += 1;
            if let Some(event) = *event {
                return Some(Update::Event(event));
            }
        }
        if !core::mem::take(&mut self.waits) {
            return None;
        }
        let taxels = self.taxels.0.get(..self.taxels.1).unwrap_or(&[]);
        Some(Update::Step {
            index: self.index,
            sample: &self.sample,
            taxels,
            step: self.step.as_ref()?,
        })
    }
}

impl Session {
    /// A frame of rows is there.
    pub(super) fn begin_frame(&mut self, now_us: u64, header: SamplesHeader) {
        if self.pipeline.is_none() {
            return;
        }
        self.time.frame(now_us);
        self.path.clock = self.link.clock().and_then(ClockSync::relation);
        (self.path.frame, self.path.next) = (Some(header), 0);
        self.due.fresh = true;
    }

    /// Handles the next row of the frame; `false` where there is none.
    pub(super) fn handle_row(&mut self, now_us: u64) -> bool {
        let Self { path, pipeline: Some(pipeline), link, time, freshness, .. } = self else {
            return false;
        };
        let Some(header) = path.frame else { return false };
        let samples = link.samples(header).filter(|_| path.next < header.rows);
        let Some(row) = samples.and_then(|samples| samples.row(path.next)) else {
            path.frame = None;
            return false;
        };
        path.next = path.next.saturating_add(1);
        let motion = self.motion.now(pipeline.grip_state());
        // A row that is not usable has the time of the last one, which the pipeline counts and ignores.
        let t = time.row(row.index, row.tick).t;
        // When the row was taken in, and how old it was; 0 where its clock is not related to the host's.
        let clock = path.clock.filter(|_| time.follows_ticks());
        let taken_us = clock.and_then(|clock| clock.host_us(row.tick)).unwrap_or(now_us);
        let arrival =
            Some(Arrival { at: Micros(now_us), age: Micros(now_us.saturating_sub(taken_us)) });
        freshness.arrive(arrival, t);
        if clock.is_none() {
            freshness.forget();
        }
        path.index = row.index;
        path.sample = Sample { motion, arrival, ..sample_of(&row, t) };
        let taxels = taxels_of(&row, &mut path.taxels.0);
        path.taxels.1 = taxels.len();
        let step = path.step.insert(pipeline.handle_with(&path.sample, taxels));
        self.counters.samples += 1;
        if self.log.follows(step) {
            (path.events, path.events_returned) = (self.log.events(step), 0);
        }
        if self.steady.step(step, pipeline.detector()) {
            self.steady_at = Some(step.t);
        }
        path.waits = true;
        true
    }

    /// Device time at which an alarm has been found to be steady, as that of a machine is; once an alarm.
    pub fn take_steady(&mut self) -> Option<Micros> {
        self.steady_at.take()
    }
}

/// The sample of a row; `NaN` in an optional channel means that there is no reading. The link carries one axis of a stylus.
fn sample_of(row: &Row<'_>, t: Micros) -> Sample {
    let mut sample = Sample { t, ..Sample::default() };
    // The first column of a kind counts: it comes last.
    for column in row.columns().iter().rev() {
        let reading = row.value(column, 0).filter(|value| !value.is_nan());
        match column.kind {
            ChannelKind::Stylus => sample.stylus = reading.unwrap_or(f32::NAN),
            ChannelKind::NormalForce => sample.normal_force_n = reading,
            ChannelKind::TangentialForce => sample.tangential_n = reading,
            ChannelKind::Travel => sample.travel_m = reading,
            ChannelKind::Velocity => sample.velocity_m_s = reading,
            ChannelKind::SecondStylus => sample.second_stylus = reading,
            ChannelKind::Reference => sample.reference = reading,
            ChannelKind::Pressure => sample.pressure = reading,
            _ => {}
        }
    }
    sample
}

/// The frame of the taxel array in a row; empty where there is none, or where no taxel has a reading.
fn taxels_of<'a>(row: &Row<'_>, frame: &'a mut [f32]) -> &'a [f32] {
    let taxels = row.read_all(ChannelKind::PressureArray, frame);
    if taxels.iter().all(|value| value.is_nan()) { &[] } else { taxels }
}

// Client set points.

/// A stop is sent this often until the gripper reports that it has stopped (us).
const STOP_EVERY_US: u64 = 20_000;

/// What was asked for and still stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ClientSetpoints {
    least_n: f32,
    released: bool,
    stop_at_us: Option<u64>,
}

impl ClientSetpoints {
    /// Carries out and remembers what concerns the controller; `false` where it cannot.
    pub(super) fn apply<W: AsRef<[f32]>>(
        &mut self,
        command: ClientCommand,
        pipeline: &mut Pipeline<W>,
    ) -> bool {
        let done = pipeline.obey(command);
        match command {
            ClientCommand::AtLeast(force_n) if done => self.least_n = force_n,
            ClientCommand::Release => self.released = true,
            ClientCommand::Grasp => self.released = false,
            _ => {}
        }
        done
    }

    /// A stop also takes back what was asked for.
    pub(super) fn stop(&mut self, now_us: u64) {
        self.least_n = 0.0;
        self.stop_at_us = Some(now_us);
    }

    /// Whether the stop is to be sent now.
    pub(super) fn stop_due(&mut self, now_us: u64) -> bool {
        let due = self.stop_at_us.is_some_and(|at_us| now_us >= at_us);
        if due {
            self.stop_at_us = Some(now_us + STOP_EVERY_US);
        }
        due
    }

    /// The gripper has reported its state.
    pub(super) fn receive(&mut self, state: DeviceState) {
        if state == DeviceState::Estop {
            self.stop_at_us = None;
        }
    }

    pub(super) fn least_n(&self) -> f32 {
        self.least_n
    }

    pub(super) fn released(&self) -> bool {
        self.released
    }
}

/// What is known of the gripper's own motion between two STATUS.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct OwnMotion {
    reported: Option<bool>,
    /// Commands are sent, so that the controller's state is what the fingers do.
    commands: bool,
}

impl OwnMotion {
    /// Nothing reported yet; `commands` states whether the controller's commands reach the gripper.
    pub(super) fn new(commands: bool) -> Self {
        Self { reported: None, commands }
    }

    /// Takes a STATUS.
    pub(super) fn receive(&mut self, status: &Status) {
        let reported = status.flags.has(StatusFlags::MOTION);
        self.reported = reported.then(|| status.flags.has(StatusFlags::MOVING));
    }

    /// The gripper has started anew: what it said before does not count.
    pub(super) fn forget(&mut self) {
        self.reported = None;
    }

    /// The `motion` of a sample taken while the controller is in `state`: 1 while the gripper reports that it moves and while it is
    /// commanded to close, 0 where it reports that it stands still, `None` where nothing is known. The answer to a slip presses harder and is
    /// no motion.
    pub(super) fn now(&self, state: Option<GripState>) -> Option<f32> {
        let closing = self.commands && state == Some(GripState::Closing);
        match self.reported {
            _ if closing => Some(1.0),
            Some(moving) => Some(f32::from(u8::from(moving))),
            None => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::OwnMotion;
    use grip_link::message::{DeviceState, FaultCode, ForceClamp, Status, StatusFlags};
    use slip_core::grip::GripState;

    fn status(flags: StatusFlags) -> Status {
        Status {
            last_cmd_id: 0,
            state: DeviceState::Armed,
            clamp: ForceClamp(0),
            fault: FaultCode::NONE,
            applied_mn: 0,
            target_mn: 0,
            age_us: 0,
            flags,
            rejected: 0,
        }
    }

    #[test]
    fn a_gripper_that_reports_is_believed_and_silence_is_not_stillness() {
        let mut motion = OwnMotion::new(true);
        motion.receive(&status(StatusFlags::SAMPLING));
        assert_eq!(motion.now(Some(GripState::Holding)), None);
        motion.receive(&status(StatusFlags::MOTION));
        assert_eq!(motion.now(Some(GripState::Slipping)), Some(0.0));
        motion.receive(&status(StatusFlags::MOTION.with(StatusFlags::MOVING, true)));
        assert_eq!(motion.now(Some(GripState::Holding)), Some(1.0));
        motion.forget();
        assert_eq!(motion.now(None), None);
    }

    #[test]
    fn closing_is_motion_where_commands_are_sent() {
        assert_eq!(OwnMotion::new(true).now(Some(GripState::Closing)), Some(1.0));
        assert_eq!(OwnMotion::new(false).now(Some(GripState::Closing)), None);
    }
}
