//! Events of pipeline steps, and their lines for people or machines. Names and units of the JSON fields are a contract.
//!
//! An event holds codes and numbers; its words are made where it is shown.

use core::fmt;
use serde::{Serialize, Serializer, ser::SerializeMap};
use slip_core::{
    Cause, CauseSet, Phase, SlipReport, Step,
    alarm::Method,
    detector::FloorHealth,
    esc::{Flag, Flags, Reading},
    estimate::{Features, ForceEstimate},
    grip::GripEvent,
    health::{Sensor, SensorHealth},
    units::Micros,
    velocity::{SpeedSource, Velocity},
};

/// Something worth a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A slip has been noticed, has become gross, has been certified, or has ended.
    Slip(SlipReport),
    /// The fingers lost the object, touch it again, or closed on nothing.
    Grip {
        /// Device time.
        t: Micros,
        /// What the controller found out.
        event: GripEvent,
        /// Commanded force (N).
        command_n: Option<f32>,
    },
    /// The state of a sensor, of the noise floor or of the device's clock has changed.
    Health {
        /// Device time.
        t: Micros,
        /// What is in which state now.
        condition: Condition,
    },
}

impl Event {
    /// Events that a step leads to, at most.
    pub const MOST: usize = 7;
}

/// What can be good or bad, with its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// A sensor.
    Sensor(Sensor, SensorHealth),
    /// The noise floor of the stylus.
    Floor(FloorHealth),
    /// The device's clock.
    Clock(ClockHealth),
}

impl Condition {
    /// `stylus`, `travel`, `pressure` or `reference`; `floor` for the noise floor of the stylus, `clock` for that of the device.
    #[must_use]
    pub fn channel(self) -> &'static str {
        match self {
            Self::Sensor(sensor, _) => sensor.name(),
            Self::Floor(_) => "floor",
            Self::Clock(_) => "clock",
        }
    }

    /// `good`, or what is wrong: `frozen`, `saturated`, `failed`, `jumped`, `backwards`, `doubted`, `coarse`, `lost`; of
    /// the reference also `late`, `uncoupled`; of the floor `doubtful`: not confirmed yet; of the clock `stopped`, `back`, `forward`,
    /// `fast`, `slow`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sensor(_, health) => health.name(),
            Self::Floor(health) => health.name(),
            Self::Clock(health) => health.name(),
        }
    }
}

slip_core::named! {
    /// State of the device's clock.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum ClockHealth {
        fn name: "The name used in output lines.";
    }
    #[default]
    Good: "Ticks run at the nominal rate.", "good";
    Stopped: "Ticks do not advance; rows are timed by their numbers.", "stopped";
    Back: "Ticks went back.", "back";
    Forward: "Ticks jumped ahead of row numbers and host.", "forward";
    Fast: "Ticks run more than 1 % fast.", "fast";
    Slow: "Ticks run more than 1 % slow.", "slow";
}

impl Serialize for Event {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut line = serializer.serialize_map(None)?;
        match self {
            Self::Slip(slip) => slip_entries(slip, &mut line)?,
            Self::Grip { t, event, command_n } => {
                line.serialize_entry("type", "grip")?;
                line.serialize_entry("t_s", &t.as_seconds())?;
                line.serialize_entry("event", event.name())?;
                line.serialize_entry("command_n", command_n)?;
            }
            Self::Health { t, condition } => {
                line.serialize_entry("type", "health")?;
                line.serialize_entry("t_s", &t.as_seconds())?;
                line.serialize_entry("channel", condition.channel())?;
                line.serialize_entry("health", condition.name())?;
            }
        }
        line.end()
    }
}

/// The entries of a slip; `null` where nothing is known.
fn slip_entries<M: SerializeMap>(slip: &SlipReport, line: &mut M) -> Result<(), M::Error> {
    let ended = slip.phase == Phase::Ended;
    line.serialize_entry("type", if ended { "slip_end" } else { "slip" })?;
    line.serialize_entry("t_s", &slip.t.as_seconds())?;
    if ended {
        line.serialize_entry("duration_s", &slip.duration_s)?;
    } else {
        line.serialize_entry("phase", slip.phase.name())?;
        line.serialize_entry("method", slip.method.name())?;
        line.serialize_entry("statistic", &slip.statistic)?;
        line.serialize_entry("confidence", &slip.confidence)?;
    }
    line.serialize_entry("certified", &slip.certified_s.is_some())?;
    line.serialize_entry("certified_interval_s", &slip.certified_s)?;
    if !ended {
        for (name, bits) in [("ruled_out", slip.ruled_out), ("possible", slip.possible)] {
            let causes: Vec<_> = CauseSet::from_bits(bits).iter().map(Cause::name).collect();
            line.serialize_entry(name, &causes)?;
        }
    }
    line.serialize_entry("speed_m_s", &slip.speed_m_s)?;
    line.serialize_entry("speed_sigma_m_s", &slip.speed_sigma_m_s)?;
    let source = Some(slip.speed_source).filter(|source| *source != SpeedSource::None);
    line.serialize_entry("speed_source", &source.map(SpeedSource::name))?;
    line.serialize_entry("moved_m", &slip.moved_m)?;
    line.serialize_entry("irregularities", &slip.irregularities)?;
    line.serialize_entry("esc_w", &slip.esc_w)?;
    line.serialize_entry("esc_informative", &slip.esc_w.map(|_| slip.is_informative()))?;
    let names = || Flags::from_bits(slip.esc_flags).iter().map(Flag::name).collect::<Vec<_>>();
    line.serialize_entry("esc_flags", &slip.esc_w.map(|_| names()))?;
    let reading = slip.esc.map(|_| slip.esc_kind);
    line.serialize_entry("esc_reading", &reading.map(Reading::name))?;
    line.serialize_entry("esc_value", &slip.esc)?;
    line.serialize_entry("esc_unit", &reading.map(Reading::unit))?;
    line.serialize_entry("estimate_n", &slip.estimate_n)?;
    line.serialize_entry("estimate_sigma_n", &slip.estimate_sigma_n)?;
    line.serialize_entry("estimate_lo_n", &slip.estimate_lo_n)?;
    line.serialize_entry("estimate_hi_n", &slip.estimate_hi_n)?;
    line.serialize_entry("extrapolated", &slip.estimate_n.map(|_| slip.is_extrapolated()))?;
    line.serialize_entry("command_n", &slip.command_n)
}

/// Follows the steps and states which of them deserve a line.
#[derive(Clone, Copy, Debug, Default)]
pub struct EventLog {
    features: Option<Features>,
    velocity: Option<Velocity>,
    estimate: Option<ForceEstimate>,
    sensors: [SensorHealth; 4],
    floor_health: FloorHealth,
    slips: u64,
}

impl EventLog {
    /// Slips seen so far.
    #[must_use]
    pub fn slips(&self) -> u64 {
        self.slips
    }

    /// The features and the estimate of the last slip.
    #[must_use]
    pub fn evidence(&self) -> (Option<Features>, Option<ForceEstimate>) {
        (self.features, self.estimate)
    }

    /// Whether [`EventLog::events`] has anything to do with a step.
    #[must_use]
    #[inline]
    pub fn follows(&self, step: &Step) -> bool {
        let changed = step.sensors != self.sensors || step.floor_health != self.floor_health;
        let happened = step.event.is_some() || step.grip.is_some();
        changed || happened || step.features.is_some() || step.velocity.is_some()
    }

    /// The events of a step: at most one on the health of each sensor and of the noise floor, one on slip and one
    /// on the object in hand.
    pub fn events(&mut self, step: &Step) -> [Option<Event>; Event::MOST] {
        if step.features.is_some() {
            self.features = step.features;
            self.estimate = step.estimate;
        }
        if let Some(now) = step.velocity
            && (is_measured(&now) || !self.velocity.is_some_and(|last| is_measured(&last)))
        {
            self.velocity = Some(now);
        }
        let t = step.t;
        let before = core::mem::replace(&mut self.sensors, step.sensors);
        let floor_before = core::mem::replace(&mut self.floor_health, step.floor_health);
        let health = |changed: bool, condition| changed.then_some(Event::Health { t, condition });
        let sensor =
            |(sensor, (before, now))| health(now != before, Condition::Sensor(sensor, now));
        let mut sensors =
            Sensor::ALL.into_iter().zip(before.into_iter().zip(step.sensors)).map(sensor);
        let mut sensor = || sensors.next().flatten();
        let command_n = step.command.map(|command| command.0);
        [
            sensor(),
            sensor(),
            sensor(),
            sensor(),
            step.event.map(|report| Event::Slip(self.complete(report, step))),
            step.grip.map(|event| Event::Grip { t, event, command_n }),
            health(step.floor_health != floor_before, Condition::Floor(step.floor_health)),
        ]
    }

    /// The report of a slip with all that is known at this step.
    fn complete(&mut self, report: SlipReport, step: &Step) -> SlipReport {
        if report.first {
            self.slips += 1;
            (self.features, self.velocity, self.estimate) = (None, None, None);
        }
        if report.phase == Phase::Ended {
            // The model of a free fall knows nothing of the end of one.
            self.velocity = self.velocity.filter(is_measured);
        }
        let Self { features, velocity, estimate, .. } = *self;
        let esc = features.and_then(|f| f.esc);
        let chosen = features.and_then(|f| f.esc_chosen);
        let state = step.state(None, esc, estimate);
        SlipReport {
            speed_source: velocity.map_or(SpeedSource::None, |v| v.source),
            esc_kind: chosen.map_or(Reading::None, |esc| esc.reading),
            speed_m_s: velocity.map(|v| v.speed_m_s),
            speed_sigma_m_s: velocity.map(|v| v.sigma_m_s),
            moved_m: features.map(|f| f.micro_displacement_m),
            irregularities: features.map(|f| f.irregularities),
            esc_w: esc.map(|esc| esc.value),
            esc: chosen.map(|esc| esc.value),
            esc_flags: state.esc_flags,
            notes: state.notes,
            estimate_n: state.estimate_n,
            command_n: state.command_n,
            estimate_sigma_n: estimate.map(|e| e.sigma_n),
            estimate_lo_n: estimate.and_then(|e| e.limits_n).map(|[low_n, _]| low_n),
            estimate_hi_n: estimate.and_then(|e| e.limits_n).map(|[_, high_n]| high_n),
            mean_slope: features.and_then(|f| f.mean_slope),
            ..report
        }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slip(slip) => write!(f, "{:10.4} s  {}", slip.t.as_seconds(), slip_text(slip)),
            Self::Grip { t, event, command_n } => {
                let event = match event {
                    GripEvent::Empty => "nothing between the fingers",
                    GripEvent::Lost => "the object is lost",
                    GripEvent::Persistent => "the slip does not end",
                    GripEvent::Found => "the needed force is found",
                    GripEvent::Limited => "limit reached, the needed force is not known",
                    GripEvent::Regrasped => "the object is touched again",
                };
                write!(f, "{:10.4} s  {event}", t.as_seconds())?;
                command_n.map_or(Ok(()), |force| write!(f, ", command {force:.2} N"))
            }
            Self::Health { t, condition } => {
                let (channel, state) = (condition.channel(), condition.name());
                // Not every sensor of vibration is a stylus.
                let channel = if channel == "stylus" { "stylus or vibration" } else { channel };
                write!(f, "{:10.4} s  {channel} {state}", t.as_seconds())?;
                f.write_str(match condition {
                    Condition::Floor(FloorHealth::Doubtful) => {
                        ": not confirmed yet by steady stillness"
                    }
                    Condition::Sensor(Sensor::Reference, SensorHealth::Late) => {
                        ": the stylus shows its motion at another time"
                    }
                    Condition::Sensor(Sensor::Reference, SensorHealth::Uncoupled) => {
                        ": the stylus shows nothing of its motion, it is not used"
                    }
                    _ => "",
                })
            }
        }
    }
}

/// A slip in words, without its time; what is not known is left out.
#[must_use]
pub fn slip_text(slip: &SlipReport) -> String {
    let reported = || {
        let (phase, by) = (slip.phase, slip.method.felt());
        if slip.method == Method::None {
            format!("slip ({phase})")
        } else {
            format!("slip ({phase}, by {by})")
        }
    };
    let ended = |duration_s: f64| format!("slip ended after {:.1} ms", 1e3 * duration_s);
    let mut parts = vec![slip.duration_s.map_or_else(reported, ended)];
    if slip.duration_s.is_none() {
        parts.extend(slip.statistic.map(|times| format!("statistic {}", statistic_text(times))));
        parts.extend(slip.confidence.map(confidence_text));
    }
    let certified = |s| format!("certified: one false alarm in {s:.0} s or more");
    parts.extend(slip.certified_s.map(certified));
    parts.extend(causes_text(slip).into_iter().flatten());
    parts.extend(speed_text(slip));
    parts.extend(slip.moved_m.map(|moved| format!("moved {:.2} mm", 1e3 * moved)));
    if let Some(esc) = slip.esc_w {
        let n = slip.irregularities.unwrap_or(0);
        let note =
            if slip.is_informative() { "" } else { ", carries no information at this noise" };
        parts.push(format!("E_sc {esc:.3} W (n = {n}{note})"));
    }
    let (kind, unit) = (slip.esc_kind, slip.esc_kind.unit());
    let reading = slip.esc.filter(|_| kind != Reading::Literal);
    parts.extend(reading.map(|value| format!("{kind} {value:.3e} {unit}")));
    if let Some(estimate) = slip.estimate_n {
        let limits = slip.estimate_lo_n.zip(slip.estimate_hi_n);
        let limits = limits.map(|(low, high)| format!(" ({low:.2} to {high:.2})"));
        let note = if slip.is_extrapolated() { " (extrapolated, not used)" } else { "" };
        parts.push(format!("estimate {estimate:.2} N{}{note}", limits.unwrap_or_default()));
    }
    parts.extend(slip.command_n.map(|command| format!("command {command:.2} N")));
    parts.join(", ")
}

/// The speed of a slip, how sure it is, and what has shown it.
#[must_use]
pub fn speed_text(slip: &SlipReport) -> Option<String> {
    let (speed, source) = (1e3 * slip.speed_m_s?, slip.speed_source);
    let sigma = slip.speed_sigma_m_s.map(|sigma| format!(" +- {:.1}", 1e3 * sigma));
    Some(format!("{speed:.1}{} mm/s ({source})", sigma.unwrap_or_default()))
}

/// What is known of the causes of a slip other than a slip (`ruled out: knock and motion`, `possible: closing`); `None` for a set
/// that is empty.
#[must_use]
pub fn causes_text(slip: &SlipReport) -> [Option<String>; 2] {
    [("ruled out", slip.ruled_out), ("possible", slip.possible)].map(|(what, bits)| {
        let names: Vec<_> = CauseSet::from_bits(bits).iter().map(Cause::name).collect();
        (!names.is_empty()).then(|| format!("{what}: {}", names.join(" and ").replace('_', " ")))
    })
}

/// Whether a sensor has shown the speed, and not a model.
fn is_measured(velocity: &Velocity) -> bool {
    velocity.source != SpeedSource::Gravity
}

/// Evidence of a slip over the wanted interval; beyond a thousand only that it is, since it may have thirty digits.
#[must_use]
pub fn statistic_text(statistic: f32) -> String {
    match statistic {
        1000.0.. => "> 1000".to_owned(),
        ..1.0 => format!("{statistic:.2}"),
        _ => format!("{statistic:.1}"),
    }
}

/// A confidence (0..1) in percent, rounded down: it never rounds up to certainty.
#[must_use]
pub fn confidence_text(confidence: f32) -> String {
    match confidence {
        0.999 => "confidence 99.9 %".to_owned(),
        0.999.. => "confidence > 99.9 %".to_owned(),
        _ => format!("confidence {:.0} %", (100.0 * confidence).floor()),
    }
}

#[cfg(test)]
mod tests {
    use super::{Condition, Event, EventLog, confidence_text, statistic_text};
    use slip_core::{
        CauseSet, Phase, SlipReport, Step,
        alarm::Method,
        detector::FloorHealth,
        grip::GripEvent,
        health::{Sensor, SensorHealth},
        sample::Scene,
        units::{Micros, Newtons},
        velocity::{SpeedSource, Velocity},
    };

    const G: SensorHealth = SensorHealth::Good;
    const F: SensorHealth = SensorHealth::Frozen;

    fn step(t: u64, event: Option<SlipReport>) -> Step {
        Step {
            t: Micros(t),
            scene: Scene::Holding,
            statistic: 1.5,
            event,
            features: None,
            velocity: None,
            estimate: None,
            need: None,
            command: Some(Newtons(2.5)),
            grip: None,
            sensors: [SensorHealth::Good; 4],
            floor_health: FloorHealth::Good,
        }
    }

    #[test]
    fn a_floor_that_never_saw_rest_is_stated_once() {
        let mut log = EventLog::default();
        let doubted = Step { floor_health: FloorHealth::Doubtful, ..step(3, None) };
        let [None, None, None, None, None, None, Some(line)] = log.events(&doubted) else {
            panic!()
        };
        assert_eq!(
            line,
            Event::Health { t: Micros(3), condition: Condition::Floor(FloorHealth::Doubtful) }
        );
        assert!(
            line.to_string().ends_with("floor doubtful: not confirmed yet by steady stillness"),
            "{line}"
        );
        assert_eq!(log.events(&doubted), [None; 7]);
    }

    #[test]
    fn json_has_the_names_of_the_contract() {
        let mut log = EventLog::default();
        let event = SlipReport {
            t: Micros(1_500_000),
            phase: Phase::Incipient,
            first: true,
            method: Method::Travel,
            statistic: Some(1.5),
            confidence: Some(0.5),
            certified_s: Some(600.0),
            ruled_out: CauseSet::from_bits(0b1_0001).bits(),
            possible: CauseSet::from_bits(0b00110).bits(),
            ..SlipReport::UNKNOWN
        };
        let [None, None, None, None, Some(line), None, None] =
            log.events(&step(1_500_000, Some(event)))
        else {
            panic!()
        };
        let json: serde_json::Value = serde_json::to_value(line).unwrap();
        assert_eq!(json["type"], "slip");
        assert_eq!(json["phase"], "incipient");
        assert_eq!((&json["method"], &json["t_s"]), (&"travel".into(), &1.5.into()));
        assert_eq!((&json["command_n"], &json["confidence"]), (&2.5.into(), &0.5.into()));
        assert_eq!(
            (&json["certified"], &json["certified_interval_s"]),
            (&true.into(), &600.0.into())
        );
        let words = "statistic 1.5, confidence 50 %, certified: one false alarm in 600 s or more";
        assert!(line.to_string().contains(words), "{line}");
        assert_eq!([0.02, 326.63, 1.87e31].map(statistic_text), ["0.02", "326.6", "> 1000"]);
        assert_eq!(json["ruled_out"], serde_json::json!(["knock", "arm_stop"]));
        assert_eq!(json["possible"], serde_json::json!(["motion", "grip_change"]));
        let words = ", ruled out: knock and arm stop, possible: motion and grip change";
        assert!(line.to_string().contains(words), "{line}");
        assert_eq!(confidence_text(0.9985), "confidence 99 %");
        assert_eq!(
            [0.999, 0.9991].map(confidence_text),
            ["99.9 %", "> 99.9 %"].map(|s| format!("confidence {s}"))
        );
        assert!(json["esc_w"].is_null() && json["estimate_n"].is_null());
        assert_eq!(log.slips(), 1);
    }

    #[test]
    fn a_slip_that_turns_gross_counts_once_and_health_is_reported_on_change() {
        let mut log = EventLog::default();
        let slip = |phase, first| SlipReport { phase, first, ..SlipReport::UNKNOWN };
        log.events(&step(1, Some(slip(Phase::Incipient, true))));
        log.events(&step(2, Some(slip(Phase::Gross, false))));
        assert_eq!(log.slips(), 1);
        let frozen = Step { sensors: [F, G, G, G], ..step(3, None) };
        let [line, None, None, None, None, None, None] = log.events(&frozen) else { panic!() };
        assert_eq!(
            line,
            Some(Event::Health {
                t: Micros(3),
                condition: Condition::Sensor(Sensor::Stylus, SensorHealth::Frozen)
            })
        );
        assert_eq!(log.events(&frozen), [None; 7]);
        let jumped = Step { sensors: [F, SensorHealth::Jumped, G, G], ..frozen };
        let [None, Some(line), None, None, None, None, None] = log.events(&jumped) else {
            panic!()
        };
        assert_eq!(
            line,
            Event::Health {
                t: Micros(3),
                condition: Condition::Sensor(Sensor::Travel, SensorHealth::Jumped)
            }
        );
        let lost = Step { sensors: [F, SensorHealth::Jumped, G, SensorHealth::Lost], ..jumped };
        let [None, None, None, Some(line), None, None, None] = log.events(&lost) else { panic!() };
        assert_eq!(
            line,
            Event::Health {
                t: Micros(3),
                condition: Condition::Sensor(Sensor::Reference, SensorHealth::Lost)
            }
        );
    }

    #[test]
    fn the_speed_of_a_slip_that_has_ended_is_the_last_measured_one() {
        let velocity = |source, speed_m_s| Some(Velocity { speed_m_s, sigma_m_s: 1e-3, source });
        let ended = step(9, Some(SlipReport { duration_s: Some(5e-6), ..SlipReport::UNKNOWN }));
        for (measured, wanted) in [(true, Some(0.02)), (false, None)] {
            let mut log = EventLog::default();
            if measured {
                log.events(&Step {
                    velocity: velocity(SpeedSource::Travel, 0.02),
                    ..step(1, None)
                });
            }
            log.events(&Step { velocity: velocity(SpeedSource::Gravity, 0.3), ..step(2, None) });
            let Some(Event::Slip(slip)) = log.events(&ended)[4] else { panic!() };
            assert_eq!((slip.phase, slip.speed_m_s), (Phase::Ended, wanted));
        }
    }

    #[test]
    fn what_becomes_of_the_object_is_reported() {
        let gone = Step { grip: Some(GripEvent::Lost), ..step(2_000_000, None) };
        let [None, None, None, None, None, Some(line), None] = EventLog::default().events(&gone)
        else {
            panic!()
        };
        let json = serde_json::to_value(line).unwrap();
        assert_eq!((&json["type"], &json["event"]), (&"grip".into(), &"lost".into()));
        assert_eq!(line.to_string(), "    2.0000 s  the object is lost, command 2.50 N");
    }
}
