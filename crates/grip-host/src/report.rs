//! Pipeline steps in, the lines for people and machines out. Names and units of the JSON fields are a contract.

use serde::Serialize;
use slip_core::{
    Cause, CauseSet, SlipEvent, Step,
    detector::{FloorHealth, ReferenceHealth},
    distance::TravelHealth,
    esc::Flags,
    estimate::ForceEstimate,
    features::Features,
    health::Health,
    pressure::PressureHealth,
    velocity::{Velocity, VelocitySource},
};

/// One event, as it is printed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum EventLine {
    /// A slip has been noticed, has become gross, or has been certified.
    Slip {
        /// Device time (s).
        t_s: f64,
        /// `incipient` or `gross`.
        phase: &'static str,
        /// Which method spoke: `stylus`, `travel` or `pressure`.
        method: &'static str,
        /// Statistic over its threshold.
        statistic: f32,
        /// Probability (0 to 1) that noise alone would not reach this statistic within the stated false-alarm interval.
        confidence: f32,
        /// Whether the evidence is enough to certify the slip; otherwise only the fast trigger has spoken so far.
        certified: bool,
        /// The interval (s) that it is certified with: false alarms of that kind are at least so far apart on average.
        certified_interval_s: Option<f32>,
        /// Names of the causes other than a slip that were ruled out ([`slip_core::causes`]) ...
        #[serde(serialize_with = "cause_names")]
        ruled_out: CauseSet,
        /// ... and of those that were not. What is in neither could not be judged.
        #[serde(serialize_with = "cause_names")]
        possible: CauseSet,
        /// What is known of the slip.
        #[serde(flatten)]
        evidence: EvidenceFields,
    },
    /// A slip has ended.
    SlipEnd {
        /// Device time (s).
        t_s: f64,
        /// From the first notice to the end (s).
        duration_s: f64,
        /// Whether the slip was certified; otherwise only the fast trigger had spoken.
        certified: bool,
        /// The interval (s) that it was certified with.
        certified_interval_s: Option<f32>,
        /// What is known of the slip.
        #[serde(flatten)]
        evidence: EvidenceFields,
    },
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
        /// `good`, or what is wrong: `frozen`, `saturated`, `failed`, `jumped`, `backwards`, `doubted`, `coarse`,
        /// `lost`; of the reference also `late`, `uncoupled`; of the floor `doubtful`: no rest was seen yet; of the clock `stopped`, `back`, `forward`,
        /// `fast`, `slow`.
        health: &'static str,
    },
}

/// What is known of a slip at the time of an event; `null` where nothing is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct EvidenceFields {
    /// Slip speed (m/s).
    pub speed_m_s: Option<f32>,
    /// Standard deviation of the best speed there is (m/s).
    pub speed_sigma_m_s: Option<f32>,
    /// Where that one comes from: `fixed`, `direct`, `travel`, `two_styli` or `gravity`.
    pub speed_source: Option<&'static str>,
    /// Distance moved since the slip was noticed (m).
    pub moved_m: Option<f32>,
    /// Irregularities the stylus passed.
    pub irregularities: Option<u32>,
    /// E_sc as printed (W).
    pub esc_w: Option<f64>,
    /// Whether E_sc still depends on the surface at the assumed sensor noise.
    pub esc_informative: Option<bool>,
    /// What is wrong with E_sc, by name: `pole_inside`, `sign_unknown`, `no_information`, `degenerate`.
    #[serde(serialize_with = "flag_names")]
    pub esc_flags: Option<Flags>,
    /// The reading of E_sc that was asked for with `--esc`; `literal` unless another one was.
    pub esc_reading: Option<&'static str>,
    /// Its value, in `esc_unit`.
    pub esc_value: Option<f64>,
    /// `W` or `J`.
    pub esc_unit: Option<&'static str>,
    /// The network's adequate force (N).
    pub estimate_n: Option<f32>,
    /// Its standard deviation (N).
    pub estimate_sigma_n: Option<f32>,
    /// Whether the estimate lies outside what the network was trained on, and is not used.
    pub extrapolated: Option<bool>,
    /// Commanded force (N).
    pub command_n: Option<f32>,
}

fn cause_names<S: serde::Serializer>(causes: &CauseSet, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(causes.iter().map(Cause::name))
}

fn flag_names<S: serde::Serializer>(
    flags: &Option<Flags>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match flags {
        Some(flags) => serializer.collect_seq(flags.iter().map(|flag| flag.name())),
        None => serializer.serialize_none(),
    }
}

impl EvidenceFields {
    fn new(log: &EventLog, step: &Step) -> Self {
        let EventLog { features, velocity, estimate, .. } = *log;
        let esc = features.and_then(|f| f.esc);
        let chosen = features.and_then(|f| f.esc_chosen);
        Self {
            speed_m_s: velocity.map(|v| v.speed_m_s),
            speed_sigma_m_s: velocity.map(|v| v.sigma_m_s),
            speed_source: velocity.map(|v| v.source.name()),
            moved_m: features.map(|f| f.micro_displacement_m),
            irregularities: features.map(|f| f.irregularities),
            esc_w: esc.map(|esc| esc.value),
            esc_informative: esc.map(|esc| esc.informative()),
            esc_flags: esc.map(|esc| esc.flags),
            esc_reading: chosen.map(|esc| esc.reading.name()),
            esc_value: chosen.map(|esc| esc.value),
            esc_unit: chosen.map(|esc| esc.reading.unit().symbol()),
            estimate_n: estimate.map(|e| e.force_n),
            estimate_sigma_n: estimate.map(|e| e.sigma_n),
            extrapolated: estimate.map(|e| e.extrapolated),
            command_n: step.command.map(|c| c.0),
        }
    }
}

/// Follows the steps and says which of them deserve a line.
#[derive(Clone, Copy, Debug, Default)]
pub struct EventLog {
    features: Option<Features>,
    velocity: Option<Velocity>,
    estimate: Option<ForceEstimate>,
    health: Health,
    floor_health: FloorHealth,
    reference_health: ReferenceHealth,
    travel_health: TravelHealth,
    pressure_health: PressureHealth,
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
        if step.health != self.health {
            self.health = step.health;
            lines[0] =
                Some(EventLine::Health { t_s, channel: "stylus", health: step.health.name() });
        }
        if step.travel_health != self.travel_health {
            self.travel_health = step.travel_health;
            let health = step.travel_health.name();
            lines[1] = Some(EventLine::Health { t_s, channel: "travel", health });
        }
        if step.pressure_health != self.pressure_health {
            self.pressure_health = step.pressure_health;
            let health = step.pressure_health.name();
            lines[2] = Some(EventLine::Health { t_s, channel: "pressure", health });
        }
        if step.reference_health != self.reference_health {
            self.reference_health = step.reference_health;
            let health = step.reference_health.name();
            lines[3] = Some(EventLine::Health { t_s, channel: "reference", health });
        }
        lines[4] = step.event.map(|event| self.slip_line(event, t_s, step));
        let command_n = step.command.map(|c| c.0);
        if step.floor_health != self.floor_health {
            self.floor_health = step.floor_health;
            let health = step.floor_health.name();
            lines[6] = Some(EventLine::Health { t_s, channel: "floor", health });
        }
        lines[5] = step.grip.map(|e| EventLine::Grip { t_s, event: e.name(), command_n });
        lines
    }

    fn slip_line(&mut self, event: SlipEvent, t_s: f64, step: &Step) -> EventLine {
        match event {
            SlipEvent::Slip { phase, first, method, confidence, certified_s, causes } => {
                if first {
                    self.slips += 1;
                    self.features = None;
                    self.velocity = None;
                    self.estimate = None;
                }
                let evidence = EvidenceFields::new(self, step);
                let (phase, method) = (phase.name(), method.name());
                let statistic = step.statistic;
                EventLine::Slip {
                    t_s,
                    phase,
                    method,
                    statistic,
                    confidence,
                    certified: certified_s.is_some(),
                    certified_interval_s: certified_s,
                    ruled_out: causes.ruled_out,
                    possible: causes.possible,
                    evidence,
                }
            }
            SlipEvent::Ended { duration, certified_s } => {
                // The model of a free fall knows nothing of the end of one.
                self.velocity = self.velocity.filter(is_measured);
                let evidence = EvidenceFields::new(self, step);
                EventLine::SlipEnd {
                    t_s,
                    duration_s: duration.as_seconds(),
                    certified: certified_s.is_some(),
                    certified_interval_s: certified_s,
                    evidence,
                }
            }
        }
    }
}

impl core::fmt::Display for EventLine {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Slip {
                t_s,
                phase,
                method,
                statistic,
                confidence,
                certified_interval_s,
                ruled_out,
                possible,
                evidence,
                ..
            } => {
                write!(f, "{t_s:10.4} s  slip ({phase}, by {method}), statistic {statistic:.1}, ")?;
                write_confidence(f, *confidence)?;
                write_certified(f, *certified_interval_s)?;
                write_causes(f, "ruled out", *ruled_out)?;
                write_causes(f, "possible", *possible)?;
                evidence.write(f)
            }
            Self::SlipEnd { t_s, duration_s, certified_interval_s, evidence, .. } => {
                write!(f, "{t_s:10.4} s  slip ended after {:.1} ms", 1e3 * duration_s)?;
                if certified_interval_s.is_some() {
                    write_certified(f, *certified_interval_s)?;
                }
                evidence.write(f)
            }
            Self::Grip { t_s, event, command_n } => {
                let told = match *event {
                    "empty" => "nothing between the fingers",
                    "lost" => "the object is lost",
                    "persistent" => "the slip does not end",
                    _ => "the object is touched again",
                };
                write!(f, "{t_s:10.4} s  {told}")?;
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

/// Whether a sensor has told the speed, and not a model.
fn is_measured(velocity: &Velocity) -> bool {
    velocity.source != VelocitySource::Gravity
}

/// In percent, never rounded up to certainty.
fn write_confidence(f: &mut core::fmt::Formatter<'_>, confidence: f32) -> core::fmt::Result {
    if confidence > 0.999 {
        return write!(f, "confidence > 99.9 %");
    }
    write!(f, "confidence {:.0} %", (100.0 * confidence).floor())
}

fn write_certified(f: &mut core::fmt::Formatter<'_>, interval_s: Option<f32>) -> core::fmt::Result {
    match interval_s {
        Some(interval_s) => write!(f, ", certified: one false alarm in {interval_s:.0} s or more"),
        None => write!(f, ", fast trigger only"),
    }
}

fn write_causes(
    f: &mut core::fmt::Formatter<'_>,
    what: &str,
    causes: CauseSet,
) -> core::fmt::Result {
    if causes == CauseSet::default() {
        return Ok(());
    }
    write!(f, ", {what}:")?;
    causes.iter().try_for_each(|cause| write!(f, " {}", cause.name()))
}

impl EvidenceFields {
    fn write(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        if let (Some(speed), Some(sigma), Some(source)) =
            (self.speed_m_s, self.speed_sigma_m_s, self.speed_source)
        {
            write!(f, ", {:.1} +- {:.1} mm/s ({source})", 1e3 * speed, 1e3 * sigma)?;
        }
        if let Some(moved) = self.moved_m {
            write!(f, ", moved {:.2} mm", 1e3 * moved)?;
        }
        if let (Some(esc), Some(informative)) = (self.esc_w, self.esc_informative) {
            let n = self.irregularities.unwrap_or(0);
            let note = if informative { "" } else { ", carries no information at this noise" };
            write!(f, ", E_sc {esc:.3} W (n = {n}{note})")?;
        }
        if let (Some(reading), Some(value), Some(unit)) =
            (self.esc_reading, self.esc_value, self.esc_unit)
            && reading != "literal"
        {
            write!(f, ", {reading} {value:.3e} {unit}")?;
        }
        if let Some(estimate) = self.estimate_n {
            let note =
                if self.extrapolated == Some(true) { " (extrapolated, not used)" } else { "" };
            let sigma = self.estimate_sigma_n.unwrap_or(0.0);
            write!(f, ", estimate {estimate:.2} +- {sigma:.2} N{note}")?;
        }
        if let Some(command) = self.command_n {
            write!(f, ", command {command:.2} N")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{EventLine, EventLog};
    use slip_core::{
        CauseSet, Causes, Phase, SlipEvent, Step,
        detector::{FloorHealth, ReferenceHealth},
        distance::TravelHealth,
        grip::GripEvent,
        health::Health,
        methods::Method,
        pressure::PressureHealth,
        scene::Scene,
        units::{Micros, Newtons},
        velocity::{Velocity, VelocitySource},
    };

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
            health: Health::Good,
            floor_health: FloorHealth::Good,
            reference_health: ReferenceHealth::Good,
            travel_health: TravelHealth::Good,
            pressure_health: PressureHealth::Good,
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
        let frozen = Step { health: Health::Frozen, ..step(3, None) };
        let [line, None, None, None, None, None, None] = log.lines(&frozen) else { panic!() };
        assert_eq!(
            line,
            Some(EventLine::Health { t_s: 3e-6, channel: "stylus", health: "frozen" })
        );
        assert_eq!(log.lines(&frozen), [None; 7]);
        let jumped = Step { travel_health: TravelHealth::Jumped, ..frozen };
        let [None, Some(line), None, None, None, None, None] = log.lines(&jumped) else { panic!() };
        assert_eq!(line, EventLine::Health { t_s: 3e-6, channel: "travel", health: "jumped" });
        let lost = Step { reference_health: ReferenceHealth::Lost, ..jumped };
        let [None, None, None, Some(line), None, None, None] = log.lines(&lost) else { panic!() };
        assert_eq!(line, EventLine::Health { t_s: 3e-6, channel: "reference", health: "lost" });
        let late = EventLine::Health { t_s: 3e-6, channel: "reference", health: "late" };
        assert!(
            late.to_string().ends_with("the stylus shows its motion at another time"),
            "{late}"
        );
    }

    #[test]
    fn the_speed_of_a_slip_that_has_ended_is_the_last_measured_one() {
        let velocity = |source, speed_m_s| Some(Velocity { speed_m_s, sigma_m_s: 1e-3, source });
        let ended = step(9, Some(SlipEvent::Ended { duration: Micros(5), certified_s: None }));
        for (measured, wanted) in [(true, Some(0.02)), (false, None)] {
            let mut log = EventLog::default();
            if measured {
                log.lines(&Step {
                    velocity: velocity(VelocitySource::Travel, 0.02),
                    ..step(1, None)
                });
            }
            log.lines(&Step { velocity: velocity(VelocitySource::Gravity, 0.3), ..step(2, None) });
            let Some(EventLine::SlipEnd { evidence, .. }) = log.lines(&ended)[4] else { panic!() };
            assert_eq!(evidence.speed_m_s, wanted);
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
