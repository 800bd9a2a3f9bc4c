//! An order about models as parameters and a payload of a question, and back.

use crate::rollout::JudgeConfig;

/// What a gripper is asked about its models.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// How do they stand?
    Tell,
    /// Take this one and try it.
    Take {
        /// The name of its file, for people.
        name: String,
        /// SHA-256 that its file should have.
        sha256: String,
        /// When it is worse.
        judge: JudgeConfig,
        /// Its file.
        bytes: Vec<u8>,
    },
    /// Give this one back.
    Back {
        /// SHA-256 of its file.
        sha256: String,
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
    #[error("order={0} is not known; there are take and back")]
    Unknown(String),
}

impl Order {
    /// The names and values behind the key of the question; the payload of [`Order::Take`] goes beside them.
    #[must_use]
    pub fn parameters(&self) -> Vec<(&'static str, String)> {
        match self {
            Self::Tell => Vec::new(),
            Self::Back { sha256 } => vec![("order", "back".to_owned()), ("sha256", sha256.clone())],
            Self::Take { name, sha256, judge, .. } => vec![
                ("order", "take".to_owned()),
                ("sha256", sha256.clone()),
                ("name", name.chars().filter(|letter| !";=#?&".contains(*letter)).collect()),
                ("watch", judge.watch_s.to_string()),
                ("factor", judge.factor.to_string()),
                ("alpha", judge.alpha.to_string()),
            ],
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
        let text = |order, name| {
            let missing = || OrderError::Parameter { order, name, got: "nothing".to_owned() };
            parameter(name).ok_or_else(missing)
        };
        let number = |name| {
            let got = text("take", name)?;
            got.parse().map_err(|_| OrderError::Parameter { order: "take", name, got })
        };
        match order.as_str() {
            "" => Ok(Self::Tell),
            "back" => Ok(Self::Back { sha256: text("give back", "sha256")? }),
            "take" => Ok(Self::Take {
                name: parameter("name").unwrap_or_default(),
                sha256: text("take", "sha256")?,
                judge: JudgeConfig {
                    factor: number("factor")?,
                    alpha: number("alpha")?,
                    watch_s: number("watch")?,
                },
                bytes,
            }),
            other => Err(OrderError::Unknown(other.chars().take(20).collect())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Order;
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
        let take = Order::Take { name, sha256: sha256.clone(), judge, bytes: vec![1, 2] };
        for order in [Order::Tell, Order::Back { sha256 }, take] {
            let bytes: &[u8] = if matches!(order, Order::Take { .. }) { &[1, 2] } else { &[] };
            assert_eq!(read(&order.parameters(), bytes).as_ref(), Ok(&order));
        }
    }

    #[test]
    fn what_is_no_order_is_told() {
        let parameter = |name, value: &str| (name, value.to_owned());
        let take = |name, value| [parameter("order", "take"), parameter(name, value)];
        let told = |parameters: &[(&'static str, String)]| read(parameters, &[]).unwrap_err();
        assert_eq!(told(&take("x", "")), "an order to take a model needs sha256=, and got nothing");
        let odd = [&take("factor", "a")[..], &[parameter("sha256", "ab")]].concat();
        assert_eq!(told(&odd), "an order to take a model needs factor=, and got a");
        assert_eq!(
            told(&[parameter("order", "drop")]),
            "order=drop is not known; there are take and back"
        );
        assert!(told(&[parameter("order", "back")]).contains("needs sha256="));
    }
}
