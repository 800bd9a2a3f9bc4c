//! A host, a virtual gripper and a line that a test may disturb, a millisecond a turn, all in simulated time.

use grip_link::decoder::{Decoder, Role, Verdict};
use grip_link::frame::{Direction, Header, MAX_WIRE, encode};
use grip_link::host::{CloseReason, GripCommand, HostConfig, HostEvent, HostLink};
use grip_link::message::{
    Config, DeviceState, Event, EventKind, Grip, Kind, LossAction, SampleFormat, Status,
};
use grip_sim::{Scene, VirtualMcu};
use slip_core::units::Micros;

pub(crate) const SESSION: u16 = 0xBEEF;

/// 1 kHz, 10 N at 200 N/s, 8 N held, 50 ms of life, hold after 1 s.
pub(crate) fn config() -> Config {
    Config {
        sample_rate_hz: 1_000,
        batch: 2,
        format: SampleFormat::F32,
        ttl_ms: 50,
        channel_mask: u32::MAX,
        force_max_mn: 10_000,
        slew_mn_s: 200_000,
        hold_cap_mn: 8_000,
        loss_after_ms: 1_000,
        loss_action: LossAction::Hold,
    }
}

/// A light object that stays on its support for a minute: whatever the fingers do, nothing falls.
pub(crate) fn supported() -> Scene {
    scene("mass_kg = 0.02\nlift_at_s = 60.0\n")
}

/// An object that is lifted soon and needs 6.5 N.
pub(crate) fn lifted() -> Scene {
    scene("mass_kg = 0.4\nlift_at_s = 0.2\n")
}

/// The same without a travel sensor: the stylus is all that shows a slip.
pub(crate) fn without_travel() -> Scene {
    scene("mass_kg = 0.4\nlift_at_s = 0.2\n[channels]\ntravel = false\n")
}

fn scene(object: &str) -> Scene {
    let text = format!(
        "name = \"t\"\nfriction = 0.3\nroughness_ra_um = 1.6\nsample_rate_hz = 1000\n{object}"
    );
    Scene::from_toml(&text).unwrap()
}

pub(crate) struct Rig {
    pub(crate) mcu: VirtualMcu,
    pub(crate) host: HostLink,
    pub(crate) now: Micros,
    /// The force that the host's controller asks for every millisecond.
    pub(crate) wanted_n: Option<f32>,
    pub(crate) host_runs: bool,
    pub(crate) status: Option<Status>,
    pub(crate) events: Vec<Event>,
    pub(crate) closed: Option<CloseReason>,
    pub(crate) rebooted: bool,
    /// Force asked of the drive after each turn (N).
    pub(crate) forces: Vec<f64>,
}

impl Rig {
    pub(crate) fn new(scene: &Scene, config: Config) -> Self {
        let mut host = HostLink::new(HostConfig::new(config)).unwrap();
        host.open(0, SESSION).unwrap();
        Self {
            mcu: VirtualMcu::new(scene, 7).unwrap(),
            host,
            now: Micros(0),
            wanted_n: None,
            host_runs: true,
            status: None,
            events: Vec::new(),
            closed: None,
            rebooted: false,
            forces: Vec::new(),
        }
    }

    /// A host that has been gripping with `force_n` for 300 ms.
    pub(crate) fn gripping(scene: &Scene, config: Config, force_n: f32) -> Self {
        let mut rig = Self::new(scene, config);
        rig.grip(force_n, 300);
        assert_eq!(rig.mcu.link().state(), DeviceState::Active);
        assert!((rig.force_n() - f64::from(force_n)).abs() < 1e-3, "{}", rig.force_n());
        rig
    }

    pub(crate) fn grip(&mut self, force_n: f32, ms: u32) {
        self.wanted_n = Some(force_n);
        self.run(ms);
    }

    pub(crate) fn run(&mut self, ms: u32) {
        self.run_through(ms, |_, _| {});
    }

    /// Runs; `disturb(to_device, to_host)` may change what is on the line in each millisecond.
    pub(crate) fn run_through(
        &mut self,
        ms: u32,
        mut disturb: impl FnMut(&mut Vec<u8>, &mut Vec<u8>),
    ) {
        for _ in 0..ms {
            self.now = self.now.plus(Micros(1000));
            let mut to_device = self.host_writes();
            let mut to_host = Vec::new();
            self.mcu.advance(self.now);
            self.mcu.transmit(self.now, &mut to_host);
            disturb(&mut to_device, &mut to_host);
            self.mcu.receive(self.now, &to_device);
            if self.host_runs {
                self.host_reads(&to_host);
            }
            self.forces.push(self.force_n());
        }
    }

    fn host_writes(&mut self) -> Vec<u8> {
        let (mut wire, mut out) = (Vec::new(), [0; MAX_WIRE]);
        if !self.host_runs {
            return wire;
        }
        if let Some(command) = self.wanted_n.and_then(GripCommand::newtons)
            && let Some(len) = self.host.grip(self.now.0, &command, &mut out)
        {
            wire.extend_from_slice(&out[..len]);
        }
        while let Some(len) = self.host.poll_transmit(self.now.0, &mut out) {
            wire.extend_from_slice(&out[..len]);
        }
        wire
    }

    fn host_reads(&mut self, mut bytes: &[u8]) {
        while let Some(event) = self.host.receive(self.now.0, &mut bytes) {
            match event {
                HostEvent::Status(status) => self.status = Some(status),
                HostEvent::Event(event) => self.events.push(event),
                HostEvent::Closed(reason) => self.closed = Some(reason),
                HostEvent::Rebooted { .. } => self.rebooted = true,
                _ => {}
            }
        }
    }

    /// Force asked of the drive (N).
    pub(crate) fn force_n(&self) -> f64 {
        self.mcu.commanded_n()
    }

    pub(crate) fn state(&self) -> DeviceState {
        self.mcu.link().state()
    }

    /// Puts a frame on the line that the host did not write.
    pub(crate) fn inject(&mut self, header: &Header, payload: &[u8]) {
        let bytes = wire(header, payload);
        self.mcu.receive(self.now, &bytes);
    }

    /// A GRIP from beside the host, with the next sequence number but one.
    pub(crate) fn inject_grip(&mut self, grip: &Grip) {
        let seq = self.mcu.link().counters().ok.wrapping_add(30_000);
        let seq = u16::try_from(seq % 65_536).unwrap();
        self.inject(&to_device(Kind::GRIP, seq, SESSION), &payload(grip));
    }

    /// Whether the device reported an event of this kind.
    pub(crate) fn reported(&self, kind: EventKind) -> bool {
        self.events.iter().any(|event| event.kind == kind)
    }
}

pub(crate) fn to_device(kind: Kind, seq: u16, session: u16) -> Header {
    Header::new(Direction::ToDevice, kind, seq, session)
}

pub(crate) fn wire(header: &Header, payload: &[u8]) -> Vec<u8> {
    let mut out = [0; MAX_WIRE];
    let len = encode(header, payload, &mut out).unwrap();
    out[..len].to_vec()
}

pub(crate) fn press(cmd_id: u32, force_mn: i32) -> Grip {
    Grip { cmd_id, mode: 1, flags: 0, ttl_ms: 0, force_mn, slew_mn_s: 0, cause_sample: 0 }
}

pub(crate) fn payload(grip: &Grip) -> [u8; Grip::SIZE] {
    let mut bytes = [0; Grip::SIZE];
    grip.write(&mut bytes).unwrap();
    bytes
}

/// The frames of one type among bytes to the device.
pub(crate) fn frames_of(kind: Kind, bytes: &[u8]) -> Vec<Vec<u8>> {
    let blocks = bytes.split(|&byte| byte == 0).filter(|block| !block.is_empty());
    let framed = blocks.map(|block| [&[0], block, &[0]].concat());
    let wanted = |wire: &Vec<u8>| {
        let mut decoder = Decoder::new(Role::Device);
        decoder.open_session(SESSION, None);
        let verdict = decoder.next(&mut wire.as_slice());
        matches!(verdict, Some(Verdict::Frame(frame)) if frame.header.kind == kind)
    };
    framed.filter(wanted).collect()
}
