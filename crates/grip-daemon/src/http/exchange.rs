//! One connection without its socket, driven by bytes and the time: its answer and its timeouts.

use super::request::{Content, Page, Parsed, Refusal, parse};

/// What a browser may do with an answer: files of gripd and nothing else, in no frame.
const POLICY: &str = "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'\r\nX-Content-Type-Options: nosniff\r\nCross-Origin-Resource-Policy: same-origin\r\n";

/// What a client may cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Longest request (bytes).
    pub request_bytes: usize,
    /// Longest time from the first look at a connection to a complete request (us), however often it sends a byte.
    pub request_us: u64,
    /// Longest time to take the answer and hang up, and to catch up with a stream (us).
    pub answer_us: u64,
    /// Most of a stream that waits for its client (bytes).
    pub stream_bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            request_bytes: 4096,
            request_us: 2_000_000,
            answer_us: 5_000_000,
            stream_bytes: 256 * 1024,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Reading,
    Answering,
    /// An answer without end.
    Streaming,
    /// All is sent; what still comes is thrown away, so that the answer is not lost by a reset.
    Draining,
    Over,
}

/// A connection.
#[derive(Debug)]
pub struct Exchange {
    limits: Limits,
    /// Only requests that are for this computer are answered.
    guarded: bool,
    deadline_us: u64,
    stage: Stage,
    request: Vec<u8>,
    answer: Vec<u8>,
    sent: usize,
    /// Whether the client has sent its last byte.
    received: bool,
}

impl Exchange {
    /// A connection that was accepted at `now_us` (us); a `guarded` one is answered only where its Host is this computer.
    #[must_use]
    pub fn new(now_us: u64, limits: Limits, guarded: bool) -> Self {
        Self {
            limits,
            guarded,
            deadline_us: now_us.saturating_add(limits.request_us),
            stage: Stage::Reading,
            request: Vec::new(),
            answer: Vec::new(),
            sent: 0,
            received: false,
        }
    }

    /// Takes bytes. `page` gives what is at a path, or why there is nothing; it is asked at most once.
    pub fn receive(&mut self, now_us: u64, bytes: &[u8], page: &mut dyn FnMut(&str) -> Page) {
        if self.stage != Stage::Reading {
            return;
        }
        let room = self.limits.request_bytes - self.request.len();
        self.request.extend(bytes.iter().take(room));
        let request = core::mem::take(&mut self.request);
        match parse(&request) {
            Parsed::Incomplete if bytes.len() >= room => self.refuse(now_us, Refusal::TooLarge),
            Parsed::Incomplete => self.request = request,
            Parsed::Refused(refusal) => self.refuse(now_us, refusal),
            Parsed::Page { local: false, .. } if self.guarded => {
                self.refuse(now_us, Refusal::Misdirected);
            }
            Parsed::Page { path, head, .. } => match page(path) {
                Ok(Content { media_type, text, more }) => {
                    let length = format!("\r\nContent-Length: {}", text.len());
                    let length = if more { "" } else { &length };
                    let fields = format!("Content-Type: {media_type}{length}");
                    self.answer(now_us, 200, "OK", &fields, if head { "" } else { &text });
                    if more && !head {
                        self.stage = Stage::Streaming;
                    }
                }
                Err(refusal) => self.refuse(now_us, refusal),
            },
        }
    }

    /// Answers with a refusal.
    pub fn refuse(&mut self, now_us: u64, refusal: Refusal) {
        let (code, words) = refusal.status();
        let why = match refusal {
            Refusal::Misdirected => ": only for Host: localhost or a loopback address",
            _ => "",
        };
        let text = format!("{code} {words}{why}\n");
        let allow = if refusal == Refusal::Method { "\r\nAllow: GET, HEAD" } else { "" };
        let len = text.len();
        let fields =
            format!("Content-Type: text/plain; charset=utf-8\r\nContent-Length: {len}{allow}");
        self.answer(now_us, code, words, &fields, &text);
    }

    fn answer(&mut self, now_us: u64, code: u16, words: &str, fields: &str, body: &str) {
        self.stage = Stage::Answering;
        self.deadline_us = now_us.saturating_add(self.limits.answer_us);
        let end = "Cache-Control: no-store\r\nConnection: close\r\n\r\n";
        self.answer =
            format!("HTTP/1.1 {code} {words}\r\n{fields}\r\n{POLICY}{end}{body}").into_bytes();
    }

    /// Adds to a stream. A client that has left too much of it waiting is given up: nothing waits for it.
    pub fn append(&mut self, now_us: u64, text: &str) {
        if self.stage != Stage::Streaming {
            return;
        }
        let waiting = self.to_send().len();
        if waiting + text.len() > self.limits.stream_bytes {
            return self.failed();
        }
        if waiting == 0 {
            self.deadline_us = now_us.saturating_add(self.limits.answer_us);
        }
        self.answer.drain(..self.sent);
        self.sent = 0;
        self.answer.extend_from_slice(text.as_bytes());
    }

    /// Whether this is an answer without end.
    #[must_use]
    pub fn streams(&self) -> bool {
        self.stage == Stage::Streaming
    }

    /// For how long the client of a stream has not caught up (us); 0 where nothing waits for it.
    #[must_use]
    pub fn behind_us(&self, now_us: u64) -> u64 {
        let waits = self.streams() && !self.to_send().is_empty();
        let since_us = self.deadline_us.saturating_sub(self.limits.answer_us);
        if waits { now_us.saturating_sub(since_us) } else { 0 }
    }

    /// Bytes that wait to be sent.
    #[must_use]
    pub fn to_send(&self) -> &[u8] {
        self.answer.get(self.sent..).unwrap_or(&[])
    }

    /// `count` of them were sent; `true` once, when they were the last ones: now the sending side is closed.
    pub fn was_sent(&mut self, count: usize) -> bool {
        self.sent += count;
        let done = self.stage == Stage::Answering && self.to_send().is_empty();
        if done {
            self.stage = if self.received { Stage::Over } else { Stage::Draining };
        }
        done
    }

    /// The client sends nothing more; it may read on.
    pub fn hung_up(&mut self) {
        self.received = true;
        if matches!(self.stage, Stage::Reading | Stage::Draining) {
            self.stage = Stage::Over;
        }
    }

    /// The socket failed: nothing more can be sent.
    pub fn failed(&mut self) {
        self.stage = Stage::Over;
        self.sent = self.answer.len();
    }

    /// Time has gone on.
    pub fn tick(&mut self, now_us: u64) {
        if now_us < self.deadline_us {
            return;
        }
        match self.stage {
            Stage::Reading => self.refuse(now_us, Refusal::Timeout),
            Stage::Streaming if self.to_send().is_empty() => {}
            _ => self.stage = Stage::Over,
        }
    }

    /// Whether more bytes may come.
    #[must_use]
    pub fn listens(&self) -> bool {
        !self.received && !self.is_over()
    }

    /// Whether the socket can be closed.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.stage == Stage::Over
    }
}

#[cfg(test)]
mod tests {
    use super::{Exchange, Limits};
    use crate::http::{Content, Page, Refusal};

    fn page(path: &str) -> Page {
        match path {
            "/x" => Ok(Content::whole("text/plain", "all is well\n")),
            _ => Err(Refusal::NotFound),
        }
    }

    fn answer(exchange: &Exchange) -> String {
        String::from_utf8(exchange.to_send().to_vec()).unwrap()
    }

    #[test]
    fn an_answer_is_sent_in_any_pieces_and_the_connection_ends() {
        let mut exchange = Exchange::new(0, Limits::default(), true);
        for byte in b"GET /x HTTP/1.1\r\nHost: localhost\r\n\r\n" {
            assert!(exchange.to_send().is_empty());
            exchange.receive(1, &[*byte], &mut page);
        }
        let text = answer(&exchange);
        assert!(
            text.starts_with(
                "HTTP/1.1 200 OK\r\nContent-Type: text/plain\r\nContent-Length: 12\r\n"
            )
        );
        assert!(text.ends_with("\r\nConnection: close\r\n\r\nall is well\n"), "{text}");
        exchange.hung_up();
        assert!(!exchange.is_over(), "a client may close its sending side and read on");
        assert!(!exchange.listens(), "and wakes nobody any more");
        assert!(!exchange.was_sent(10) && exchange.was_sent(text.len() - 10));
        assert!(exchange.is_over());
    }

    #[test]
    fn a_stream_keeps_only_so_much_and_so_long_for_its_client() {
        let limits = Limits { stream_bytes: 10, ..Limits::default() };
        let [mut full, mut slow] = [(); 2].map(|()| Exchange::new(0, limits, true));
        for exchange in [&mut full, &mut slow] {
            let page = &mut |_: &str| Ok(Content { more: true, ..Content::whole("a/b", "first") });
            exchange.receive(0, b"GET / HTTP/1.1\r\n\r\n", page);
            exchange.was_sent(exchange.to_send().len());
            exchange.tick(u64::MAX);
            exchange.append(7, "12345");
            exchange.tick(6 + limits.answer_us);
            assert_eq!(exchange.to_send(), b"12345", "who takes everything stays");
        }
        slow.tick(7 + limits.answer_us);
        full.append(8, "678901");
        assert!(slow.is_over() && full.is_over() && full.to_send().is_empty());
    }

    #[test]
    fn a_head_has_no_body() {
        let mut exchange = Exchange::new(0, Limits::default(), true);
        exchange.receive(0, b"HEAD /x HTTP/1.1\r\n\r\n", &mut page);
        let text = answer(&exchange);
        assert!(text.contains("Content-Length: 12\r\n") && text.ends_with("\r\n\r\n"), "{text}");
        assert!(exchange.was_sent(text.len()) && !exchange.is_over(), "what comes is thrown away");
        exchange.receive(1, b"more", &mut page);
        exchange.hung_up();
        assert!(exchange.is_over());
    }

    #[test]
    fn refusals_have_their_codes() {
        for (request, start) in [
            ("GET /y HTTP/1.1\r\n\r\n", "HTTP/1.1 404 Not Found\r\n"),
            ("PUT /x HTTP/1.1\r\n\r\n", "HTTP/1.1 405 Method Not Allowed\r\n"),
            ("GET\r\n\r\n", "HTTP/1.1 400 Bad Request\r\n"),
            (
                "GET /x HTTP/1.1\r\nHost: evil.example\r\n\r\n",
                "HTTP/1.1 421 Misdirected Request\r\n",
            ),
        ] {
            let mut exchange = Exchange::new(0, Limits::default(), true);
            exchange.receive(0, request.as_bytes(), &mut page);
            let text = answer(&exchange);
            assert!(text.starts_with(start), "{text}");
            assert_eq!(text.contains("\r\nAllow: GET, HEAD\r\n"), start.contains("405"));
        }
    }

    #[test]
    fn a_slow_or_long_request_ends() {
        let limits = Limits::default();
        let mut slow = Exchange::new(0, limits, true);
        // A byte in every tenth of a second does not buy more time.
        for step in 0..20 {
            slow.receive(step * 100_000, b"G", &mut page);
            slow.tick(step * 100_000);
            assert!(slow.to_send().is_empty());
        }
        slow.tick(limits.request_us);
        assert!(answer(&slow).starts_with("HTTP/1.1 408 "));
        slow.tick(limits.request_us + limits.answer_us - 1);
        assert!(!slow.is_over());
        slow.tick(limits.request_us + limits.answer_us);
        assert!(slow.is_over(), "who does not take the answer is left");
        let mut long = Exchange::new(0, limits, true);
        for _ in 0..limits.request_bytes / 8 - 1 {
            long.receive(0, b"GGGGGGGG", &mut page);
        }
        assert!(long.to_send().is_empty());
        long.receive(0, b"GGGGGGGG", &mut page);
        assert!(answer(&long).starts_with("HTTP/1.1 431 "));
        assert!(long.request.is_empty());
    }
}
