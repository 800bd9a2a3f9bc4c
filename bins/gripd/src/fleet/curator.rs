//! Orders from the network and counts of the service thread in, answers and models for the hot thread out: the thread that may wait for a disk
//! and for the border of a frame. It watches a trial also where nobody asks any more.

use super::{Common, PAUSE};
use grip_daemon::{HotCounters, log::LogLevel};
use grip_fleet::{
    deploy::{Examined, MOST_BYTES, Models, News, Order},
    net::{NetError, Question},
    rollout::{Bursts, Counts},
};
use grip_session::exit::message;
use std::{
    collections::HashMap,
    sync::{
        Arc, Mutex, PoisonError,
        mpsc::{self, Receiver, RecvTimeoutError, Sender},
    },
};

/// An order, with a number that the answer has too.
type Asked = (u64, Order);
/// An answer: JSON, or the reason why there is none.
type Answered = (u64, Result<String, String>);

/// Orders that may wait; one waits for a disk and for the border of a frame.
const MOST_ORDERS: usize = 16;

/// A model to be put in force.
#[derive(Debug)]
pub(crate) struct Wanted {
    pub(crate) model: Examined,
    /// It came over the network; otherwise it is that of the configuration.
    pub(crate) deployed: bool,
}

/// What the service thread has to do with models. Nothing here waits.
#[derive(Debug)]
pub(crate) struct Desk {
    wanted: Receiver<Wanted>,
    swapped: Sender<Result<Counts, String>>,
    reloaded: Sender<Examined>,
    counts: Arc<Mutex<Counts>>,
    /// A model is in force since some time before that (us).
    fresh: Option<u64>,
    /// Samples with an object, and slips, of the last counters.
    last: (u64, u64),
    bursts: Bursts,
}

impl Desk {
    /// The next model to be put in force.
    pub(crate) fn wanted(&self) -> Option<Wanted> {
        self.wanted.try_recv().ok()
    }

    /// What became of it, as it is known now. Of one that is in force the thread learns with the next counters: what came before, while it waited for its
    /// turn, is none of its faults.
    pub(crate) fn swapped(&mut self, outcome: Result<(), String>, now_us: u64) {
        match outcome {
            Ok(()) => self.fresh = Some(now_us),
            // A thread that is gone waits for nothing.
            Err(reason) => drop(self.swapped.send(Err(reason))),
        }
    }

    /// Other settings are in force, with that model in the configuration.
    pub(crate) fn reloaded(&self, configured: Examined) {
        let _gone = self.reloaded.send(configured);
    }

    /// Takes the counters of the hot thread, the rate of the samples and the faults that the gripper has reported.
    pub(crate) fn count(&mut self, counters: &HotCounters, rate_hz: u32, faults: u64) {
        let [_idle, with_object @ ..] = counters.scenes;
        let now = (with_object.iter().sum(), counters.slips);
        let (samples, slips) = core::mem::replace(&mut self.last, now);
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        #[expect(clippy::cast_precision_loss, reason = "samples of a quarter of a second")]
        let samples = now.0.saturating_sub(samples) as f64;
        if rate_hz > 0 {
            counts.seconds += samples / f64::from(rate_hz);
        }
        counts.slips += self.bursts.take(counts.seconds, now.1.saturating_sub(slips));
        counts.faults = faults;
        if self.fresh.take_if(|since| counters.host_us >= *since).is_some() {
            drop(self.swapped.send(Ok(*counts)));
        }
    }
}

/// The thread.
pub(super) struct Curator {
    models: Models,
    common: Common,
    asked: Receiver<Asked>,
    answered: Sender<Answered>,
    wanted: Sender<Wanted>,
    swapped: Receiver<Result<Counts, String>>,
    reloaded: Receiver<Examined>,
    counts: Arc<Mutex<Counts>>,
}

/// What the thread of the network has of it.
#[derive(Debug)]
pub(super) struct Line {
    asked: Sender<Asked>,
    answered: Receiver<Answered>,
    /// Questions that are not answered yet, by number; and the last number.
    waiting: HashMap<u64, Question>,
    ticket: u64,
}

impl Line {
    /// Hands an order on; the answer comes when it is obeyed. What is no order is refused at once.
    pub(super) fn ask(&mut self, question: Question) -> Result<(), NetError> {
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
    pub(super) fn answered(&mut self) -> Option<(Question, Result<String, String>)> {
        let (ticket, answer) = self.answered.try_recv().ok()?;
        Some((self.waiting.remove(&ticket)?, answer))
    }
}

impl Curator {
    /// The thread's body, and the ends of its neighbours.
    pub(super) fn new(models: Models, common: Common) -> (Self, Line, Desk) {
        let (asked_in, asked) = mpsc::channel();
        let (answered, answered_out) = mpsc::channel();
        let (wanted, wanted_out) = mpsc::channel();
        let (swapped_in, swapped) = mpsc::channel();
        let (reloaded_in, reloaded) = mpsc::channel();
        let counts = Arc::<Mutex<Counts>>::default();
        let desk = Desk {
            wanted: wanted_out,
            swapped: swapped_in,
            reloaded: reloaded_in,
            counts: Arc::clone(&counts),
            fresh: None,
            last: (0, 0),
            bursts: Bursts::default(),
        };
        let waiting = HashMap::new();
        let line = Line { asked: asked_in, answered: answered_out, waiting, ticket: 0 };
        (Self { models, common, asked, answered, wanted, swapped, reloaded, counts }, line, desk)
    }

    /// Runs until the service thread or the network's thread has ended.
    pub(super) fn run(mut self) {
        loop {
            let asked = match self.asked.recv_timeout(PAUSE) {
                Ok(asked) => Some(asked),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            let total = *self.counts.lock().unwrap_or_else(PoisonError::into_inner);
            let Self { models, wanted, swapped, reloaded, .. } = &mut self;
            let swap = &mut |model: &Examined, deployed| swap(wanted, swapped, model, deployed);
            while let Ok(configured) = reloaded.try_recv() {
                models.reloaded(configured, swap);
            }
            models.count(total, swap);
            if let Some((ticket, order)) = asked {
                let answer = models.obey(order, swap).map_err(|fault| message(&fault));
                let answer = answer.and_then(|standing| {
                    serde_json::to_string(&standing).map_err(|error| error.to_string())
                });
                let _gone = self.answered.send((ticket, answer));
            }
            self.tell();
        }
    }

    fn tell(&mut self) {
        for news in self.models.news() {
            match news {
                News::Done(text) => self.common.tell(LogLevel::Info, &text),
                News::Trouble(text) => self.common.tell(LogLevel::Error, &text),
            }
        }
    }
}

/// Puts a model in force; waits for the border of a frame, for two seconds for one at which nothing slips.
fn swap(
    wanted: &Sender<Wanted>,
    swapped: &Receiver<Result<Counts, String>>,
    model: &Examined,
    deployed: bool,
) -> Result<Counts, String> {
    let ending = |_| "gripd is ending".to_owned();
    wanted.send(Wanted { model: model.clone(), deployed }).map_err(|_| ending(()))?;
    swapped.recv().map_err(|_| ending(()))?
}
