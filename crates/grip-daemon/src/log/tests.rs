//! Lines as each reader gets them.

use super::{Clocks, Entry, Log, LogLevel, LogStyle};
use core::fmt::Display;

const WALL_US: u64 = 1_795_301_948_125_000;

fn at(host_us: u64) -> Clocks {
    Clocks { host_us, wall_us: WALL_US + host_us }
}

fn entry(level: LogLevel, text: &str) -> Entry<'_> {
    Entry { level, text, fields: &[] }
}

fn lines(style: LogStyle, level: LogLevel, report: impl FnOnce(&mut Log, &mut Vec<u8>)) -> String {
    let (mut log, mut out) = (Log::new("gripd", style, level), Vec::new());
    report(&mut log, &mut out);
    String::from_utf8(out).unwrap()
}

/// The header of a foreign program, for example.
#[test]
fn text_from_outside_changes_no_terminal() {
    for (style, begin) in [(LogStyle::Terminal, "gripd: "), (LogStyle::Journal, "<4>")] {
        let report = |log: &mut Log, out: &mut Vec<u8>| {
            log.report(at(0), &entry(LogLevel::Warn, "a\x1b[2J\u{202e}b"), out).unwrap();
        };
        let line = lines(style, LogLevel::Info, report);
        assert_eq!(line, format!("{begin}a\\u{{1b}}[2J\\u{{202e}}b\n"));
    }
}

#[test]
fn each_reader_gets_its_lines() {
    let fields: [(&str, &dyn Display); 3] =
        [("port", &"/dev/ttyACM0"), ("why", &"a \"b\""), ("n", &7)];
    let entry = Entry { level: LogLevel::Warn, text: "the port is gone\nreally", fields: &fields };
    let line =
        |style| lines(style, LogLevel::Info, |log, out| log.report(at(0), &entry, out).unwrap());
    assert_eq!(line(LogStyle::Terminal), "gripd: the port is gone\nreally\n");
    assert_eq!(
        line(LogStyle::Journal),
        "<4>the port is gone\n<4>really port=/dev/ttyACM0 why=\"a \\\"b\\\"\" n=7\n"
    );
    assert_eq!(
        line(LogStyle::Plain),
        "time=2026-11-21T22:59:08.125Z level=warn msg=\"the port is gone\\nreally\" port=/dev/ttyACM0 why=\"a \\\"b\\\"\" n=7\n"
    );
}

#[test]
fn a_thousand_equal_lines_are_one_and_a_count() {
    let text = lines(LogStyle::Terminal, LogLevel::Info, |log, out| {
        for ms in 0..12_000 {
            log.report(at(1000 * ms), &entry(LogLevel::Warn, "echo"), out).unwrap();
        }
        log.report(at(12_000_000), &entry(LogLevel::Info, "other"), out).unwrap();
        log.tick(at(20_000_000), out).unwrap();
        log.tick(at(30_000_000), out).unwrap();
        // It had stopped: the next one is news.
        log.report(at(45_000_000), &entry(LogLevel::Warn, "echo"), out).unwrap();
        log.report(at(45_000_001), &entry(LogLevel::Warn, "echo"), out).unwrap();
        log.finish(at(45_000_002), out).unwrap();
    });
    assert_eq!(
        text,
        "gripd: echo\ngripd: echo (and 9999 times more)\ngripd: other\ngripd: echo (and 2000 times more)\n\
         gripd: echo\ngripd: echo (and 1 times more)\n"
    );
}

#[test]
fn memory_stays_small_whatever_is_reported() {
    lines(LogStyle::Plain, LogLevel::Debug, |log, out| {
        for n in 0..10_000 {
            log.report(at(n), &entry(LogLevel::Debug, &n.to_string()), out).unwrap();
        }
        assert!(log.reported.len() <= 64);
    });
}

#[test]
fn light_entries_stay_unreported() {
    let text = lines(LogStyle::Terminal, LogLevel::Warn, |log, out| {
        log.report(at(0), &entry(LogLevel::Info, "hello"), out).unwrap();
        log.report(at(0), &entry(LogLevel::Error, "help"), out).unwrap();
        log.set_level(LogLevel::Debug);
        log.report(at(0), &entry(LogLevel::Debug, "detail"), out).unwrap();
    });
    assert_eq!(text, "gripd: help\ngripd: detail\n");
}

#[test]
fn the_journal_is_known_by_its_socket() {
    let of = |terminal, journal, stderr| LogStyle::of(terminal, journal, stderr);
    assert_eq!(of(false, Some("8:123"), Some((8, 123))), LogStyle::Journal);
    assert_eq!(of(false, Some("8:123"), Some((8, 124))), LogStyle::Plain, "redirected");
    assert_eq!(of(true, Some("8:123"), Some((5, 1))), LogStyle::Terminal);
    for odd in ["", "8", "a:b", "8:123:4"] {
        assert_eq!(of(false, Some(odd), Some((8, 123))), LogStyle::Plain, "{odd}");
    }
    assert_eq!(of(false, None, None), LogStyle::Plain);
}
