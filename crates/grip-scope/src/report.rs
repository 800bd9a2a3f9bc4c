//! Report of the grasp in a span of the model, as a page: numbers, curves, an explanation of each slip, events.

use crate::channel::Channel;
use crate::explain::{self, Explanation};
use crate::feed::EventKind;
use crate::format::{count, duration, prefix_of, with_unit};
use crate::model::{Bucket, Doing, Model, Stats};
use crate::span::Span;
use grip_plot::report::{Block, Cell, Figure, Report, Section, Table};
use grip_plot::{Axis, Chart, Layer, Mark, Scale};
use grip_session::report::speed_text;
use slip_core::SlipReport;

/// Parts of a curve: twice as many points, lowest and highest of each.
const PARTS: usize = 400;
/// Slips that are explained, and events that are listed; the rest is counted.
const MOST: usize = 100;

/// A page about a span of a source; `None` where it has no sample.
#[must_use]
pub fn grasp(model: &Model, span: Span, source: &str) -> Option<Report> {
    let known = model.channels().any(|channel| stats(model, channel, span).is_some());
    let span = model.span().and_then(|data| data.common(span)).filter(|_| known)?;
    let slips: Vec<Explanation> = explain::slips(model, span).collect();
    let mut report = Report { title: format!("Grasp: {source}"), ..Report::default() };
    report.summary = summary(model, span, slips.len());
    report.push(Section::new("numbers", "Numbers").with(numbers(model, span, &slips)));
    report.push(curves(model, span, &slips));
    report.push(explanations(&slips));
    report.push(events(model, span));
    Some(report)
}

fn stats(model: &Model, channel: Channel, span: Span) -> Option<Stats> {
    model.series(channel)?.stats(span)
}

/// The whole grasp in a sentence: slips, how far the object moved, the force at the end, and how many times that what it needs is.
fn sentence(model: &Model, span: Span, slips: usize) -> String {
    let at_end = |channel| {
        let series = model.series(channel)?;
        let end_s = series.latest()?.0.min(span.to_s);
        series.at(end_s).filter(|value| value.is_finite()).map(f64::from)
    };
    let moved_m = stats(model, Channel::Travel, span).map(|stats| f64::from(stats.peak_to_peak()));
    let held_n = at_end(Channel::Command);
    let need_n =
        at_end(Channel::NeedTruth).or(at_end(Channel::Need)).filter(|need_n| *need_n > 0.0);
    let end = match model.events().doings.within(span).last().map(|stretch| stretch.what) {
        Some(Doing::Dropped) => "dropped with",
        Some(Doing::Crushed) => "crushed with",
        Some(Doing::Slipping) => "still slipping with",
        Some(Doing::Held) => "held with",
        Some(Doing::Idle | Doing::Moving) | None => "command at the end",
    };
    let slips = match slips {
        0 => "No slip was found".to_owned(),
        1 => "1 slip".to_owned(),
        slips => format!("{slips} slips"),
    };
    let parts = [
        Some(slips),
        moved_m.map(|moved_m| format!("moved {:.2} mm", 1e3 * moved_m)),
        held_n.map(|held_n| format!("{end} {held_n:.2} N")),
        held_n
            .zip(need_n)
            .map(|(held_n, need_n)| format!("{:.2} of what was needed", held_n / need_n)),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    format!("{}.", parts.join(", "))
}

/// What a reader must know first.
fn summary(model: &Model, span: Span, slips: usize) -> Vec<String> {
    let from_to = format!("{:.4} s to {:.4} s", span.from_s, span.to_s);
    let clock = if model.is_device_time() {
        "Times are those of the gripper's clock."
    } else {
        "The gripper's clock began again meanwhile: times go on over it."
    };
    let times = format!("{from_to}, {}. {clock}", duration(span.length_s()));
    let mut lines = vec![sentence(model, span, slips), times];
    if model.series(Channel::Command).is_none() {
        let sentence = "The source has samples only: slips are those that are found in them now, with the \
                        shipped settings; commands of that time are not known.";
        lines.push(sentence.to_owned());
    }
    let gaps = model.events().gaps.within(span).count();
    if gaps > 0 {
        lines.push(format!("{gaps} gaps without samples; curves are joined over them."));
    }
    lines.push(format!("Written by grip-scope {}.", env!("CARGO_PKG_VERSION")));
    lines
}

/// The numbers of the grasp.
fn numbers(model: &Model, span: Span, slips: &[Explanation]) -> Table {
    let of = |channel| stats(model, channel, span);
    let highest = |channel| {
        of(channel).map(|stats| with_unit(f64::from(stats.max), model.info().unit(channel)))
    };
    let travel = of(Channel::Travel).map(|stats| with_unit(f64::from(stats.peak_to_peak()), "m"));
    let slipped_s: f64 = slips.iter().map(|slip| slip.span.length_s()).sum();
    let longest_s = slips.iter().map(|slip| slip.span.length_s()).reduce(f64::max);
    let marks = |kind| model.events().marks.within(span).filter(|mark| mark.kind == kind).count();
    let counted = |kind| Some(marks(kind).to_string());
    let reports = || model.events().marks.within(span).filter_map(|mark| mark.slip);
    let moved = reports().filter_map(|slip| slip.moved_m).reduce(f32::max);
    let moved = moved.map(|most| with_unit(f64::from(most), "m"));
    let faster = |a: SlipReport, b: SlipReport| if b.speed_m_s > a.speed_m_s { b } else { a };
    let speed = reports().reduce(faster).and_then(|slip| speed_text(&slip));
    let rows = [
        ("samples", of(Channel::Stylus).map(|stats| count(stats.count))),
        ("slips", Some(slips.len().to_string())),
        ("reports of gross slip", counted(EventKind::Gross)),
        ("time in slips", Some(with_unit(slipped_s, "s"))),
        ("longest slip", longest_s.map(|time_s| with_unit(time_s, "s"))),
        ("highest evidence of a slip", highest(Channel::Statistic)),
        ("highest command", highest(Channel::Command)),
        ("highest normal force, as the state has it", highest(Channel::Applied)),
        ("highest normal force of a sample", highest(Channel::NormalForce)),
        ("highest estimate of the adequate force", highest(Channel::Estimate)),
        ("limit of the force", highest(Channel::ForceLimit)),
        ("travel, from lowest to highest", travel),
        ("largest movement that was reported", moved),
        ("highest slip speed that was reported", speed),
        ("reflexes", counted(EventKind::Reflex)),
        ("faults", counted(EventKind::Fault)),
    ];
    let mut table = Table::new("figures", "Of the whole span", &["what", "value"]);
    // What is not known has no row.
    for (what, value) in rows.into_iter().filter_map(|(what, value)| Some((what, value?))) {
        table.push(vec![Cell::text(what), Cell::text(value)]);
    }
    table
}

/// Curves of one unit in one chart.
struct Plot {
    title: &'static str,
    channels: &'static [Channel],
}

const PLOTS: [Plot; 6] = [
    Plot {
        title: "Force",
        channels: &[
            Channel::Command,
            Channel::Applied,
            Channel::Estimate,
            Channel::NeedLow,
            Channel::Need,
            Channel::NeedHigh,
            Channel::NeedTruth,
        ],
    },
    Plot { title: "Travel", channels: &[Channel::Travel] },
    Plot { title: "Slip speed as measured", channels: &[Channel::Velocity] },
    Plot { title: "Evidence of a slip", channels: &[Channel::Statistic, Channel::OwnStatistic] },
    Plot {
        title: "Normal and tangential force",
        channels: &[Channel::NormalForce, Channel::TangentialForce],
    },
    Plot { title: "Stylus", channels: &[Channel::Stylus, Channel::SecondStylus] },
];

impl Plot {
    fn title(&self, model: &Model) -> String {
        match self.channels {
            [Channel::Stylus, ..] => model.info().stylus_title(),
            _ => self.title.to_owned(),
        }
    }

    /// Evidence goes over decades; what is beyond its axis stands at the edge.
    fn scale(&self, model: &Model) -> (Scale, [f64; 2]) {
        match self.channels {
            [Channel::Statistic, ..] => (Scale::Log, model.info().evidence_axis()),
            _ => (Scale::Linear, [f64::NEG_INFINITY, f64::INFINITY]),
        }
    }
}

/// The curves, those without samples left out.
fn curves(model: &Model, span: Span, slips: &[Explanation]) -> Section {
    let text = format!(
        "Each curve goes through the lowest and the highest sample of each of {PARTS} parts."
    );
    let section = Section::new("curves", "Curves").with(text);
    let charts = PLOTS.iter().filter_map(|plot| chart(model, span, slips, plot));
    match charts.reduce(Chart::above) {
        Some(chart) => section.with(Figure {
            id: "curves".into(),
            caption: "Slips are shaded; a triangle is a reflex.".into(),
            chart,
        }),
        None => section,
    }
}

fn chart(model: &Model, span: Span, slips: &[Explanation], plot: &Plot) -> Option<Chart> {
    let (scale, [least, most]) = plot.scale(model);
    let curves: Vec<(Channel, Vec<(f64, f64)>)> = plot
        .channels
        .iter()
        .map(|channel| {
            let mut points = points(model, *channel, span, scale);
            points.iter_mut().for_each(|(_, value)| *value = value.clamp(least, most));
            (*channel, points)
        })
        .filter(|(_, points)| !points.is_empty())
        .collect();
    let unit = model.info().unit(curves.first()?.0);
    let values = || curves.iter().flat_map(|(_, points)| points).map(|(_, value)| *value);
    let (low, high) =
        values().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    let (factor, prefix) = prefix_of(low.abs().max(high.abs()), unit);
    let label = format!("{prefix}{unit}");
    let mut chart = Chart::new(plot.title(model), Axis::linear("s"), Axis { label, scale });
    for (channel, points) in &curves {
        let scaled = points.iter().map(|(t_s, value)| (*t_s, value / factor)).collect();
        chart = chart.with(Layer::line(model.info().name(*channel), scaled));
    }
    if scale == Scale::Log {
        let interval_s = model.info().interval_s();
        let line =
            [span.from_s, span.to_s].map(|t_s| (t_s, f64::from(interval_s) / factor)).to_vec();
        let name = format!("interval {interval_s} s");
        chart = chart.with(Layer::line(name, line).drawn_as(Mark::DashedLine));
    }
    let reflexes = model.events().marks.within(span).filter(|mark| mark.kind == EventKind::Reflex);
    let reflexes: Vec<(f64, f64)> = reflexes.map(|mark| (mark.t_s, high / factor)).collect();
    if !reflexes.is_empty() {
        chart = chart.with(Layer::markers("reflex", reflexes).drawn_as(Mark::TrianglesDown));
    }
    let slips = slips.iter().filter_map(|slip| slip.span.common(span));
    Some(chart.shaded(slips.map(|slip| (slip.from_s, slip.to_s)).collect()))
}

/// A channel as points: the lowest and the highest of each part, on a linear scale without readings that no sensor sends.
fn points(model: &Model, channel: Channel, span: Span, scale: Scale) -> Vec<(f64, f64)> {
    let Some(series) = model.series(channel) else { return Vec::new() };
    let range = match scale {
        Scale::Linear | Scale::Percent => series.robust_range(span),
        Scale::Log => Some((f32::MIN, f32::MAX)),
    };
    let Some((low, high)) = range else { return Vec::new() };
    let mut parts: Vec<Bucket> = Vec::new();
    series.envelope(span, PARTS, &mut parts);
    let both = |part: &Bucket| {
        let t_s = f64::midpoint(part.from_s, part.to_s);
        let ends = [part.min, part.max];
        let shown = if part.min < part.max { 2 } else { 1 };
        ends.into_iter().take(shown).map(move |value| (t_s, value))
    };
    let seen = parts.iter().flat_map(both).filter(|(_, value)| (low..=high).contains(value));
    seen.map(|(t_s, value)| (t_s, f64::from(value))).collect()
}

/// What each method saw, and why the force moved.
fn explanations(slips: &[Explanation]) -> Section {
    let mut section = Section::new("slips", "Slips");
    if slips.is_empty() {
        return section.with("No slip was reported.");
    }
    for (number, slip) in slips.iter().take(MOST).enumerate() {
        let saw = table(format!("saw-{number}"), "What each method saw", &slip.saw);
        let force = table(format!("force-{number}"), "Why the force moved", &slip.force);
        section = section.with(Block::Heading(slip.title.clone())).with(saw);
        if !slip.causes.is_empty() {
            section = section.with(table(format!("causes-{number}"), "Other causes", &slip.causes));
        }
        section = section.with(force);
    }
    match slips.len().saturating_sub(MOST) {
        0 => section,
        more => section.with(format!("{more} later slips are not explained here.")),
    }
}

/// Lines of the form `who: what`.
fn table(id: String, caption: &str, lines: &[String]) -> Table {
    let mut table = Table::new(id, caption, &["who", "what"]);
    for line in lines {
        let (who, what) = line.split_once(": ").unwrap_or(("", line));
        table.push(vec![Cell::text(who), Cell::text(what)]);
    }
    table
}

/// What happened, in order.
fn events(model: &Model, span: Span) -> Section {
    let mut table = Table::new("event-list", "In order of time", &["at (s)", "event", "text"]);
    let all = || model.events().marks.within(span);
    for mark in all().take(MOST) {
        let at = format!("{:.4}", mark.t_s);
        table.push(vec![Cell::text(at), Cell::text(mark.kind.name()), Cell::text(&mark.text)]);
    }
    let section = Section::new("events", "Events").with(table);
    match all().count().saturating_sub(MOST) {
        0 => section,
        more => section.with(format!("{more} later events are not listed.")),
    }
}

#[cfg(test)]
mod tests {
    use super::{Scale, grasp};
    use crate::channel::Channel;
    use crate::feed::{EventKind, EventMark, Feed, RowBlock, StylusInfo};
    use crate::model::Model;
    use crate::span::Span;
    use grip_link::message::Unit;
    use slip_core::{
        PipelineState, SlipReport, alarm::Method, units::Micros, velocity::SpeedSource,
    };

    /// Two seconds; a slip from 1.0 s to 1.2 s, over which the object travels 1.5 mm and the force rises from 5 N to 12 N.
    fn model() -> Model {
        let mut model = Model::new(1 << 22);
        model.take(Feed::Stylus(StylusInfo::one(Unit::Metre)));
        let times_us: Vec<u64> = (0..2000).map(|i| 1000 * i).collect();
        let travel = times_us.iter().map(|t_us| match t_us {
            0..1_000_000 => 0.0,
            _ => 0.0015,
        });
        let stylus = |t_us: &u64| if *t_us == 500_000 { 1e30 } else { 1e-5 };
        let columns = vec![
            (Channel::Stylus, times_us.iter().map(stylus).collect()),
            (Channel::Travel, travel.collect()),
        ];
        model.take(Feed::Rows(RowBlock { times_us, columns, ..RowBlock::default() }));
        for i in 0..200 {
            let t = Micros(10_000 * i);
            let command_n = Some(if t.0 < 1_100_000 { 5.0 } else { 12.0 });
            let statistic = Some(match t.0 {
                0 => 0.0,
                1_050_000 => 8.0,
                _ => 0.1,
            });
            model.take(Feed::State(PipelineState {
                t,
                command_n,
                statistic,
                ..PipelineState::UNKNOWN
            }));
        }
        let slip = SlipReport {
            method: Method::Stylus,
            statistic: Some(8.0),
            speed_m_s: Some(0.013),
            speed_sigma_m_s: Some(0.0003),
            speed_source: SpeedSource::Gravity,
            ..SlipReport::UNKNOWN
        };
        let plain = EventMark::plain;
        let gross = plain(1.0, EventKind::Gross, "a <gross> slip");
        model.take(Feed::Event(EventMark { slip: Some(slip), ..gross }));
        model.take(Feed::Event(plain(1.05, EventKind::Reflex, "12 N")));
        model.take(Feed::Event(plain(1.2, EventKind::Ended, "")));
        model
    }

    #[test]
    fn numbers_curves_slips_and_events_stand_on_the_page() {
        let report = grasp(&model(), Span::new(0.0, 9.0), "run.mcap").unwrap();
        let numbers = report.tables()[0].markdown();
        for row in [
            "| samples | 2,000 |",
            "| slips | 1 |",
            "| longest slip | 200.0 ms |",
            "| highest command | 12.00 N |",
            "| travel, from lowest to highest | 1.500 mm |",
            "| reflexes | 1 |",
            "| highest slip speed that was reported | 13.0 +- 0.3 mm/s (gravity) |",
        ] {
            assert!(numbers.contains(row), "{row} in {numbers}");
        }
        assert!(!numbers.contains("limit of the force"), "it is not known: {numbers}");
        let force = &report.figures()[0].chart;
        let [travel, _, stylus] = force.below.as_slice() else { panic!("{force:?}") };
        assert_eq!([&force.title, &travel.title, &stylus.title], ["Force", "Travel", "Stylus"]);
        // The spike that no sensor sends does not scale the curve.
        assert_eq!(stylus.y.label, "\u{b5}m");
        assert!(stylus.layers[0].points.iter().all(|(_, value)| (value - 10.0).abs() < 1e-3));
        assert_eq!(force.spans, [(1.0, 1.2)]);
        let html = report.html().unwrap();
        for text in [
            "<h1>Grasp: run.mcap</h1>",
            "Slip at 1.0000 s, 200.0 ms long",
            "reported gross slip first, evidence of up to 4800 s, wanted one false alarm in 600 s",
            "from 5.00 N to 12.00 N at most, 12.00 N at the end",
            "1 slip, moved 1.50 mm, command at the end 12.00 N.",
            "a &#60;gross&#62; slip",
        ] {
            assert!(html.contains(text), "{text} in {html}");
        }
        for outside in ["src=", "<script", "<link", "@import", "href=\"http"] {
            assert!(!html.contains(outside), "{outside}");
        }
    }

    #[test]
    fn evidence_stands_on_a_scale_of_its_own() {
        let report = grasp(&model(), Span::new(0.0, 9.0), "run.mcap").unwrap();
        let statistic = &report.figures()[0].chart.below[1];
        // Evidence of nothing stands at the lower edge, and the interval is a line.
        assert_eq!((statistic.y.scale, statistic.layers[0].points.len()), (Scale::Log, 200));
        assert_eq!(statistic.layers[0].points[0].1, 1e-4);
        // The alarm rises over it, however seldom it is.
        let top = statistic.layers[0].points.iter().map(|(_, value)| *value).fold(0.0, f64::max);
        assert_eq!(top, 4800.0);
        assert_eq!(statistic.layers[1].points, [(0.0, 600.0), (1.999, 600.0)]);
    }

    #[test]
    fn a_span_without_samples_has_no_page_and_one_without_slips_has_no_explanation() {
        assert!(grasp(&model(), Span::new(20.0, 21.0), "").is_none());
        assert!(grasp(&Model::new(1 << 20), Span::new(0.0, 1.0), "").is_none());
        let html = grasp(&model(), Span::new(0.0, 0.9), "").unwrap().html().unwrap();
        assert!(html.contains("No slip was reported.") && !html.contains("Why the force moved"));
    }
}
