//! A daemon without a gripper, and clients of it, in one thread: time is counted, nothing waits for long.

use core::time::Duration;
use grip_daemon::client::Client;
use grip_daemon::clients::{About, Clients, ClientsConfig, Listen};
use grip_daemon::{Item, LinkNote};
use grip_link::host::LinkState;
use grip_link::message::Versions;
use grip_link::message::daemon::{
    Estimates, Goodbye, NoticeKind, RealTime, RowSet, Subscribe, ToClient, Topics,
};
use slip_core::PipelineState;
use slip_core::{Sample, grip::GripState, health::SensorHealth, sample::Scene, units::Micros};

/// Turns of the daemon after which a test has hung.
pub(crate) const PATIENCE: u32 = 20_000;

pub(crate) struct Rig {
    pub(crate) clients: Clients,
    pub(crate) now_us: u64,
    pub(crate) index: u32,
}

pub(crate) fn about() -> About {
    About {
        name: "gripd test".into(),
        run_id: 99,
        dry_run: false,
        records: true,
        real_time: RealTime::Partly,
    }
}

pub(crate) fn tcp() -> ClientsConfig {
    ClientsConfig { listen: "tcp:127.0.0.1:0".parse().unwrap(), ..ClientsConfig::default() }
}

impl Rig {
    pub(crate) fn new(config: ClientsConfig) -> Self {
        let clients = Clients::listen(config, about()).unwrap();
        Self { clients, now_us: 1_000, index: 0 }
    }

    pub(crate) fn place(&self) -> Listen {
        self.clients.place().unwrap()
    }

    /// One turn of the service thread, a millisecond later.
    pub(crate) fn turn(&mut self) {
        self.now_us += 1_000;
        self.clients.poll(self.now_us, Duration::from_millis(1)).unwrap();
    }

    pub(crate) fn connect(&self, nonce: u16, wanted: Subscribe) -> Viewer {
        let patience = Duration::from_secs(10);
        let client = Client::connect(&self.place(), nonce, wanted, patience).unwrap();
        Viewer { client, seen: Seen::default() }
    }

    /// A viewer that has its WELCOME.
    pub(crate) fn viewer(&mut self, nonce: u16, wanted: Subscribe) -> Viewer {
        let mut viewer = self.connect(nonce, wanted);
        self.until(&mut viewer, |seen| seen.welcomes > 0);
        viewer
    }

    /// Turns until the viewer has seen what it waits for.
    pub(crate) fn until(&mut self, viewer: &mut Viewer, done: impl Fn(&Seen) -> bool) {
        for _ in 0..PATIENCE {
            if done(&viewer.seen) {
                return;
            }
            self.turn();
            viewer.look();
        }
        panic!("it never came: {:?}", viewer.seen);
    }

    /// Samples for everybody who wants them.
    pub(crate) fn samples(&mut self, count: u32) {
        for _ in 0..count {
            let t = Micros(u64::from(self.index) * 100);
            let sample = Sample { normal_force_n: Some(2.0), ..Sample::stylus(t, 1e-6) };
            let (host_us, index) = (self.now_us, self.index);
            self.index += 1;
            self.clients.take(&Item::Sample { host_us, index, sample: &sample, taxels: &[] });
        }
    }

    pub(crate) fn state(&mut self) {
        let state = state();
        self.clients.take(&Item::State(&PipelineState { host: Micros(self.now_us), ..state }));
    }

    pub(crate) fn link(&mut self, note: &LinkNote) {
        self.clients.take(&Item::Link { host_us: self.now_us, note });
    }

    pub(crate) fn updates(&mut self) {
        self.link(&LinkNote::State(LinkState::Stream));
    }
}

pub(crate) fn state() -> PipelineState {
    PipelineState {
        t: Micros(77),
        scene: Scene::Holding,
        grip: GripState::Holding,
        sensors: [SensorHealth::Good, SensorHealth::Good, SensorHealth::Good, SensorHealth::Lost],
        statistic: Some(0.25),
        applied_n: Some(3.5),
        lost: 5,
        rate_hz: 10_000,
        ..PipelineState::UNKNOWN
    }
}

pub(crate) const fn wanted(topics: Topics, every_nth: u16) -> Subscribe {
    Subscribe { versions: Versions::OURS, topics, every_nth, state_ms: 0 }
}

/// What came.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    pub(crate) welcomes: u32,
    pub(crate) token: u32,
    pub(crate) rows: Vec<u32>,
    pub(crate) row_frames: u32,
    pub(crate) states: u32,
    pub(crate) slips: Vec<u32>,
    pub(crate) grippers: u32,
    pub(crate) healths: u32,
    pub(crate) dropped: u32,
    pub(crate) acks: Vec<u16>,
    pub(crate) nacks: Vec<(u16, String)>,
    pub(crate) setups: Vec<[u8; 32]>,
    pub(crate) estimates: Vec<Estimates>,
    pub(crate) goodbye: Option<Goodbye>,
    pub(crate) texts: Vec<String>,
    pub(crate) closed: bool,
}

impl Seen {
    fn take(&mut self, message: &ToClient<'_>) {
        match message {
            ToClient::Welcome(welcome) => {
                assert_eq!(welcome.daemon(), "gripd test");
                self.welcomes += 1;
                self.token = welcome.token;
            }
            ToClient::Rows(rows) => {
                self.row_frames += 1;
                for row in rows.iter() {
                    assert_eq!(row.t_us, u64::from(row.index) * 100);
                    assert_eq!(row.value(RowSet::NORMAL_FORCE), Some(2.0));
                    self.rows.push(row.index);
                }
            }
            ToClient::State(known) => {
                // What is not known stays so on its way.
                let of =
                    |state: &PipelineState| (state.late_ms, state.need_n, state.admissible_m_s2);
                assert_eq!(of(known), of(&state()));
                self.states += 1;
            }
            ToClient::Slip(slip) => self.slips.push(slip.number),
            ToClient::Gripper(_) => self.grippers += 1,
            ToClient::Health(_) => self.healths += 1,
            ToClient::Notice(notice) => {
                match notice.kind {
                    NoticeKind::Dropped => self.dropped += notice.count,
                    NoticeKind::Goodbye => self.goodbye = Some(Goodbye::from_code(notice.code)),
                    _ => {}
                }
                self.texts.push(notice.as_str().to_owned());
            }
            ToClient::Estimates(estimates) => self.estimates.push(*estimates),
            ToClient::Setup(setup) => self.setups.push(setup.in_force),
            ToClient::Ack(ack) => self.acks.push(ack.seq),
            ToClient::Nack(nack) => self.nacks.push((nack.seq, format!("{:?}", nack.reason))),
        }
    }
}

/// A client that notes what it sees.
pub(crate) struct Viewer {
    pub(crate) client: Client,
    pub(crate) seen: Seen,
}

impl Viewer {
    /// Reads what is there.
    pub(crate) fn look(&mut self) {
        while !self.seen.closed {
            let seen = &mut self.seen;
            match self.client.wait(Duration::ZERO, &mut |message| seen.take(message)) {
                Ok(true) => {}
                Ok(false) => break,
                Err(_) => self.seen.closed = true,
            }
        }
    }
}
