//! The server on a real loopback socket, with clients that behave and clients that do not. Time is an argument, so nothing waits long.

use crate::{made, parser::parse};
use core::{net::SocketAddr, time::Duration};
use grip_daemon::{
    exposition::Exposition,
    http::{HttpServer, Limits, ServeError},
    pages,
};
use std::{
    io::{ErrorKind, Read as _, Write as _},
    net::{Shutdown, TcpStream},
};

/// A server and the time it is given.
pub(crate) struct Rig {
    pub(crate) server: HttpServer,
    address: SocketAddr,
    pub(crate) now_us: u64,
}

impl Rig {
    pub(crate) fn new() -> Self {
        let server = HttpServer::bind(SocketAddr::from(([127, 0, 0, 1], 0)), false).unwrap();
        let address = server.address().unwrap();
        Self { server, address, now_us: 0 }
    }

    pub(crate) fn turn(&mut self) {
        let (board, mut page) = (made::board(), Exposition::default());
        let now_us = self.now_us;
        self.server.serve(now_us, &mut |path| pages::page(&board, now_us, &mut page, path));
    }

    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(2))).unwrap();
        stream
    }

    /// Turns until the server has closed the connection; what it said.
    fn answer(&mut self, stream: &mut TcpStream) -> String {
        let mut answer = Vec::new();
        for _ in 0..10_000 {
            self.turn();
            let mut bytes = [0; 4096];
            match stream.read(&mut bytes) {
                Ok(0) => return String::from_utf8(answer).unwrap(),
                Ok(count) => answer.extend(&bytes[..count]),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(error) => panic!("{error} after {} bytes", answer.len()),
            }
        }
        panic!("no end after {} bytes", answer.len());
    }

    pub(crate) fn ask(&mut self, request: &str) -> String {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).unwrap();
        self.answer(&mut stream)
    }

    /// Turns until there are `wanted` connections.
    pub(crate) fn settle(&mut self, wanted: usize) {
        for _ in 0..10_000 {
            self.turn();
            if self.server.counts().0 == wanted {
                return;
            }
            std::thread::yield_now();
        }
        panic!("{} connections, not {wanted}", self.server.counts().0);
    }
}

pub(crate) fn get(path: &str) -> String {
    format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nUser-Agent: test\r\n\r\n")
}

#[test]
fn pages_are_handed_out() {
    let mut rig = Rig::new();
    let metrics = rig.ask(&get("/metrics"));
    let (head, body) = metrics.split_once("\r\n\r\n").unwrap();
    assert!(head.starts_with("HTTP/1.1 200 OK\r\n"), "{head}");
    assert!(
        head.contains("\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\n"),
        "{head}"
    );
    assert!(head.contains(&format!("\r\nContent-Length: {}\r\n", body.len())), "{head}");
    assert!(parse(body).len() > 100);
    let status = rig.ask(&get("/status"));
    let (_, body) = status.split_once("\r\n\r\n").unwrap();
    let status: serde_json::Value = serde_json::from_str(body).unwrap();
    assert_eq!(status["version"], "1.2.3");
    assert!(rig.ask(&get("/healthz")).ends_with("\r\n\r\nok\n"));
    assert!(rig.ask(&get("/nothing")).starts_with("HTTP/1.1 404 "));
    assert!(rig.ask("DELETE /metrics HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 405 "));
    assert!(rig.ask("hello\r\n\r\n").starts_with("HTTP/1.1 400 "));
    let head = rig.ask("HEAD /metrics HTTP/1.1\r\n\r\n");
    assert!(head.ends_with("\r\n\r\n"), "{head}");
    rig.settle(0);
}

#[test]
fn a_client_that_closes_its_sending_side_gets_its_page() {
    let mut rig = Rig::new();
    let mut stream = rig.connect();
    stream.write_all(get("/metrics").as_bytes()).unwrap();
    stream.shutdown(Shutdown::Write).unwrap();
    assert!(rig.answer(&mut stream).starts_with("HTTP/1.1 200 OK\r\n"));
    rig.settle(0);
}

#[test]
fn slow_clients_are_reported_and_closed_and_others_are_served_meanwhile() {
    let mut rig = Rig::new();
    let mut slow: Vec<TcpStream> = (0..8).map(|_| rig.connect()).collect();
    rig.settle(8);
    for step in 0..19 {
        rig.now_us = 100_000 * step;
        for stream in &mut slow {
            stream.write_all(b"G").unwrap();
        }
        rig.turn();
    }
    assert!(rig.ask(&get("/healthz")).starts_with("HTTP/1.1 200 "));
    rig.now_us = Limits::default().request_us;
    for stream in &mut slow {
        let answer = rig.answer(stream);
        assert!(answer.starts_with("HTTP/1.1 408 "), "{answer}");
    }
    drop(slow);
    rig.settle(0);
}

#[test]
fn a_client_that_never_reads_is_left_after_its_time() {
    let mut rig = Rig::new();
    let mut stream = rig.connect();
    stream.write_all(get("/metrics").as_bytes()).unwrap();
    rig.settle(1);
    for _ in 0..100 {
        rig.turn();
    }
    assert_eq!(rig.server.counts().0, 1, "it may still take its time");
    assert_eq!(rig.server.interests().count(), 2);
    assert!(rig.server.interests().all(|interest| interest.read));
    rig.now_us = Limits::default().request_us + Limits::default().answer_us;
    rig.settle(0);
}

#[test]
fn too_many_connections_are_reported_and_the_server_recovers() {
    let mut rig = Rig::new();
    let held: Vec<TcpStream> = (0..16).map(|_| rig.connect()).collect();
    rig.settle(16);
    for _ in 0..100 {
        let mut extra = rig.connect();
        let answer = rig.answer(&mut extra);
        assert!(answer.starts_with("HTTP/1.1 503 "), "{answer}");
    }
    assert_eq!(rig.server.counts(), (16, 100));
    drop(held);
    rig.settle(0);
    assert!(rig.ask(&get("/healthz")).starts_with("HTTP/1.1 200 "));
}

#[test]
fn garbage_ends_at_once_and_long_requests_are_cut() {
    let mut rig = Rig::new();
    let mut seed = 1_u64;
    for _ in 0..50 {
        let garbage: Vec<u8> = (0..64)
            .map(|_| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                seed.to_be_bytes()[0]
            })
            .collect();
        let mut stream = rig.connect();
        stream.write_all(&garbage).unwrap();
        let answer = rig.answer(&mut stream);
        assert!(answer.starts_with("HTTP/1.1 400 "), "{answer}");
    }
    let long = format!("GET / HTTP/1.1\r\nX: {}", "x".repeat(4096));
    assert!(rig.ask(&long).starts_with("HTTP/1.1 431 "));
    // Hung up in the middle of a request.
    let mut stream = rig.connect();
    stream.write_all(b"GET /met").unwrap();
    drop(stream);
    rig.turn();
    rig.settle(0);
}

#[test]
fn addresses_open_to_others_need_leave() {
    let any = SocketAddr::from(([0, 0, 0, 0], 0));
    let error = HttpServer::bind(any, false).unwrap_err();
    assert!(matches!(error, ServeError::Remote(_)));
    assert!(HttpServer::bind(any, true).is_ok());
    let rig = Rig::new();
    let taken = HttpServer::bind(rig.address, false).unwrap_err().to_string();
    assert!(taken.starts_with(&format!("cannot listen on {}: ", rig.address)), "{taken}");
}
