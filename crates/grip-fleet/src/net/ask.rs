//! A question to one gripper in, the parts of its answer out.

use super::{NetError, refused};
use crate::key::{Member, Part};
use core::time::Duration;
use zenoh::{Session, Wait as _, query::ConsolidationMode};

/// Something that one gripper is asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ask<'a> {
    /// Whom.
    pub member: &'a Member,
    /// For what.
    pub part: Part,
    /// Names and values behind the key; without `;`, `=` and `#`.
    pub parameters: &'a [(&'a str, &'a str)],
    /// What comes with it.
    pub payload: &'a [u8],
    /// How long an answer may take.
    pub patience: Duration,
}

/// The parts of the answer, in their order.
///
/// # Errors
/// [`NetError::Declined`] where the gripper gives a reason instead, [`NetError::Silent`] where nothing comes in time, and
/// [`NetError::Refused`].
pub fn ask(session: &Session, ask: &Ask<'_>) -> Result<Vec<Vec<u8>>, NetError> {
    let member = || ask.member.to_string();
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
                let reason = String::from_utf8_lossy(&error.payload().to_bytes()).into_owned();
                return Err(NetError::Declined { member: member(), reason });
            }
        }
    }
    if parts.is_empty() { Err(NetError::Silent { member: member() }) } else { Ok(parts) }
}
