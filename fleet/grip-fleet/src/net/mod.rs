//! Session with a router at an address, and what grippers and receivers do there.
//!
//! One session each, as a client of a router; nothing is searched for by multicast or gossip, and nothing listens. Names,
//! retries and the like come from a Zenoh configuration file, whose keys are read first; mode, scouting and, where it is given, the endpoint
//! are then set here.

mod announce;
mod ask;
mod deploy;
mod list;
mod ros;
mod watch;

pub use announce::{Announced, Question, WithLog};
pub use ask::{Ask, ask};
pub use deploy::{Deployer, Happening, standing};
pub use list::{Listed, ask_about, list, members};
pub use ros::{RosAnnounced, RosTimes};
pub use watch::{Reported, Watch};

use core::time::Duration;
use serde_json::Value;
use std::path::PathBuf;
pub use zenoh::Session;
use zenoh::{Config, Wait as _, config::EndPoint};

/// Which network.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Network {
    /// Where the router is, as Zenoh writes it: `tcp/10.0.0.1:7447`, `quic/10.0.0.1:7447`,
    /// `unixsock-stream//run/zenoh.sock`. What the file states, where absent.
    pub router: Option<String>,
    /// Zenoh configuration file.
    pub file: Option<PathBuf>,
}

/// Why there is no session, or why it does not do what it should.
#[derive(Debug, thiserror::Error)]
pub enum NetError {
    /// File or address can never be a network: a sentence.
    #[error("{0}")]
    Place(String),
    /// A router cannot listen there.
    #[error("a router cannot listen at {place}: {reason}")]
    Listen {
        /// Where.
        place: String,
        /// What Zenoh states.
        reason: String,
    },
    /// No router answers.
    #[error("no router answers at {router}: {reason}")]
    NoRouter {
        /// Where it was looked for.
        router: String,
        /// What Zenoh states.
        reason: String,
    },
    /// Somebody of that name is there already.
    #[error("another gripd is there as {member}")]
    Taken {
        /// The name.
        member: String,
    },
    /// A gripper gives a reason instead of an answer.
    #[error("{member}: {reason}")]
    Declined {
        /// Which one.
        member: String,
        /// The reason.
        reason: String,
    },
    /// What a gripper answers is none.
    #[error("{member}: {reason}")]
    Unusable {
        /// Which one.
        member: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A gripper does not answer, or not in time.
    #[error("{member} does not answer")]
    Silent {
        /// Which one.
        member: String,
    },
    /// The session refuses something.
    #[error("the session refuses {key}: {reason}")]
    Refused {
        /// The name that was asked for.
        key: String,
        /// What Zenoh states.
        reason: String,
    },
}

impl Network {
    /// What the file states, as a `mode`, with the router's address at `place`, and with these keys.
    fn config(&self, mode: &str, place: &str, more: &[(&str, &str)]) -> Result<Config, NetError> {
        let mut config = match &self.file {
            None => Config::default(),
            Some(file) => Config::from_file(file).map_err(|reason| {
                let (file, reason) = (file.display(), short(&reason));
                NetError::Place(format!("{file}: no Zenoh configuration: {reason}"))
            })?,
        };
        match &self.router {
            Some(router) => check_endpoint(router)?,
            None if self.file.is_none() => {
                let text = "no router: say where one listens, for example tcp/10.0.0.1:7447, or name a Zenoh configuration file that does";
                return Err(NetError::Place(text.to_owned()));
            }
            None => refuse_tls(&config, place)?,
        }
        let endpoints = self.router.as_ref().map(|router| format!("[{router:?}]"));
        let fixed = [("scouting/multicast/enabled", "false"), ("scouting/gossip/enabled", "false")];
        let own = [("mode", mode)].into_iter().chain(fixed).chain(more.iter().copied());
        for (key, value) in own.chain(endpoints.as_deref().map(|endpoints| (place, endpoints))) {
            let wrong = |reason| no_endpoint(&self.name(), &short(&reason));
            config.insert_json5(key, value).map_err(wrong)?;
        }
        Ok(config)
    }

    /// The configuration of a session.
    fn client(&self) -> Result<Config, NetError> {
        let more = [("listen/endpoints", "[]"), ("transport/link/rx/max_message_size", LARGEST)];
        self.config("\"client\"", "connect/endpoints", &more)
    }

    /// Whether the configuration can be used at all; nothing is opened.
    ///
    /// # Errors
    /// [`NetError`] that trying again will not cure.
    pub fn check(&self) -> Result<(), NetError> {
        self.client().map(drop)
    }

    /// Opens a session. A router that goes away later is looked for again by the session itself.
    ///
    /// # Errors
    /// [`NetError::NoRouter`] where none answers now; the others will not go away.
    pub fn open(&self) -> Result<Session, NetError> {
        zenoh::open(self.client()?)
            .wait()
            .map_err(|reason| NetError::NoRouter { router: self.name(), reason: self.why(&reason) })
    }

    /// Zenoh states only in its log why it has reached nobody, and what is wrong with a certificate.
    fn why(&self, reason: &zenoh::Error) -> String {
        let mut text = short(reason);
        if text.starts_with("Unable to connect") {
            "is it running, and can it be reached from here?".clone_into(&mut text);
        }
        if self.router.as_ref().is_some_and(|router| router.starts_with("quic/")) {
            text += " If it is, look at the certificates: both sides need one of the same authority, and enable_mtls";
        }
        text
    }

    /// Where the router is, for people.
    #[must_use]
    pub fn name(&self) -> String {
        match (&self.router, &self.file) {
            (Some(router), _) => router.clone(),
            (None, Some(file)) => format!("the endpoints of {}", file.display()),
            (None, None) => "no endpoint".to_owned(),
        }
    }
}

/// A router in this process, at an endpoint such as `tcp/127.0.0.1:7447` or where a Zenoh configuration file states, which also holds
/// keys, certificates, how many may connect and who may do what: for tests, and where none is installed. It ends with the session.
///
/// # Errors
/// [`NetError::Place`], and [`NetError::Listen`] where it cannot listen there.
pub fn router(network: &Network) -> Result<Session, NetError> {
    let wrong = |reason: zenoh::Error| {
        let text = short(&reason);
        // It states the place twice, and in brackets.
        let reason = text.rsplit(": [").next().unwrap_or(&text).trim_end_matches(']').to_owned();
        NetError::Listen { place: network.name(), reason }
    };
    let more = [("transport/unicast/max_sessions", MOST_SESSIONS)];
    let more = if network.file.is_none() { &more[..] } else { &[] };
    let config = network.config("\"router\"", "listen/endpoints", more)?;
    // It only tries again, and says nothing, where it cannot connect.
    refuse_tls(&config, "connect/endpoints")?;
    zenoh::open(config).wait().map_err(wrong)
}

/// Whether this is an address, of a kind that is built in.
fn check_endpoint(text: &str) -> Result<(), NetError> {
    let endpoint: EndPoint = text.parse().map_err(|reason| no_endpoint(text, &short(&reason)))?;
    match endpoint.protocol().as_str() {
        "tcp" | "quic" | "unixsock-stream" => Ok(()),
        "tls" => Err(tls(text)),
        other => {
            let built = "is not built in, only tcp, quic and unixsock-stream are";
            Err(no_endpoint(text, &format!("{other} {built}")))
        }
    }
}

fn no_endpoint(router: &str, reason: &str) -> NetError {
    NetError::Place(format!(
        "router = {router}: {reason}; expected an endpoint such as tcp/10.0.0.1:7447"
    ))
}

/// Two threads use one connection of Zenoh's TLS at the same time (eclipse-zenoh/zenoh#2557).
fn tls(endpoint: &str) -> NetError {
    NetError::Place(format!(
        "{endpoint}: Zenoh's TLS can spoil memory; write quic/ in its place, here and at the router, with the same keys and certificates"
    ))
}

/// Refuses `tls/` among the endpoints under `key`: a list, or one for each mode.
fn refuse_tls(config: &Config, key: &str) -> Result<(), NetError> {
    let listed = config.get_json(key).ok();
    let listed = listed.and_then(|json| serde_json::from_str(&json).ok()).unwrap_or_default();
    let mut left = vec![listed];
    while let Some(value) = left.pop() {
        match value {
            Value::String(endpoint) if endpoint.starts_with("tls/") => {
                return Err(tls(&endpoint));
            }
            Value::Array(more) => left.extend(more),
            Value::Object(more) => left.extend(more.into_iter().map(|(_, more)| more)),
            _ => {}
        }
    }
    Ok(())
}

/// What Zenoh states, without the places in its source.
fn short(reason: &zenoh::Error) -> String {
    let text = reason.to_string();
    let sentence = text.split(" at /").next().unwrap_or_default();
    sentence.trim_end_matches(['!', '.', ' ']).to_owned()
}

fn refused(key: &str) -> impl FnOnce(zenoh::Error) -> NetError + use<> {
    let key = key.to_owned();
    move |reason| NetError::Refused { key, reason: short(&reason) }
}

/// Messages above this (bytes) are dropped: more than any of ours has, and less than what one stranger can fill a memory with (Zenoh: 1 GiB).
const LARGEST: &str = "4194304";
/// Sessions of a router that has no file (Zenoh: 1000).
const MOST_SESSIONS: &str = "10000";

/// Patience with answers over the network.
pub const PATIENCE: Duration = Duration::from_secs(3);
