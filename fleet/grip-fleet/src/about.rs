//! What a gripper and its daemon are made of, as they report it to those who ask: JSON in and out.

use serde::{Deserialize, Serialize};

/// The answer of one gripper's daemon. A later one may show more; what is not known is not read.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct About {
    /// Name and version of the daemon.
    pub program: String,
    /// Version of the gripper's firmware; absent while none has answered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub firmware: Option<String>,
    /// The model that estimates the force: a file, or the name of a built-in one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::About;

    #[test]
    fn what_is_reported_comes_back_and_what_a_later_daemon_reports_is_left_alone() {
        let about = About {
            program: "gripd 0.1.0".to_owned(),
            firmware: Some("1.2.3".to_owned()),
            model: None,
        };
        let text = serde_json::to_string(&about).unwrap();
        assert_eq!(text, r#"{"program":"gripd 0.1.0","firmware":"1.2.3"}"#);
        let later = text.replace("{\"program", "{\"colour\":[1],\"program");
        assert_eq!(serde_json::from_str::<About>(&later).unwrap(), about);
        assert!(serde_json::from_str::<About>("{}").is_err());
    }
}
