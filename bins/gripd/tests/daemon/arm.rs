//! A gripper of Robotiq at the tool connector of an arm, behind what forwards RS-485 over TCP: late, in pieces, reset, without power.

#[path = "../../../../crates/grip-robotiq/src/gripper/tests/device.rs"]
mod device;

use crate::running::serving;
use core::{
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use device::Device;
use std::{
    io::{Read as _, Write as _},
    net::{Shutdown, TcpListener, TcpStream},
    os::unix::net::UnixStream,
    path::PathBuf,
    sync::{Arc, Mutex},
    thread,
    time::Instant,
};
use stories::until;

/// What a test does with the arm while gripd uses it.
#[derive(Clone)]
struct Arm {
    device: Arc<Mutex<Device>>,
    line: Arc<Mutex<Option<TcpStream>>>,
    port: u16,
}

impl Arm {
    fn new() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let device = Device { object: true, ..Device::new(true) };
        let arm = Self { device: Arc::new(Mutex::new(device)), line: Arc::default(), port };
        let serving = arm.clone();
        // It ends with the tests.
        thread::spawn(move || listener.incoming().for_each(|line| serving.forward(line.unwrap())));
        arm
    }

    /// Answers each request after 2 to 12 ms, in two pieces; what comes meanwhile waits, and is one with what follows.
    fn forward(&self, mut line: TcpStream) {
        *self.line.lock().unwrap() = Some(line.try_clone().unwrap());
        let (mut came, mut input, mut turn) = (Vec::new(), [0; 256], 0_usize);
        while let Ok(count @ 1..) = line.read(&mut input) {
            came.extend(&input[..count]);
            while came.len() >= 8 {
                let whole = if came[1] == 0x10 { 15 } else { 8 };
                if came.len() < whole {
                    break;
                }
                let request: Vec<u8> = came.drain(..whole).collect();
                let Some(answer) = self.device.lock().unwrap().answer(&request) else { continue };
                turn += 1;
                let (one, other) = answer.split_at(turn % answer.len());
                for (piece, ms) in [(one, 2 + turn % 7), (other, turn % 4)] {
                    pause(Duration::from_millis(ms.try_into().unwrap()));
                    // Nobody is there any more after a reset.
                    let _sent = line.write_all(piece);
                }
            }
        }
    }

    fn reset(&self) {
        let line = self.line.lock().unwrap().take();
        line.unwrap().shutdown(Shutdown::Both).unwrap();
    }

    /// What the registers ask the force to be; `None` where the fingers are not to close.
    fn asks(&self) -> Option<u8> {
        let [_, position, strength] = self.device.lock().unwrap().registers;
        (position == 255).then_some(strength.to_be_bytes()[1])
    }
}

/// A program that sends an accelerometer at 1600 Hz, ten times as loud in a tenth of every second.
struct Sensor(Arc<AtomicBool>);

impl Sensor {
    fn start(path: PathBuf) -> Self {
        let stopped = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&stopped);
        thread::spawn(move || {
            let mut line = None;
            assert!(until(|| {
                line = UnixStream::connect(&path).ok();
                line.is_some()
            }));
            let mut line = line.unwrap();
            line.write_all(b"vibration,rate=1600\n").unwrap();
            let (begin, mut row, mut seed) = (now(), 0_u32, 1_u32);
            while !ends.load(Ordering::Relaxed) {
                while f64::from(row) / 1600.0 < begin.elapsed().as_secs_f64() {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    let loud = row > 1600 && row % 1600 < 160;
                    let noise = f64::from(seed >> 16) / 32_768.0 - 1.0;
                    let text = format!("{:.5}\n", noise * if loud { 0.1 } else { 0.01 });
                    if line.write_all(text.as_bytes()).is_err() {
                        return;
                    }
                    row += 1;
                }
                pause(Duration::from_millis(2));
            }
        });
        Self(stopped)
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

#[expect(clippy::disallowed_methods, reason = "a device lives in real time")]
fn pause(time: Duration) {
    thread::sleep(time);
}

#[expect(clippy::disallowed_methods, reason = "a device lives in real time")]
fn now() -> Instant {
    Instant::now()
}

#[test]
fn a_slip_is_answered_over_the_forwarder_and_its_faults_open_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let arm = Arm::new();
    let rows = folder.path().join("rows.sock");
    let gripper = format!("robotiq:2f-85:tcp:127.0.0.1:{}", arm.port);
    let port = format!("rows:unix:{}", rows.display());
    let gripd = serving(folder.path(), &["--port", &port, "--gripper", &gripper]);
    let _sensor = Sensor::start(rows);
    gripd.until_reported(&format!("2F-85 on tcp:127.0.0.1:{}: found", arm.port));
    assert!(until(|| gripd.printed().contains("\"slip\"")), "{}", gripd.reported());
    let pressed = || arm.asks().is_some_and(|register| register > 0);
    assert!(until(pressed), "the force follows the slip: {}", gripd.reported());

    let held = arm.asks();
    arm.reset();
    gripd.until_reported("found again");
    assert!(arm.asks() >= held, "a reset of the connection lets nothing go");

    // Tool power off, for as long as a gripper takes to start, and on: nothing is activated or written.
    let silences = || gripd.reported().matches("no answer over Modbus RTU").count();
    let before = silences();
    arm.device.lock().unwrap().answers = false;
    assert!(until(|| silences() > before), "{}", gripd.reported());
    let written = {
        let mut device = arm.device.lock().unwrap();
        (device.answers, device.activated, device.registers) = (true, false, [0; 3]);
        device.writes.len()
    };
    gripd.until_reported("not activated");
    let writes = arm.device.lock().unwrap().writes.clone();
    assert_eq!(writes.len(), written, "{writes:?}");
    let opens = |[action, position, _]: &[u16; 3]| *position == 0 || action & 0x0100 == 0;
    assert!(!writes.iter().any(opens), "{writes:?}");
    let ran = gripd.interrupted();
    assert!([0, 3].contains(&ran.code), "{ran:?}");
}

#[test]
fn an_arm_that_is_not_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    // Nothing listens at a port that was given back.
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let rows = ["--sensor", "rows:unix:rows.sock", "--listen", "off", "--gripper"];
    let start =
        |gripper: &str| crate::running::gripd(folder.path(), &[&rows[..], &[gripper]].concat());
    start(&format!("robotiq:2f-85:tcp:127.0.0.1:{port}"))
        .refused(1, &[&format!("tcp:127.0.0.1:{port}"), "is the robot on", "forwarder"]);
    start("robotiq:2f-85:tcp:192.168.1.10").refused(2, &["expected tcp:HOST:PORT"]);
}
