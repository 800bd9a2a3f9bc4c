//! The vectors of protocol/vectors and some lives of a gripper in, the files under `fuzz/seeds` out. Run it from anywhere:
//! `cargo run --manifest-path fuzz/Cargo.toml --bin seeds`. Files that start with `found-` are kept.

use grip_link_fuzz::targets::words::unhex;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;

/// Target and name of a seed.
type Seeds = BTreeMap<(&'static str, String), Vec<u8>>;

fn main() -> io::Result<()> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut seeds = Seeds::new();
    valid(&fs::read_to_string(here.join("../protocol/vectors/valid.tsv"))?, &mut seeds);
    invalid(&fs::read_to_string(here.join("../protocol/vectors/invalid.tsv"))?, &mut seeds);
    clients(&fs::read_to_string(here.join("../protocol/vectors/clients.tsv"))?, &mut seeds);
    refused(&fs::read_to_string(here.join("../protocol/vectors/clients-invalid.tsv"))?, &mut seeds);
    lives(&mut seeds);
    conversations(&mut seeds);
    let folder = here.join("seeds");
    for ((target, name), bytes) in &seeds {
        fs::create_dir_all(folder.join(target))?;
        fs::write(folder.join(target).join(name), bytes)?;
    }
    let bytes: usize = seeds.values().map(Vec::len).sum();
    println!("{} seeds, {bytes} bytes under {}", seeds.len(), folder.display());
    Ok(())
}

fn rows(text: &str) -> impl Iterator<Item = Vec<&str>> {
    text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split('\t').collect())
}

/// One frame of each type, alone for `messages`; all frames of a direction in a row for `decoder` and `chunks`.
fn valid(text: &str, seeds: &mut Seeds) {
    let mut streams = [Vec::new(), Vec::new()];
    for row in rows(text) {
        let [name, _, direction, _, _, _, wire] = row[..] else { panic!("{row:?}") };
        if direction == "cobs" {
            continue;
        }
        let wire = unhex(wire);
        let to_host = usize::from(direction == "to_host");
        streams[to_host].extend(&wire);
        let body = uncobs(&wire[1..wire.len() - 1]);
        let payload = &body[8..body.len() - 4];
        if payload.len() < 300 {
            seeds.insert(("messages", name.to_owned()), [&body[1..2], payload].concat());
        }
    }
    for (role, stream) in streams.iter().enumerate() {
        let role = u8::try_from(role).unwrap();
        for (variant, bits) in [("open", 1 << 2), ("closed", 3 << 2)] {
            let name = format!("valid-{role}-{variant}");
            let part = &stream[..stream.len().min(3000)];
            seeds.insert(("decoder", name.clone()), [&[role | bits], part].concat());
            seeds.insert(("chunks", name), [&[role | bits, 7], part].concat());
        }
    }
}

/// Each broken input of the vectors, and all of them in a row.
fn invalid(text: &str, seeds: &mut Seeds) {
    let mut all = [Vec::new(), Vec::new()];
    for row in rows(text) {
        let [name, role, session, wire, ..] = row[..] else { panic!("{row:?}") };
        let host = u8::from(role == "host");
        let first = host | if session == "beef" { 0 } else { 3 << 2 };
        let wire = unhex(wire);
        all[usize::from(host)].extend(&wire);
        if wire.len() < 700 {
            seeds.insert(("decoder", name.to_owned()), [&[first], wire.as_slice()].concat());
        }
    }
    for (role, stream) in (0_u8..).zip(&all) {
        let name = format!("invalid-{role}");
        for seed in 0..4 {
            seeds.insert(
                ("chunks", format!("{name}-{seed}")),
                [&[role, seed], stream.as_slice()].concat(),
            );
        }
    }
}

/// Frames between daemon and clients: the first of each type for `messages`, all of a direction in a row for `decoder`.
fn clients(text: &str, seeds: &mut Seeds) {
    let mut streams = [Vec::new(), Vec::new()];
    let mut types = Vec::new();
    for row in rows(text) {
        let [name, _, direction, kind, _, _, wire] = row[..] else { panic!("{row:?}") };
        let wire = unhex(wire);
        streams[usize::from(direction == "to_client")].extend(&wire);
        let body = uncobs(&wire[1..wire.len() - 1]);
        if !types.contains(&kind.to_owned()) {
            types.push(kind.to_owned());
            let payload = &body[8..body.len() - 4];
            seeds.insert(("messages", name.to_owned()), [&body[1..2], payload].concat());
        }
    }
    for (role, stream) in (0_u8..).zip(&streams) {
        let part = &stream[..stream.len().min(3000)];
        let name = format!("clients-{role}");
        seeds.insert(("decoder", name), [&[LISTENS_TO_CLIENTS | role], part].concat());
    }
}

/// Bit of the first byte of an input for `decoder`: a daemon or a client listens.
const LISTENS_TO_CLIENTS: u8 = 1 << 4;

/// What daemon and clients refuse, in a row.
fn refused(text: &str, seeds: &mut Seeds) {
    let mut all = [Vec::new(), Vec::new()];
    for row in rows(text) {
        let [_, role, _, wire, ..] = row[..] else { panic!("{row:?}") };
        all[usize::from(role == "client")].extend(unhex(wire));
    }
    for (role, stream) in (0_u8..).zip(&all) {
        let name = format!("clients-invalid-{role}");
        seeds.insert(("decoder", name), [&[LISTENS_TO_CLIENTS | role], stream.as_slice()].concat());
    }
}

/// The data of a good COBS block.
fn uncobs(block: &[u8]) -> Vec<u8> {
    let mut data = Vec::new();
    let mut rest = block;
    while let Some((&code, after)) = rest.split_first() {
        let (part, next) = after.split_at(usize::from(code) - 1);
        data.extend(part);
        rest = next;
        if code < 255 && !rest.is_empty() {
            data.push(0);
        }
    }
    data
}

/// Turns of `script`, by their numbers there.
mod turn {
    pub(super) const MICROS: u8 = 0;
    pub(super) const MILLIS: u8 = 1;
    pub(super) const READY: u8 = 2;
    pub(super) const NOISE: u8 = 3;
    pub(super) const FRAME: u8 = 4;
    pub(super) const HELLO: u8 = 5;
    pub(super) const CONFIG: u8 = 6;
    pub(super) const START: u8 = 7;
    pub(super) const GRIP: u8 = 8;
    pub(super) const DRIVE: u8 = 9;
    pub(super) const SEND: u8 = 10;
    pub(super) const ROW: u8 = 11;
    pub(super) const FLOATS: u8 = 12;
    pub(super) const FAULT: u8 = 13;
    pub(super) const CLEAR: u8 = 14;
    pub(super) const ESTOP: u8 = 15;
    pub(super) const MEASURED: u8 = 16;
    pub(super) const ALIVE: u8 = 17;
    pub(super) const LOG: u8 = 18;
    pub(super) const SHORT: u8 = 19;
}

/// Lives of a gripper for `device`.
fn lives(seeds: &mut Seeds) {
    use turn::{
        ALIVE, CLEAR, CONFIG, DRIVE, ESTOP, FAULT, FLOATS, FRAME, GRIP, HELLO, LOG, MEASURED,
        MICROS, MILLIS, NOISE, READY, ROW, SEND, SHORT, START,
    };
    let link: &[u8] = &[1, READY, HELLO, 0, SEND, 7, CONFIG, 0, SEND, 7, START, SEND, 7];
    let wait = |ms: u16| [&[MILLIS][..], &ms.to_le_bytes()].concat();
    let press = |force_mn: u16| [&[GRIP, 0][..], &force_mn.to_le_bytes()].concat();
    let grasp: Vec<u8> =
        (0..20).flat_map(|_| [press(5000), wait(4), vec![DRIVE]].concat()).collect();
    let rows: Vec<u8> = (0..25_u8).flat_map(|i| [MICROS, 200, 0, ROW, 0, i, 0, SEND, 3]).collect();
    let mut life = |name: &str, parts: &[&[u8]]| {
        seeds.insert(("device", name.to_owned()), [link, &parts.concat()].concat());
    };
    life("grasp", &[&grasp, &[SEND, 7, ALIVE]]);
    life("stream", &[&rows, &grasp]);
    life(
        "ttl-expires",
        &[&press(9000), &wait(10), &[DRIVE], &wait(60), &[DRIVE], &wait(2000), &[DRIVE, SEND, 7]],
    );
    life(
        "lost-then-armed",
        &[
            &grasp,
            &wait(2000),
            &[DRIVE],
            &press(9000),
            &[CONFIG, 0],
            &press(9000),
            &wait(5),
            &[DRIVE],
        ],
    );
    for action in 0..3 {
        let config = [CONFIG, 2, 50, 0, 200, 0, action];
        life(
            &format!("loss-action-{action}"),
            &[&config, &grasp, &wait(60), &[DRIVE], &wait(300), &[DRIVE, SEND, 7]],
        );
    }
    for fault in 0..7 {
        life(
            &format!("fault-{fault}"),
            &[
                &grasp,
                &[FAULT, fault, DRIVE],
                &grasp,
                &[HELLO, 0, CLEAR, 6, CLEAR, fault, SEND, 7, CONFIG, 0],
                &grasp,
            ],
        );
    }
    life("estop", &[&grasp, &[ESTOP, DRIVE], &grasp, &[CLEAR, 4, SEND, 7, CONFIG, 0], &grasp]);
    life("estop-frame", &[&grasp, &[FRAME, 0x12, 0b0100_0010, 0, 0, DRIVE], &grasp]);
    life(
        "negative-force",
        &[
            &grasp,
            &[GRIP, 64, 0xFF, 0xFF, 0xFF, 0xFF, DRIVE],
            &[GRIP, 64, 0, 0, 0, 0x80, DRIVE, SEND, 7],
        ],
    );
    life(
        "force-over-all-limits",
        &[
            &[GRIP, 0b1110_0000, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0xFF, 0xFF],
            &wait(50),
            &[DRIVE],
            &grasp,
        ],
    );
    life("old-commands", &[&grasp, &[GRIP, 2, 0xFF, 0x7F, DRIVE, GRIP, 3, 0xFF, 0x7F, DRIVE]]);
    life(
        "open-and-passive",
        &[&grasp, &[GRIP, 16, 0, 0, DRIVE], &wait(1200), &[DRIVE, GRIP, 20, 0, 0, DRIVE], &grasp],
    );
    life("unknown-modes", &[&grasp, &[GRIP, 24, 0, 40, DRIVE, GRIP, 28, 0, 40, DRIVE]]);
    life(
        "any-config",
        &[
            &[
                CONFIG, 3, 1, 0, 0, 0, 9, 1, 7, 0, 0, 0, 0, 9, 0, 0, 0, 9, 9, 0, 0, 9, 0, 0, START,
                FLOATS, 3, 0, 1, 2, 3, 4, 0,
            ],
            &grasp,
        ],
    );
    life(
        "negative-limits",
        &[
            &[CONFIG, 3, 1, 0, 0, 0, 9, 1, 7, 0, 0, 0, 0, 0, 0, 0x80, 0, 9, 9, 0, 0, 9, 0, 0x80],
            &grasp,
        ],
    );
    life(
        "travel-end",
        &[
            &grasp,
            &[MEASURED, 0, 0, 0, 0x7F],
            &press(9000),
            &wait(5),
            &[DRIVE, MEASURED, 0, 0, 0, 0],
            &press(9000),
            &wait(5),
            &[DRIVE],
        ],
    );
    life(
        "sequence-wraps",
        &[
            &[FRAME, 0x06, 1, 8, 1, 2, 3, 4, 5, 6, 7, 8, 2],
            &[FRAME, 0x06, 1, 8, 1, 2, 3, 4, 5, 6, 7, 8, 2],
            &[FRAME, 0x06, 1, 8, 1, 2, 3, 4, 5, 6, 7, 8, 2],
            &grasp,
        ],
    );
    life(
        "other-sessions",
        &[
            &grasp,
            &[FRAME, 0x10, 2, 20],
            &[0xFF; 20],
            &[1, DRIVE],
            &[FRAME, 0x01, 2, 16],
            &[1; 16],
            &[2, SEND, 7],
            &grasp,
        ],
    );
    life(
        "other-versions",
        &[&[HELLO, 2, HELLO, 3, SEND, 7, FRAME, 0x06, 0x70, 8], &[1; 8], &grasp],
    );
    life("echoes", &[&[FRAME, 0x91, 0x0C, 24], &[0; 24], &[SEND, 7], &grasp]);
    life(
        "unknown-types",
        &[&[FRAME, 0x7E, 0x40, 3, 1, 2, 3, SEND, 7, FRAME, 0xA0, 0x40, 0, SEND, 7]],
    );
    life("modem-commands", &[&[NOISE, 8], b"AT+GCAP\r", &grasp, &[NOISE, 5], b"\0ATE1", &grasp]);
    life(
        "texts-and-beats",
        &[
            &[LOG, 1, 5],
            b"hello",
            &[SHORT, 0, 1, 2, 3, 4, SHORT, 1, 1, 0, 0, 0, SEND, 7, ALIVE, DRIVE, ALIVE],
        ],
    );
    seeds.insert(
        ("device", "no-host".to_owned()),
        vec![0, DRIVE, ROW, 0, 1, 0, SEND, 7, READY, DRIVE, SEND, 7, ALIVE],
    );
    seeds.insert(
        ("device", "commands-before-hello".to_owned()),
        [&[2, READY][..], &grasp, &[SEND, 7]].concat(),
    );
}

/// Conversations for `host`: numbers as in its `turn`.
fn conversations(seeds: &mut Seeds) {
    const TURN: &[u8] = &[0, 200, 0, 2];
    let attach: Vec<u8> = TURN.repeat(8);
    let stream: Vec<u8> = [8, 10, 2].repeat(6);
    let grip: Vec<u8> = [&[6, 0, 0x88, 0x13, 0, 0, 0, 0, 2][..], TURN].concat();
    let mut talk = |name: &str, parts: &[&[u8]]| {
        seeds.insert(("host", name.to_owned()), parts.concat());
    };
    talk("attach", &[&attach]);
    talk("grip", &[&attach, &stream, &grip, &stream, &grip]);
    talk(
        "degraded",
        &[&attach, &stream, &grip, &[0, 0, 40], &[6, 0, 0xFF, 0xFF, 0, 0, 0, 0], &stream, &grip],
    );
    talk("negative", &[&attach, &stream, &[6, 8, 0, 0, 0, 0x80, 0, 0, 0, 0], &grip]);
    talk("silence", &[&attach, &stream, &[1, 0, 8, 4, 0, 10, 7, 1, 2], &attach, &stream, &grip]);
    talk("nobody", &[&[11, 0, 1, 0, 1, 11, 0, 1, 0, 16, 2, 4, 0]]);
    talk("reboot", &[&attach, &stream, &grip, &[9, 3], &grip, &attach, &attach, &stream, &grip]);
    talk(
        "damage",
        &[
            &attach,
            &stream,
            &[8, 10, 3, 7, 1, 9, 0, 1, 2],
            &stream,
            &[6, 0, 1, 1, 0, 0, 0, 0, 7, 0, 5, 0, 64, 2],
        ],
    );
    talk("lost", &[&attach, &stream, &[8, 31, 3, 11, 1], &stream, &grip]);
    talk("start-unacknowledged", &[&TURN.repeat(5), &[2, 3, 11, 1], &stream, &grip]);
    let nothing_arrives = [3, 11, 0, 11, 1, 1, 50, 0];
    talk("config-unanswered", &[&TURN.repeat(2), &nothing_arrives.repeat(5), &attach]);
    for (name, trouble) in [("fault-and-clear", &[9, 0, 1, 2][..]), ("estop-and-clear", &[10, 5])] {
        let (told, cleared) = (TURN.repeat(4), TURN.repeat(6));
        talk(name, &[&attach, &stream, &grip, trouble, &told, &[10, 2], &cleared, &stream, &grip]);
    }
    talk(
        "stop-and-start",
        &[
            &attach,
            &stream,
            &[10, 0],
            &TURN.repeat(3),
            &[10, 1],
            &TURN.repeat(3),
            &stream,
            &[10, 4, 10, 6],
        ],
    );
    talk(
        "reconfigure",
        &[
            &attach,
            &stream,
            &[10, 3, 0x88, 0x13, 0, 0, 0xE8, 3, 0, 0, 1, 0, 0, 0],
            &TURN.repeat(4),
            &stream,
            &grip,
        ],
    );
    talk(
        "forged",
        &[
            &attach,
            &stream,
            &[5, 0, 1 << 6, 7, 0, 4, 1, 2, 3, 4],
            &[5, 5, 1 << 6, 8, 0, 24],
            &[9; 24],
            &[5, 10, 1 | 1 << 6, 0, 0, 0, 200],
            &[1; 100],
            &grip,
        ],
    );
    talk("modem-commands", &[&[4, 8], b"AT+GCAP\r", &attach, &[4, 5], b"\0ATE1", &stream, &grip]);
}
