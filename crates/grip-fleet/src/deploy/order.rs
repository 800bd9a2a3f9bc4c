//! An order about models as parameters and a payload of a question, and back.

use crate::rollout::JudgeConfig;
use std::sync::Arc;

/// A model, and when it is worse than the one before.
#[derive(Clone, Debug, PartialEq)]
pub struct Offer {
    /// The name of its file, for people.
    pub name: String,
    /// SHA-256 that its file should have.
    pub sha256: String,
    /// When it is worse.
    pub judge: JudgeConfig,
    /// Its file, shared by all who are offered it.
    pub bytes: Arc<[u8]>,
}

/// What a gripper is asked about its models.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// How do they stand?
    Notify,
    /// Would you take this one?
    Check(Offer),
    /// Take this one and try it.
    Take(Offer),
    /// Give this one back, or whichever is in force.
    Back {
        /// SHA-256 of its file.
        sha256: Option<String>,
    },
}

/// Why a question is no order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OrderError {
    /// A parameter is missing or no number.
    #[error("an order to {order} a model needs {name}=, and got {got}")]
    Parameter {
        /// Which order.
        order: &'static str,
        /// Which parameter.
        name: &'static str,
        /// What came.
        got: String,
    },
    /// An order of another kind.
    #[error("order={0} is not known; there are check, take and back")]
    Unknown(String),
}

impl Order {
    /// The names and values behind the key of the question; the file of an [`Offer`] goes beside them.
    #[must_use]
    pub fn parameters(&self) -> Vec<(&'static str, String)> {
        match self {
            Self::Notify => Vec::new(),
            Self::Back { sha256 } => {
                let sha256 = sha256.clone().map(|sha256| ("sha256", sha256));
                [("order", "back".to_owned())].into_iter().chain(sha256).collect()
            }
            Self::Check(offer) => offer.parameters("check"),
            Self::Take(offer) => offer.parameters("take"),
        }
    }

    /// The file that goes with it; empty, where none does.
    #[must_use]
    pub fn payload(&self) -> &[u8] {
        match self {
            Self::Check(offer) | Self::Take(offer) => &offer.bytes,
            Self::Notify | Self::Back { .. } => &[],
        }
    }

    /// Reads an order.
    ///
    /// # Errors
    /// [`OrderError`], a sentence for whoever sent it.
    pub fn read(
        parameter: impl Fn(&str) -> Option<String>,
        bytes: Vec<u8>,
    ) -> Result<Self, OrderError> {
        let order = parameter("order").unwrap_or_default();
        match order.as_str() {
            "" => Ok(Self::Notify),
            "back" => Ok(Self::Back { sha256: parameter("sha256") }),
            "check" => Ok(Self::Check(Offer::read(&parameter, "check", bytes)?)),
            "take" => Ok(Self::Take(Offer::read(&parameter, "take", bytes)?)),
            other => Err(OrderError::Unknown(other.chars().take(20).collect())),
        }
    }
}

impl Offer {
    fn parameters(&self, order: &'static str) -> Vec<(&'static str, String)> {
        let Self { name, sha256, judge, .. } = self;
        vec![
            ("order", order.to_owned()),
            ("sha256", sha256.clone()),
            ("name", name.chars().filter(|letter| !";=#?&".contains(*letter)).collect()),
            ("watch", judge.watch_s.to_string()),
            ("factor", judge.factor.to_string()),
            ("alpha", judge.alpha.to_string()),
        ]
    }

    fn read(
        parameter: &impl Fn(&str) -> Option<String>,
        order: &'static str,
        bytes: Vec<u8>,
    ) -> Result<Self, OrderError> {
        let number = |name| {
            let got = text(parameter, order, name)?;
            got.parse().map_err(|_| OrderError::Parameter { order, name, got })
        };
        let (factor, alpha, watch_s) = (number("factor")?, number("alpha")?, number("watch")?);
        Ok(Self {
            name: parameter("name").unwrap_or_default(),
            sha256: text(parameter, order, "sha256")?,
            judge: JudgeConfig { factor, alpha, watch_s },
            bytes: bytes.into(),
        })
    }
}

fn text(
    parameter: &impl Fn(&str) -> Option<String>,
    order: &'static str,
    name: &'static str,
) -> Result<String, OrderError> {
    let missing = || OrderError::Parameter { order, name, got: "nothing".to_owned() };
    parameter(name).ok_or_else(missing)
}

#[cfg(test)]
mod tests {
    use super::{Offer, Order};
    use crate::rollout::JudgeConfig;

    fn read(parameters: &[(&str, String)], bytes: &[u8]) -> Result<Order, String> {
        let found = |name: &str| {
            parameters.iter().find(|(known, _)| *known == name).map(|(_, value)| value.clone())
        };
        Order::read(found, bytes.to_vec()).map_err(|error| error.to_string())
    }

    #[test]
    fn orders_are_read_as_they_are_written() {
        let judge = JudgeConfig { watch_s: 12.5, ..JudgeConfig::default() };
        let (name, sha256) = ("m.json".to_owned(), "ab".to_owned());
        let offer = Offer { name, sha256: sha256.clone(), judge, bytes: [1, 2].into() };
        let offers = [Order::Check(offer.clone()), Order::Take(offer)];
        let backs = [None, Some(sha256)].map(|sha256| Order::Back { sha256 });
        for order in [Order::Notify].into_iter().chain(backs).chain(offers) {
            assert_eq!(read(&order.parameters(), order.payload()).as_ref(), Ok(&order));
        }
    }

    #[test]
    fn what_is_no_order_is_reported() {
        let parameter = |name, value: &str| (name, value.to_owned());
        let take = |name, value| [parameter("order", "take"), parameter(name, value)];
        let numbers = [("factor", "2"), ("alpha", "0.1"), ("watch", "9")];
        let numbers = numbers.map(|(name, value)| parameter(name, value));
        let reported = |parameters: &[(&'static str, String)]| read(parameters, &[]).unwrap_err();
        let bare = [&take("x", "")[..], &numbers].concat();
        assert_eq!(reported(&bare), "an order to take a model needs sha256=, and got nothing");
        assert_eq!(
            reported(&[parameter("order", "check")]),
            "an order to check a model needs factor=, and got nothing"
        );
        let odd = [&take("factor", "a")[..], &[parameter("sha256", "ab")]].concat();
        assert_eq!(reported(&odd), "an order to take a model needs factor=, and got a");
        assert_eq!(
            reported(&[parameter("order", "drop")]),
            "order=drop is not known; there are check, take and back"
        );
    }
}
