//! The health of the link: rates, losses, clocks, latency, stages, sensors.

use super::{Seen, heading, row, row_in, sentence};
use crate::num;
use crate::palette::Tone;
use core::ops::RangeInclusive;
use eframe::egui::{RichText, Role, Ui, WidgetInfo};
use egui_plot::{Bar, BarChart, GridMark, Plot};
use grip_link::message::daemon::{Appended, Health, RealTime, SensorHealth};
use grip_scope::Channel;
use grip_scope::feed::ObserverSettings;
use grip_scope::format;

/// Height of the histogram (points).
const HIGH: f32 = 74.0;

pub(super) fn health(ui: &mut Ui, seen: &Seen<'_>) {
    source(ui, seen);
    sensors(ui, seen);
    match seen.model.health().latest.as_deref() {
        Some(point) => figures(ui, point, seen),
        None => {
            heading(ui, "Link");
            sentence(
                ui,
                "This source has no figures of a link: a running gripd and the demo have.",
            );
        }
    }
    scope(ui, seen);
    notices(ui, seen);
}

fn source(ui: &mut Ui, seen: &Seen<'_>) {
    heading(ui, "Source");
    row(ui, "state", seen.model.status().sentence());
    let info = seen.model.info();
    if let Some(daemon) = &info.daemon {
        row(ui, "daemon", daemon.name.clone());
        row(ui, "at", daemon.place.clone());
        let commands = match (daemon.dry_run, daemon.may_command) {
            (true, _) => "none: dry run",
            (false, true) => "allowed",
            (false, false) => "not allowed",
        };
        row(ui, "commands", commands);
        let real_time = match daemon.real_time {
            RealTime::Other(_) => format::NOTHING,
            reported => reported.name(),
        };
        row(ui, "real time", real_time);
    }
    if let Some((file, span)) = &info.recording {
        row(ui, "file", file.file_name().unwrap_or_default().to_string_lossy());
        row(ui, "holds", format::duration(span.length_s()));
    }
    if let Some(gripper) = info.gripper {
        let uid: String = gripper.uid.iter().take(6).map(|byte| format!("{byte:02x}")).collect();
        row(ui, "gripper", uid);
        row(ui, "link", gripper.link.name());
        let limit = gripper
            .force_max_n
            .map_or(format::NOTHING.to_owned(), |n| format::with_unit(n.into(), "N"));
        row(ui, "force limit", limit);
    }
}

/// The sensors in the order of a state, and the channels that each of them fills.
const SENSORS: [(&str, &[Channel]); 4] = [
    ("stylus", &[Channel::Stylus, Channel::SecondStylus]),
    ("travel", &[Channel::Travel]),
    ("pressure", &[Channel::Pressure]),
    ("reference", &[Channel::Reference]),
];
/// Readings older than this (ms) raise no force, but for what the sensor and the line are known to need.
const LATE_MS: f32 = 20.0;
/// What stands for the health of a sensor that never sent anything.
const ABSENT: &str = "\u{2013}";

/// Whether any of these channels ever had a sample.
fn ever(seen: &Seen<'_>, channels: &[Channel]) -> bool {
    let any = |channel| seen.model.series(channel).is_some_and(|series| series.latest().is_some());
    channels.iter().copied().any(any)
}

fn sensors(ui: &mut Ui, seen: &Seen<'_>) {
    let Some(state) = seen.model.info().state else { return };
    heading(ui, "Grasp and sensors");
    row(ui, "scene", state.scene.name());
    row(ui, "controller", state.grip.name());
    let unread = seen.model.info().gripper.is_some_and(|gripper| !gripper.link.streams());
    for ((name, channels), health) in SENSORS.into_iter().zip(state.sensors) {
        let name = channels
            .first()
            .filter(|_| name == "stylus")
            .map_or(name, |of| seen.model.info().name(*of));
        let absent = health == SensorHealth::Good && !ever(seen, channels);
        if absent || health == SensorHealth::Absent {
            row(ui, name, ABSENT);
            continue;
        }
        if unread {
            row(ui, name, "unread");
            continue;
        }
        let good = health == SensorHealth::Good;
        let tone = if good { Tone::Green } else { Tone::Red };
        let mark = if good { health.name().to_owned() } else { format!("! {}", health.name()) };
        row_in(ui, name, RichText::new(mark).monospace().color(seen.palette.tone(tone)));
    }
    if let Some(late_ms) = state.late_ms {
        let text = RichText::new(format::with_unit(f64::from(late_ms) * 1e-3, "s")).monospace();
        let late = late_ms > LATE_MS;
        let tone = seen.palette.tone(Tone::Orange);
        row_in(ui, "evidence age", if late { text.color(tone) } else { text });
    }
    if state.fault.is_fault() {
        let text = RichText::new(format!("! {:04x}", state.fault.0)).monospace();
        row_in(ui, "gripper fault", text.color(seen.palette.tone(Tone::Red)));
    }
}

fn figures(ui: &mut Ui, point: &Health, seen: &Seen<'_>) {
    heading(ui, "Link");
    let rate =
        point.rate_hz.map_or(format::NOTHING.to_owned(), |hz| format::with_unit(hz.into(), "Hz"));
    row(ui, "sample rate", rate);
    row(ui, "samples", format::count(point.samples));
    counted(ui, "rows lost", point.lost, seen);
    counted(ui, "CRC errors", point.bad.crc.into(), seen);
    let other =
        [point.bad.too_long, point.bad.cobs, point.bad.length, point.bad.useless, point.bad.gap];
    counted(ui, "other bad frames", other.iter().map(|n| u64::from(*n)).sum(), seen);
    let dropped = point.dropped;
    let inside = dropped.service + dropped.recorder + u64::from(dropped.clients);
    counted(ui, "dropped inside", inside, seen);
    row(ui, "lines opened", format::count(u64::from(point.reconnects) + 1));
    row(ui, "commands", format::count(point.commands));
    let seconds = |us: f64| format::with_unit(us * 1e-6, "s");
    let clock = point.appended.and_then(|appended| appended.clock);
    let clock = clock.map_or(format::NOTHING.to_owned(), |clock| {
        let offset_us = num::signed(clock.offset_us);
        format!("{} +- {}", seconds(offset_us), seconds(clock.half_us.into()))
    });
    row(ui, "clock offset", clock);
    row(
        ui,
        "recording",
        format!(
            "{}, {}",
            point.recording.name(),
            format::with_unit(num::counter(point.recorded_bytes), "B")
        ),
    );
    latency(ui, point, seen);
    heading(ui, "Work");
    for (name, samples) in
        ["bands", "gate", "other methods", "observation"].into_iter().zip(point.stages)
    {
        let share = 100.0 * num::counter(samples) / num::counter(point.samples.max(1));
        row(ui, name, format!("{share:5.1} % of samples"));
    }
    row(ui, "slips", format::count(point.slips.into()));
}

fn counted(ui: &mut Ui, name: &str, count: u64, seen: &Seen<'_>) {
    let text = RichText::new(if count == 0 {
        "0".to_owned()
    } else {
        format!("! {}", format::count(count))
    });
    let text = text.monospace();
    row_in(ui, name, if count == 0 { text } else { text.color(seen.palette.tone(Tone::Orange)) });
}

fn latency(ui: &mut Ui, health: &Health, seen: &Seen<'_>) {
    heading(ui, "Latency, last byte to command");
    let figures = [
        ("p50", health.latency.p50_us),
        ("p99", health.latency.p99_us),
        ("p99.9", health.appended.and_then(|appended| appended.p999_us)),
        ("max", health.latency.max_us),
    ];
    ui.horizontal(|ui| {
        for (name, value) in figures {
            ui.vertical(|ui| {
                ui.weak(name);
                let text = value.map_or(format::NOTHING.to_owned(), |us| {
                    format::with_unit(f64::from(us) * 1e-6, "s")
                });
                ui.monospace(text);
            });
        }
    });
    match health.appended.map(|appended| appended.histogram) {
        None => sentence(ui, "This gripd is older than gripmon and sends quantiles only."),
        Some(counts) if counts.iter().all(|count| *count == 0) => {
            sentence(ui, "No command was sent yet.");
        }
        Some(counts) => histogram(ui, &counts, seen),
    }
}

/// Bars by their logarithm, so that one slow command in a million is seen.
fn histogram(ui: &mut Ui, counts: &[u64], seen: &Seen<'_>) {
    let (first, last) = filled(counts);
    let bars = counts.iter().enumerate().take(last).skip(first);
    let bar = |(bucket, count): (usize, &u64)| {
        Bar::new(num::count(bucket), (1.0 + num::counter(*count)).log10()).width(0.9)
    };
    let chart = BarChart::new("commands", bars.map(bar).collect());
    let label = |mark: GridMark, _: &RangeInclusive<f64>| bound_text(num::whole(mark.value));
    let third = last.saturating_sub(first).div_ceil(3);
    let marks = move |_| {
        let mark = |bucket| GridMark { value: num::count(bucket), step_size: num::count(third) };
        (first..last).step_by(third.max(1)).map(mark).collect()
    };
    let plot = Plot::new("latency")
        .height(HIGH)
        .show_axes([true, false])
        .show_grid(false)
        .x_axis_formatter(label)
        .x_grid_spacer(marks)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .show_x(false)
        .show_y(false);
    let colour = seen.palette.tone(Tone::Blue);
    let shown = plot.show(ui, |plot| plot.bar_chart(chart.color(colour).allow_hover(false)));
    shown.response.widget_info(|| WidgetInfo::labeled(Role::Figure, true, "Latency histogram"));
    shown.response.on_hover_text(
        "Commands by latency; heights are logarithmic, so that single slow ones are seen.",
    );
}

/// The upper bound of a bucket.
fn bound_text(bucket: usize) -> String {
    let upper_ns = Appended::upper_ns(bucket);
    upper_ns.map_or("more".to_owned(), |ns| format::with_unit(num::counter(ns) * 1e-9, "s"))
}

/// From the first to behind the last bucket that holds anything, with one more at each side.
fn filled(counts: &[u64]) -> (usize, usize) {
    let holds = |count: &u64| *count > 0;
    let first = counts.iter().position(holds).unwrap_or(0);
    let last = counts.iter().rposition(holds).map_or(counts.len(), |last| last + 1);
    (first.saturating_sub(1), (last + 1).min(counts.len()))
}

fn scope(ui: &mut Ui, seen: &Seen<'_>) {
    heading(ui, "This program");
    let health = seen.model.health();
    row(ui, "history", format::with_unit(num::count(seen.model.bytes()), "B"));
    counted(ui, "gaps", seen.model.events().gapped(), seen);
    if let Some(settings) = seen.model.info().observer {
        let settings = match settings {
            ObserverSettings::Source { .. } => "those of the source",
            ObserverSettings::Shipped => "shipped settings",
        };
        row(ui, "settings", settings);
    }
    for (name, count) in [
        ("late rows", health.late_rows),
        ("stray states", health.stray_states),
        ("absurd values", health.huge),
        ("NaN of the stylus", health.nan),
        ("values too late", health.misplaced),
    ] {
        if count > 0 {
            counted(ui, name, count, seen);
        }
    }
}

fn notices(ui: &mut Ui, seen: &Seen<'_>) {
    if seen.model.notices().len() == 0 {
        return;
    }
    heading(ui, "Last notices");
    for line in seen.model.notices().rev().take(6) {
        sentence(ui, line);
    }
}

#[cfg(test)]
mod tests {
    use super::filled;

    #[test]
    fn empty_ends_of_a_histogram_are_left_out() {
        assert_eq!(filled(&[0, 0, 0, 5, 1, 0, 0]), (2, 6));
        assert_eq!(filled(&[1]), (0, 1));
        assert_eq!(filled(&[0, 0]), (0, 2));
    }
}
