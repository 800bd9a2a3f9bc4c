//! Explanation of a slip: what each method saw, and why the force moved, in sentences made from the events and curves of the model.

use crate::format::with_unit;
use crate::{Channel, EventKind, EventMark, Model, Series, Span};
use grip_session::report::{causes_text, confidence_text, speed_text};
use slip_core::{SlipReport, alarm::Method};

/// A force that differs by less than this share is the same one.
const SAME: f64 = 0.01;
/// A slip whose end is not among the events is looked at for so long (s).
const OPEN_S: f64 = 2.0;
/// The command before a slip is the last one of so many seconds.
const BEFORE_S: f64 = 0.1;
/// What stands where the force is not known.
const UNKNOWN: &str = "command: not known";

/// Why a slip was noticed, and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// From its first notice to its end, or to the newest sample.
    pub span: Span,
    /// When and for how long.
    pub title: String,
    /// A line for each method.
    pub saw: Vec<String>,
    /// Other causes, those that are ruled out and those that are possible.
    pub causes: Vec<String>,
    /// What the force did and by which law, estimate or limit.
    pub force: Vec<String>,
}

/// The slip at or before a time (s); `None` where there is none.
#[must_use]
pub fn slip(model: &Model, at_s: f64) -> Option<Explanation> {
    let (span, ended) = stretch(model, at_s)?;
    let marks: Vec<&EventMark> = model.events().marks.within(span).collect();
    let lasted = with_unit(span.length_s(), "s");
    let end = if ended { format!("{lasted} long") } else { "its end is not known".to_owned() };
    let title = format!("Slip at {:.4} s, {end}", span.from_s);
    let saw = Method::ALL.iter().map(|method| seen_by(model, span, &marks, *method)).collect();
    // The last report knows most.
    let reports = marks.iter().rev().filter_map(|mark| mark.slip);
    let causes = reports.map(|slip| causes_text(&slip)).find(|c| c.iter().any(Option::is_some));
    let causes = causes.into_iter().flatten().flatten().collect();
    let force = force(model, span, &marks);
    Some(Explanation { span, title, saw, causes, force })
}

/// Every slip with a notice in the span, in order of time.
pub fn slips(model: &Model, span: Span) -> impl Iterator<Item = Explanation> {
    let mut slipping = false;
    let starts = move |mark: &&EventMark| {
        let starts = is_slip(mark) && !slipping;
        slipping = is_slip(mark) || (slipping && !is_end(mark));
        starts
    };
    model.events().marks.within(span).filter(starts).filter_map(|mark| slip(model, mark.t_s))
}

const fn is_slip(mark: &EventMark) -> bool {
    matches!(mark.kind, EventKind::Incipient | EventKind::Gross)
}

const fn is_end(mark: &EventMark) -> bool {
    matches!(mark.kind, EventKind::Ended)
}

/// From the first notice of a slip to its end, and whether that is known.
fn stretch(model: &Model, at_s: f64) -> Option<(Span, bool)> {
    let before = Span { from_s: f64::NEG_INFINITY, to_s: at_s };
    let mut from_s = None;
    // Backwards to the first notice behind the end of the slip before.
    for mark in model.events().marks.within(before).rev() {
        if is_slip(mark) {
            from_s = Some(mark.t_s);
        } else if is_end(mark) && from_s.is_some() {
            break;
        }
    }
    let from_s = from_s?;
    let behind = Span { from_s, to_s: f64::INFINITY };
    let end_s = model.events().marks.within(behind).find(|mark| is_end(mark)).map(|mark| mark.t_s);
    let last_s = model.span().map_or(from_s, |data| data.to_s).min(from_s + OPEN_S);
    Some((Span::new(from_s, end_s.unwrap_or(last_s.max(from_s))), end_s.is_some()))
}

/// What a method has reported, or what its sensor shows.
fn seen_by(model: &Model, span: Span, marks: &[&EventMark], method: Method) -> String {
    let name = method.felt();
    let of = |mark: &&&EventMark| mark.slip.is_some_and(|slip| slip.method == method);
    let reports: Vec<(&EventMark, SlipReport)> =
        marks.iter().filter(of).filter_map(|mark| Some((*mark, mark.slip?))).collect();
    let Some((first, slip)) = reports.first() else { return silent(model, span, method) };
    let after = match first.t_s - span.from_s {
        after_s if after_s > 0.0 => format!("{} after the first notice", with_unit(after_s, "s")),
        _ => "first".to_owned(),
    };
    let highest = reports.iter().filter_map(|(_, slip)| slip.statistic).reduce(f32::max);
    let moved = reports.iter().filter_map(|(_, slip)| slip.moved_m).reduce(f32::max);
    let parts = [
        Some(format!("{name}: reported {} {after}", first.kind.name())),
        highest.map(|times| evidence(times, model.info().interval_s())),
        slip.confidence.map(confidence_text),
        speed_text(slip).map(|speed| format!("speed {speed}")),
        moved.map(|moved| format!("moved {}", with_unit(f64::from(moved), "m"))),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Evidence that is so many times the wanted time between false alarms (s).
fn evidence(times: f32, interval_s: f32) -> String {
    let evidence = with_unit(f64::from(times) * f64::from(interval_s), "s");
    format!("evidence of up to {evidence}, wanted one false alarm in {interval_s} s")
}

/// A method that reported nothing: what its sensor showed meanwhile.
fn silent(model: &Model, span: Span, method: Method) -> String {
    let name = method.felt();
    let stats = |channel| model.series(channel).and_then(|series| series.stats(span));
    let shown = match method {
        Method::Travel => stats(Channel::Travel)
            .map(|travel| with_unit(f64::from(travel.max) - f64::from(travel.min), "m"))
            .map(|moved| format!("its reading changed by {moved}")),
        Method::Stylus => stats(Channel::Stylus)
            .map(|_| format!("{} peaks and valleys passed", model.turns(span, 100_000).len())),
        // The model keeps a frame of every 10 ms: their number is not that of those that came.
        _ => model.taxel_frames(span).next().map(|_| "its frames came".to_owned()),
    };
    match shown {
        Some(shown) => format!("{name}: reported nothing; {shown}"),
        None => format!("{name}: no readings"),
    }
}

/// A force, always in newtons: commands of one slip are compared.
fn newton(force_n: f64) -> String {
    format!("{force_n:.2} N")
}

/// What the force did, and why.
fn force(model: &Model, span: Span, marks: &[&EventMark]) -> Vec<String> {
    let commands = commands(model, span);
    let (Some(first), Some(last)) = (commands.first(), commands.last()) else {
        return vec![UNKNOWN.to_owned()];
    };
    let (from_n, end_n) = (first[1], last[1]);
    let most_n = commands.iter().map(|point| point[1]).fold(from_n, f64::max);
    let mut lines = vec![format!(
        "command: from {} to {} at most, {} at the end",
        newton(from_n),
        newton(most_n),
        newton(end_n)
    )];
    lines.extend(law(marks, &commands, &estimates(model, span, marks)));
    let limit = model.series(Channel::ForceLimit).and_then(|series| series.stats(span));
    if let Some(limit_n) = limit.map(|limit| f64::from(limit.min)) {
        let reached = most_n >= limit_n * (1.0 - SAME);
        let how = if reached { "reached: the force rises no further" } else { "not reached" };
        lines.push(format!("limit: {}, {how}", newton(limit_n)));
    }
    let others = marks.iter().filter(|mark| {
        matches!(mark.kind, EventKind::Reflex | EventKind::Fault | EventKind::Client)
    });
    lines.extend(others.map(|mark| {
        let after = with_unit(mark.t_s - span.from_s, "s");
        format!("{}: after {after}, {}", mark.kind.name(), mark.text)
    }));
    lines
}

/// Which law moved the force: the reflex until there is an estimate, then that.
fn law(marks: &[&EventMark], commands: &[[f64; 2]], estimates: &[[f64; 2]]) -> Vec<String> {
    let from_n = commands.first().map_or(f64::NAN, |point| point[1]);
    let most_n = commands.iter().map(|point| point[1]).fold(from_n, f64::max);
    if most_n <= from_n * (1.0 + SAME) {
        return vec!["law: none raised the force".to_owned()];
    }
    let extrapolated = |slip: &SlipReport| slip.is_extrapolated() && slip.estimate_n.is_some();
    let mut lines = Vec::new();
    if marks.iter().filter_map(|mark| mark.slip).any(|slip| extrapolated(&slip)) {
        let why = "outside what the network was trained on, not used";
        lines.push(format!("estimate: {why}"));
    }
    let (Some([known_s, first_n]), Some([_, last_n])) = (estimates.first(), estimates.last())
    else {
        lines.push(format!(
            "law: reflex, without an estimate; it raised the force to {}",
            newton(most_n)
        ));
        return lines;
    };
    let at_n = commands.iter().take_while(|point| point[0] < *known_s).last();
    let at_n = at_n.map_or(from_n, |point| point[1]);
    if at_n > from_n * (1.0 + SAME) {
        let way = format!("from {} to {}", newton(from_n), newton(at_n));
        lines.push(format!("law: reflex until an estimate came, {way}"));
    }
    lines.push(format!(
        "law: estimate of the adequate force, {} at first, {} at last; command {} at most",
        newton(*first_n),
        newton(*last_n),
        newton(most_n)
    ));
    lines
}

/// Estimates of the adequate force during a slip (s, N): those of the states from the first that is another one than before the slip,
/// else those that the events report. What the network does not know is none.
fn estimates(model: &Model, span: Span, marks: &[&EventMark]) -> Vec<[f64; 2]> {
    let slips = || marks.iter().filter_map(|mark| Some((mark.t_s, mark.slip?)));
    let known = slips().filter(|(_, slip)| !slip.is_extrapolated());
    let reported: Vec<[f64; 2]> =
        known.filter_map(|(t_s, slip)| Some([t_s, f64::from(slip.estimate_n?)])).collect();
    let unknown = slips().any(|(_, slip)| slip.is_extrapolated() && slip.estimate_n.is_some());
    let Some(series) =
        model.series(Channel::Estimate).filter(|_| !(unknown && reported.is_empty()))
    else {
        return reported;
    };
    let before_n = series.at(span.from_s.next_down()).map(f64::from);
    let mut points = numbers(series, span);
    let is_old = |point: &&[f64; 2]| Some(point[1]) == before_n;
    let old = points.iter().take_while(is_old).count();
    points.drain(..old);
    if points.is_empty() { reported } else { points }
}

/// The values of a span that are numbers.
fn numbers(series: &Series, span: Span) -> Vec<[f64; 2]> {
    let points = series.samples(span).map(|(t_s, value, _)| [t_s, f64::from(value)]);
    points.filter(|point| point[1].is_finite()).collect()
}

/// Commands of a slip (s, N), the last one before it first.
fn commands(model: &Model, span: Span) -> Vec<[f64; 2]> {
    let Some(series) = model.series(Channel::Command) else { return Vec::new() };
    let from_s = span.from_s - BEFORE_S;
    let mut points = numbers(series, Span::new(from_s, span.to_s));
    let before = points.iter().take_while(|point| point[0] < span.from_s).count();
    points.drain(..before.saturating_sub(1));
    points
}

#[cfg(test)]
mod tests {
    use super::{Explanation, UNKNOWN, slip, slips};
    use crate::feed::Feed;
    use crate::{EventKind, EventMark, Model, Span};
    use slip_core::{
        PipelineState, SlipReport, alarm::Method, units::Micros, velocity::SpeedSource,
    };

    fn state(t_s: f64, command_n: f32) -> Feed {
        Feed::State(PipelineState {
            t: Micros::from_seconds(t_s),
            command_n: Some(command_n),
            ..PipelineState::UNKNOWN
        })
    }

    fn mark(t_s: f64, kind: EventKind, slip: SlipReport) -> Feed {
        Feed::Event(EventMark { slip: Some(slip), ..EventMark::plain(t_s, kind, "") })
    }

    /// A slip from 1.0 s to 1.2 s; the force rises from 5 N over 7 N to 12 N, and back to 10 N.
    fn model(report: SlipReport) -> Model {
        let mut model = Model::new(1 << 20);
        for i in 0..40 {
            let t_s = 0.8 + 0.01 * f64::from(i);
            let command_n = match t_s {
                0.0..1.0 => 5.0,
                1.0..1.05 => 7.0,
                1.05..1.1 => 12.0,
                _ => 10.0,
            };
            model.take(state(t_s + 0.001, command_n));
        }
        let seen = SlipReport {
            method: Method::Stylus,
            statistic: Some(8.0),
            confidence: Some(0.76),
            ..SlipReport::UNKNOWN
        };
        model.take(mark(1.0, EventKind::Incipient, seen));
        model.take(mark(1.04, EventKind::Gross, report));
        model.take(Feed::Event(EventMark::plain(1.2, EventKind::Ended, "")));
        model
    }

    fn explained(report: SlipReport) -> Explanation {
        slip(&model(report), 1.1).unwrap()
    }

    #[test]
    fn each_method_and_the_way_of_the_force_are_explained() {
        let report = SlipReport {
            method: Method::Travel,
            speed_m_s: Some(0.013),
            speed_sigma_m_s: Some(0.0003),
            speed_source: SpeedSource::Travel,
            moved_m: Some(0.0003),
            estimate_n: Some(9.5),
            ruled_out: 1,
            ..SlipReport::UNKNOWN
        };
        let found = explained(report);
        assert_eq!(found.title, "Slip at 1.0000 s, 200.0 ms long");
        let saw = [
            "vibration: reported incipient slip first, evidence of up to 4800 s, wanted one false alarm in 600 s, confidence 76 %",
            "travel: reported gross slip 40.00 ms after the first notice, speed 13.0 +- 0.3 mm/s (travel), moved 300.0 \u{b5}m",
            "pressure: no readings",
        ];
        assert_eq!(found.saw, saw);
        assert_eq!(found.causes, ["ruled out: knock"]);
        let force = [
            "command: from 5.00 N to 12.00 N at most, 10.00 N at the end",
            "law: reflex until an estimate came, from 5.00 N to 7.00 N",
            "law: estimate of the adequate force, 9.50 N at first, 9.50 N at last; command 12.00 N at most",
        ];
        assert_eq!(found.force, force);
    }

    #[test]
    fn an_estimate_of_a_state_counts_from_where_it_is_another_one_than_before() {
        let mut model = Model::new(1 << 20);
        for i in 0..40 {
            let t_s = 0.8 + 0.01 * f64::from(i);
            // That of the last slip stays until there is another one, which the events report at the end only.
            let (command_n, estimate_n) = match t_s {
                0.0..1.015 => (2.0, 22.0),
                1.015..1.035 => (3.0, 22.0),
                1.035..1.1 => (8.0, 9.0),
                _ => (11.0, 10.0),
            };
            let mut state =
                PipelineState { t: Micros::from_seconds(t_s), ..PipelineState::UNKNOWN };
            (state.command_n, state.estimate_n) = (Some(command_n), Some(estimate_n));
            model.take(Feed::State(state));
        }
        model.take(mark(1.0, EventKind::Gross, SlipReport::UNKNOWN));
        let ended = SlipReport { estimate_n: Some(10.0), ..SlipReport::UNKNOWN };
        model.take(mark(1.15, EventKind::Ended, ended));
        let force = [
            "command: from 2.00 N to 11.00 N at most, 11.00 N at the end",
            "law: reflex until an estimate came, from 2.00 N to 3.00 N",
            "law: estimate of the adequate force, 9.00 N at first, 10.00 N at last; command 11.00 N at most",
        ];
        assert_eq!(slip(&model, 1.1).unwrap().force, force);
    }

    #[test]
    fn without_an_estimate_that_is_used_the_reflex_has_raised_the_force() {
        let reflex = "law: reflex, without an estimate; it raised the force to 12.00 N";
        assert_eq!(explained(SlipReport::UNKNOWN).force[1], reflex);
        let report = SlipReport {
            estimate_n: Some(99.0),
            notes: slip_msg::EXTRAPOLATED,
            ..SlipReport::UNKNOWN
        };
        let unused = "estimate: outside what the network was trained on, not used";
        assert_eq!(explained(report).force[1..], [unused, reflex]);
    }

    #[test]
    fn the_slip_is_the_last_one_at_or_before_the_time() {
        let mut model = model(SlipReport::UNKNOWN);
        assert_eq!(slip(&model, 0.99), None);
        model.take(mark(1.3, EventKind::Gross, SlipReport::UNKNOWN));
        assert!(slip(&model, 1.2).unwrap().title.starts_with("Slip at 1.0000 s"));
        let open = slip(&model, 9.0).unwrap();
        assert_eq!(open.title, "Slip at 1.3000 s, its end is not known");
        assert_eq!(open.force, [UNKNOWN]);
    }

    #[test]
    fn each_slip_of_a_span_is_found_once() {
        let mut model = model(SlipReport::UNKNOWN);
        model.take(mark(1.3, EventKind::Gross, SlipReport::UNKNOWN));
        let starts = |from_s, to_s| -> Vec<f64> {
            slips(&model, Span::new(from_s, to_s)).map(|found| found.span.from_s).collect()
        };
        assert_eq!(starts(0.0, 9.0), [1.0, 1.3]);
        assert_eq!(starts(1.02, 1.1), [1.0], "the span begins within it");
        assert_eq!(starts(0.0, 0.9), [0.0; 0]);
    }

    #[test]
    fn what_is_only_observed_has_no_command() {
        let mut model = Model::new(1 << 20);
        model.take(mark(1.0, EventKind::Gross, SlipReport::UNKNOWN));
        assert_eq!(slip(&model, 1.0).unwrap().force, [UNKNOWN]);
    }
}
