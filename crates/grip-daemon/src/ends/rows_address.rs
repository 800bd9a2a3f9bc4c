//! Checked addresses of rows, from texts such as `rows:tcp:127.0.0.1:7750`.

use core::{fmt, net::SocketAddr, str::FromStr};
use grip_session::config::Listen;

/// Where rows come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RowsAddress {
    /// Standard input.
    Stdin,
    /// The first program that connects here.
    Stream(Listen),
    /// The first program that sends a datagram here.
    Udp(SocketAddr),
}

/// Why a text is no address of rows.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no source of rows: expected rows:- (standard input), rows:tcp:IP:PORT, rows:unix:PATH or rows:udp:IP:PORT"
)]
pub struct RowsAddressError(String);

impl RowsAddress {
    /// The address that a port of the name `rows:ADDRESS` means; `None` where the name is that of another port.
    ///
    /// # Errors
    /// Where what follows `rows:` is no address.
    pub fn of_port(name: &str) -> Result<Option<Self>, RowsAddressError> {
        if name == "rows" || name.starts_with("rows:") { name.parse().map(Some) } else { Ok(None) }
    }

    /// Whether another computer could send rows.
    #[must_use]
    pub fn is_remote(&self) -> bool {
        match self {
            Self::Stdin => false,
            Self::Stream(listen) => listen.is_remote(),
            Self::Udp(address) => !address.ip().to_canonical().is_loopback(),
        }
    }
}

impl FromStr for RowsAddress {
    type Err = RowsAddressError;

    fn from_str(name: &str) -> Result<Self, RowsAddressError> {
        let wrong = || RowsAddressError(name.to_owned());
        let address = name.strip_prefix("rows:").ok_or_else(wrong)?;
        if address == "-" {
            return Ok(Self::Stdin);
        }
        if let Some(address) = address.strip_prefix("udp:") {
            let address = address.replacen("localhost:", "127.0.0.1:", 1);
            return address.parse().map(Self::Udp).map_err(|_| wrong());
        }
        match address.parse() {
            Ok(listen @ (Listen::Tcp(_) | Listen::Unix(_))) => Ok(Self::Stream(listen)),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for RowsAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stdin => write!(f, "standard input"),
            Self::Stream(listen) => write!(f, "{listen}"),
            Self::Udp(address) => write!(f, "udp:{address}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::RowsAddress;

    #[test]
    fn addresses() {
        let of = |name: &str| RowsAddress::of_port(name);
        assert_eq!(of("rows:-"), Ok(Some(RowsAddress::Stdin)));
        for (name, place, remote) in [
            ("rows:tcp:127.0.0.1:7750", "tcp:127.0.0.1:7750", false),
            ("rows:tcp:0.0.0.0:7750", "tcp:0.0.0.0:7750", true),
            ("rows:udp:localhost:9", "udp:127.0.0.1:9", false),
            ("rows:udp:[::]:9", "udp:[::]:9", true),
            ("rows:unix:/run/rows", "unix:/run/rows", false),
        ] {
            let address = of(name).unwrap().unwrap();
            assert_eq!((address.to_string().as_str(), address.is_remote()), (place, remote));
        }
        for name in
            ["rows", "rows:", "rows:off", "rows:tcp:7750", "rows:udp:x", "rows:/dev/ttyACM0"]
        {
            assert!(of(name).is_err(), "{name}");
        }
        assert_eq!(of("/dev/rows"), Ok(None));
    }
}
