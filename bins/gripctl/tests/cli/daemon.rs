//! What clients see of a gripd, without a gripper: on a thread until it is dropped.

use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use grip_daemon::{
    Item,
    clients::{About, Clients, ClientsConfig},
};
use grip_link::message::daemon::RealTime;
use grip_session::report::Event;
use slip_core::{SlipReport, units::Micros};
use std::{
    sync::Arc,
    thread::{self, JoinHandle},
};

pub(crate) struct Daemon {
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// gripd 9.9.9, which has seen a slip end.
pub(crate) fn listening(listen: &str, run_id: u32, duration_s: f64) -> Clients {
    let (name, real_time) = ("gripd 9.9.9".into(), RealTime::Partly);
    let about = About { name, run_id, dry_run: false, records: false, real_time };
    let config = ClientsConfig { listen: listen.parse().unwrap(), ..ClientsConfig::default() };
    let mut clients = Clients::listen(config, about).unwrap();
    let line = Event::Slip(SlipReport {
        t: Micros(1_500_000),
        duration_s: Some(duration_s),
        command_n: Some(4.5),
        ..SlipReport::UNKNOWN
    });
    clients.take(&Item::Event { host_us: 2_000_000, event: &line });
    clients
}

impl Daemon {
    /// Serves; `turn` comes once a millisecond of its own time (us).
    pub(crate) fn start(
        mut clients: Clients,
        mut turn: impl FnMut(&mut Clients, u64) + Send + 'static,
    ) -> Self {
        let end = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&end);
        let thread = thread::spawn(move || {
            let mut now_us = 5_000_000;
            while !ended.load(Ordering::Relaxed) {
                now_us += 1_000;
                turn(&mut clients, now_us);
                clients.poll(now_us, Duration::from_millis(1)).unwrap();
            }
            clients.close(now_us);
        });
        Self { end, thread: Some(thread) }
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        self.thread.take().unwrap().join().unwrap();
    }
}
