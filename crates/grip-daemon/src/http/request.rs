//! Parser of the bytes that came so far: what is asked for, or why it is refused.

use core::net::IpAddr;
use std::borrow::Cow;

/// What the bytes are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parsed<'a> {
    /// The beginning of a request.
    Incomplete,
    /// A request for the page at `path`, without its query; `head` where only the header is wanted.
    Page {
        /// The path, from its `/`.
        path: &'a str,
        /// HEAD instead of GET.
        head: bool,
        /// Whether it is for this computer by every Host that it names, if any, and from a page of this computer by every Origin: a page
        /// of a foreign name that was made to lead here by DNS is not.
        local: bool,
    },
    /// Nothing that can be answered with a page.
    Refused(Refusal),
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// 400: this is not HTTP/1.
    BadRequest,
    /// 404: there is no such page.
    NotFound,
    /// 405: neither GET nor HEAD.
    Method,
    /// 408: the request took too long.
    Timeout,
    /// 421: the request is for another computer.
    Misdirected,
    /// 431: the request is too long.
    TooLarge,
    /// 500: the page could not be made.
    Internal,
    /// 503: too many connections, or not in good health.
    Unavailable,
    /// 505: another version of HTTP.
    Version,
}

/// What is answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Content {
    /// Media type.
    pub media_type: &'static str,
    /// The text, or its beginning.
    pub text: Cow<'static, str>,
    /// Whether more follows, until the client hangs up.
    pub more: bool,
}

impl Content {
    /// A text that is complete.
    pub fn whole(media_type: &'static str, text: impl Into<Cow<'static, str>>) -> Self {
        Self { media_type, text: text.into(), more: false }
    }
}

/// What is answered, or why nothing is.
pub type Page = Result<Content, Refusal>;

impl Refusal {
    /// Status code and its usual words.
    #[must_use]
    pub fn status(self) -> (u16, &'static str) {
        match self {
            Self::BadRequest => (400, "Bad Request"),
            Self::NotFound => (404, "Not Found"),
            Self::Method => (405, "Method Not Allowed"),
            Self::Timeout => (408, "Request Timeout"),
            Self::Misdirected => (421, "Misdirected Request"),
            Self::TooLarge => (431, "Request Header Fields Too Large"),
            Self::Internal => (500, "Internal Server Error"),
            Self::Unavailable => (503, "Service Unavailable"),
            Self::Version => (505, "HTTP Version Not Supported"),
        }
    }
}

/// More fields than any browser or Prometheus sends.
const MOST_FIELDS: usize = 64;

/// Reads a request up to the empty line that ends its header. A body, where there is one, is not looked at.
#[must_use]
pub fn parse(bytes: &[u8]) -> Parsed<'_> {
    let mut fields = [httparse::EMPTY_HEADER; MOST_FIELDS];
    let mut request = httparse::Request::new(&mut fields);
    let asked = match request.parse(bytes) {
        Ok(status) if status.is_partial() => return Parsed::Incomplete,
        Ok(_) => wanted(request.method, request.path),
        Err(httparse::Error::Version) => Err(Refusal::Version),
        Err(httparse::Error::TooManyHeaders) => Err(Refusal::TooLarge),
        Err(_) => Err(Refusal::BadRequest),
    };
    let local = request.headers.iter().all(|field| {
        let value = str::from_utf8(field.value);
        match field.name {
            name if name.eq_ignore_ascii_case("host") => value.is_ok_and(is_local),
            name if name.eq_ignore_ascii_case("origin") => value.is_ok_and(|page| {
                page.split_once("://").is_some_and(|(_, host)| !host.is_empty() && is_local(host))
            }),
            _ => true,
        }
    });
    asked.map_or_else(Parsed::Refused, |(path, head)| Parsed::Page { path, head, local })
}

/// Whether a Host is a loopback address or `localhost`, with any port, or empty.
fn is_local(host: &str) -> bool {
    let host = host.trim();
    let host = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|digit| digit.is_ascii_digit()) => name,
        _ => host,
    };
    let address = host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host);
    let is_loopback = |ip: IpAddr| ip.to_canonical().is_loopback();
    host.is_empty()
        || host.eq_ignore_ascii_case("localhost")
        || address.parse().is_ok_and(is_loopback)
}

/// Path and whether only the header is wanted.
fn wanted<'a>(method: Option<&str>, target: Option<&'a str>) -> Result<(&'a str, bool), Refusal> {
    let head = match method {
        Some("GET") => false,
        Some("HEAD") => true,
        _ => return Err(Refusal::Method),
    };
    let path = target.and_then(|target| target.split('?').next());
    path.filter(|path| path.starts_with('/')).map(|path| (path, head)).ok_or(Refusal::BadRequest)
}

#[cfg(test)]
mod tests {
    use super::{Parsed, Refusal, parse};

    #[test]
    fn a_request_is_read_once_it_is_complete() {
        let request = b"GET /metrics?x=1 HTTP/1.1\r\nHost: localhost\r\nAccept: */*\r\n\r\n";
        for end in 0..request.len() {
            assert_eq!(parse(&request[..end]), Parsed::Incomplete, "{end}");
        }
        assert_eq!(parse(request), Parsed::Page { path: "/metrics", head: false, local: true });
        let head = b"HEAD /healthz HTTP/1.0\r\n\r\nrest";
        assert_eq!(parse(head), Parsed::Page { path: "/healthz", head: true, local: true });
    }

    #[test]
    fn a_host_is_this_computer_or_another() {
        let local = |fields: &str| {
            let request = format!("GET / HTTP/1.1\r\n{fields}\r\n");
            matches!(parse(request.as_bytes()), Parsed::Page { local: true, .. })
        };
        for host in [
            "localhost",
            "LocalHost:9477",
            "127.0.0.1",
            "127.9.9.9:80",
            "[::1]:9477",
            "[::ffff:127.0.0.1]",
            "",
            ":80",
        ] {
            assert!(local(&format!("Host: {host}\r\n")), "{host}");
        }
        for host in [
            "evil.example",
            "127.0.0.1.evil.example",
            "192.0.2.7:9477",
            "[::2]",
            "localhost.evil.example:80",
            "\u{b5}",
        ] {
            assert!(!local(&format!("Host: {host}\r\n")), "{host}");
        }
        assert!(local("") && !local("Host: localhost\r\nhost: evil.example\r\n"));
        assert!(local("Origin: http://127.0.0.1:9747\r\n"));
        assert!(
            !local("Origin: file://\r\n")
                && !local("Origin: null\r\n")
                && !local("origin: http://evil.example\r\n")
        );
    }

    #[test]
    fn everything_else_is_refused_with_its_reason() {
        for (request, refusal) in [
            ("POST /metrics HTTP/1.1\r\nHost: x\r\n\r\n", Refusal::Method),
            ("BREW /pot HTTP/1.1\r\n\r\n", Refusal::Method),
            ("get / HTTP/1.1\r\n\r\n", Refusal::Method),
            ("GET /metrics HTTP/2.0\r\n\r\n", Refusal::Version),
            ("GET /metrics\r\n\r\n", Refusal::BadRequest),
            ("GET  /metrics HTTP/1.1\r\n\r\n", Refusal::BadRequest),
            ("GET metrics HTTP/1.1\r\n\r\n", Refusal::BadRequest),
            ("GET /metrics FTP/1.1\r\n\r\n", Refusal::Version),
            ("GET / HTTP/1.1\r\nno colon\r\n\r\n", Refusal::BadRequest),
            ("GET / HTTP/1.1\r\n folded: x\r\n\r\n", Refusal::BadRequest),
        ] {
            assert_eq!(parse(request.as_bytes()), Parsed::Refused(refusal), "{request}");
        }
        let many = format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(65));
        assert_eq!(parse(many.as_bytes()), Parsed::Refused(Refusal::TooLarge));
        assert_eq!(parse(b"GET /\xFF\xFE HTTP/1.1\r\n\r\n"), Parsed::Refused(Refusal::BadRequest));
        assert_eq!(parse(b"GE\0"), Parsed::Refused(Refusal::BadRequest), "at once");
        assert_eq!(parse(b"\x16\x03\x01"), Parsed::Refused(Refusal::BadRequest), "TLS");
    }
}
