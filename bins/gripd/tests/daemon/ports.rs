//! Ports that are no gripper: each is distinguished from the others, within the three seconds that gripd asks.

use crate::running::{command, gripd};
use core::sync::atomic::{AtomicBool, Ordering};
use grip_link::{
    decoder::{Decoder, Role, Verdict},
    frame::{Direction, Header, MAX_WIRE, encode},
    message::{Channel, ChannelKind, Ident, Kind, Limits, ResetReason, Unit, Versions},
};
use grip_sim::Pty;
use std::{
    fs::{self, Permissions},
    os::unix::{fs::PermissionsExt as _, process::CommandExt as _},
    thread,
};
use stories::{Ended, Program};

/// Ends the other side of the line, also where a test fails.
struct Ending<'a>(&'a AtomicBool);

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// gripd on a pseudo-terminal whose other end gives `answer` to what it reads (nothing, every 20 ms, where nothing comes).
fn on_line(answer: impl FnMut(&[u8]) -> Vec<u8> + Send) -> Ended {
    let folder = tempfile::tempdir().unwrap();
    let pty = Pty::open(None).unwrap();
    let port = pty.port().display().to_string();
    let over = AtomicBool::new(false);
    thread::scope(|threads| {
        threads.spawn(|| serve(&pty, &over, answer));
        let _ending = Ending(&over);
        // An older recording must survive a port without a gripper.
        fs::write(folder.path().join("old.csv"), "kept").unwrap();
        let ran = gripd(folder.path(), &["--port", &port, "--json", "--record", "old.csv"]);
        assert_eq!(fs::read_to_string(folder.path().join("old.csv")).unwrap(), "kept");
        ran
    })
}

fn serve(pty: &Pty, over: &AtomicBool, mut answer: impl FnMut(&[u8]) -> Vec<u8>) {
    let mut buffer = [0; 4096];
    while !over.load(Ordering::Relaxed) {
        pty.wait(20_000, false).unwrap();
        let count = pty.read(&mut buffer).unwrap();
        let bytes = answer(&buffer[..count]);
        pty.write(&bytes).unwrap();
    }
}

/// Noise of the kind a wrong baud rate makes, seeded.
fn noise() -> impl FnMut() -> u8 {
    let mut state = 1_u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state.to_be_bytes()[0]
    }
}

/// All at once, since each takes the three seconds.
#[test]
fn lines_without_a_gripper() {
    thread::scope(|threads| {
        threads.spawn(|| {
            on_line(|_| Vec::new()).refused(1, &["no gripper answered", "not one byte", "powered"]);
        });
        threads.spawn(|| {
            let mut noise = noise();
            let ran = on_line(move |_| (0..200).map(|_| noise()).collect());
            ran.refused(
                1,
                &["no gripper answered", "bytes came back", "none of it is a frame", "--baud"],
            );
        });
        threads.spawn(|| {
            let ran = on_line(|_| b"login: \r\n".to_vec());
            ran.refused(
                1,
                &["no gripper answered", "it looks like text: `login:`", "docs/rows.md"],
            );
        });
        threads.spawn(|| {
            on_line(<[u8]>::to_vec).refused(1, &["echoed", "TX and RX"]);
        });
    });
}

const STYLUS: Channel =
    Channel { kind: ChannelKind::Stylus, unit: Unit::Metre, formats: 0xFF, count: 1, scale: 1e-6 };

/// A gripper in order, but for what a test changes.
fn ident() -> Ident {
    let limits = Limits {
        rate_max_hz: 10_000,
        force_max_mn: 20_000,
        slew_max_mn_s: 1_000_000,
        hold_cap_mn: 20_000,
        travel_min_um: 0,
        travel_max_um: 10_000,
    };
    Ident { reset: ResetReason::from_code(0), ..Ident::new([7; 16], 1, limits, &[STYLUS]) }
}

/// gripd facing a device of protocol `version` that answers every HELLO with `ident` and knows no other request.
fn facing(version: u8, ident: &Ident) -> Ended {
    let mut decoder = Decoder::new(Role::Device);
    let mut payload = [0; Ident::MAX_SIZE];
    let len = ident.write(&mut payload).unwrap();
    on_line(move |mut bytes| {
        let mut out = Vec::new();
        while let Some(verdict) = decoder.next(&mut bytes) {
            let Verdict::Frame(frame) = verdict else { continue };
            if frame.header.kind == Kind::HELLO {
                let header = Header {
                    version,
                    ..Header::new(Direction::ToHost, Kind::IDENT, 0, frame.header.session)
                };
                let mut wire = [0; MAX_WIRE];
                let size = encode(&header, &payload[..len], &mut wire).unwrap();
                out.extend_from_slice(&wire[..size]);
            }
        }
        out
    })
}

#[test]
fn grippers_that_cannot_serve() {
    let other = Ident { versions: Versions { min: 9, max: 9 }, ..ident() };
    facing(9, &other).refused(1, &["protocol versions 9 to 9", "speaks 1", "Update the older"]);
    let mut numb = ident();
    numb.channels[0].kind = ChannelKind::NormalForce;
    facing(1, &numb).refused(1, &["no stylus"]);
    let mut strange = ident();
    strange.channels[0].scale = f32::NAN;
    facing(1, &strange).refused(1, &["describes itself", "firmware"]);
    facing(1, &ident()).refused(1, &["did not answer", "CONFIG"]);
}

/// The uid of nobody, as whom a test that runs as root must knock: root may do everything.
const NOBODY: u32 = 65_534;

fn is_root(folder: &std::path::Path) -> bool {
    let locked = folder.join("locked");
    fs::write(&locked, "").unwrap();
    fs::set_permissions(&locked, Permissions::from_mode(0o000)).unwrap();
    fs::File::open(&locked).is_ok()
}

#[test]
fn a_port_that_may_not_be_opened() {
    let folder = tempfile::tempdir().unwrap();
    let root = is_root(folder.path());
    let mut command = command(folder.path(), &["--port", "./locked"]);
    if root {
        fs::set_permissions(folder.path(), Permissions::from_mode(0o755)).unwrap();
        command.uid(NOBODY);
        let reached = std::process::Command::new(env!("CARGO_BIN_EXE_gripd"))
            .uid(NOBODY)
            .current_dir(folder.path())
            .arg("--version")
            .output();
        if let Err(error) = reached {
            println!(
                "left out: root is denied nothing, and nobody cannot start gripd here ({error})"
            );
            return;
        }
    }
    Program::of(command).ended().refused(1, &["./locked", "access denied", "dialout"]);
}

#[test]
fn things_that_are_no_serial_port() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a scrape.wav"), "x").unwrap();
    gripd(folder.path(), &["--port", "./a scrape.wav"])
        .refused(1, &["no serial port", "`gripctl replay './a scrape.wav'`"]);
    for port in [".", "/dev/null"] {
        gripd(folder.path(), &["--port", port])
            .refused(1, &[port, "no serial port", "gripctl ports"]);
    }
    gripd(folder.path(), &["--port", "./none"])
        .refused(1, &["./none", "no such port", "gripctl ports"]);
    let pty = Pty::open(None).unwrap();
    let port = pty.port().display().to_string();
    let held = serialport::new(&port, 115_200).open().unwrap();
    gripd(folder.path(), &["--port", &port]).refused(1, &[&port, "busy", "another program"]);
    drop(held);
}
