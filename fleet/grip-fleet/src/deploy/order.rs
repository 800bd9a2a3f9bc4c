//! An order about models as parameters and a payload of a question, and back.

use super::{Origin, Refused, digest, history::reason};
use std::sync::Arc;

/// What can be ordered.
const KNOWN: &str = "check, replay, shadow, take, watch, accept, back, pause, resume and history";

/// A model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Offer {
    /// The name of its file, for people.
    pub name: String,
    /// SHA-256 that its file should have.
    pub sha256: String,
    /// Its trial ends where nobody watches it for so long (s), 1 to 86400.
    pub lease_s: u32,
    /// Which roll-out it belongs to.
    pub origin: Origin,
    /// Its file, shared by all who are offered it.
    pub bytes: Arc<[u8]>,
}

/// What a gripper is asked about its models.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// How do they stand?
    Notify,
    /// Would you take this one?
    Check(Offer),
    /// What do your own recordings show of this one?
    Replay(Offer),
    /// Let this one estimate beside the model in force.
    Shadow(Offer),
    /// Take this one and try it.
    Take(Offer),
    /// How does the trial of this one go, or its work as a shadow? It goes on for another lease.
    Watch {
        /// SHA-256 of its file.
        sha256: String,
        /// Grasps that are known already.
        from: usize,
    },
    /// Keep this one.
    Accept {
        /// SHA-256 of its file.
        sha256: String,
    },
    /// Give this one back, or whichever is in force.
    Back {
        /// SHA-256 of its file.
        sha256: Option<String>,
        /// Why, for the history.
        why: Option<String>,
    },
    /// Let roll-outs pause here: no model begins, and no grasp of one counts.
    Pause {
        /// Who orders it.
        by: String,
    },
    /// Let them go on.
    Resume,
    /// Which roll-outs were there?
    History,
}

impl Order {
    /// The names and values behind the key of the question; the file of an [`Offer`] goes beside them.
    #[must_use]
    pub fn parameters(&self) -> Vec<(&'static str, String)> {
        let order = |name: &str| ("order", name.to_owned());
        match self {
            Self::Notify => Vec::new(),
            Self::Back { sha256, why } => {
                let sha256 = sha256.iter().map(|sha256| ("sha256", sha256.clone()));
                let why = why.iter().map(|why| ("why", reason(why)));
                [order("back")].into_iter().chain(sha256).chain(why).collect()
            }
            Self::Pause { by } => vec![order("pause"), ("by", Origin::new(by, 0, 0).by)],
            Self::Resume => vec![order("resume")],
            Self::History => vec![order("history")],
            Self::Watch { sha256, from } => {
                vec![order("watch"), ("sha256", sha256.clone()), ("from", from.to_string())]
            }
            Self::Accept { sha256 } => vec![order("accept"), ("sha256", sha256.clone())],
            Self::Check(offer) => offer.parameters("check"),
            Self::Replay(offer) => offer.parameters("replay"),
            Self::Shadow(offer) => offer.parameters("shadow"),
            Self::Take(offer) => offer.parameters("take"),
        }
    }

    /// The file that goes with it; empty, where none does.
    #[must_use]
    pub fn payload(&self) -> &[u8] {
        match self {
            Self::Check(offer) | Self::Replay(offer) | Self::Shadow(offer) | Self::Take(offer) => {
                &offer.bytes
            }
            _ => &[],
        }
    }

    /// Reads an order.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn read(
        parameter: impl Fn(&str) -> Option<String>,
        bytes: Vec<u8>,
    ) -> Result<Self, Refused> {
        let order = parameter("order").unwrap_or_default();
        match order.as_str() {
            "" => Ok(Self::Notify),
            "back" => {
                let why = parameter("why").map(|why| reason(&why));
                Ok(Self::Back { sha256: parameter("sha256"), why })
            }
            "pause" => {
                let by = parameter("by").unwrap_or_default();
                Ok(Self::Pause { by: Origin::new(&by, 0, 0).by })
            }
            "resume" => Ok(Self::Resume),
            "history" => Ok(Self::History),
            "watch" => {
                let sha256 = text(&parameter, "watch", "sha256")?;
                Ok(Self::Watch { sha256, from: number(&parameter, "watch", "from")? })
            }
            "accept" => Ok(Self::Accept { sha256: text(&parameter, "accept", "sha256")? }),
            "check" => Ok(Self::Check(Offer::read(&parameter, "check", bytes)?)),
            "replay" => Ok(Self::Replay(Offer::read(&parameter, "replay", bytes)?)),
            "shadow" => Ok(Self::Shadow(Offer::read(&parameter, "shadow", bytes)?)),
            "take" => Ok(Self::Take(Offer::read(&parameter, "take", bytes)?)),
            other => {
                let other: String = other.chars().take(20).collect();
                Err(Refused(format!("order={other} is not known; there are {KNOWN}")))
            }
        }
    }
}

impl Offer {
    /// A model file of that name, whose trial ends where nobody watches it for `lease_s`.
    #[must_use]
    pub fn new(name: String, bytes: Vec<u8>, lease_s: u32) -> Self {
        let sha256 = digest(&bytes);
        Self { name, sha256, lease_s, origin: Origin::default(), bytes: bytes.into() }
    }

    fn parameters(&self, order: &'static str) -> Vec<(&'static str, String)> {
        let Self { name, sha256, lease_s, origin, .. } = self;
        let Origin { by, rollout_ns, stage } = origin;
        vec![
            ("order", order.to_owned()),
            ("sha256", sha256.clone()),
            ("name", name.chars().filter(|letter| !";=#?&".contains(*letter)).collect()),
            ("lease", lease_s.to_string()),
            ("by", Origin::new(by, 0, 0).by),
            ("rollout", rollout_ns.to_string()),
            ("stage", stage.to_string()),
        ]
    }

    fn read(
        parameter: &impl Fn(&str) -> Option<String>,
        order: &'static str,
        bytes: Vec<u8>,
    ) -> Result<Self, Refused> {
        let whole = |name| parameter(name).and_then(|text| text.parse().ok()).unwrap_or_default();
        let stage = u32::try_from(whole("stage")).unwrap_or_default();
        let by = parameter("by").unwrap_or_default();
        Ok(Self {
            origin: Origin::new(&by, whole("rollout"), stage),
            name: parameter("name").unwrap_or_default(),
            sha256: text(parameter, order, "sha256")?,
            lease_s: number(parameter, order, "lease")?,
            bytes: bytes.into(),
        })
    }
}

fn number<T: core::str::FromStr>(
    parameter: &impl Fn(&str) -> Option<String>,
    order: &'static str,
    name: &'static str,
) -> Result<T, Refused> {
    let got = text(parameter, order, name)?;
    got.parse().map_err(|_| wrong(order, name, &got))
}

fn text(
    parameter: &impl Fn(&str) -> Option<String>,
    order: &'static str,
    name: &'static str,
) -> Result<String, Refused> {
    parameter(name).ok_or_else(|| wrong(order, name, "nothing"))
}

/// A parameter is missing or no number.
fn wrong(order: &str, name: &str, got: &str) -> Refused {
    Refused(format!("an order to {order} a model needs {name}=, and got {got}"))
}

#[cfg(test)]
mod tests {
    use super::{Offer, Order, Origin};

    fn read(parameters: &[(&str, String)], bytes: &[u8]) -> Result<Order, String> {
        let found = |name: &str| {
            parameters.iter().find(|(known, _)| *known == name).map(|(_, value)| value.clone())
        };
        Order::read(found, bytes.to_vec()).map_err(|error| error.to_string())
    }

    #[test]
    fn orders_are_read_as_they_are_written() {
        let (name, sha256) = ("m.json".to_owned(), "ab".to_owned());
        let (sha, origin, bytes) = (sha256.clone(), Origin::new("bob", 17, 2), [1, 2].into());
        let offer = Offer { name, sha256: sha, lease_s: 12, origin, bytes };
        for order in [
            Order::Notify,
            Order::Back { sha256: None, why: None },
            Order::Back { sha256: Some(sha256.clone()), why: Some("it is worse".to_owned()) },
            Order::Pause { by: "alice".to_owned() },
            Order::Resume,
            Order::History,
            Order::Watch { sha256: sha256.clone(), from: 7 },
            Order::Accept { sha256 },
            Order::Check(offer.clone()),
            Order::Replay(offer.clone()),
            Order::Shadow(offer.clone()),
            Order::Take(offer),
        ] {
            assert_eq!(read(&order.parameters(), order.payload()).as_ref(), Ok(&order));
        }
    }

    #[test]
    fn what_is_no_order_is_reported() {
        for (parameters, reported) in [
            (
                &[("order", "take"), ("lease", "9")][..],
                "an order to take a model needs sha256=, and got nothing",
            ),
            (
                &[("order", "check"), ("sha256", "ab")],
                "an order to check a model needs lease=, and got nothing",
            ),
            (
                &[("order", "take"), ("sha256", "ab"), ("lease", "-1")],
                "an order to take a model needs lease=, and got -1",
            ),
            (
                &[("order", "watch"), ("sha256", "ab")],
                "an order to watch a model needs from=, and got nothing",
            ),
            (&[("order", "accept")], "an order to accept a model needs sha256=, and got nothing"),
            (
                &[("order", "drop")],
                "order=drop is not known; there are check, replay, shadow, take, watch, accept, back, pause, resume and history",
            ),
        ] {
            let parameters: Vec<_> =
                parameters.iter().map(|(name, value)| (*name, (*value).to_owned())).collect();
            assert_eq!(read(&parameters, &[]).unwrap_err(), reported);
        }
    }
}
