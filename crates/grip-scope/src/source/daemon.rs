//! Source of what the daemon at an address reports, for as long as the scope looks, however often the daemon goes and comes.

use super::outlet::Outlet;
use super::reception::Reception;
use super::reported;
use crate::feed::{Feed, SourceStatus};
use core::time::Duration;
use grip_daemon::client::{Client, ClientError};
use grip_daemon::clients::Listen;
use grip_link::message::Versions;
use grip_link::message::daemon::{Command, Operation, Subscribe, Topics};
use grip_port::{Backoff, nonce};
use slip_core::ClientCommand;
use std::io::ErrorKind;
use std::sync::mpsc::Receiver;

/// How long a connection may take.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long one look for bytes waits.
const TURN: Duration = Duration::from_millis(10);
/// Time between two looks while bytes come: what comes meanwhile is read at once, most of a picture's 33 ms of it.
const REST: Duration = Duration::from_millis(20);
/// Reads of one look: of a daemon that sends faster than this program reads the rest waits for the next look.
const READS: usize = 64;
/// How long a pause looks away from the scope.
const STEP: Duration = Duration::from_millis(25);
/// A daemon reports its health every second; one that sends nothing for so long is gone.
const SILENCE: Duration = Duration::from_secs(6);
/// An answer to SUBSCRIBE takes no longer.
const GREETING: Duration = Duration::from_secs(3);
/// Pauses between attempts grow from the one to the other.
const FIRST: Duration = Duration::from_millis(250);
const LONGEST: Duration = Duration::from_secs(5);
/// States come at most this often (ms).
const STATE_MS: u16 = 10;

/// Listens to the daemon until the scope lets go.
pub(super) fn run(listen: &Listen, outlet: &mut Outlet, orders: &Receiver<ClientCommand>) {
    let mut backoff = Backoff::new(FIRST, LONGEST);
    let mut before = String::new();
    while !outlet.stops() {
        outlet.status(SourceStatus::Connecting { what: listen.to_string(), before });
        let wanted = Subscribe {
            versions: Versions::OURS,
            topics: Topics::ALL,
            every_nth: 1,
            state_ms: STATE_MS,
        };
        before = match Client::connect(listen, nonce(), wanted, PATIENCE) {
            Ok(client) => {
                let reception = Reception::new(listen.to_string(), 1);
                let mut talk = Talk { client, reception, orders };
                let reason = talk.run(outlet);
                if talk.reception.greeted {
                    backoff.reset();
                }
                reason
            }
            Err(error) => sentence(&error),
        };
        // What was asked for while nobody was there is old when somebody is.
        while orders.try_recv().is_ok() {
            unsent(outlet, "there is no daemon to take the command");
        }
        pause(outlet, &before, backoff.pause());
    }
}

/// Waits, unless the scope lets go.
pub fn pause(outlet: &mut Outlet, reason: &str, time: Duration) {
    let again_in_s = time.as_secs_f32();
    outlet.status(SourceStatus::Waiting { reason: reason.to_owned(), again_in_s });
    let until = outlet.clock.now() + time;
    while !outlet.stops() && outlet.clock.now() < until {
        outlet.clock.wait(STEP);
    }
}

/// One connection.
struct Talk<'a> {
    client: Client,
    reception: Reception,
    orders: &'a Receiver<ClientCommand>,
}

impl Talk<'_> {
    /// Listens until the connection ends: why, as a sentence.
    fn run(&mut self, outlet: &mut Outlet) -> String {
        outlet.offer(Feed::Restart);
        if let Err(error) = self.client.query() {
            return sentence(&error);
        }
        let begun = outlet.clock.now();
        let mut received = begun;
        loop {
            if outlet.stops() {
                return String::new();
            }
            let came = match self.look() {
                Ok(came) => came,
                Err(error) => {
                    return self.reception.farewell.take().unwrap_or_else(|| sentence(&error));
                }
            };
            if came {
                received = outlet.clock.now();
            }
            self.reception.deliver(outlet);
            let now = outlet.clock.now();
            if !self.reception.greeted && now > begun + GREETING {
                return "something answers there, but not as gripd does".to_owned();
            }
            if now > received + SILENCE {
                let silence_s = SILENCE.as_secs();
                return format!("the daemon has said nothing for {silence_s} s");
            }
            if let Some(reason) = self.reception.refusal.take() {
                return reason;
            }
            if let Err(error) = self.obey(outlet) {
                return sentence(&error);
            }
            if came {
                outlet.clock.wait(REST);
            }
        }
    }

    /// Waits for bytes and reads all that are there; `false` where none came.
    fn look(&mut self) -> Result<bool, ClientError> {
        let reception = &mut self.reception;
        let mut patience = TURN;
        for read in 0..READS {
            if !self.client.wait(patience, &mut |message| reception.take(message))? {
                return Ok(read > 0);
            }
            patience = Duration::ZERO;
        }
        Ok(true)
    }

    /// Passes on what a person asks for.
    fn obey(&mut self, outlet: &mut Outlet) -> Result<(), ClientError> {
        while let Ok(action) = self.orders.try_recv() {
            let Some(token) = self.reception.token else {
                unsent(outlet, "the daemon allows no commands");
                continue;
            };
            self.client.command(&command(action, token))?;
            self.reception.asked = Some((self.client.link().last_request(), action));
        }
        Ok(())
    }
}

/// The command as the daemon takes it.
fn command(action: ClientCommand, token: u32) -> Command {
    let plain = Command::new;
    match action {
        ClientCommand::AtLeast(force_n) | ClientCommand::Expect(force_n) => {
            #[expect(clippy::cast_possible_truncation, reason = "the cast saturates")]
            let force_mn = (1e3 * force_n).round() as i32;
            Command { force_mn: force_mn.max(0), ..plain(action.operation()) }
        }
        ClientCommand::Release => Command { token, ..plain(Operation::Release) },
        ClientCommand::Grasp => plain(Operation::Grasp),
        ClientCommand::Stop => plain(Operation::Stop),
        ClientCommand::ClearFault(fault) => Command { fault, ..plain(Operation::ClearFault) },
    }
}

/// Why a command was not sent.
pub fn unsent(outlet: &mut Outlet, why: &str) {
    let feeds = reported::answer(why.to_owned());
    feeds.into_iter().for_each(|feed| outlet.offer(feed));
}

/// What is wrong, as a sentence. A daemon that dies with bytes unread resets the connection: that is how it is closed too.
fn sentence(error: &ClientError) -> String {
    match error {
        ClientError::Broken { listen, source }
            if matches!(
                source.kind(),
                ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted | ErrorKind::BrokenPipe
            ) =>
        {
            format!("{listen}: the daemon closed the connection")
        }
        other => other.to_string(),
    }
}
