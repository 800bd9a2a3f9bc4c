//! List of the grippers that are there now, over a session, and what each reports of itself.

use super::{NetError, PATIENCE, refused};
use crate::{
    about::About,
    key::{Member, Part, Selector},
    message::Message,
};
use grip_link::message::daemon::{Gripper, Health, PipelineState, ToClient};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::mpsc::channel,
};
use zenoh::{
    Session, Wait as _,
    query::{ConsolidationMode, Reply},
    sample::Sample,
};

/// One gripper that is there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Listed {
    /// What it is; absent where it did not answer.
    pub gripper: Option<Gripper>,
    /// What its pipeline thinks.
    pub state: Option<PipelineState>,
    /// Figures of its daemon.
    pub health: Option<Health>,
    /// What it is made of.
    pub about: Option<About>,
}

impl Listed {
    /// Takes one of its messages; the others are not for here.
    pub fn take(&mut self, message: &ToClient<'_>) {
        match message {
            ToClient::Gripper(gripper) => self.gripper = Some(*gripper),
            ToClient::State(state) => self.state = Some(*state),
            ToClient::Health(health) => self.health = Some(*health),
            _ => {}
        }
    }
}

/// Asks what grippers are made of and does not wait: each answer goes to `received`, on a thread of the session. What cannot be read, or does not
/// come, shows nothing.
///
/// # Errors
/// [`NetError::Refused`].
pub fn ask_about(
    session: &Session,
    selector: &Selector,
    received: impl Fn(Member, About) + Send + Sync + 'static,
) -> Result<(), NetError> {
    let key = selector.key(Part::About);
    let take = move |reply: Reply| {
        if let Ok(sample) = reply.into_result()
            && let Some((member, Part::About)) = Member::parse(sample.key_expr().as_str())
            && let Ok(about) = serde_json::from_slice(&sample.payload().to_bytes())
        {
            received(member, about);
        }
    };
    let asked = session.get(&key).consolidation(ConsolidationMode::None).timeout(PATIENCE);
    asked.callback(take).wait().map_err(refused(&key))
}

/// Everybody who is there, in the order of site and identity; nobody is asked anything.
///
/// # Errors
/// [`NetError::Refused`].
pub fn members(session: &Session, selector: &Selector) -> Result<BTreeSet<Member>, NetError> {
    let key = selector.key(Part::Alive);
    let alive = session.liveliness().get(&key).timeout(PATIENCE).wait().map_err(refused(&key))?;
    let alive = alive.iter().filter_map(|reply| reply.into_result().ok());
    Ok(alive.filter_map(|sample| Some(Member::parse(sample.key_expr().as_str())?.0)).collect())
}

/// Everybody who is there, in the order of site and identity, and what each reports of itself.
///
/// # Errors
/// [`NetError::Refused`].
pub fn list(session: &Session, selector: &Selector) -> Result<BTreeMap<Member, Listed>, NetError> {
    let alive = members(session, selector)?.into_iter();
    let mut listed: BTreeMap<_, _> = alive.map(|member| (member, Listed::default())).collect();
    // Both questions at once: who does not answer costs the patience for one. Zenoh's own queue of answers is short, and a full one would hold back the
    // answers to the other question.
    let (sender, answers) = channel();
    for part in [Part::Status, Part::About] {
        let (key, sender) = (part.question(&selector.key(part)), sender.clone());
        let take = move |reply: Reply| {
            if let Ok(sample) = reply.into_result() {
                // Whoever asked waits for the end of all answers.
                let _gone = sender.send(sample);
            }
        };
        let asked = session.get(&key).consolidation(ConsolidationMode::None).timeout(PATIENCE);
        asked.callback(take).wait().map_err(refused(&key))?;
    }
    drop(sender);
    for sample in answers {
        answer(&mut listed, &sample);
    }
    Ok(listed)
}

/// Takes an answer; what cannot be read shows nothing of its gripper.
fn answer(listed: &mut BTreeMap<Member, Listed>, sample: &Sample) {
    let Some((member, part)) = Member::parse(sample.key_expr().as_str()) else { return };
    let listed = listed.entry(member).or_default();
    let bytes = sample.payload().to_bytes();
    if part == Part::About {
        listed.about = serde_json::from_slice(&bytes).ok();
    } else if let Ok(message) = Message::from_wire(&bytes)
        && let Ok(message) = message.read()
    {
        listed.take(&message);
    }
}
