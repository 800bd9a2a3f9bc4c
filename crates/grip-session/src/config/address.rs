//! Checked addresses and identities, from texts such as `tcp:127.0.0.1:7747`.

use core::{fmt, net::SocketAddr, str::FromStr};
use serde::{Deserialize, Deserializer, Serialize};
use std::path::PathBuf;

/// Where clients may connect: `tcp:IP:PORT`, `unix:PATH` or `off`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Listen {
    /// Nowhere.
    Off,
    /// A TCP port.
    Tcp(SocketAddr),
    /// A socket in the file system.
    Unix(PathBuf),
}

/// Why a text is no address, identity or template.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    /// Neither `tcp:`, `unix:` nor `off`.
    #[error(
        "`{0}` is no address: expected tcp:IP:PORT such as tcp:127.0.0.1:7747, unix:PATH or off"
    )]
    Listen(String),
    /// No IP address with a port.
    #[error("`{0}` is no address: expected IP:PORT, for example 127.0.0.1:9747")]
    Socket(String),
    /// Not 32 hexadecimal digits.
    #[error("`{0}` is no identity: expected 32 hexadecimal digits")]
    Uid(String),
    /// Not one word.
    #[error("`{0}` is no name of a site: expected 1 to 64 letters, digits, -, _ and .")]
    Site(String),
}

impl Listen {
    /// Where gripd listens by default.
    pub const DEFAULT: &'static str = "tcp:127.0.0.1:7747";

    /// Whether another computer could connect.
    #[must_use]
    pub fn is_remote(&self) -> bool {
        matches!(self, Self::Tcp(address) if !address.ip().to_canonical().is_loopback())
    }
}

impl Default for Listen {
    fn default() -> Self {
        Self::Tcp(SocketAddr::from(([127, 0, 0, 1], 7747)))
    }
}

impl FromStr for Listen {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        let wrong = || AddressError::Listen(text.to_owned());
        match text.split_once(':') {
            None if text == "off" => Ok(Self::Off),
            Some(("tcp", address)) => {
                let address = address.replacen("localhost:", "127.0.0.1:", 1);
                address.parse().map(Self::Tcp).map_err(|_| wrong())
            }
            Some(("unix", path)) if !path.is_empty() => Ok(Self::Unix(path.into())),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for Listen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => write!(f, "off"),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

/// What stands as a text in files and messages.
macro_rules! as_text {
    ($($type:ident)+) => {$(
        impl TryFrom<String> for $type {
            type Error = AddressError;

            fn try_from(text: String) -> Result<Self, AddressError> {
                text.parse()
            }
        }

        impl From<$type> for String {
            fn from(value: $type) -> Self {
                value.to_string()
            }
        }
    )+};
}

as_text!(Listen Uid Site);

/// An `IP:PORT` that may be absent.
pub(super) fn socket<'de, D: Deserializer<'de>>(from: D) -> Result<Option<SocketAddr>, D::Error> {
    let text = String::deserialize(from)?;
    text.parse().map(Some).map_err(|_| serde::de::Error::custom(AddressError::Socket(text)))
}

/// The identity of a gripper: 16 bytes, written as 32 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Uid(pub [u8; 16]);

impl FromStr for Uid {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        let digits = text.len() == 32 && text.bytes().all(|digit| digit.is_ascii_hexdigit());
        let number = digits.then(|| u128::from_str_radix(text, 16).ok()).flatten();
        number
            .map(|number| Self(number.to_be_bytes()))
            .ok_or_else(|| AddressError::Uid(text.to_owned()))
    }
}

impl fmt::Display for Uid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Where grippers stand together: a plant, a laboratory. One word of 1 to 64 letters, digits, `-`, `_` and `.`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Site(String);

impl Site {
    /// Longest name (bytes).
    const LONGEST: usize = 64;
}

impl FromStr for Site {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        let fits = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
        let long = text.is_empty() || text.len() > Self::LONGEST;
        // Sites are folders where recordings are collected.
        let dots = text.bytes().all(|byte| byte == b'.');
        if long || dots || !text.bytes().all(fits) {
            return Err(AddressError::Site(text.to_owned()));
        }
        Ok(Self(text.to_owned()))
    }
}

impl fmt::Display for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{Listen, Site, Uid};

    #[test]
    fn a_site_is_one_word() {
        assert_eq!("hall-2.east".parse::<Site>().unwrap().to_string(), "hall-2.east");
        for wrong in
            ["..", ".", "", "a/b", "*", "a b", "a$", "#", "hall?", "größe", &"x".repeat(65)]
        {
            assert!(wrong.parse::<Site>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn addresses_are_read_as_they_are_written() {
        for text in ["off", "tcp:127.0.0.1:7747", "tcp:[::1]:7747", "unix:/run/gripd/gripd.sock"] {
            assert_eq!(text.parse::<Listen>().unwrap().to_string(), text);
        }
        for text in ["", "on", "tcp:", "tcp:7747", "tcp:robot:7747", "unix:", "udp:1.2.3.4:5"] {
            assert!(text.parse::<Listen>().is_err(), "{text}");
        }
        assert_eq!("tcp:localhost:1".parse(), "tcp:127.0.0.1:1".parse::<Listen>());
        assert_eq!(Listen::DEFAULT.parse(), Ok(Listen::default()));
    }

    #[test]
    fn what_other_computers_can_reach_is_remote() {
        let remote = |text: &str| text.parse::<Listen>().unwrap().is_remote();
        for text in ["tcp:0.0.0.0:1", "tcp:[::]:1", "tcp:192.168.1.2:1"] {
            assert!(remote(text), "{text}");
        }
        for text in ["tcp:127.3.0.1:1", "tcp:[::1]:1", "tcp:[::ffff:127.0.0.1]:1", "unix:x", "off"]
        {
            assert!(!remote(text), "{text}");
        }
    }

    #[test]
    fn an_identity_has_32_digits() {
        let text = "00112233445566778899aabbccddeeff";
        let uid: Uid = text.parse().unwrap();
        assert_eq!((uid.0[0], uid.0[15], uid.to_string().as_str()), (0, 0xFF, text));
        for wrong in ["..", ".", "", "00", "+0112233445566778899aabbccddeeff", &text[1..]] {
            assert!(wrong.parse::<Uid>().is_err(), "{wrong}");
        }
    }
}
