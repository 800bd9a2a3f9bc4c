//! Connection from gripd to publications on a network of many grippers, on three threads: one keeps events and never waits for a network,
//! one talks to it, one looks after models. gripd serves the first as it serves any client; a network that is gone stops nothing.

use crate::{
    clock::Clock,
    common::{Common, Message, PAUSE, pause},
    curator::{Curator, Places},
    keeper::{Keeper, KeeperEnds},
    lending::{Lending, own_recordings},
    network::{Place, Speaker, SpeakerEnds},
    settings::{Settings, network},
};
use anyhow::Context as _;
use core::{hash::BuildHasher as _, time::Duration};
use grip_daemon::{clients::Stream, log::LogLevel};
use grip_fleet::{Bridge, LastReceived};
use grip_port::nonce;
use std::{
    hash::RandomState,
    io::Write as _,
    sync::mpsc::{self, Receiver},
    thread::{self, JoinHandle},
};

/// Publications on their way to the network; what finds no room is asked for again, or out of date soon.
const ON_THE_WAY: usize = 1024;
/// How long the end may take: a session on a line that is cut takes ten seconds to close.
const END: Duration = Duration::from_millis(1500);

/// The threads, as seen from outside.
#[derive(Debug)]
pub(crate) struct Connection {
    threads: Vec<JoinHandle<()>>,
    /// Their log lines.
    messages: Receiver<Message>,
    common: Common,
}

impl Connection {
    /// Begins to publish what gripd sends at the other end of `stream`; `received` is where it was when it was last received.
    pub(crate) fn start(
        settings: &Settings,
        mut stream: Stream,
        received: Option<LastReceived>,
        clock: Clock,
    ) -> anyhow::Result<Self> {
        let (config, fleet) = (&settings.config, &settings.config.fleet);
        let mut bridge = Bridge::new(nonce(), received);
        stream.set_read_timeout(PAUSE)?;
        // A connection that breaks now is one that is over.
        let _broken = stream.write_all(&bridge.subscribe(fleet.samples_every));
        let shown = toml::to_string(config).context("the configuration cannot be written")?;
        let (sender, messages) = mpsc::channel();
        let common = Common::new(sender);
        let (sender, outgoing) = mpsc::sync_channel(ON_THE_WAY);
        let (order, orders) = mpsc::channel();
        let (answer, answers) = mpsc::channel();
        let places = Places {
            models: fleet.models.clone(),
            keys: config.keys()?,
            recordings: own_recordings(config),
        };
        let (curator, models, desk) = Curator::new(places, common.clone(), clock);
        let ends = KeeperEnds { common: common.clone(), sender, orders, answer, desk, clock };
        let keeper = Keeper::new(bridge, fleet.clone(), run(), ends);
        let lending = Lending::new(config);
        if let Some(trouble) = lending.trouble(config) {
            common.report(LogLevel::Warn, trouble);
        }
        let commands = config.allow_commands && fleet.commands;
        let ends = SpeakerEnds { common: common.clone(), outgoing, order, answers, models };
        let (site, ceiling_n) = (settings.site.clone(), config.grip.ceiling_n());
        let ros_domain = fleet.ros_domain;
        let place = Place { site, shown, commands, ceiling_n, lending, ros_domain, clock };
        let speaker = Speaker::new(network(fleet), place, ends);
        let spawn = |name: &str, body: Box<dyn FnOnce() + Send>| {
            thread::Builder::new().name(name.to_owned()).spawn(body)
        };
        let threads = vec![
            spawn("gripd", Box::new(move || keeper.run(stream)))?,
            spawn("network", Box::new(move || speaker.run()))?,
            spawn("models", Box::new(move || curator.run()))?,
        ];
        Ok(Self { threads, messages, common })
    }

    /// The log lines since the last call.
    pub(crate) fn messages(&self) -> impl Iterator<Item = Message> {
        self.messages.try_iter()
    }

    /// Whether one of them has ended.
    pub(crate) fn is_over(&self) -> bool {
        self.threads.iter().any(JoinHandle::is_finished)
    }

    /// Waits a little for their end: the last log lines, and where gripd was.
    pub(crate) fn finish(self) -> (Vec<Message>, Option<LastReceived>) {
        self.common.end();
        let steps = END.as_millis() / PAUSE.as_millis();
        for _ in 0..steps {
            if self.threads.iter().all(JoinHandle::is_finished) {
                break;
            }
            pause(PAUSE);
        }
        let mut kept = self.common.kept();
        // A session that takes longer to close must not keep the spool from the next connection.
        kept.gripper = None;
        let received = kept.received;
        drop(kept);
        (self.messages.try_iter().collect(), received)
    }
}

/// The number of this run: from the system's random numbers, since clocks may be set back.
fn run() -> u32 {
    let [_, _, _, _, a, b, c, d] = RandomState::new().hash_one(0).to_le_bytes();
    u32::from_le_bytes([a, b, c, d])
}
