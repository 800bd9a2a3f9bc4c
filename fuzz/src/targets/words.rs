//! Texts in the words of the vectors and the peers: bytes as hex digits, and back; what a decoder makes of wire bytes.

use grip_link::crc::crc32c;
use grip_link::decoder::{Decoder, Fault, Role, Verdict};

/// Bytes as hex digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// "00ff12" to bytes.
pub fn unhex(text: &str) -> Vec<u8> {
    (0..text.len()).step_by(2).map(|i| u8::from_str_radix(&text[i..i + 2], 16).unwrap()).collect()
}

/// A fault by its name.
pub const fn fault_word(fault: Fault) -> &'static str {
    match fault {
        Fault::TooLong => "too_long",
        Fault::Cobs => "cobs",
        Fault::Length => "length",
        Fault::Crc => "crc",
        Fault::Echo => "echo",
        Fault::Version(_) => "version",
        Fault::Stale(_) => "stale",
        Fault::Duplicate(_) => "duplicate",
        Fault::UnknownKind(_) => "unknown",
    }
}

/// The answer to `ROLE SESSION[:SEQ]|- HEX`: all verdicts, and the counts of gaps and garbage.
pub fn decode(line: &str) -> String {
    let [role, session, bytes] = line.split(' ').collect::<Vec<_>>().try_into().unwrap();
    let mut decoder = Decoder::new(if role == "device" { Role::Device } else { Role::Host });
    if session != "-" {
        let (session, seq) = session.split_once(':').map_or((session, None), |(s, q)| (s, Some(q)));
        let newest = seq.map(|seq| seq.parse().unwrap());
        decoder.open_session(u16::from_str_radix(session, 16).unwrap(), newest);
    }
    let bytes = unhex(bytes);
    let mut input = &bytes[..];
    let mut words = Vec::new();
    while let Some(verdict) = decoder.next(&mut input) {
        words.push(match verdict {
            Verdict::Frame(frame) => {
                format!("ok:{:02x}:{:08x}", frame.header.kind.0, crc32c(frame.payload))
            }
            Verdict::Bad(fault) => fault_word(fault).to_owned(),
        });
    }
    if words.is_empty() {
        words.push("-".to_owned());
    }
    let counters = decoder.counters();
    format!("{} gap={} garbage={}", words.join(","), counters.gap, counters.garbage_bytes)
}
