//! Pipeline steps in, the lines for people and machines out. Names and units of the JSON fields are a contract.

use core::fmt;
use serde::{Serialize, Serializer, ser::SerializeMap};
use slip_core::{
    Cause, CauseSet, Phase, SlipEvent, SlipReport, Step,
    detector::FloorHealth,
    esc::{Flag, Flags, Reading},
    estimate::ForceEstimate,
    features::Features,
    health::{Sensor, SensorHealth},
    velocity::{SpeedSource, Velocity},
};

/// One event, as it is printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventLine {
    /// A slip has been noticed, has become gross, has been certified, or has ended.
    Slip(SlipReport),
    /// The fingers lost the object, touch it again, or closed on nothing.
    Grip {
        /// Device time (s).
        t_s: f64,
        /// `empty`, `lost`, `regrasped` or `persistent`.
        event: &'static str,
        /// Commanded force (N).
        command_n: Option<f32>,
    },
    /// The state of a sensor or of the device's clock has changed.
    Health {
        /// Device time (s).
        t_s: f64,
        /// `stylus`, `travel`, `pressure` or `reference`; `floor` for the noise floor of the stylus, `clock` for that of the device.
        channel: &'static str,
        /// `good`, or what is wrong: `frozen`, `saturated`, `failed`, `jumped`, `backwards`, `doubted`, `coarse`, `lost`; of
        /// the reference also `late`, `uncoupled`; of the floor `doubtful`: no rest was seen yet; of the clock `stopped`, `back`, `forward`,
        /// `fast`, `slow`.
        health: &'static str,
    },
}

impl Serialize for EventLine {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut line = serializer.serialize_map(None)?;
        match self {
            Self::Slip(slip) => slip_entries(slip, &mut line)?,
            Self::Grip { t_s, event, command_n } => {
                line.serialize_entry("type", "grip")?;
                line.serialize_entry("t_s", t_s)?;
                line.serialize_entry("event", event)?;
                line.serialize_entry("command_n", command_n)?;
            }
            Self::Health { t_s, channel, health } => {
                line.serialize_entry("type", "health")?;
                line.serialize_entry("t_s", t_s)?;
                line.serialize_entry("channel", channel)?;
                line.serialize_entry("health", health)?;
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
    line.serialize_entry("extrapolated", &slip.estimate_n.map(|_| slip.is_extrapolated()))?;
    line.serialize_entry("command_n", &slip.command_n)
}

/// Follows the steps and says which of them deserve a line.
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

    /// The lines a step leads to: at most one on the health of each sensor and of the noise floor, one on slip and one
    /// on the object in hand.
    #[inline]
    pub fn lines(&mut self, step: &Step) -> [Option<EventLine>; 7] {
        if step.features.is_some() {
            self.features = step.features;
            self.estimate = step.estimate;
        }
        if let Some(now) = step.velocity
            && (is_measured(&now) || !self.velocity.is_some_and(|last| is_measured(&last)))
        {
            self.velocity = Some(now);
        }
        let t_s = step.t.as_seconds();
        let mut lines = [None; 7];
        if step.sensors != self.sensors {
            let before = core::mem::replace(&mut self.sensors, step.sensors);
            let sensors = Sensor::ALL.into_iter().zip(before.into_iter().zip(step.sensors));
            for (line, (sensor, (before, now))) in lines.iter_mut().zip(sensors) {
                let health = EventLine::Health { t_s, channel: sensor.name(), health: now.name() };
                *line = (now != before).then_some(health);
            }
        }
        lines[4] = step.event.map(|event| EventLine::Slip(self.slip_report(event, step)));
        let command_n = step.command.map(|c| c.0);
        if step.floor_health != self.floor_health {
            self.floor_health = step.floor_health;
            let health = step.floor_health.name();
            lines[6] = Some(EventLine::Health { t_s, channel: "floor", health });
        }
        lines[5] = step.grip.map(|e| EventLine::Grip { t_s, event: e.name(), command_n });
        lines
    }

    fn slip_report(&mut self, event: SlipEvent, step: &Step) -> SlipReport {
        match event {
            SlipEvent::Slip { phase, first, method, confidence, certified_s, causes } => {
                if first {
                    self.slips += 1;
                    self.features = None;
                    self.velocity = None;
                    self.estimate = None;
                }
                SlipReport {
                    phase,
                    method,
                    statistic: Some(step.statistic),
                    confidence: Some(confidence),
                    certified_s,
                    ruled_out: causes.ruled_out.bits(),
                    possible: causes.possible.bits(),
                    ..self.known(step)
                }
            }
            SlipEvent::Ended { duration, certified_s } => {
                // The model of a free fall knows nothing of the end of one.
                self.velocity = self.velocity.filter(is_measured);
                let duration_s = Some(duration.as_seconds());
                SlipReport { duration_s, certified_s, ..self.known(step) }
            }
        }
    }

    /// What is known of the slip at this step.
    fn known(&self, step: &Step) -> SlipReport {
        let Self { features, velocity, estimate, .. } = *self;
        let esc = features.and_then(|f| f.esc);
        let chosen = features.and_then(|f| f.esc_chosen);
        let state = step.state(None, esc, estimate);
        SlipReport {
            t: step.t,
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
            ..SlipReport::UNKNOWN
        }
    }
}

impl fmt::Display for EventLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slip(slip) => write_slip(f, slip),
            Self::Grip { t_s, event, command_n } => {
                let event = match *event {
                    "empty" => "nothing between the fingers",
                    "lost" => "the object is lost",
                    "persistent" => "the slip does not end",
                    _ => "the object is touched again",
                };
                write!(f, "{t_s:10.4} s  {event}")?;
                command_n.map_or(Ok(()), |force| write!(f, ", command {force:.2} N"))
            }
            Self::Health { t_s, channel: "floor", health: "doubtful" } => {
                write!(f, "{t_s:10.4} s  floor doubtful: no rest seen yet")
            }
            Self::Health { t_s, channel: "reference", health: "late" } => {
                write!(
                    f,
                    "{t_s:10.4} s  reference late: the stylus shows its motion at another time"
                )
            }
            Self::Health { t_s, channel: "reference", health: "uncoupled" } => {
                write!(
                    f,
                    "{t_s:10.4} s  reference uncoupled: the stylus shows nothing of its motion, it is not used"
                )
            }
            Self::Health { t_s, channel, health } => {
                write!(f, "{t_s:10.4} s  {channel} {health}")
            }
        }
    }
}

fn write_slip(f: &mut fmt::Formatter<'_>, slip: &SlipReport) -> fmt::Result {
    let t_s = slip.t.as_seconds();
    if let Some(duration_s) = slip.duration_s {
        write!(f, "{t_s:10.4} s  slip ended after {:.1} ms", 1e3 * duration_s)?;
    } else {
        let (phase, method) = (slip.phase, slip.method);
        let statistic = slip.statistic.unwrap_or(f32::NAN);
        write!(f, "{t_s:10.4} s  slip ({phase}, by {method}), statistic {statistic:.1}, ")?;
        write_confidence(f, slip.confidence.unwrap_or(f32::NAN))?;
    }
    match slip.certified_s {
        Some(s) => write!(f, ", certified: one false alarm in {s:.0} s or more")?,
        None if slip.duration_s.is_none() => write!(f, ", fast trigger only")?,
        None => {}
    }
    for (what, bits) in [("ruled out", slip.ruled_out), ("possible", slip.possible)] {
        if bits != 0 {
            write!(f, ", {what}:")?;
            CauseSet::from_bits(bits)
                .iter()
                .try_for_each(|cause| write!(f, " {}", cause.name()))?;
        }
    }
    if let (Some(speed), Some(sigma)) = (slip.speed_m_s, slip.speed_sigma_m_s) {
        write!(f, ", {:.1} +- {:.1} mm/s ({})", 1e3 * speed, 1e3 * sigma, slip.speed_source)?;
    }
    if let Some(moved) = slip.moved_m {
        write!(f, ", moved {:.2} mm", 1e3 * moved)?;
    }
    if let Some(esc) = slip.esc_w {
        let n = slip.irregularities.unwrap_or(0);
        let note =
            if slip.is_informative() { "" } else { ", carries no information at this noise" };
        write!(f, ", E_sc {esc:.3} W (n = {n}{note})")?;
    }
    if let Some(value) = slip.esc.filter(|_| slip.esc_kind != Reading::Literal) {
        write!(f, ", {} {value:.3e} {}", slip.esc_kind, slip.esc_kind.unit())?;
    }
    if let Some(estimate) = slip.estimate_n {
        let note = if slip.is_extrapolated() { " (extrapolated, not used)" } else { "" };
        let sigma = slip.estimate_sigma_n.unwrap_or(0.0);
        write!(f, ", estimate {estimate:.2} +- {sigma:.2} N{note}")?;
    }
    slip.command_n.map_or(Ok(()), |command| write!(f, ", command {command:.2} N"))
}

/// Whether a sensor has told the speed, and not a model.
fn is_measured(velocity: &Velocity) -> bool {
    velocity.source != SpeedSource::Gravity
}

/// In percent, never rounded up to certainty.
fn write_confidence(f: &mut fmt::Formatter<'_>, confidence: f32) -> fmt::Result {
    if confidence > 0.999 {
        return write!(f, "confidence > 99.9 %");
    }
    write!(f, "confidence {:.0} %", (100.0 * confidence).floor())
}

#[cfg(test)]
mod tests {
    use super::{EventLine, EventLog};
    use slip_core::{
        CauseSet, Causes, Phase, SlipEvent, Step,
        detector::FloorHealth,
        grip::GripEvent,
        health::SensorHealth,
        methods::Method,
        scene::Scene,
        units::{Micros, Newtons},
        velocity::{SpeedSource, Velocity},
    };

    const G: SensorHealth = SensorHealth::Good;
    const F: SensorHealth = SensorHealth::Frozen;

    fn step(t: u64, event: Option<SlipEvent>) -> Step {
        Step {
            t: Micros(t),
            scene: Scene::Holding,
            statistic: 1.5,
            event,
            features: None,
            velocity: None,
            estimate: None,
            command: Some(Newtons(2.5)),
            grip: None,
            sensors: [SensorHealth::Good; 4],
            floor_health: FloorHealth::Good,
        }
    }

    #[test]
    fn a_floor_that_never_saw_rest_is_said_once() {
        let mut log = EventLog::default();
        let doubted = Step { floor_health: FloorHealth::Doubtful, ..step(3, None) };
        let [None, None, None, None, None, None, Some(line)] = log.lines(&doubted) else {
            panic!()
        };
        assert_eq!(line, EventLine::Health { t_s: 3e-6, channel: "floor", health: "doubtful" });
        assert!(line.to_string().ends_with("floor doubtful: no rest seen yet"), "{line}");
        assert_eq!(log.lines(&doubted), [None; 7]);
    }

    #[test]
    fn json_has_the_names_of_the_contract() {
        let mut log = EventLog::default();
        let event = SlipEvent::Slip {
            phase: Phase::Incipient,
            first: true,
            method: Method::Travel,
            confidence: 0.5,
            certified_s: Some(600.0),
            causes: Causes {
                ruled_out: CauseSet::from_bits(0b1_0001),
                possible: CauseSet::from_bits(0b00110),
            },
        };
        let [None, None, None, None, Some(line), None, None] =
            log.lines(&step(1_500_000, Some(event)))
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
        assert_eq!(json["ruled_out"], serde_json::json!(["knock", "arm_stop"]));
        assert_eq!(json["possible"], serde_json::json!(["motion", "grip_change"]));
        let words = ", ruled out: knock arm_stop, possible: motion grip_change";
        assert!(line.to_string().contains(words), "{line}");
        assert!(json["esc_w"].is_null() && json["estimate_n"].is_null());
        assert_eq!(log.slips(), 1);
    }

    #[test]
    fn a_slip_that_turns_gross_counts_once_and_health_is_told_on_change() {
        let mut log = EventLog::default();
        let slip = |phase, first| SlipEvent::Slip {
            phase,
            first,
            method: Method::Stylus,
            confidence: 0.5,
            certified_s: None,
            causes: Causes::default(),
        };
        log.lines(&step(1, Some(slip(Phase::Incipient, true))));
        log.lines(&step(2, Some(slip(Phase::Gross, false))));
        assert_eq!(log.slips(), 1);
        let frozen = Step { sensors: [F, G, G, G], ..step(3, None) };
        let [line, None, None, None, None, None, None] = log.lines(&frozen) else { panic!() };
        assert_eq!(
            line,
            Some(EventLine::Health { t_s: 3e-6, channel: "stylus", health: "frozen" })
        );
        assert_eq!(log.lines(&frozen), [None; 7]);
        let jumped = Step { sensors: [F, SensorHealth::Jumped, G, G], ..frozen };
        let [None, Some(line), None, None, None, None, None] = log.lines(&jumped) else { panic!() };
        assert_eq!(line, EventLine::Health { t_s: 3e-6, channel: "travel", health: "jumped" });
        let lost = Step { sensors: [F, SensorHealth::Jumped, G, SensorHealth::Lost], ..jumped };
        let [None, None, None, Some(line), None, None, None] = log.lines(&lost) else { panic!() };
        assert_eq!(line, EventLine::Health { t_s: 3e-6, channel: "reference", health: "lost" });
    }

    #[test]
    fn the_speed_of_a_slip_that_has_ended_is_the_last_measured_one() {
        let velocity = |source, speed_m_s| Some(Velocity { speed_m_s, sigma_m_s: 1e-3, source });
        let ended = step(9, Some(SlipEvent::Ended { duration: Micros(5), certified_s: None }));
        for (measured, wanted) in [(true, Some(0.02)), (false, None)] {
            let mut log = EventLog::default();
            if measured {
                log.lines(&Step { velocity: velocity(SpeedSource::Travel, 0.02), ..step(1, None) });
            }
            log.lines(&Step { velocity: velocity(SpeedSource::Gravity, 0.3), ..step(2, None) });
            let Some(EventLine::Slip(slip)) = log.lines(&ended)[4] else { panic!() };
            assert_eq!((slip.phase, slip.speed_m_s), (Phase::Ended, wanted));
        }
    }

    #[test]
    fn what_becomes_of_the_object_is_told() {
        let gone = Step { grip: Some(GripEvent::Lost), ..step(2_000_000, None) };
        let [None, None, None, None, None, Some(line), None] = EventLog::default().lines(&gone)
        else {
            panic!()
        };
        let json = serde_json::to_value(line).unwrap();
        assert_eq!((&json["type"], &json["event"]), (&"grip".into(), &"lost".into()));
        assert_eq!(line.to_string(), "    2.0000 s  the object is lost, command 2.50 N");
    }
}
