//! Figures of all detectors in; tables, one JSON file and charts out.

use super::{
    bound::{BANDS, Least},
    contest::Working,
    latency::{Latency, quantile},
    robot::RobotConfig,
    trials::Slips,
};
use core::fmt;
use grip_plot::{Axis, Chart, Layer, Mark};
use serde::Serialize;
use std::path::Path;

/// False alarms an hour for which thresholds are set.
pub const PER_HOUR: [f64; 5] = [360.0, 60.0, 6.0, 1.0, 0.1];
/// Those that are shown as tables, their false alarms counted on a fresh run.
pub const SHOWN: [f64; 2] = [60.0, 1.0];
/// Where what is later stands in the charts of time (ms).
const LATE_MS: f64 = 70.0;
/// The kinds of slips: roughness (um), whether the robot moves.
const KINDS: [(f64, bool); 6] =
    [(0.4, false), (1.6, false), (6.3, false), (0.4, true), (1.6, true), (6.3, true)];

/// The run time of a detector.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// Its name.
    pub detector: &'static str,
    /// Time per sample (ns), the shortest of the rounds.
    pub ns: f64,
}

impl fmt::Display for Cost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:18} {:7.1} ns/sample", self.detector, self.ns)
    }
}

/// Bounds for one kind of slip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BoundRow {
    /// Samples per second.
    pub rate_hz: f64,
    /// Roughness (um).
    pub ra_um: f64,
    /// Whether the robot moves.
    pub moving: bool,
    /// False alarms an hour.
    pub per_hour: f64,
    /// Median signal over noise of each band in the first 10 ms of gross slip (dB).
    pub snr_db: [f64; BANDS],
    /// Median bound of each band alone (ms from gross slip).
    pub alone_ms: [f64; BANDS],
    /// Bound of all bands together: median and 95 % of the slips (ms).
    pub together_ms: [f64; 2],
}

impl BoundRow {
    /// Of the bounds of single slips.
    #[must_use]
    pub fn new(robot: RobotConfig, slips: Slips, per_hour: f64, least: &[Least]) -> Self {
        let at = |q: f64, of: &dyn Fn(&Least) -> f64| {
            let mut all: Vec<f64> = least.iter().map(of).collect();
            all.sort_by(f64::total_cmp);
            quantile(&all, q)
        };
        Self {
            rate_hz: robot.rate_hz,
            ra_um: slips.ra_um,
            moving: slips.moving,
            per_hour,
            snr_db: core::array::from_fn(|b| 10.0 * at(0.5, &|l: &Least| l.snr[b]).log10()),
            alone_ms: core::array::from_fn(|b| at(0.5, &|l: &Least| l.alone_ms[b])),
            together_ms: [0.5, 0.95].map(|q| at(q, &|l: &Least| l.together_ms)),
        }
    }

    fn is_of(&self, ra_um: f64, moving: bool, per_hour: f64) -> bool {
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        near(self.ra_um, ra_um) && self.moving == moving && near(self.per_hour, per_hour)
    }
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Hours without slip that the thresholds were set on, and again that false alarms were counted on.
    pub hours: f64,
    /// Run times.
    pub cost: Vec<Cost>,
    /// Detectors at their thresholds.
    pub working: Vec<Working>,
    /// Bounds, those at 10 kHz first.
    pub bounds: Vec<BoundRow>,
}

impl Report {
    /// Writes detectors.json and the charts into `folder`.
    ///
    /// # Errors
    /// Where a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Box<dyn core::error::Error>> {
        let text = serde_json::to_string_pretty(self)?;
        std::fs::write(folder.join("detectors.json"), text + "\n")?;
        for (name, moving) in [("still", false), ("moving", true)] {
            let file = folder.join(format!("detectors-time-{name}.svg"));
            std::fs::write(file, self.time_chart(moving).svg()?)?;
            let curve = self.curve_chart(moving);
            if curve.layers.iter().any(|layer| !layer.points.is_empty()) {
                std::fs::write(folder.join(format!("detectors-curve-{name}.svg")), curve.svg()?)?;
            }
        }
        Ok(())
    }

    fn ns(&self, detector: &str) -> f64 {
        self.cost.iter().find(|cost| cost.detector == detector).map_or(f64::NAN, |cost| cost.ns)
    }

    fn at(&self, per_hour: f64) -> impl Iterator<Item = &Working> {
        self.working.iter().filter(move |w| (w.wanted_per_hour / per_hour - 1.0).abs() < 1e-9)
    }

    /// Median and 95 % latency over the time per sample, at one false alarm a minute and an hour, on surfaces rough enough for all of
    /// them; those that are later or miss more stand at [`LATE_MS`].
    fn time_chart(&self, moving: bool) -> Chart {
        let robot = if moving { "moving" } else { "still" };
        let chart = Chart::new(
            format!("Detectors: run time against latency, robot {robot}, Ra 6.3 um"),
            Axis::log("time per sample (ns)"),
            Axis::linear(format!("latency from gross slip (ms); {LATE_MS}: later or missed")),
        );
        let points = |per_hour: f64, of: fn(&Latency) -> f64| -> Vec<(f64, f64)> {
            let place = |w: &Working| {
                let latency = of(&w.outcome(6.3, moving)?.latency).min(LATE_MS);
                Some((self.ns(w.detector), latency))
            };
            self.at(per_hour).filter_map(place).collect()
        };
        let names = self.at(60.0).map(|w| w.detector.to_owned()).collect();
        chart
            .with(
                Layer::markers("95 %, one an hour", points(1.0, |l| l.p95))
                    .drawn_as(Mark::TrianglesDown),
            )
            .with(
                Layer::markers("95 %, one a minute", points(60.0, |l| l.p95))
                    .drawn_as(Mark::Triangles),
            )
            .with(Layer::markers("median, one an hour", points(1.0, |l| l.p50)))
            .with(Layer::markers("median, one a minute", points(60.0, |l| l.p50)).labelled(names))
    }

    /// 95 % latency over the false-alarm rate, Ra 1.6 um.
    fn curve_chart(&self, moving: bool) -> Chart {
        let robot = if moving { "moving" } else { "still" };
        let chart = Chart::new(
            format!("Latency against false alarms, robot {robot}, Ra 1.6 um"),
            Axis::log("false alarms per hour the threshold is set for"),
            Axis::linear("95 % latency from gross slip (ms)"),
        );
        self.cost.iter().fold(chart, |chart, cost| {
            let own = self.working.iter().filter(|w| w.detector == cost.detector);
            let place = |w: &Working| {
                let latency = w.outcome(1.6, moving)?.latency.p95;
                latency.is_finite().then_some((w.wanted_per_hour, latency))
            };
            let points: Vec<(f64, f64)> = own.filter_map(place).collect();
            // A lone point would be a name without a line.
            if points.len() < 2 { chart } else { chart.with(Layer::line(cost.detector, points)) }
        })
    }

    fn table(&self, f: &mut fmt::Formatter<'_>, per_hour: f64) -> fmt::Result {
        writeln!(
            f,
            "{per_hour} false alarms an hour; median / 95 % ms from gross slip, missed + under an alarm before"
        )?;
        write!(f, "{:18} {:>6} {:>9} {:>9}", "detector", "ns", "threshold", "counted")?;
        for (ra_um, moving) in KINDS {
            write!(f, "{:>22}", format!("Ra {ra_um} {}", if moving { "moving" } else { "still" }))?;
        }
        for w in self.at(per_hour) {
            let mark = if w.continued { "~" } else { "" };
            let threshold = format!("{mark}{:.3e}", w.threshold);
            let counted = w.fresh.map_or(String::new(), |fresh| fresh.alarms.to_string());
            write!(
                f,
                "\n{:18} {:6.1} {threshold:>9} {counted:>9}",
                w.detector,
                self.ns(w.detector)
            )?;
            for kind in KINDS {
                let cell = w.outcome(kind.0, kind.1).map_or(String::new(), |outcome| {
                    let l = outcome.latency;
                    format!("{} / {}, {}+{}", ms(l.p50), ms(l.p95), l.missed, l.early)
                });
                write!(f, "{cell:>22}")?;
            }
        }
        write!(f, "\n{:18} {:6} {:9} {:9}", "ln(ARL)/KL", "", "", "")?;
        for kind in KINDS {
            let row = self.bounds.iter().find(|row| row.is_of(kind.0, kind.1, per_hour));
            let cell = row.map_or(String::new(), |row| {
                format!("{} / {}     ", ms(row.together_ms[0]), ms(row.together_ms[1]))
            });
            write!(f, "{cell:>22}")?;
        }
        writeln!(f, "\n")
    }
}

fn ms(x: f64) -> String {
    if x.is_finite() { format!("{x:.1}") } else { "-".to_owned() }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for per_hour in SHOWN {
            self.table(f, per_hour)?;
        }
        writeln!(
            f,
            "counted: false alarms in {} fresh hours; ~: the tail of the run was continued to this rate",
            self.hours
        )?;
        writeln!(
            f,
            "\nln(ARL)/KL for one false alarm an hour, robot still: ms from gross slip (dB over the noise in its first 10 ms)"
        )?;
        for row in self.bounds.iter().filter(|row| !row.moving && row.per_hour < 2.0) {
            write!(
                f,
                "{:6} Hz Ra {:3}: together {:>6}",
                row.rate_hz,
                row.ra_um,
                ms(row.together_ms[0])
            )?;
            for (alone, db) in row.alone_ms.iter().zip(row.snr_db) {
                let db = if db.is_finite() { format!(" ({db:.0})") } else { String::new() };
                write!(f, "{:>16}", format!("{}{db}", ms(*alone)))?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
