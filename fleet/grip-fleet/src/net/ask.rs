//! Question to one gripper, and the parts of its answer.

use super::{NetError, refused};
use crate::key::{Member, Part};
use core::time::Duration;
use std::thread;
use zenoh::{Session, Wait as _, query::ConsolidationMode};

/// Something that one gripper is asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ask<'a> {
    /// Whom.
    pub member: &'a Member,
    /// For what.
    pub part: Part,
    /// Names and values behind the key; without `;`, `=` and `#`.
    pub parameters: &'a [(&'a str, String)],
    /// What comes with it.
    pub payload: &'a [u8],
    /// How long an answer may take.
    pub patience: Duration,
}

/// Times that a question which reaches nobody is asked, and the pause before each further one: a router needs a moment to learn that a
/// gripper has come.
const TIMES: usize = 20;
const PAUSE: Duration = Duration::from_millis(100);
/// What Zenoh answers itself where an answer takes too long.
const TIMEOUT: &str = "Timeout";

/// The parts of the answer, in their order. A question that reaches nobody is asked again for two seconds, but for a command: one whose
/// answer is lost on the way must not move fingers twice.
///
/// # Errors
/// [`NetError::Declined`] where the gripper gives a reason instead, [`NetError::Silent`] where nothing comes in time, and
/// [`NetError::Refused`].
pub fn ask(session: &Session, ask: &Ask<'_>) -> Result<Vec<Vec<u8>>, NetError> {
    let times = if ask.part == Part::Command { 1 } else { TIMES };
    for _ in 0..times {
        let parts = once(session, ask)?;
        if !parts.is_empty() {
            return Ok(parts);
        }
        thread::park_timeout(PAUSE);
    }
    Err(NetError::Silent { member: ask.member.to_string() })
}

/// Asks once; nothing where nobody was reached.
fn once(session: &Session, ask: &Ask<'_>) -> Result<Vec<Vec<u8>>, NetError> {
    let key = ask.member.key(ask.part);
    let words: Vec<String> =
        ask.parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let question = format!("{key}?{}", words.join(";"));
    let answers = session
        .get(&question)
        .payload(ask.payload)
        // Parts of one answer have one name, and all of them count.
        .consolidation(ConsolidationMode::None)
        .timeout(ask.patience)
        .wait()
        .map_err(refused(&key))?;
    let mut parts = Vec::new();
    for reply in answers {
        match reply.into_result() {
            Ok(sample) => parts.push(sample.payload().to_bytes().into_owned()),
            Err(error) => {
                let member = ask.member.to_string();
                let reason = String::from_utf8_lossy(&error.payload().to_bytes()).into_owned();
                return Err(match reason.as_str() {
                    TIMEOUT => NetError::Silent { member },
                    _ => NetError::Declined { member, reason },
                });
            }
        }
    }
    Ok(parts)
}
