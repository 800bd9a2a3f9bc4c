//! A gripper, a host and a line between them, all in simulated time.

use crate::targets::gripper::{CONFIG, SESSION, idle};
use grip_link::cobs::decode_in_place;
use grip_link::device::{DeviceEvent, DeviceLink, Drive};
use grip_link::frame::{Frame, MAX_WIRE};
use grip_link::host::{CloseReason, GripCommand, HostConfig, HostEvent, HostLink, LinkState, Loss};
use grip_link::message::{Kind, Status, StatusFlags};

/// What the host was informed of, without borrowed parts.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Reported {
    State(LinkState),
    Identified(bool),
    Rebooted(u32, u32),
    Configured(u8),
    Rows(Vec<(u32, u64, i16)>, Loss),
    Status(Status),
    Closed(CloseReason),
    Other(String),
}

fn reported(host: &HostLink, event: &HostEvent) -> Reported {
    match event {
        HostEvent::State { to, .. } => Reported::State(*to),
        HostEvent::Identified { rebooted } => Reported::Identified(*rebooted),
        HostEvent::Rebooted { before, now } => Reported::Rebooted(*before, *now),
        HostEvent::Configured { clamped } => Reported::Configured(clamped.0),
        HostEvent::Samples { header, loss } => {
            let samples = host.samples(*header).unwrap();
            let rows =
                samples.rows().map(|row| (row.index, row.tick, row.raw(0).unwrap())).collect();
            Reported::Rows(rows, *loss)
        }
        HostEvent::Status(status) => Reported::Status(*status),
        HostEvent::Closed(reason) => Reported::Closed(*reason),
        other => Reported::Other(format!("{other:?}")),
    }
}

/// Wire bytes of each frame in `bytes`, with its type.
pub(crate) fn frames(bytes: &[u8]) -> Vec<(Kind, Vec<u8>)> {
    let framed = bytes.split(|&byte| byte == 0).filter(|block| !block.is_empty()).map(|block| {
        let mut copy = block.to_vec();
        let kind = Frame::from_body(decode_in_place(&mut copy).unwrap()).unwrap().header.kind;
        (kind, [&[0], block, &[0]].concat())
    });
    framed.collect()
}

/// Removes the frames of one type, at most `most`; how many went.
pub(crate) fn remove(bytes: &mut Vec<u8>, kind: Kind, most: usize) -> usize {
    let mut removed = 0;
    let kept = frames(bytes).into_iter().filter(|(found, _)| {
        let goes = *found == kind && removed < most;
        removed += usize::from(goes);
        !goes
    });
    *bytes = kept.flat_map(|(_, wire)| wire).collect();
    removed
}

/// Host and device on a line, advanced in steps of 100 us.
pub(crate) struct Line {
    pub(crate) host: HostLink,
    pub(crate) device: DeviceLink,
    pub(crate) now_us: u64,
    /// Ticks of the device are host microseconds minus this.
    pub(crate) tick_offset: u64,
    pub(crate) reported: Vec<Reported>,
    pub(crate) device_events: Vec<DeviceEvent>,
    pub(crate) drives: Vec<(u64, Drive)>,
    /// Force the controller asks for every millisecond.
    pub(crate) grip_n: Option<f32>,
    pub(crate) sample_every_us: u64,
    pub(crate) samples_pushed: u32,
    /// Frames the device may write a step.
    pub(crate) device_frames_a_step: usize,
    pub(crate) host_runs: bool,
}

pub(crate) const STEP_US: u64 = 100;

impl Line {
    pub(crate) fn new() -> Self {
        Self::with(HostConfig::new(CONFIG), idle(1))
    }

    pub(crate) fn with(host: HostConfig, device: DeviceLink) -> Self {
        Self {
            host: HostLink::new(host).unwrap(),
            device,
            now_us: 1_000_000,
            tick_offset: 1_000_000,
            reported: Vec::new(),
            device_events: Vec::new(),
            drives: Vec::new(),
            grip_n: None,
            sample_every_us: 200,
            samples_pushed: 0,
            device_frames_a_step: 8,
            host_runs: true,
        }
    }

    /// Linked and sampling for some time.
    pub(crate) fn streaming() -> Self {
        let mut line = Self::new();
        line.open();
        line.run(100_000);
        line
    }

    pub(crate) fn open(&mut self) {
        self.host.open(self.now_us, SESSION).unwrap();
    }

    pub(crate) const fn tick(&self) -> u64 {
        self.now_us - self.tick_offset
    }

    /// Runs without disturbance.
    pub(crate) fn run(&mut self, for_us: u64) {
        self.run_through(for_us, |_, _| {});
    }

    /// Runs; `disturb(to_device, to_host)` may change the bytes of each step.
    pub(crate) fn run_through(
        &mut self,
        for_us: u64,
        mut disturb: impl FnMut(&mut Vec<u8>, &mut Vec<u8>),
    ) {
        let end = self.now_us + for_us;
        while self.now_us < end {
            let mut to_device = self.host_writes();
            let mut to_host = self.device_writes();
            disturb(&mut to_device, &mut to_host);
            let tick = self.tick();
            let mut input = &to_device[..];
            while let Some(event) = self.device.receive(tick, &mut input) {
                self.device_events.push(event);
            }
            self.drives.push((tick, self.device.drive(tick)));
            if self.host_runs {
                let mut input = &to_host[..];
                while let Some(event) = self.host.receive(self.now_us, &mut input) {
                    let reported = reported(&self.host, &event);
                    self.reported.push(reported);
                }
            }
            self.now_us += STEP_US;
        }
    }

    fn host_writes(&mut self) -> Vec<u8> {
        let mut wire = Vec::new();
        let mut out = [0; MAX_WIRE];
        if !self.host_runs {
            return wire;
        }
        if self.now_us.is_multiple_of(1000)
            && let Some(command) = self.grip_n.and_then(GripCommand::newtons)
            && let Some(len) = self.host.grip(self.now_us, &command, &mut out)
        {
            wire.extend_from_slice(&out[..len]);
        }
        while let Some(len) = self.host.poll_transmit(self.now_us, &mut out) {
            wire.extend_from_slice(&out[..len]);
        }
        wire
    }

    fn device_writes(&mut self) -> Vec<u8> {
        let tick = self.tick();
        let mut wire = Vec::new();
        let mut out = [0; MAX_WIRE];
        let sampling = self.device.status(tick).flags.has(StatusFlags::SAMPLING);
        if sampling && tick.is_multiple_of(self.sample_every_us) {
            let stylus = i16::try_from(self.samples_pushed % 20_000).unwrap();
            self.device.push_i16(tick, &[stylus, 500]).unwrap();
            self.samples_pushed += 1;
        }
        for _ in 0..self.device_frames_a_step {
            let Some(len) = self.device.poll_transmit(tick, &mut out) else { break };
            wire.extend_from_slice(&out[..len]);
        }
        wire
    }

    pub(crate) fn states(&self) -> Vec<LinkState> {
        self.reported
            .iter()
            .filter_map(
                |reported| if let Reported::State(to) = reported { Some(*to) } else { None },
            )
            .collect()
    }

    pub(crate) fn last_status(&self) -> Status {
        self.reported
            .iter()
            .rev()
            .find_map(|reported| if let Reported::Status(s) = reported { Some(*s) } else { None })
            .unwrap()
    }

    pub(crate) fn closed(&self) -> Option<CloseReason> {
        self.reported.iter().find_map(|reported| {
            if let Reported::Closed(reason) = reported { Some(*reason) } else { None }
        })
    }

    /// Largest force set since a tick.
    pub(crate) fn most_since(&self, tick: u64) -> i32 {
        self.drives
            .iter()
            .filter(|(at, _)| *at >= tick)
            .map(|(_, drive)| drive.force_mn())
            .max()
            .unwrap()
    }

    pub(crate) fn force_now(&self) -> i32 {
        self.drives.last().unwrap().1.force_mn()
    }
}
