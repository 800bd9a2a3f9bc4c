//! A session in, the grippers that are there now and what each says of itself out.

use super::{NetError, PATIENCE, refused};
use crate::{
    key::{Member, Part, Selector},
    message::Message,
};
use grip_link::message::daemon::{Gripper, Health, State, ToClient};
use std::collections::BTreeMap;
use zenoh::{Session, Wait as _, query::ConsolidationMode, sample::Sample};

/// One gripper that is there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Listed {
    /// What it is; absent where it did not answer.
    pub gripper: Option<Gripper>,
    /// What its pipeline thinks.
    pub state: Option<State>,
    /// Figures of its daemon.
    pub health: Option<Health>,
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

/// Everybody who is there, in the order of site and identity.
///
/// # Errors
/// [`NetError::Refused`].
pub fn list(session: &Session, selector: &Selector) -> Result<BTreeMap<Member, Listed>, NetError> {
    let mut listed = BTreeMap::new();
    let key = selector.key(Part::Alive);
    let alive = session.liveliness().get(&key).timeout(PATIENCE).wait().map_err(refused(&key))?;
    for sample in alive.iter().filter_map(|reply| reply.into_result().ok()) {
        if let Some((member, _)) = Member::parse(sample.key_expr().as_str()) {
            listed.entry(member).or_insert_with(Listed::default);
        }
    }
    let key = selector.key(Part::Status);
    let asked = session.get(&key).consolidation(ConsolidationMode::None).timeout(PATIENCE);
    let answers = asked.wait().map_err(refused(&key))?;
    for sample in answers.iter().filter_map(|reply| reply.into_result().ok()) {
        if let Some((listed, message)) = answer(&mut listed, &sample)
            && let Ok(message) = message.read()
        {
            listed.take(&message);
        }
    }
    Ok(listed)
}

/// Whose answer, and what it says.
fn answer<'a>(
    listed: &'a mut BTreeMap<Member, Listed>,
    sample: &Sample,
) -> Option<(&'a mut Listed, Message)> {
    let (member, _) = Member::parse(sample.key_expr().as_str())?;
    let message = Message::from_wire(&sample.payload().to_bytes()).ok()?;
    Some((listed.entry(member).or_default(), message))
}
