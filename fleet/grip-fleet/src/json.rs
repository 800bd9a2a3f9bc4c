//! The JSON object that stands for a message of one gripper on the network, in lines of gripfleet and in the archive.

use crate::{id::Stamp, key::Member, message::Message};
use grip_link::message::daemon::ToClient;
use grip_session::status::{EventReport, HealthReport};
use serde::Serialize;
use serde_json::{Error, Map, Value};

/// What stands for a message; its fields stand beside those of [`object`].
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Body {
    Event(EventReport),
    Other(Other),
}

#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Other {
    Health(HealthReport),
    /// Of a kind that a later daemon has: its number counts all the same.
    Unknown {},
}

/// The object of a message: `site`, `uid`, the number of the event (or of the last event, for what is none) as `id`, `run` and `seq`, where it is
/// known `unix_ns` and `error_us`, `type` and its fields. What has no value is absent.
///
/// # Errors
/// Where the serialiser fails; no message makes it.
pub fn of_message(member: &Member, stamp: Stamp, message: &Message) -> Result<String, Error> {
    let read = message.read();
    let body = match read.as_ref().map(|message| (EventReport::of(message), message)) {
        Ok((Some(event), _)) => Body::Event(event),
        Ok((None, ToClient::Health(health))) => {
            Body::Other(Other::Health(HealthReport::of(health)))
        }
        _ => Body::Other(Other::Unknown {}),
    };
    serde_json::to_string(&object(member, Some(stamp), &body)?)
}

/// Puts beside the fields of `what` whose it is and, with a stamp, its number and time.
///
/// # Errors
/// Where `what` is no object, or cannot be serialised.
pub fn object(
    member: &Member,
    stamp: Option<Stamp>,
    what: &impl Serialize,
) -> Result<Map<String, Value>, Error> {
    // Through text: a single of seven digits keeps these.
    let mut object: Map<String, Value> = serde_json::from_str(&serde_json::to_string(what)?)?;
    object.retain(|_, value| !value.is_null());
    let mut put = |name: &str, value: Value| object.insert(name.to_owned(), value);
    put("site", member.site.to_string().into());
    put("uid", member.uid.to_string().into());
    if let Some(Stamp { id, at }) = stamp {
        put("id", id.to_string().into());
        put("run", format!("{:08x}", id.run).into());
        put("seq", id.seq.into());
        if at.ns > 0 {
            put("unix_ns", at.ns.into());
            put("error_us", at.error_us.into());
        }
    }
    Ok(object)
}
