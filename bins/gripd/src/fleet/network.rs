//! What is to be published in, a gripper on the network out. This thread may wait for the network; nobody waits for it.

use super::{
    Common, Outgoing, PAUSE,
    curator::{Answered, Line},
    pause,
};
use core::{mem, time::Duration};
use grip_daemon::log::LogLevel;
use grip_fleet::{
    Member, Part, Site,
    deploy::Order,
    net::{Announced, NetError, Network, Question},
};
use grip_host::exit::message;
use std::{
    collections::HashMap,
    sync::mpsc::{Receiver, RecvTimeoutError},
};

/// Pause between two attempts to find the router, or a free name.
const RETRY: Duration = Duration::from_secs(2);

/// What this gripper can be asked, beside events, status and configuration.
const PARTS: [Part; 2] = [Part::About, Part::Model];

pub(super) struct Speaker {
    network: Network,
    site: Site,
    /// The configuration at the start, as text.
    shown: String,
    common: Common,
    outgoing: Receiver<Outgoing>,
    /// The way to the models, or why there is none.
    models: Result<Line, &'static str>,
    /// Questions about models that are not answered yet, by number; and the next number.
    waiting: HashMap<u64, Question>,
    ticket: u64,
    /// The last complaint was told.
    complained: bool,
}

impl Speaker {
    pub(super) fn new(
        network: Network,
        (site, shown): (Site, String),
        models: Result<Line, &'static str>,
        (common, outgoing): (Common, Receiver<Outgoing>),
    ) -> Self {
        let waiting = HashMap::new();
        Self {
            network,
            site,
            shown,
            common,
            outgoing,
            models,
            waiting,
            ticket: 0,
            complained: false,
        }
    }

    /// Runs until the keeper has ended.
    pub(super) fn run(mut self) {
        let Some(session) = self.retry(|network| network.open()) else { return };
        let Some(member) = self.member() else { return };
        let Some(mut announced) = self.retry(|_| Announced::new(&session, &member, &PARTS)) else {
            return;
        };
        self.common.tell(LogLevel::Info, &format!("this gripper is there as {member}"));
        self.speak(&mut announced);
        if announced.refused() > 0 {
            let text = format!("the session has refused {} publications", announced.refused());
            self.common.tell(LogLevel::Warn, &text);
        }
    }

    /// The gripper's name, as soon as it has one.
    fn member(&self) -> Option<Member> {
        while !self.common.has_ended() {
            if let Some((uid, _)) = &self.common.kept().gripper {
                return Some(Member { site: self.site.clone(), uid: *uid });
            }
            pause(PAUSE);
        }
        None
    }

    /// Tries until it works; `None` at the end of the daemon.
    fn retry<T>(&mut self, attempt: impl Fn(&Network) -> Result<T, NetError>) -> Option<T> {
        let mut wait = Duration::ZERO;
        while !self.common.has_ended() {
            if !wait.is_zero() {
                wait = wait.saturating_sub(PAUSE);
                pause(PAUSE);
                continue;
            }
            match attempt(&self.network) {
                Ok(done) => {
                    self.complained = false;
                    return Some(done);
                }
                Err(error) => {
                    if !mem::replace(&mut self.complained, true) {
                        let text = format!("{}; events are kept and told later", message(&error));
                        self.common.tell(LogLevel::Warn, &text);
                    }
                    wait = RETRY;
                }
            }
        }
        None
    }

    fn speak(&mut self, announced: &mut Announced) {
        loop {
            // While an answer is under way nothing is waited for.
            let patience = if announced.is_answering() { Duration::ZERO } else { PAUSE };
            match self.outgoing.recv_timeout(patience) {
                Ok((topic, id, wire)) => announced.publish(topic, id, &wire),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            let status = self.common.kept().status.clone();
            let lend = |use_it: &mut dyn FnMut(&grip_fleet::EventLog)| {
                if let Some((_, spool)) = &self.common.kept().gripper {
                    use_it(spool.log());
                }
            };
            announced.answer(&lend, &status, &self.shown);
            while let Some(question) = announced.question() {
                self.question(question);
            }
            while let Some((ticket, answer)) = self.answered() {
                if let Some(question) = self.waiting.remove(&ticket) {
                    self.answer(&question, answer.as_deref().map_err(String::as_str));
                }
            }
        }
    }

    fn answered(&self) -> Option<Answered> {
        self.models.as_ref().ok()?.answered.try_recv().ok()
    }

    /// Answers what the log does not know.
    fn question(&mut self, question: Question) {
        match question.part() {
            Part::About => {
                let about = self.common.kept().about.clone();
                self.answer(&question, Ok(&about));
            }
            Part::Model => self.model(question),
            _ => self.answer(&question, Err("this is not asked here")),
        }
    }

    /// Hands an order on; the answer comes when it is obeyed.
    fn model(&mut self, question: Question) {
        let line = match &self.models {
            Ok(line) => line,
            Err(reason) => return self.answer(&question, Err(reason)),
        };
        match Order::read(|name| question.parameter(name), question.payload()) {
            Ok(order) => {
                self.ticket += 1;
                if line.asked.send((self.ticket, order)).is_err() {
                    return self.answer(&question, Err("the thread of the models has ended"));
                }
                self.waiting.insert(self.ticket, question);
            }
            Err(error) => self.answer(&question, Err(&error.to_string())),
        }
    }

    fn answer(&self, question: &Question, answer: Result<&str, &str>) {
        let told = match answer {
            Ok(text) => question.reply(text.as_bytes()),
            Err(reason) => question.refuse(reason),
        };
        if let Err(error) = told {
            self.common.tell(LogLevel::Warn, &message(&error));
        }
    }
}
