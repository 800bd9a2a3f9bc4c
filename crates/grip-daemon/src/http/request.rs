//! The bytes that came so far in; what is asked for, or why it is refused, out.

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
    /// 431: the request is too long.
    TooLarge,
    /// 500: the page could not be made.
    Internal,
    /// 503: too many connections, or not in good health.
    Unavailable,
    /// 505: another version of HTTP.
    Version,
}

/// Media type and text of a page, or why there is none.
pub type Page = Result<(&'static str, String), Refusal>;

impl Refusal {
    /// Status code and its usual words.
    #[must_use]
    pub fn status(self) -> (u16, &'static str) {
        match self {
            Self::BadRequest => (400, "Bad Request"),
            Self::NotFound => (404, "Not Found"),
            Self::Method => (405, "Method Not Allowed"),
            Self::Timeout => (408, "Request Timeout"),
            Self::TooLarge => (431, "Request Header Fields Too Large"),
            Self::Internal => (500, "Internal Server Error"),
            Self::Unavailable => (503, "Service Unavailable"),
            Self::Version => (505, "HTTP Version Not Supported"),
        }
    }
}

/// Reads a request up to the empty line that ends its header. A body, where there is one, is not looked at.
#[must_use]
pub fn parse(bytes: &[u8]) -> Parsed<'_> {
    if !could_be_text(bytes) {
        return Parsed::Refused(Refusal::BadRequest);
    }
    let Some(end) = bytes.windows(4).position(|four| four == b"\r\n\r\n") else {
        return Parsed::Incomplete;
    };
    let header = bytes.get(..end).map(core::str::from_utf8);
    let Some(Ok(header)) = header else { return Parsed::Refused(Refusal::BadRequest) };
    let (line, fields) = header.split_once("\r\n").unwrap_or((header, ""));
    match (request_line(line), fields_are_right(fields)) {
        (Ok((path, head)), true) => Parsed::Page { path, head },
        (Ok(_), false) => Parsed::Refused(Refusal::BadRequest),
        (Err(refusal), _) => Parsed::Refused(refusal),
    }
}

/// Whether these bytes can begin a request: a method is a word of capitals, and control characters stand nowhere but in line ends and tabs.
fn could_be_text(bytes: &[u8]) -> bool {
    bytes.first().is_none_or(u8::is_ascii_uppercase)
        && bytes.iter().all(|b| matches!(b, b'\r' | b'\n' | b'\t' | 0x20..=0x7E | 0x80..))
}

/// Path and whether only the header is wanted.
fn request_line(line: &str) -> Result<(&str, bool), Refusal> {
    let mut words = line.split(' ');
    let (Some(method), Some(target), Some(version), None) =
        (words.next(), words.next(), words.next(), words.next())
    else {
        return Err(Refusal::BadRequest);
    };
    match version {
        "HTTP/1.1" | "HTTP/1.0" => {}
        other if other.starts_with("HTTP/") => return Err(Refusal::Version),
        _ => return Err(Refusal::BadRequest),
    }
    let head = match method {
        "GET" => false,
        "HEAD" => true,
        word if !word.is_empty() && word.bytes().all(|b| b.is_ascii_uppercase()) => {
            return Err(Refusal::Method);
        }
        _ => return Err(Refusal::BadRequest),
    };
    let path = target.split_once('?').map_or(target, |(path, _)| path);
    if path.starts_with('/') { Ok((path, head)) } else { Err(Refusal::BadRequest) }
}

/// Each line is `name: value` with a name of visible characters.
fn fields_are_right(fields: &str) -> bool {
    fields.is_empty()
        || fields.split("\r\n").all(|line| {
            line.split_once(':').is_some_and(|(name, _)| {
                !name.is_empty() && name.bytes().all(|b| b.is_ascii_graphic())
            }) && !line.contains(['\r', '\n'])
        })
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
        assert_eq!(parse(request), Parsed::Page { path: "/metrics", head: false });
        let head = b"HEAD /healthz HTTP/1.0\r\n\r\nrest";
        assert_eq!(parse(head), Parsed::Page { path: "/healthz", head: true });
    }

    #[test]
    fn everything_else_is_refused_with_its_reason() {
        for (request, refusal) in [
            ("POST /metrics HTTP/1.1\r\nHost: x\r\n\r\n", Refusal::Method),
            ("BREW /pot HTTP/1.1\r\n\r\n", Refusal::Method),
            ("GET /metrics HTTP/2.0\r\n\r\n", Refusal::Version),
            ("GET /metrics\r\n\r\n", Refusal::BadRequest),
            ("GET  /metrics HTTP/1.1\r\n\r\n", Refusal::BadRequest),
            ("GET metrics HTTP/1.1\r\n\r\n", Refusal::BadRequest),
            ("GET /metrics FTP/1.1\r\n\r\n", Refusal::BadRequest),
            ("GET / HTTP/1.1\r\nno colon\r\n\r\n", Refusal::BadRequest),
            ("GET / HTTP/1.1\r\n folded: x\r\n\r\n", Refusal::BadRequest),
            ("GET / HTTP/1.1\r\na: b\nc: d\r\n\r\n", Refusal::BadRequest),
            ("G3T / HTTP/1.1\r\n\r\n", Refusal::BadRequest),
            ("\r\n\r\n", Refusal::BadRequest),
            ("get / HTTP/1.1\r\n\r\n", Refusal::BadRequest),
        ] {
            assert_eq!(parse(request.as_bytes()), Parsed::Refused(refusal), "{request}");
        }
        assert_eq!(parse(b"GET /\xFF\xFE HTTP/1.1\r\n\r\n"), Parsed::Refused(Refusal::BadRequest));
        assert_eq!(parse(b"GE\0"), Parsed::Refused(Refusal::BadRequest), "at once");
        assert_eq!(parse(b"\x16\x03\x01"), Parsed::Refused(Refusal::BadRequest), "TLS");
    }
}
