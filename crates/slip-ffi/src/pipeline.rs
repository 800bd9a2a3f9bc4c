//! A pipeline behind a pointer, made from options: events, statistic and commands for each block.

use crate::{
    SlipBlock, SlipEvent, SlipOptions, SlipResult, SlipSignal, SlipState, SlipStatus,
    abi::known,
    border::{Column, place},
    clock::Clock,
};
use grip_record::StylusKind;
use grip_session::{
    HostConfig,
    calibration::Calibration,
    config::{Layers, Setting},
    model,
    replay::stylus_config,
    report::EventLog,
};
use slip_core::{
    Arrival, ClientCommand, NeededForce, Pipeline, PipelineConfig, Sample, Step,
    health::SensorHealth,
    pressure::MAX_TAXELS,
    sample::Scene,
    units::{Hertz, Micros},
};
use std::{path::Path, sync::Arc};

/// Marks memory that holds a pipeline; together with its address, so that a copy is none.
const MARK: usize = 0x5EED_511B;

/// A pipeline. What is in it is of no concern to C.
#[derive(Debug)]
pub struct SlipPipeline {
    mark: usize,
    pipeline: Pipeline<Arc<[f32]>>,
    log: EventLog,
    signal: StylusKind,
    clock: Clock,
    /// After the last row.
    pub(crate) state: SlipState,
    /// The same.
    pub(crate) need: Option<NeededForce>,
}

impl SlipPipeline {
    /// A pipeline for `memory`: options and the texts of settings, calibration and model in, or a sentence why not.
    pub(crate) fn new(
        options: &SlipOptions,
        [settings, calibration, model]: [Option<&str>; 3],
        memory: *mut Self,
    ) -> Result<Self, String> {
        let signal = match options.signal {
            x if x == SlipSignal::Displacement as u32 => StylusKind::Displacement,
            x if x == SlipSignal::Vibration as u32 => StylusKind::Vibration,
            x if x == SlipSignal::Absent as u32 => StylusKind::Absent,
            other => return Err(format!("signal = {other} is none of SLIP_SIGNAL_*")),
        };
        let mut layers = Layers::default();
        layers.push(Path::new("settings"), settings.unwrap_or_default());
        let set = layers.settings().map_err(|error| error.to_string())?;
        if let Some(Setting { key, place, .. }) =
            set.iter().find(|setting| ["calibration", "model"].contains(&&*setting.key))
        {
            let sentence = "no file is read, its text is given in slip_options";
            return Err(format!("{place}: {key}: {sentence}"));
        }
        let config = layers.resolve().map_err(|error| error.to_string())?;
        let calibrated = calibration
            .map(Calibration::parse)
            .transpose()
            .map_err(|error| format!("calibration: {error}"))?;
        let config = HostConfig { calibrated, ..config };
        let rate = Hertz(options.rate_hz);
        config
            .check_signal(rate, signal == StylusKind::Vibration)
            .map_err(|error| error.to_string())?;
        let estimator = match model {
            None => Some(model::default_estimator()),
            Some("") => None,
            Some(text) => Some(model::parse_estimator("model", text)),
        };
        let estimator = estimator.transpose().map_err(|error| error.to_string())?;
        let settings = stylus_config(signal, rate, &config);
        let grip = settings.grip.filter(|_| options.control != 0);
        if grip.is_some() && signal == StylusKind::Absent {
            return Err("control needs a stylus or a vibration".to_owned());
        }
        let settings = PipelineConfig { grip, ..settings };
        let pipeline = Pipeline::new(settings, estimator).map_err(|error| error.to_string())?;
        let state = SlipState {
            t_us: 0,
            statistic: 0.0,
            // The fingers are open.
            command_n: known(grip.map(|_| 0.0)),
            scene: Scene::default().code(),
            grip: pipeline.grip_state().unwrap_or_default().code(),
            sensors: [SensorHealth::default().code(); 4],
            floor: pipeline.detector().floor_health() as u8,
        };
        let (mark, log, clock) = (mark(memory), EventLog::default(), Clock::new(options.rate_hz));
        Ok(Self { mark, pipeline, log, signal, clock, state, need: None })
    }

    /// The pipeline at `pointer`, where there is one.
    ///
    /// # Safety
    /// `pointer` is null or points to readable bytes of this size, which nothing else uses.
    pub(crate) unsafe fn live<'a>(pointer: *mut Self) -> Result<&'a mut Self, SlipStatus> {
        let pointer = place(pointer)?;
        // SAFETY: a number, not null and aligned, in bytes that are readable by the caller's word.
        let found = unsafe { (&raw const (*pointer).mark).read() };
        if found != mark(pointer) {
            return Err(SlipStatus::NotCreated);
        }
        // SAFETY: the mark with this address was written by `slip_create` alone, with the pipeline behind it.
        Ok(unsafe { &mut *pointer })
    }

    /// Takes the mark away.
    pub(crate) fn end(&mut self) {
        self.mark = 0;
    }

    pub(crate) fn obey(&mut self, command: ClientCommand) -> bool {
        self.pipeline.obey(command)
    }

    /// Handles every row of `block`.
    ///
    /// # Safety
    /// As `slip_push`.
    pub(crate) unsafe fn push(
        &mut self,
        block: &SlipBlock,
        result: &mut SlipResult,
    ) -> Result<(), SlipStatus> {
        let columns = Columns::new(block)?;
        let needed = match self.signal {
            StylusKind::Absent => columns.any(),
            StylusKind::Displacement | StylusKind::Vibration => columns.stylus.start().is_some(),
        };
        if block.rows > 0 && !needed {
            return Err(SlipStatus::Null);
        }
        let statistic = Column::new(result.statistic, block.rows)?.start();
        let command_n = Column::new(result.command_n, block.rows)?.start();
        let room = if result.events.is_null() { 0 } else { result.room };
        Column::new(result.events, room)?;
        let mut ahead = self.clock;
        for row in 0..block.rows {
            // SAFETY: `row` is below the number of rows.
            ahead.next(unsafe { columns.t_us.at(row) }).ok_or(SlipStatus::Value)?;
        }
        for row in 0..block.rows {
            // SAFETY: `row` is below the number of rows.
            let (mut sample, t, taxels) = unsafe { columns.row(row) };
            sample.t = self.clock.next(t).ok_or(SlipStatus::Value)?;
            let step = self.pipeline.handle_with(&sample, taxels);
            // SAFETY: by the caller's word there is room for every row.
            unsafe { put(statistic, row, step.statistic) };
            // SAFETY: the same.
            unsafe { put(command_n, row, known(step.command.map(|command| command.0))) };
            if self.log.follows(&step) {
                for event in self.log.events(&step).iter().flatten() {
                    if result.found < room {
                        // SAFETY: aligned, and below the room there is by the caller's word.
                        unsafe {
                            result
                                .events
                                .add(result.found)
                                .write(SlipEvent::new(event, row as u64));
                        }
                    }
                    result.found += 1;
                }
            }
            if row + 1 == block.rows {
                (self.state, self.need) = (self.after(&step), step.need);
                result.state = self.state;
            }
        }
        Ok(())
    }

    fn after(&self, step: &Step) -> SlipState {
        SlipState {
            t_us: step.t.0,
            statistic: step.statistic,
            command_n: known(step.command.map(|command| command.0)),
            scene: step.scene.code(),
            grip: self.pipeline.grip_state().unwrap_or_default().code(),
            sensors: step.sensors.map(|health| health.code()),
            floor: step.floor_health as u8,
        }
    }
}

fn mark(pointer: *mut SlipPipeline) -> usize {
    MARK ^ pointer.addr()
}

/// Writes the value of a row, where somebody wants it.
///
/// # Safety
/// `to` has room for more than `row` values.
unsafe fn put(to: Option<*const f32>, row: usize, value: f32) {
    if let Some(to) = to {
        // SAFETY: aligned, as a column is, and with room by the caller's word.
        unsafe { to.cast_mut().add(row).write(value) };
    }
}

/// The channels of a block, with checked pointers.
struct Columns {
    t_us: Column<u64>,
    arrived_us: Column<u64>,
    age_us: Column<u64>,
    stylus: Column<f32>,
    stylus_axes: [Column<f32>; 2],
    normal_force_n: Column<f32>,
    tangential_n: Column<f32>,
    travel_m: Column<f32>,
    velocity_m_s: Column<f32>,
    second_stylus: Column<f32>,
    reference: Column<f32>,
    reference_axes: [Column<f32>; 2],
    pressure: Column<f32>,
    motion: Column<f32>,
    taxels: Column<f32>,
    taxel_count: usize,
}

impl Columns {
    fn new(block: &SlipBlock) -> Result<Self, SlipStatus> {
        let time = |pointer| Column::new(pointer, block.rows);
        let channel = |pointer| Column::new(pointer, block.rows);
        if block.taxel_count > MAX_TAXELS {
            return Err(SlipStatus::Size);
        }
        let taxels = block.rows.checked_mul(block.taxel_count).ok_or(SlipStatus::Size)?;
        Ok(Self {
            t_us: time(block.t_us)?,
            arrived_us: time(block.arrived_us)?,
            age_us: time(block.age_us)?,
            stylus: channel(block.stylus)?,
            stylus_axes: [channel(block.stylus_y)?, channel(block.stylus_z)?],
            normal_force_n: channel(block.normal_force_n)?,
            tangential_n: channel(block.tangential_n)?,
            travel_m: channel(block.travel_m)?,
            velocity_m_s: channel(block.velocity_m_s)?,
            second_stylus: channel(block.second_stylus)?,
            reference: channel(block.reference)?,
            reference_axes: [channel(block.reference_y)?, channel(block.reference_z)?],
            pressure: channel(block.pressure)?,
            motion: channel(block.motion)?,
            taxels: Column::new(block.taxels, taxels)?,
            taxel_count: block.taxel_count,
        })
    }

    /// Whether there is a channel.
    fn any(&self) -> bool {
        [
            self.stylus,
            self.normal_force_n,
            self.tangential_n,
            self.travel_m,
            self.velocity_m_s,
            self.second_stylus,
            self.reference,
            self.pressure,
            self.motion,
            self.taxels,
        ]
        .into_iter()
        .any(|column| column.start().is_some())
    }

    /// Sample, time and taxels of a row.
    ///
    /// # Safety
    /// `row` is below the number of rows.
    unsafe fn row(&self, row: usize) -> (Sample, Option<u64>, &[f32]) {
        // SAFETY: as this function asks for, here and below.
        let time = |column: Column<u64>| unsafe { column.at(row) };
        // SAFETY: the same.
        let value = |column: Column<f32>| unsafe { column.at(row) };
        let reading = |column| value(column).filter(|value| !value.is_nan());
        let axes = |columns: [Column<f32>; 2]| columns.map(|axis| value(axis).unwrap_or(0.0));
        let arrival = time(self.arrived_us)
            .map(|at| Arrival { at: Micros(at), age: Micros(time(self.age_us).unwrap_or(0)) });
        let taxels = self.taxels.start().map_or(&[] as &[f32], |start| {
            // SAFETY: aligned; frames of `taxel_count` values, one a row, which nothing writes while this is borrowed.
            unsafe {
                core::slice::from_raw_parts(start.add(row * self.taxel_count), self.taxel_count)
            }
        });
        let sample = Sample {
            t: Micros(0),
            stylus: value(self.stylus).unwrap_or(0.0),
            stylus_axes: axes(self.stylus_axes),
            normal_force_n: reading(self.normal_force_n),
            tangential_n: reading(self.tangential_n),
            travel_m: reading(self.travel_m),
            velocity_m_s: reading(self.velocity_m_s),
            second_stylus: reading(self.second_stylus),
            reference: reading(self.reference),
            reference_axes: axes(self.reference_axes),
            pressure: reading(self.pressure),
            motion: reading(self.motion),
            arrival,
        };
        (sample, time(self.t_us), taxels)
    }
}
