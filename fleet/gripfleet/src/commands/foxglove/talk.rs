//! One connection to a daemon: its messages as those of the live view, and requests for what apps show.

use super::View;
use crate::clock;
use core::time::Duration;
use grip_daemon::client::{Client, ClientError, misfit};
use grip_fleet::live::{Translator, Wanted};
use grip_link::message::NackReason;
use grip_link::message::daemon::{NoticeKind, ToClient};
use grip_port::nonce;
use grip_session::exit::escape;

/// How long a connection may take.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long one look for bytes waits.
const TURN: Duration = Duration::from_millis(20);
/// A daemon reports its health every second; one that sends nothing for so long is gone.
const SILENCE: Duration = Duration::from_secs(6);
/// An answer to SUBSCRIBE takes no longer.
const GREETING: Duration = Duration::from_secs(3);

/// One connection.
pub(super) struct Talk<'a, 'b> {
    view: &'a mut View<'b>,
    translator: &'a mut Translator,
    asked: Wanted,
    subscriptions: u64,
    received: Received,
}

/// What the daemon reports of this connection.
#[derive(Default)]
struct Received {
    greeted: Option<String>,
    farewell: Option<String>,
    dropped: Option<String>,
}

impl<'a, 'b> Talk<'a, 'b> {
    pub(super) fn new(view: &'a mut View<'b>, translator: &'a mut Translator) -> Self {
        let (asked, subscriptions) = (view.server.wanted(), view.server.subscriptions());
        translator.want(asked);
        Self { view, translator, asked, subscriptions, received: Received::default() }
    }

    /// Whether a gripd of this protocol has answered.
    pub(super) const fn was_greeted(&self) -> bool {
        self.received.greeted.is_some()
    }

    /// Shows what comes until the connection ends: why, as a sentence.
    pub(super) fn run(&mut self) -> String {
        match self.listen() {
            Ok(reason) => reason,
            Err(error) => self.received.farewell.take().unwrap_or_else(|| error.to_string()),
        }
    }

    fn listen(&mut self) -> Result<String, ClientError> {
        let args = self.view.args;
        let wanted = self.asked.subscribe(args.every);
        let mut client = Client::connect(&args.address, nonce(), wanted, PATIENCE)?;
        client.query()?;
        let begun = clock::monotonic();
        let (mut received, mut reported) = (begun, false);
        while !self.view.is_stopped() {
            if self.look(&mut client)? {
                received = clock::monotonic();
            }
            if let Some(reason) = self.received.farewell.take() {
                return Ok(reason);
            }
            if let Some(text) = self.received.dropped.take() {
                self.view.missing("dropped", &format!("gripd says: {text}"));
            }
            self.view.pass_on_complaints();
            let now = clock::monotonic();
            match &self.received.greeted {
                Some(name) if !reported => {
                    reported = true;
                    eprintln!("gripfleet: connected to {} at {}", escape(name), args.address);
                    self.view.server.settle("daemon");
                }
                None if now > begun + GREETING => {
                    return Ok(format!(
                        "{}: something answers, but not as gripd does",
                        args.address
                    ));
                }
                _ => {}
            }
            if now > received + SILENCE {
                return Ok(format!("{}: gripd does not answer any more", args.address));
            }
            self.follow(&mut client)?;
        }
        Ok(String::new())
    }

    /// Waits for bytes and publishes what they report; `false` where none came.
    fn look(&mut self, client: &mut Client) -> Result<bool, ClientError> {
        let Self { view, translator, received, .. } = self;
        let (server, wall) = (&view.server, view.wall);
        client.wait(TURN, &mut |message| {
            received.take(message);
            translator.take(message, wall.wall_ns(), &mut |topic, log_ns, bytes| {
                server.publish(topic, log_ns, bytes);
            });
        })
    }

    /// Asks for what apps show now, and for everything known where one shows something new.
    fn follow(&mut self, client: &mut Client) -> Result<(), ClientError> {
        let server = &self.view.server;
        let (wanted, subscriptions) = (server.wanted(), server.subscriptions());
        if wanted == self.asked && subscriptions == self.subscriptions {
            return Ok(());
        }
        if wanted != self.asked {
            self.translator.want(wanted);
            client.subscribe(wanted.subscribe(self.view.args.every))?;
        }
        if subscriptions != self.subscriptions {
            client.query()?;
        }
        (self.asked, self.subscriptions) = (wanted, subscriptions);
        Ok(())
    }
}

impl Received {
    fn take(&mut self, message: &ToClient<'_>) {
        match message {
            ToClient::Welcome(welcome) => match misfit(welcome.versions) {
                Some(reason) => self.farewell = Some(reason),
                None => {
                    self.greeted.get_or_insert_with(|| welcome.daemon().to_owned());
                }
            },
            ToClient::Notice(notice) if notice.kind == NoticeKind::Goodbye => {
                let text = format!("gripd closed the connection: {}", notice.as_str());
                self.farewell.get_or_insert(text);
            }
            ToClient::Notice(notice) if notice.kind == NoticeKind::Dropped => {
                self.dropped = Some(notice.as_str().to_owned());
            }
            ToClient::Nack(nack) if nack.reason == NackReason::Version => {
                self.farewell =
                    Some("gripd speaks no protocol version of this gripfleet".to_owned());
            }
            _ => {}
        }
    }
}
