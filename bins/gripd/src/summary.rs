//! What happened, at the end.

use grip_daemon::{HotCounters, recorder::RecorderCounters, rings::Dropped};
use grip_session::{replay, rows::RowCounters};
use grip_sim::Truth;
use serde::Serialize;
use std::io::{self, Write as _};

/// What happened.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ended {
    pub(crate) counters: HotCounters,
    /// Rows lost over all openings of the port.
    pub(crate) lost: u64,
    pub(crate) command_n: Option<f32>,
    /// Items that the service thread did not get.
    pub(crate) service: Dropped,
    /// What was recorded, where that was wanted.
    pub(crate) recorded: Option<RecorderCounters>,
    /// What became of the rows, where they were the sensor.
    pub(crate) rows: Option<RowCounters>,
}

/// The last line. Fields that only the simulator knows are absent on real hardware.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "summary")]
pub(crate) struct Summary {
    samples: u64,
    lost: u64,
    slips: u64,
    commands: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    held: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    dropped: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    crushed: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    force_needed_n: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    force_final_n: Option<f64>,
    command_n: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    slip_mm: Option<f64>,
    latency_us: Latency,
    bad_frames: u32,
    unusable_readings: u64,
    isolated_readings: u64,
    /// What to say of forces that were left out.
    #[serde(skip)]
    forces: Option<String>,
    unrecorded_samples: u64,
    untold_notes: u64,
    reconnects: u64,
    floor_lowered: u64,
    stages: Stages,
    #[serde(skip_serializing_if = "Option::is_none")]
    rows: Option<Rows>,
}

/// What became of the rows of another program.
#[derive(Clone, Copy, Debug, Serialize)]
struct Rows {
    taken: u64,
    bad: u64,
    late: u64,
    missing: u64,
}

/// From the last byte of a frame to the command written (us).
#[derive(Debug, Serialize)]
struct Latency {
    p50: f64,
    p99: f64,
    max: f64,
}

/// Samples that went through each stage.
#[derive(Debug, Serialize)]
struct Stages {
    bands: u64,
    gate: u64,
    methods: u64,
    observation: u64,
    inferences: u64,
    refused_estimates: u64,
}

impl Summary {
    pub(crate) fn new(ended: &Ended, truth: Option<Truth>) -> Self {
        let us = |ns: u64| ns as f64 / 1000.0;
        let Ended { counters, command_n, lost, service, recorded, rows } = *ended;
        let unrecorded =
            recorded.map_or(0, |recorded| counters.samples.saturating_sub(recorded.samples));
        let latency = |q| us(counters.latency.quantile_ns(q).unwrap_or(0));
        Self {
            samples: counters.samples,
            lost,
            slips: counters.slips,
            commands: counters.commands,
            held: truth.map(|t| t.lifted() && !t.dropped() && !t.crushed),
            dropped: truth.map(|t| t.dropped()),
            crushed: truth.map(|t| t.crushed),
            force_needed_n: truth.map(|t| t.force_needed_n),
            force_final_n: truth.map(|t| t.applied_n),
            command_n,
            slip_mm: truth.map(|t| t.slip_mm()),
            latency_us: Latency {
                p50: latency(0.5),
                p99: latency(0.99),
                max: us(counters.latency.max_ns()),
            },
            bad_frames: counters.frames.crc,
            unusable_readings: counters.health.unusable(),
            isolated_readings: counters.health.isolated,
            forces: replay::forces(&counters.health),
            unrecorded_samples: unrecorded,
            untold_notes: service.others,
            reconnects: counters.reconnects,
            floor_lowered: counters.stages.floor_lowered,
            stages: Stages {
                bands: counters.stages.bands,
                gate: counters.stages.gate,
                methods: counters.stages.methods,
                observation: counters.stages.observation,
                inferences: counters.stages.inferences,
                refused_estimates: counters.stages.refused_estimates,
            },
            rows: rows.map(|RowCounters { rows, bad, late, missing }| Rows {
                taken: rows,
                bad,
                late,
                missing,
            }),
        }
    }

    /// Whether something that was measured did not arrive, or was not written down.
    pub(crate) fn lost_data(&self) -> bool {
        let rows = self.rows.map_or(0, |rows| rows.bad + rows.late + rows.missing);
        self.lost + self.unrecorded_samples + self.untold_notes + rows > 0
    }

    pub(crate) fn print(&self, json: bool) -> io::Result<()> {
        let mut out = io::stdout().lock();
        if json {
            serde_json::to_writer(&mut out, self)?;
            return writeln!(out);
        }
        writeln!(
            out,
            "{} samples, {} lost, {} slips, {} commands, {} unusable readings",
            self.samples, self.lost, self.slips, self.commands, self.unusable_readings
        )?;
        if let Some(Rows { taken, bad, late, missing }) = self.rows {
            writeln!(out, "{taken} rows taken, {bad} bad, {late} late, {missing} missing")?;
        }
        if self.commands > 0 {
            let Latency { p50, p99, max } = self.latency_us;
            writeln!(
                out,
                "latency from frame to command: p50 {p50:.1} us, p99 {p99:.1} us, max {max:.1} us"
            )?;
        }
        if self.isolated_readings > 0 {
            writeln!(out, "{} isolated wrong readings were replaced", self.isolated_readings)?;
        }
        if let Some(forces) = &self.forces {
            writeln!(out, "{forces}")?;
        }
        if self.floor_lowered > 0 {
            writeln!(
                out,
                "the noise floor was lowered {} times: it had been learned in motion",
                self.floor_lowered
            )?;
        }
        if self.unrecorded_samples + self.untold_notes > 0 {
            writeln!(
                out,
                "{} samples were not recorded and {} notes not printed: the computer was too slow",
                self.unrecorded_samples, self.untold_notes
            )?;
        }
        self.print_truth(&mut out)
    }

    fn print_truth(&self, out: &mut impl io::Write) -> io::Result<()> {
        let command = self.command_n.map_or_else(|| "none".to_owned(), |n| format!("{n:.2} N"));
        let (Some(needed), Some(applied), Some(slip)) =
            (self.force_needed_n, self.force_final_n, self.slip_mm)
        else {
            return writeln!(out, "last command: {command}");
        };
        let fate = match (self.dropped, self.crushed, self.held) {
            (Some(true), ..) => "DROPPED",
            (_, Some(true), _) => "CRUSHED",
            (.., Some(true)) => "HELD",
            _ => "not lifted yet",
        };
        let sent = if self.commands > 0 { "commanded" } else { "thought of, never commanded," };
        writeln!(
            out,
            "force {sent} {command}, applied {applied:.2} N, needed {needed:.2} N (x {:.2})",
            applied / needed
        )?;
        writeln!(out, "slipped {slip:.2} mm, object {fate}")
    }
}
