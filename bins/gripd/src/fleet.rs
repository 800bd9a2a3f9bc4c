//! What every client of the daemon hears in, publications on a network of many grippers out, on two threads of their own: one keeps events
//! and never waits for a network, one talks to it. The service thread serves the first as it serves any client; nothing here reaches the hot
//! thread, and a network that is gone stops nothing.

mod curator;
mod keeper;
mod lending;
mod network;
mod ros;

pub(crate) use curator::{Desk, Wanted};

use crate::{
    clock::Clock,
    settings::{Settings, network},
};
use anyhow::Context as _;
use core::{
    hash::BuildHasher as _,
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use curator::Curator;
use grip_daemon::{clients::Clients, log::LogLevel};
use grip_fleet::{About, Bridge, EventId, Spool, Topic, Uid, deploy::Models};
use grip_link::message::{NackReason, daemon::Command};
use grip_session::exit::message;
use keeper::{Keeper, KeeperEnds};
use lending::Lending;
use network::{Place, Speaker, SpeakerEnds};
use ros::Ros;
use std::{
    hash::RandomState,
    io::Write as _,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        mpsc::{self, Receiver, Sender},
    },
    thread::{self, JoinHandle},
};

/// Pause between two looks at what was asked.
const PAUSE: Duration = Duration::from_millis(10);
/// Publications on their way to the network; what finds no room is asked for again, or out of date soon.
const ON_THE_WAY: usize = 1024;
/// How long the end may take: a session on a line that is cut takes ten seconds to close.
const END: Duration = Duration::from_millis(1500);

/// A sentence for the console.
pub(crate) type Told = (LogLevel, String);

/// A publication on its way.
type Outgoing = (Topic, EventId, Vec<u8>);

/// A command from the network, by the number of its question.
type Order = (u64, Command);
/// What became of it.
type Answered = (u64, Result<(), NackReason>);

/// What is known of the gripper, for both threads.
#[derive(Debug, Default)]
struct Kept {
    /// Which one it is, and its events, as soon as it has said so.
    gripper: Option<(Uid, Spool)>,
    /// The last frames of what does not go into the log.
    status: Vec<Vec<u8>>,
}

/// What both threads share.
#[derive(Clone, Debug)]
struct Common {
    kept: Arc<Mutex<Kept>>,
    /// What the gripper is made of, as JSON. Apart from the rest, which may be held while a disk is written to: the service thread never waits
    /// for that.
    about: Arc<Mutex<String>>,
    ended: Arc<AtomicBool>,
    say: Sender<Told>,
}

impl Common {
    /// What a thread that has panicked left is still data.
    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn about(&self) -> MutexGuard<'_, String> {
        self.about.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, level: LogLevel, text: &str) {
        // A console that is gone reads nothing.
        let _gone = self.say.send((level, format!("fleet: {text}")));
    }

    fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }
}

/// The threads, as seen from outside.
#[derive(Debug)]
pub(crate) struct Fleet {
    threads: Vec<JoinHandle<()>>,
    /// What they have to say.
    told: Receiver<Told>,
    common: Common,
    mourned: bool,
    /// What is left to do for the models that come over the network, where some are taken.
    pub(crate) desk: Option<Desk>,
}

/// Opens the models that came over the network, and puts the one that was accepted into the settings. None where no folder is named, or a flag
/// names the model.
pub(crate) fn open_models(mut settings: Settings) -> anyhow::Result<(Settings, Option<Models>)> {
    let fleet = &settings.config.fleet;
    let Some(folder) = fleet.models.clone().filter(|_| fleet.site.is_some()) else {
        return Ok((settings, None));
    };
    if settings.model_is_fixed() {
        return Ok((settings, None));
    }
    match Models::open(&folder, settings.configured_model()?) {
        Ok((models, accepted)) => {
            settings.deployed = accepted;
            Ok((settings, Some(models)))
        }
        // A gripper whose models are damaged must still hold what it holds.
        Err(error) => {
            settings.models_trouble = Some(message(&error));
            Ok((settings, None))
        }
    }
}

/// Why no model is taken from the network.
fn why_no_model(settings: &Settings) -> &'static str {
    if settings.model_is_fixed() {
        "the model of this gripd was named with --model or GRIPD_MODEL, and stays"
    } else if settings.models_trouble.is_some() {
        "the folder of models cannot be used: see what this gripd has said at its start"
    } else {
        "this gripd takes no model from the network: models is not set in [fleet]"
    }
}

impl Fleet {
    /// Begins to publish where the settings ask for it; there are clients then, if only this one.
    pub(crate) fn start(
        settings: &Settings,
        models: Option<Models>,
        clients: Option<Clients>,
        clock: Clock,
    ) -> anyhow::Result<(Option<Clients>, Option<Self>)> {
        let config = &settings.config.fleet;
        let Some(site) = config.site.clone() else { return Ok((clients, None)) };
        let mut clients = clients.context("nothing can be told to the fleet without clients")?;
        let bridge = Bridge::new(1);
        let mut stream = clients.connect_inside(clock.now_us())?;
        stream.set_read_timeout(Some(PAUSE))?;
        // Before anything happens, so that nothing is missed.
        stream.write_all(&bridge.subscribe(config.samples_every))?;
        let shown =
            toml::to_string(&settings.config).context("the configuration cannot be written")?;
        let (say, told) = mpsc::channel();
        let common =
            Common { kept: Arc::default(), about: Arc::default(), ended: Arc::default(), say };
        let (sender, outgoing) = mpsc::sync_channel(ON_THE_WAY);
        let (order, orders) = mpsc::channel();
        let (answer, answers) = mpsc::channel();
        let ends = KeeperEnds { common: common.clone(), sender, orders, answer };
        let keeper = Keeper::new(bridge, config.clone(), run(), ends);
        let commands = settings.config.allow_commands && config.commands;
        let lending = Lending::new(&settings.config);
        if let Some(trouble) = lending.trouble(&settings.config) {
            common.tell(LogLevel::Warn, trouble);
        }
        if let Some(trouble) = &settings.models_trouble {
            let text = format!(
                "{trouble}; the model of the configuration is in force, and none is taken from the network"
            );
            common.tell(LogLevel::Error, &text);
        }
        let curator = models.map(|models| Curator::new(models, common.clone()));
        let (curator, line, desk) = curator.map_or((None, None, None), |(curator, line, desk)| {
            (Some(curator), Some(line), Some(desk))
        });
        let models = line.ok_or_else(|| why_no_model(settings));
        let ends = SpeakerEnds { common: common.clone(), outgoing, order, answers, models };
        let ros = Ros::new(config.ros_domain, clock);
        let place = Place { site, shown, commands, lending, ros };
        let speaker = Speaker::new(network(config), place, ends);
        let spawn = |name: &str, body: Box<dyn FnOnce() + Send>| {
            thread::Builder::new().name(name.to_owned()).spawn(body)
        };
        let mut threads = vec![
            spawn("fleet", Box::new(move || keeper.run(stream)))?,
            spawn("fleet-network", Box::new(move || speaker.run()))?,
        ];
        if let Some(curator) = curator {
            threads.push(spawn("fleet-models", Box::new(move || curator.run()))?);
        }
        Ok((Some(clients), Some(Self { threads, told, common, mourned: false, desk })))
    }

    /// What the gripper is made of, for those who ask.
    pub(crate) fn set_about(&self, about: &About) {
        // What cannot be written, which no value makes, is not told.
        let text = about.to_json().unwrap_or_default();
        *self.common.about() = text;
    }

    /// What they have said meanwhile, and, once, that one of them has ended.
    pub(crate) fn told(&mut self) -> Vec<Told> {
        let mut told: Vec<Told> = self.told.try_iter().collect();
        if !self.mourned && self.threads.iter().any(JoinHandle::is_finished) {
            self.mourned = true;
            let text = "fleet: this gripper is told to nobody any more until gripd starts again";
            told.push((LogLevel::Error, text.to_owned()));
        }
        told
    }

    /// Waits a little for their end, which comes when the service thread has said goodbye to its clients: what they said last.
    pub(crate) fn finish(self) -> Vec<Told> {
        // Whoever waits for a model to be in force waits no longer.
        drop(self.desk);
        let steps = END.as_millis() / PAUSE.as_millis();
        for _ in 0..steps {
            if self.threads.iter().all(JoinHandle::is_finished) {
                break;
            }
            pause(PAUSE);
        }
        self.told.try_iter().collect()
    }
}

/// The number of this run: from the system's random numbers, since clocks may be set back.
fn run() -> u32 {
    let [_, _, _, _, a, b, c, d] = RandomState::new().hash_one(0).to_le_bytes();
    u32::from_le_bytes([a, b, c, d])
}

#[expect(
    clippy::disallowed_methods,
    reason = "the driver may wait; nobody waits for these threads"
)]
fn pause(time: Duration) {
    thread::sleep(time);
}
