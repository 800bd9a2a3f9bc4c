//! Curator of models, by orders from the network, and grasps and settings of gripd: answers, and models for gripd. This thread may wait for a disk
//! and for gripd. It ends a trial that nobody watches any more.

use crate::{
    clock::{Clock, utc_ns},
    common::{Common, PAUSE},
};
use core::{
    sync::atomic::{AtomicU16, Ordering},
    time::Duration,
};
use grip_daemon::log::LogLevel;
use grip_fleet::{
    Setup,
    deploy::{Examined, MOST_BYTES, Models, Notice, Order, Put, Standing, rehearse},
    net::{NetError, Question},
    recordings::Shelf,
    rollout::{Finished, Rehearsal},
};
use grip_link::message::FaultCode;
use grip_session::{exit::message, signature::ModelKeys};
use std::{
    collections::HashMap,
    path::PathBuf,
    sync::{
        Arc,
        mpsc::{self, Receiver, RecvTimeoutError, Sender},
    },
    thread::{self, JoinHandle},
};

/// An order, with a number that the answer has too.
type Asked = (u64, Order);
/// An answer: JSON, or the reason why there is none.
type Answered = (u64, Result<String, String>);

/// Orders that may wait; one waits for a disk and for the border of a frame.
const MOST_ORDERS: usize = 16;

/// Turns between two looks at the lease of a trial, and two attempts at a way back that failed.
const TICK: u32 = 25;
/// gripd answers a model within two seconds; a connection on which it does not has ended.
const ANSWERED: Duration = Duration::from_secs(10);

/// What the thread that talks to gripd has to do with models.
#[derive(Debug)]
pub(crate) struct Desk {
    /// Models to be put in force, or beside the one in force.
    pub(crate) wanted: Receiver<Wanted>,
    /// What became of them: how many grasps had begun then.
    pub(crate) swapped: Sender<Result<u64, String>>,
    /// What gripd works with, and whether it takes models.
    pub(crate) setups: Sender<(Setup, bool)>,
    /// Grasps that have ended.
    pub(crate) grasped: Sender<Finished>,
    /// Latched fault of the gripper.
    pub(crate) fault: Arc<AtomicU16>,
}

/// A model, and where it goes.
#[derive(Debug)]
pub(crate) struct Wanted {
    /// None is that of the configuration, or no shadow.
    pub(crate) model: Option<Examined>,
    /// It estimates beside the one in force, and moves nothing.
    pub(crate) beside: bool,
}

/// Where models come from, and whose.
#[derive(Debug)]
pub(crate) struct Places {
    /// The folder that keeps them, where they are taken.
    pub(crate) models: Option<PathBuf>,
    /// Who has to have signed them.
    pub(crate) keys: ModelKeys,
    /// The recordings of gripd, or why there are none.
    pub(crate) recordings: Result<Shelf, String>,
}

/// The thread.
pub(crate) struct Curator {
    places: Places,
    common: Common,
    asked: Receiver<Asked>,
    answered: Sender<Answered>,
    wanted: Sender<Wanted>,
    swapped: Receiver<Result<u64, String>>,
    setups: Receiver<(Setup, bool)>,
    grasped: Receiver<Finished>,
    fault: Arc<AtomicU16>,
    clock: Clock,
    /// A replay of the recordings.
    replay: Option<JoinHandle<Rehearsal>>,
}

/// What the thread of the network has of it.
#[derive(Debug)]
pub(crate) struct Line {
    asked: Sender<Asked>,
    answered: Receiver<Answered>,
    /// Questions that are not answered yet, by number; and the last number.
    waiting: HashMap<u64, Question>,
    ticket: u64,
}

impl Line {
    /// Hands an order on; the answer comes when it is obeyed. What is no order is refused at once.
    pub(crate) fn ask(&mut self, question: Question) -> Result<(), NetError> {
        if self.waiting.len() >= MOST_ORDERS {
            return question.refuse("too many orders wait");
        }
        // Before they are copied.
        if question.payload_len() > MOST_BYTES {
            return question.refuse(&format!("a model has at most {MOST_BYTES} bytes"));
        }
        match Order::read(|name| question.parameter(name), question.payload()) {
            Ok(order) => {
                self.ticket += 1;
                if self.asked.send((self.ticket, order)).is_err() {
                    return question.refuse("the thread of the models has ended");
                }
                self.waiting.insert(self.ticket, question);
                Ok(())
            }
            Err(error) => question.refuse(&error.to_string()),
        }
    }

    /// The next question that is answered.
    pub(crate) fn answered(&mut self) -> Option<(Question, Result<String, String>)> {
        let (ticket, answer) = self.answered.try_recv().ok()?;
        Some((self.waiting.remove(&ticket)?, answer))
    }
}

impl Curator {
    /// The thread's body, and the ends of its neighbours.
    pub(crate) fn new(places: Places, common: Common, clock: Clock) -> (Self, Line, Desk) {
        let (asked_in, asked) = mpsc::channel();
        let (answered, answered_out) = mpsc::channel();
        let (wanted, wanted_out) = mpsc::channel();
        let (swapped_in, swapped) = mpsc::channel();
        let (setups_in, setups) = mpsc::channel();
        let (grasped_in, grasped) = mpsc::channel();
        let fault = Arc::<AtomicU16>::default();
        let desk = Desk {
            wanted: wanted_out,
            swapped: swapped_in,
            setups: setups_in,
            grasped: grasped_in,
            fault: Arc::clone(&fault),
        };
        let line =
            Line { asked: asked_in, answered: answered_out, waiting: HashMap::new(), ticket: 0 };
        let curator = Self {
            places,
            common,
            asked,
            answered,
            wanted,
            swapped,
            setups,
            grasped,
            fault,
            clock,
            replay: None,
        };
        (curator, line, desk)
    }

    /// Runs until one of the other threads has ended.
    pub(crate) fn run(mut self) {
        let Ok((mut setup, takes_models)) = self.setups.recv() else { return };
        let mut models = self.open(&setup, takes_models);
        let mut turns = 0;
        while !self.common.has_ended() {
            let asked = match self.asked.recv_timeout(PAUSE) {
                Ok(asked) => Some(asked),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            let now_us = self.clock.now().host_us;
            let swap = &mut |put: Put<'_>| self.swap(put);
            let latest = self.setups.try_iter().last();
            let before = setup.settings;
            if let Some((latest, _)) = latest {
                setup = latest;
            }
            if let Ok(models) = &mut models {
                models.set_utc(utc_ns());
                if setup.settings != before {
                    models.reloaded(setup.configured.clone(), swap);
                }
                self.grasped.try_iter().for_each(|finished| models.grasped(&finished));
                turns += 1;
                // An order meets the gripper as it is now, not as it was at the last turn.
                if asked.is_some() || turns >= TICK {
                    turns = 0;
                    let fault = FaultCode(self.fault.load(Ordering::Relaxed));
                    models.tick(now_us, fault, swap);
                }
            }
            if let Some((ticket, order)) = asked {
                let answer = match (&mut models, order) {
                    (Ok(models), order) => {
                        models.obey(order, now_us, swap).map_err(|fault| message(&fault))
                    }
                    // The way back is always open.
                    (Err(_), Order::Back { .. }) => {
                        swap(Put::InForce(None)).map(|_| Standing::configured(&setup.configured))
                    }
                    (Err(reason), _) => Err((*reason).to_owned()),
                };
                let answer = answer.and_then(|standing| {
                    serde_json::to_string(&standing).map_err(|error| error.to_string())
                });
                let _gone = self.answered.send((ticket, answer));
            }
            if let Ok(models) = &mut models {
                self.rehearse(models);
                self.report(models);
            }
        }
    }

    /// The models of this gripper, and the accepted one in force; or why none is taken from the network. That of the configuration is in force then.
    fn open(&mut self, setup: &Setup, takes_models: bool) -> Result<Models, &'static str> {
        let opened = match self.places.models.as_deref() {
            None => Err("this gripper takes no model from the network: models is not set in [fleet]"),
            Some(_) if !takes_models => Err(
                "gripd takes no model: allow_models is not set, or the model was named with --model or GRIPD_MODEL, and stays",
            ),
            Some(folder) => Models::open(folder, setup.configured.clone()).map_err(|error| {
                self.common.report(LogLevel::Error, format!(
                    "{}; the model of the configuration is in force, and none is taken from the network",
                    message(&error)
                ));
                "the folder of models cannot be used: see the log of gripfleet"
            }),
        };
        opened
            .map(|models| {
                let mut models = models.with_keys(self.places.keys.clone());
                models.resume(&setup.in_force, &mut |put| self.swap(put));
                models
            })
            .inspect_err(|reason| {
                if self.places.models.is_some() && !takes_models {
                    self.common.report(LogLevel::Warn, *reason);
                }
                if setup.in_force != setup.configured.sha256
                    && let Err(reason) = self.swap(Put::InForce(None))
                {
                    self.common.report(LogLevel::Error, reason);
                }
            })
    }

    /// Puts a model in force, or beside that; waits for the border of a frame, for two seconds for one at which nothing slips.
    fn swap(&self, put: Put<'_>) -> Result<u64, String> {
        let wanted = match put {
            Put::InForce(model) => Wanted { model: model.cloned(), beside: false },
            Put::Beside(model) => Wanted { model: model.cloned(), beside: true },
        };
        let ending = |_| "the connection to gripd has ended".to_owned();
        self.wanted.send(wanted).map_err(|_| ending(()))?;
        self.swapped.recv_timeout(ANSWERED).unwrap_or_else(|_| {
            self.common.end();
            Err(ending(()))
        })
    }

    /// Replays recordings in a thread of its own: that takes longer than anybody waits here.
    fn rehearse(&mut self, models: &mut Models) {
        if let Some(model) = models.rehearsing() {
            let shelf = self.places.recordings.clone();
            let replay = move || rehearse(&shelf, &model.estimator);
            match thread::Builder::new().name("replay".to_owned()).spawn(replay) {
                Ok(thread) => self.replay = Some(thread),
                Err(error) => models.rehearsed(not_replayed(error.to_string())),
            }
        }
        if let Some(over) = self.replay.take_if(|thread| thread.is_finished()) {
            let failed = |_| not_replayed("the replay has failed".to_owned());
            models.rehearsed(over.join().unwrap_or_else(failed));
        }
    }

    fn report(&self, models: &mut Models) {
        for notice in models.notices() {
            match notice {
                Notice::Done(text) => self.common.report(LogLevel::Info, text),
                Notice::Trouble(text) => self.common.report(LogLevel::Error, text),
            }
        }
    }
}

/// Recordings that were not replayed, and why.
fn not_replayed(reason: String) -> Rehearsal {
    Rehearsal { skipped: vec![reason], ..Rehearsal::default() }
}
