//! What is to be published in, a gripper on the network out. This thread may wait for the network; nobody waits for it.

use super::{Common, Outgoing, PAUSE, pause, ros::Ros};
use core::{mem, time::Duration};
use grip_daemon::log::LogLevel;
use grip_fleet::{
    Member, Site,
    net::{Announced, NetError, Network, RosAnnounced, Session},
};
use grip_host::exit::message;
use std::sync::mpsc::{Receiver, RecvTimeoutError};

/// Pause between two attempts to find the router, or a free name.
const RETRY: Duration = Duration::from_secs(2);

pub(super) struct Speaker {
    network: Network,
    site: Site,
    /// The configuration at the start, as text.
    shown: String,
    common: Common,
    outgoing: Receiver<Outgoing>,
    /// The gripper is a node of ROS 2 too.
    ros: Option<Ros>,
    /// The last complaint was told.
    complained: bool,
}

impl Speaker {
    pub(super) fn new(
        network: Network,
        site: Site,
        shown: String,
        (common, outgoing): (Common, Receiver<Outgoing>),
    ) -> Self {
        Self { network, site, shown, common, outgoing, ros: None, complained: false }
    }

    /// As a node of ROS 2 too.
    pub(super) fn with_ros(mut self, ros: Option<Ros>) -> Self {
        self.ros = ros;
        self
    }

    /// Runs until the keeper has ended.
    pub(super) fn run(mut self) {
        let Some(session) = self.retry(|network| network.open()) else { return };
        let Some(member) = self.member() else { return };
        let Some(mut announced) = self.retry(|_| Announced::new(&session, &member)) else {
            return;
        };
        self.common.tell(LogLevel::Info, &format!("this gripper is there as {member}"));
        let mut node = self.node(&session, &member);
        self.speak(&mut announced, node.as_mut());
        let refused = announced.refused() + node.map_or(0, |(_, node)| node.refused());
        if refused > 0 {
            let text = format!("the session has refused {refused} publications");
            self.common.tell(LogLevel::Warn, &text);
        }
    }

    /// The gripper as a node of ROS 2, where it is to be one. What the session refuses now it will not take later, and the fleet can do without.
    fn node(&mut self, session: &Session, member: &Member) -> Option<(Ros, RosAnnounced)> {
        let ros = self.ros.take()?;
        match ros.announce(session, member) {
            Ok(node) => {
                self.common.tell(LogLevel::Info, &format!("ROS 2 has it as {}", node.name()));
                Some((ros, node))
            }
            Err(error) => {
                let text = format!("ROS 2 does not have this gripper: {}", message(&error));
                self.common.tell(LogLevel::Error, &text);
                None
            }
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

    fn speak(&self, announced: &mut Announced, mut node: Option<&mut (Ros, RosAnnounced)>) {
        loop {
            // While an answer is under way nothing is waited for.
            let patience = if announced.is_answering() { Duration::ZERO } else { PAUSE };
            match self.outgoing.recv_timeout(patience) {
                Ok((topic, id, wire)) => {
                    announced.publish(topic, id, &wire);
                    if let Some((ros, node)) = &mut node {
                        ros.publish(node, id, &wire);
                    }
                }
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
        }
    }
}
