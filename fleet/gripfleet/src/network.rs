//! Publisher of a gripper on the network. This thread may wait for the network; nobody waits for it.

use crate::{
    clock::Clock,
    common::{Answered, Common, Order, Outgoing, PAUSE, pause},
    curator::Line,
    lending::Lending,
};
use core::{mem, time::Duration};
use grip_daemon::log::LogLevel;
use grip_fleet::{
    Member, Part, Site,
    net::{Announced, NetError, Network, Question, RosAnnounced, RosTimes, Session},
};
use grip_link::message::{
    NackReason,
    daemon::{Command, Operation},
};
use grip_session::exit::message;
use std::{
    collections::VecDeque,
    sync::mpsc::{Receiver, RecvTimeoutError, Sender},
};

/// Pause between two attempts to find the router, or a free name.
const RETRY: Duration = Duration::from_secs(2);

/// What this gripper can be asked, beside events, status and configuration.
const PARTS: [Part; 4] = [Part::About, Part::Command, Part::Model, Part::Recordings];
/// Commands that wait for the daemon; it answers within milliseconds.
const MOST_ORDERS: usize = 32;

/// What a gripper reports of itself, and what it takes.
pub(super) struct Place {
    pub(super) site: Site,
    /// The configuration at the start, as text.
    pub(super) shown: String,
    /// Whether commands are taken.
    pub(super) commands: bool,
    /// The largest force that the settings allow (N).
    pub(super) ceiling_n: f32,
    /// The recordings it gives away.
    pub(super) lending: Lending,
    /// The domain in which it is a node of ROS 2 too.
    pub(super) ros_domain: Option<u16>,
    pub(super) clock: Clock,
}

/// What leads to the other threads.
pub(super) struct SpeakerEnds {
    pub(super) common: Common,
    /// What is to be published.
    pub(super) outgoing: Receiver<Outgoing>,
    /// Commands, and what became of them.
    pub(super) order: Sender<Order>,
    pub(super) answers: Receiver<Answered>,
    /// The way to the models.
    pub(super) models: Line,
}

pub(super) struct Speaker {
    network: Network,
    place: Place,
    ends: SpeakerEnds,
    /// Commands that wait for the daemon, by their numbers.
    open: VecDeque<(u64, Question)>,
    /// Number of the last command.
    ordered: u64,
    /// The last complaint was logged.
    complained: bool,
}

impl Speaker {
    pub(super) const fn new(network: Network, place: Place, ends: SpeakerEnds) -> Self {
        Self { network, place, ends, open: VecDeque::new(), ordered: 0, complained: false }
    }

    /// Runs until the keeper has ended.
    pub(super) fn run(mut self) {
        let Some(session) = self.retry(|network| network.open()) else { return };
        let Some(member) = self.member() else { return };
        let Some(mut announced) = self.retry(|_| Announced::new(&session, &member, &PARTS)) else {
            return;
        };
        self.ends.common.report(LogLevel::Info, format!("this gripper is there as {member}"));
        // What waited for a router is out of date; of events, the log has all.
        while self.ends.outgoing.try_recv().is_ok() {}
        let mut node = self.node(&session, &member);
        self.speak(&mut announced, node.as_mut());
        let refused = announced.refused() + node.map_or(0, |node| node.refused());
        if refused > 0 {
            self.ends
                .common
                .report(LogLevel::Warn, format!("the session has refused {refused} publications"));
        }
    }

    /// The gripper as a node of ROS 2, where it is to be one. What the session refuses now it will not take later, and the fleet can do without.
    fn node(&self, session: &Session, member: &Member) -> Option<RosAnnounced> {
        match RosAnnounced::new(session, member, self.place.ros_domain?) {
            Ok(node) => {
                self.ends.common.report(LogLevel::Info, format!("ROS 2 has it as {}", node.name()));
                Some(node)
            }
            Err(error) => {
                self.ends.common.report(
                    LogLevel::Error,
                    format!("ROS 2 does not have this gripper: {}", message(&error)),
                );
                None
            }
        }
    }

    /// The gripper's name, as soon as it has one.
    fn member(&self) -> Option<Member> {
        while !self.ends.common.has_ended() {
            if let Some((uid, _)) = &self.ends.common.kept().gripper {
                return Some(Member { site: self.place.site.clone(), uid: *uid });
            }
            pause(PAUSE);
        }
        None
    }

    /// Tries until it works; `None` at the end of the connection.
    fn retry<T>(&mut self, attempt: impl Fn(&Network) -> Result<T, NetError>) -> Option<T> {
        let mut wait = Duration::ZERO;
        while !self.ends.common.has_ended() {
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
                        let text =
                            format!("{}; events are kept and published later", message(&error));
                        self.ends.common.report(LogLevel::Warn, text);
                    }
                    wait = RETRY;
                }
            }
        }
        None
    }

    fn speak(&mut self, announced: &mut Announced, mut node: Option<&mut RosAnnounced>) {
        loop {
            // While an answer is under way nothing is waited for.
            let answering = announced.is_answering() || self.place.lending.is_answering();
            let patience = if answering { Duration::ZERO } else { PAUSE };
            match self.ends.outgoing.recv_timeout(patience) {
                Ok((topic, stamp, wire)) => {
                    announced.publish(topic, stamp, &wire);
                    if let Some(node) = &mut node {
                        let start_ns = self.ends.common.kept().start_ns;
                        let now_ns = self.place.clock.wall_ns();
                        node.publish(stamp.id, &wire, RosTimes { start_ns, now_ns });
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            let common = &self.ends.common;
            let status = common.kept().status.clone();
            let with_log = |use_it: &mut dyn FnMut(&grip_fleet::EventLog)| {
                if let Some((_, spool)) = &common.kept().gripper {
                    use_it(spool.log());
                }
            };
            announced.answer(&with_log, &status, &self.place.shown);
            while let Some(question) = announced.question() {
                self.question(question);
            }
            while let Ok((number, answer)) = self.ends.answers.try_recv() {
                self.answered(number, answer);
            }
            while let Some((question, answer)) = self.ends.models.answered() {
                self.report(match answer {
                    Ok(standing) => question.reply(standing.as_bytes()),
                    Err(reason) => question.refuse(&reason),
                });
            }
            let sent = self.place.lending.go_on();
            self.report(sent);
        }
    }

    /// Answers what the log does not know.
    fn question(&mut self, question: Question) {
        match question.part() {
            Part::About => {
                let about = self.ends.common.kept().about.clone();
                self.report(question.reply(about.as_bytes()));
            }
            Part::Command => self.command(question),
            Part::Recordings => {
                let taken = self.place.lending.take(question);
                self.report(taken);
            }
            Part::Model => {
                let asked = self.ends.models.ask(question);
                self.report(asked);
            }
            _ => self.report(question.refuse("this is not asked here")),
        }
    }

    /// Hands a command to the daemon, which judges it as that of any other client.
    fn command(&mut self, question: Question) {
        if !self.place.commands {
            let reason = "commands are not taken from the network: allow_commands and fleet.commands are not both set";
            return self.report(question.refuse(reason));
        }
        // Whoever may command may also let go.
        if question.payload_len() == 0 {
            let token = self.ends.common.kept().token.unwrap_or_default().to_string();
            return self.report(question.reply(token.as_bytes()));
        }
        let Ok(command) = Command::parse(&question.payload()) else {
            return self.report(question.refuse("this is no command"));
        };
        let fault = self.ends.common.kept().fault;
        if let Some(reason) = unfit(&command, fault, self.place.ceiling_n) {
            return self.report(question.refuse(&reason));
        }
        if self.open.len() >= MOST_ORDERS {
            // The daemon had no room to answer them.
            self.open.pop_front();
        }
        self.ordered += 1;
        self.open.push_back((self.ordered, question));
        // A keeper that is gone ends this thread too.
        let _gone = self.ends.order.send((self.ordered, command));
    }

    fn answered(&mut self, number: u64, answer: Result<(), NackReason>) {
        let Some(place) = self.open.iter().position(|(open, _)| *open == number) else { return };
        let Some((_, question)) = self.open.remove(place) else { return };
        self.report(match answer {
            Ok(()) => question.reply(b"taken"),
            Err(reason) => question.refuse(refusal(reason)),
        });
    }

    /// Reports an answer that the session did not take.
    fn report(&self, sent: Result<(), NetError>) {
        if let Err(error) = sent {
            self.ends.common.report(LogLevel::Warn, message(&error));
        }
    }
}

/// Why a command would not be carried out, or not as it was meant; gripd takes it all the same.
fn unfit(command: &Command, fault: u16, ceiling_n: f32) -> Option<String> {
    let moves = !matches!(command.operation, Operation::Stop | Operation::ClearFault);
    if moves && fault != 0 {
        return Some(format!(
            "the gripper has latched fault {fault:04x} and moves nothing until that is cleared"
        ));
    }
    let has_force = matches!(command.operation, Operation::AtLeast | Operation::Expect);
    let (force_n, ceiling_n) = (f64::from(command.force_mn) / 1e3, f64::from(ceiling_n));
    (has_force && force_n > ceiling_n)
        .then(|| format!("{force_n} N is more than the {ceiling_n} N that the settings allow"))
}

/// Why the daemon does not take a command.
const fn refusal(reason: NackReason) -> &'static str {
    match reason {
        NackReason::Forbidden => "commands are not allowed: allow_commands is not set",
        NackReason::Token => "letting go needs the token of this start of gripd; ask again",
        NackReason::Busy => "too many commands wait",
        NackReason::WrongState => "the gripper cannot be commanded now: no samples come from it",
        NackReason::Latched => {
            "the gripper has latched a fault and moves nothing until that is cleared"
        }
        _ => "the daemon refuses this command",
    }
}

#[cfg(test)]
mod tests {
    use super::{Command, Operation, unfit};

    #[test]
    fn what_would_not_be_carried_out_is_refused() {
        let at_least = |force_mn| Command { force_mn, ..Command::new(Operation::AtLeast) };
        let [most, more] = [45_000, 1_000_000_000].map(at_least);
        assert_eq!(unfit(&most, 0, 45.0), None);
        assert_eq!(
            unfit(&more, 0, 45.0).unwrap(),
            "1000000 N is more than the 45 N that the settings allow"
        );
        for operation in [Operation::Release, Operation::Grasp, Operation::AtLeast] {
            let reason = unfit(&Command::new(operation), 0x0201, 45.0).unwrap();
            assert!(reason.starts_with("the gripper has latched fault 0201"), "{reason}");
        }
        for operation in [Operation::Stop, Operation::ClearFault] {
            assert_eq!(unfit(&Command::new(operation), 0x0201, 45.0), None);
        }
    }
}
