//! Events and the standing of a host in words.

use super::host_script::config_words;
use super::player::grip_words;
use super::words::hex;
use grip_link::clock::PongVerdict;
use grip_link::decoder::Counters;
use grip_link::host::{CloseReason, HostEvent, HostLink};
use grip_link::message::{Event, Samples, Stats, Status};

/// An event; what the Python peer hands over with it and this one shows elsewhere stands in [`state_words`].
pub fn event_words(host: &HostLink, event: &HostEvent) -> String {
    match event {
        HostEvent::State { from, to } => format!("state {} {}", from, to),
        HostEvent::Identified { rebooted } => format!("identified {}", u8::from(*rebooted)),
        HostEvent::Rebooted { before, now } => format!("rebooted {before} {now}"),
        HostEvent::Configured { clamped } => format!("configured {}", clamped.0),
        HostEvent::Samples { header, loss } => format!(
            "samples {} lost {} {} {}",
            samples_words(&host.samples(*header).unwrap()),
            loss.rows,
            loss.dropped_by_mcu,
            u8::from(loss.restarted)
        ),
        HostEvent::Status(status) => status_words(status),
        HostEvent::Stats(stats) => stats_words(stats),
        HostEvent::Event(event) => event_message_words(event),
        HostEvent::Log => {
            let log = host.log().unwrap();
            format!("log {} {} {}", log.tick, log.level.code(), hex(log.text))
        }
        HostEvent::Clock(verdict) => format!("clock {}", verdict_name(*verdict)),
        HostEvent::Done(kind) => format!("done {:02x}", kind.0),
        HostEvent::Refused(nack) => {
            format!("refused {:02x} {} {}", nack.kind.0, nack.reason.code(), nack.seq)
        }
        HostEvent::Closed(reason) => format!("closed {}", reason_words(*reason)),
    }
}

const fn verdict_name(verdict: PongVerdict) -> &'static str {
    match verdict {
        PongVerdict::Kept => "kept",
        PongVerdict::Slow => "slow",
        PongVerdict::Outlier => "outlier",
        PongVerdict::Impossible => "impossible",
        PongVerdict::Restarted => "restarted",
    }
}

fn samples_words(samples: &Samples<'_>) -> String {
    let h = samples.header;
    let mut text = format!(
        "{} {} {} {} {} {}",
        h.first_index,
        h.t0_tick,
        h.dt_ticks,
        h.rows,
        h.format.code(),
        h.dropped_total
    );
    for row in samples.rows() {
        for column in samples.layout().columns() {
            for k in 0..column.count {
                text += &match row.raw(usize::from(column.first) + usize::from(k)) {
                    Some(raw) => format!(" {raw}"),
                    None => format!(" {:08x}", row.value(column, k).unwrap().to_bits()),
                };
            }
        }
    }
    text
}

fn status_words(s: &Status) -> String {
    format!(
        "status {} {} {} {:04x} {} {} {} {} {}",
        s.last_cmd_id,
        s.state.code(),
        s.clamp.0,
        s.fault.0,
        s.applied_mn,
        s.target_mn,
        s.age_us,
        s.flags.0,
        s.rejected
    )
}

fn stats_words(s: &Stats) -> String {
    let rest =
        [s.sent, s.dropped_batches, s.dropped_rows, s.malformed, s.old, s.refused, s.unanswered];
    let rest = rest.map(|n| n.to_string());
    format!("stats {} {}", counter_words(&s.received), rest.join(" "))
}

fn event_message_words(e: &Event) -> String {
    let (before, after) = (e.before.code(), e.after.code());
    format!(
        "event {} {} {before} {after} {:04x} {} {}",
        e.tick,
        e.kind.code(),
        e.fault.0,
        e.dropped,
        e.value
    )
}

fn reason_words(reason: CloseReason) -> String {
    match reason {
        CloseReason::Requested => "requested".to_owned(),
        CloseReason::NoAnswer { hellos, bytes, garbage_bytes, echoes, frames, .. } => {
            format!("no_answer {hellos} {bytes} {garbage_bytes} {echoes} {frames}")
        }
        CloseReason::VersionMismatch { min, max } => format!("version_mismatch {min} {max}"),
        CloseReason::NoStylus => "no_stylus".to_owned(),
        CloseReason::BadIdent => "bad_ident".to_owned(),
        CloseReason::Unanswered { kind } => format!("unanswered {kind:02x}"),
        CloseReason::Refused { kind, reason } => format!("refused {kind:02x} {}", reason.code()),
        CloseReason::BadConfig { .. } => "bad_config".to_owned(),
        CloseReason::Lost { silent_us } => format!("lost {silent_us}"),
    }
}

fn counter_words(c: &Counters) -> String {
    let all = [
        c.ok,
        c.too_long,
        c.cobs,
        c.length,
        c.crc,
        c.echo,
        c.version,
        c.stale,
        c.duplicate,
        c.unknown,
        c.gap,
        c.garbage_bytes,
    ];
    all.map(|n| n.to_string()).join(" ")
}

/// How the host stands: state, session, back-off, rows, counters, gripper, CONFIG in force, last GRIP, clock.
pub fn state_words(host: &HostLink) -> String {
    let dash = || "-".to_owned();
    let loss = host.loss();
    let gripper = host.ident().map_or_else(dash, |i| format!("{} {}", hex(&i.uid), i.boot_id));
    let grip = host.last_grip().map_or_else(dash, grip_words);
    let clock = host.clock().map_or_else(dash, |clock| {
        format!("{} {} {:.3}", clock.boot_id(), clock.points(), clock.uncertainty_us())
    });
    format!(
        "= {} {:04x} reopen {} rows {} {} {} {} malformed {} unexpected {} counters {} gripper {gripper} config {} grip {grip} clock {clock}",
        host.state().name(),
        host.session(),
        host.reopen_after_us(),
        loss.received,
        loss.lost,
        loss.dropped_by_mcu,
        loss.restarts,
        host.malformed(),
        host.unexpected(),
        counter_words(host.counters()),
        host.in_force().map_or_else(dash, config_words),
    )
}
