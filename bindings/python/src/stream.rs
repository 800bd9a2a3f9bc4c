//! Detector and pipeline for rows: events, statistics and force commands.

use crate::{
    input::{Block, Names, exists, no_rate, refused, times},
    output::dictionary,
    recording::{Recording, rows},
    settings::{CalibrationLike, Config, ModelLike, Settings},
};
use core::slice::ChunksExact;
use grip_record::Rows;
use grip_session::{
    report::{Event, EventLog},
    tape::{Played, Tape, TapeOptions},
};
use numpy::{IntoPyArray as _, PyArray1, PyArray2, PyArrayMethods as _, ToPyArray as _};
use pyo3::{prelude::*, types::PyDict};
use slip_core::{
    ClientCommand, PipelineConfig, Sample, Step,
    detector::{BANDS, FloorHealth},
    units::Micros,
};
use std::{path::PathBuf, sync::Arc};

/// Rows between two looks at Ctrl-C: some tens of milliseconds.
const ROWS_A_TURN: usize = 1 << 18;

/// What every row led to, as far as it is wanted.
#[derive(Default)]
struct Trace {
    bands: bool,
    t_s: Vec<f64>,
    statistic: Vec<f32>,
    scene: Vec<u8>,
    command_n: Vec<f32>,
    need: Vec<f32>,
    levels: Vec<f32>,
    /// After the last row.
    floor_health: FloorHealth,
    /// Whether the floor is not known yet.
    learning: bool,
}

impl Trace {
    fn of(rows: usize, bands: bool) -> Self {
        let command_n = Vec::with_capacity(rows);
        let (t_s, statistic, scene) =
            (Vec::with_capacity(rows), Vec::with_capacity(rows), Vec::with_capacity(rows));
        let levels = Vec::with_capacity(if bands { rows * BANDS } else { 0 });
        Self { bands, t_s, statistic, scene, command_n, levels, ..Self::default() }
    }

    /// All of a row but its bands.
    #[inline]
    fn take(&mut self, step: &Step) {
        self.t_s.push(step.t.as_seconds());
        self.statistic.push(step.statistic);
        self.scene.push(step.scene.code());
        self.command_n.extend(step.command.map(|command| command.0));
        if step.command.is_some() {
            self.need.extend(need(step));
        }
        self.floor_health = step.floor_health;
    }

    fn detection(
        self,
        py: Python<'_>,
        events: &Events,
        commands: bool,
        [slips, unusable, floor_lowered]: [u64; 3],
    ) -> PyResult<Detection> {
        let rows = self.t_s.len();
        let need = self.need.into_pyarray(py).reshape([if commands { rows } else { 0 }, NEED])?;
        let levels =
            self.levels.into_pyarray(py).reshape([if self.bands { rows } else { 0 }, BANDS])?;
        Ok(Detection {
            events: dictionaries(py, events)?,
            t_s: self.t_s.into_pyarray(py).unbind(),
            statistic: self.statistic.into_pyarray(py).unbind(),
            scene: self.scene.into_pyarray(py).unbind(),
            command_n: commands.then(|| self.command_n.into_pyarray(py).unbind()),
            need: commands.then(|| need.unbind()),
            levels: self.bands.then(|| levels.unbind()),
            slips,
            unusable,
            floor_lowered,
            floor_health: health(self.learning, self.floor_health),
        })
    }
}

/// The name of what is known of the floor.
fn health(learning: bool, health: FloorHealth) -> &'static str {
    if learning { "learning" } else { health.name() }
}

/// Columns of [`Detection::need`].
const NEED: usize = 4;

/// What the object in hand needs; NaN where nothing is known of it.
fn need(step: &Step) -> [f32; NEED] {
    step.need.map_or([f32::NAN; NEED], |need| {
        [need.low_n, need.median_n, need.high_n, need.admissible_m_s2]
    })
}

/// A pipeline with the log of its events.
struct Engine {
    pipeline: slip_core::Pipeline<Arc<[f32]>>,
    config: PipelineConfig,
    log: EventLog,
    count: u64,
    last: Option<Micros>,
    command_n: f32,
    need: [f32; NEED],
}

/// Events with the number of their row.
type Events = Vec<(u64, Event)>;

impl Engine {
    fn new(settings: &Settings, about: &grip_record::Recording, control: bool) -> PyResult<Self> {
        let (config, pipeline) = settings.pipeline(about, control)?;
        if control && config.grip.is_none() {
            return Err(refused(
                "channels: the controller needs `stylus` or `vibration`, and `force_n`, the grip force",
            ));
        }
        let log = EventLog::default();
        Ok(Self {
            pipeline,
            config,
            log,
            count: 0,
            last: None,
            command_n: f32::NAN,
            need: [f32::NAN; NEED],
        })
    }

    #[inline]
    fn take(
        &mut self,
        sample: &Sample,
        frame: &[f32],
        events: &mut Events,
        trace: Option<&mut Trace>,
    ) {
        let step = self.pipeline.handle_with(sample, frame);
        if self.log.follows(&step) {
            let happened = self.log.events(&step).into_iter().flatten();
            events.extend(happened.map(|event| (self.count, event)));
        }
        self.count += 1;
        self.last = Some(sample.t);
        self.command_n = step.command.map_or(f32::NAN, |command| command.0);
        self.need = need(&step);
        let Some(trace) = trace else { return };
        trace.take(&step);
        if trace.bands {
            trace.levels.extend(self.pipeline.detector().levels().energy);
        }
    }

    fn rows(
        &mut self,
        rows: &mut Rows,
        values: ChunksExact<'_, f32>,
        times: Option<&[Micros]>,
        events: &mut Events,
        mut trace: Option<&mut Trace>,
    ) {
        let mut times = times.map(<[Micros]>::iter);
        for row in values {
            let t = times.as_mut().and_then(|times| times.next().copied());
            let (sample, frame) = rows.sample(t, row);
            self.take(sample, frame, events, trace.as_deref_mut());
        }
    }

    fn detection(&self, py: Python<'_>, events: &Events, mut trace: Trace) -> PyResult<Detection> {
        let slips = self.log.slips();
        let unusable = self.pipeline.health_counters().unusable();
        let floor_lowered = self.pipeline.stage_counters().floor_lowered;
        trace.learning = self.pipeline.is_learning();
        trace.detection(py, events, self.config.grip.is_some(), [slips, unusable, floor_lowered])
    }
}

/// Events as dictionaries, with the number of their row as `sample`.
fn dictionaries(py: Python<'_>, events: &Events) -> PyResult<Vec<Py<PyDict>>> {
    let one = |(at, event): &(u64, Event)| {
        let dict = dictionary(py, event)?;
        dict.set_item("sample", at)?;
        Ok(dict.unbind())
    };
    events.iter().map(one).collect()
}

/// What a run over rows gave.
#[pyclass(frozen, get_all, module = "slipgrip")]
pub(crate) struct Detection {
    /// Events in order: dictionaries with the keys of `gripctl replay --json`, and `sample`, the number of the row.
    events: Vec<Py<PyDict>>,
    /// Times of the rows (s), (rows,).
    t_s: Py<PyArray1<f64>>,
    /// Evidence of a slip over the wanted interval, (rows,): 1 and above is a slip; 0 where nothing is held.
    statistic: Py<PyArray1<f32>>,
    /// What the pipeline sees, (rows,): the number of one of `SCENES`.
    scene: Py<PyArray1<u8>>,
    /// Commanded force (N), (rows,); None without a controller.
    command_n: Option<Py<PyArray1<f32>>>,
    /// What the object in hand needs, (rows, 4): columns as in `NEED`, NaN where nothing is known; None without a controller.
    need: Option<Py<PyArray2<f32>>>,
    /// Energy of each band over its floor, (rows, 6), as last computed; None unless bands=True.
    levels: Option<Py<PyArray2<f32>>>,
    /// Slips.
    slips: u64,
    /// Readings that no working sensor sends.
    unusable: u64,
    /// Times a quieter second has lowered the floor: it had been learned in motion.
    floor_lowered: u64,
    /// "learning" until the floor is known, and the stylus shows no slip before; "doubtful" where it was learned on something that moved or slid
    /// and no rest was seen since; else "good".
    floor_health: &'static str,
}

#[pymethods]
impl Detection {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let rows = self.t_s.bind(py).len()?;
        let floor = match (self.floor_health, self.floor_lowered) {
            ("learning", _) => ", floor never learned",
            ("good", 0) => "",
            ("good", _) => ", floor learned in motion and lowered",
            _ => ", floor doubtful",
        };
        let (slips, events) = (self.slips, self.events.len());
        Ok(format!("Detection({rows} rows, {slips} slips, {events} events{floor})"))
    }
}

/// Rows that arrive in blocks.
struct Stream {
    engine: Engine,
    rows: Rows,
    channels: Vec<String>,
}

impl Stream {
    fn shown(&self, class: &str) -> String {
        let rate_hz = self.engine.config.sample_rate.0;
        format!("{class}({rate_hz} Hz, channels={:?})", self.channels)
    }

    fn new(channels: Names, rate_hz: f64, settings: &Settings, control: bool) -> PyResult<Self> {
        let Names(channels) = channels;
        let rows = rows("rows", &channels, rate_hz)?;
        Ok(Self { engine: Engine::new(settings, &rows.about(), control)?, rows, channels })
    }

    /// Takes a block. All of it is checked before its first row is used.
    fn push(
        &mut self,
        py: Python<'_>,
        block: &Block<'_>,
        times_s: Option<&Bound<'_, PyAny>>,
        mut trace: Option<&mut Trace>,
    ) -> PyResult<Events> {
        let times = times_s.map(|t| times(t, block.rows(), self.engine.last)).transpose()?;
        let mut events = Events::new();
        let width = self.channels.len();
        for from in (0..block.rows()).step_by(ROWS_A_TURN) {
            let rows = from..block.rows().min(from + ROWS_A_TURN);
            let part_times = times.as_deref().map(|times| &times[rows.clone()]);
            // Without the GIL another thread of Python may write to the array, or free it.
            let part = block.values()?.get(rows.start * width..rows.end * width);
            let part = part.ok_or_else(|| refused("data: it has changed its size"))?.to_vec();
            let (engine, rows) = (&mut self.engine, &mut self.rows);
            let (events, trace) = (&mut events, trace.as_deref_mut());
            let values = part.chunks_exact(width);
            py.detach(|| engine.rows(rows, values, part_times, events, trace));
            if part.len() == ROWS_A_TURN * width {
                py.check_signals()?;
            }
        }
        Ok(events)
    }
}

/// Slips in rows that arrive in blocks; the events of `gripctl replay --observe`.
///
/// rate_hz: samples per second, 20 to 50,000 (Hz); channels: the name of each column, "vibration" by default;
/// config: gripd.toml or a dictionary with its keys; calibration: of `calibrate`, or its file;
/// model: of `train`, a file or "default".
#[pyclass(module = "slipgrip")]
pub(crate) struct Detector(Stream);

#[pymethods]
impl Detector {
    #[new]
    #[pyo3(signature = (rate_hz, channels=Names::vibration(), *, config=None, calibration=None, model=None))]
    fn new(
        rate_hz: f64,
        channels: Names,
        config: Option<Config<'_>>,
        calibration: Option<CalibrationLike<'_>>,
        model: Option<ModelLike<'_>>,
    ) -> PyResult<Self> {
        let settings = Settings::new(config, calibration, model)?;
        Stream::new(channels, rate_hz, &settings, false).map(Self)
    }

    fn __repr__(&self) -> String {
        self.0.shown("Detector")
    }

    /// Takes rows, (rows, channels) or (rows,) of one channel, and gives the events they led to. No rows are no events.
    /// `times`: (rows,) in s, never decreasing; without them rows follow each other at the rate.
    /// All of a block is checked before its first row is used.
    #[pyo3(signature = (block, times=None))]
    fn push(
        &mut self,
        py: Python<'_>,
        block: &Bound<'_, PyAny>,
        times: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<Py<PyDict>>> {
        let block = Block::new(block, &self.0.channels)?;
        let events = self.0.push(py, &block, times, None)?;
        dictionaries(py, &events)
    }

    /// The names of the columns of a block.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.0.channels.clone()
    }

    /// Samples per second (Hz).
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.0.engine.config.sample_rate.0.into()
    }

    /// Rows so far.
    #[getter]
    fn samples(&self) -> u64 {
        self.0.engine.count
    }

    /// Slips so far.
    #[getter]
    fn slips(&self) -> u64 {
        self.0.engine.log.slips()
    }

    /// The statistic of the stylus now, over its threshold.
    #[getter]
    fn statistic(&self) -> f64 {
        self.0.engine.pipeline.detector().levels().statistic.into()
    }

    /// Energy of each band over its floor now, (6,).
    #[getter]
    fn levels<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.0.engine.pipeline.detector().levels().energy.to_pyarray(py)
    }

    /// Energy of each band at rest (signal unit squared), (6,); None while it is being learned.
    #[getter]
    fn floor<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f32>>> {
        self.0.engine.pipeline.detector().floor().map(|floor| floor.to_pyarray(py))
    }

    /// "learning" until the floor is known, and the stylus shows no slip before; "doubtful" where it was learned on something that moved or slid
    /// and no rest was seen since; else "good".
    #[getter]
    fn floor_health(&self) -> &'static str {
        let pipeline = &self.0.engine.pipeline;
        health(pipeline.is_learning(), pipeline.detector().floor_health())
    }

    /// Times a quieter second has lowered the floor: it had been learned in motion or in a slip.
    #[getter]
    fn floor_lowered(&self) -> u32 {
        self.0.engine.pipeline.detector().floor_lowered()
    }
}

/// The whole signal path of a gripper with its force controller; arguments as for `Detector`. The channels must
/// have `stylus` or `vibration`, and `force_n`, the grip force of one finger (N).
#[pyclass(module = "slipgrip")]
pub(crate) struct Pipeline(Stream);

#[pymethods]
impl Pipeline {
    #[new]
    #[pyo3(signature = (rate_hz, channels, *, config=None, calibration=None, model=None))]
    fn new(
        rate_hz: f64,
        channels: Names,
        config: Option<Config<'_>>,
        calibration: Option<CalibrationLike<'_>>,
        model: Option<ModelLike<'_>>,
    ) -> PyResult<Self> {
        let settings = Settings::new(config, calibration, model)?;
        Stream::new(channels, rate_hz, &settings, true).map(Self)
    }

    fn __repr__(&self) -> String {
        self.0.shown("Pipeline")
    }

    /// Takes rows, (rows, channels), and gives what each led to, with the force commands (N).
    #[pyo3(signature = (block, times=None))]
    fn push(
        &mut self,
        py: Python<'_>,
        block: &Bound<'_, PyAny>,
        times: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Detection> {
        let block = Block::new(block, &self.0.channels)?;
        let mut trace = Trace::of(block.rows(), false);
        let events = self.0.push(py, &block, times, Some(&mut trace))?;
        self.0.engine.detection(py, &events, trace)
    }

    /// Takes rows, (rows, channels), and gives the force (N) to command now, and the events.
    #[pyo3(signature = (rows, times=None))]
    fn step(
        &mut self,
        py: Python<'_>,
        rows: &Bound<'_, PyAny>,
        times: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(f64, Vec<Py<PyDict>>)> {
        let block = Block::new(rows, &self.0.channels)?;
        let events = self.0.push(py, &block, times, None)?;
        Ok((self.0.engine.command_n.into(), dictionaries(py, &events)?))
    }

    /// The command does not fall below this force (N) any more.
    fn at_least(&mut self, force_n: f64) -> PyResult<()> {
        let force_n = crate::input::positive("force_n", force_n, true)?;
        #[expect(clippy::cast_possible_truncation, reason = "a force has 24 bits")]
        self.0.engine.pipeline.obey(ClientCommand::AtLeast(force_n as f32));
        Ok(())
    }

    /// The next objects are known to be held with this force (N), margin included; 0: nothing is known.
    fn expect(&mut self, force_n: f64) -> PyResult<()> {
        let force_n = crate::input::positive("force_n", force_n, true)?;
        #[expect(clippy::cast_possible_truncation, reason = "a force has 24 bits")]
        self.0.engine.pipeline.obey(ClientCommand::Expect(force_n as f32));
        Ok(())
    }

    /// Lets go.
    fn release(&mut self) {
        self.0.engine.pipeline.obey(ClientCommand::Release);
    }

    /// Closes again after `release`.
    fn grasp(&mut self) {
        self.0.engine.pipeline.obey(ClientCommand::Grasp);
    }

    /// The names of the columns of a block.
    #[getter]
    fn channels(&self) -> Vec<String> {
        self.0.channels.clone()
    }

    /// Samples per second (Hz).
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.0.engine.config.sample_rate.0.into()
    }

    /// The commanded force (N); NaN before the first row.
    #[getter]
    fn command_n(&self) -> f64 {
        self.0.engine.command_n.into()
    }

    /// What the object in hand needs, (4,): as in `NEED`, NaN where nothing is known.
    #[getter]
    fn need<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.0.engine.need.to_pyarray(py)
    }

    /// What the controller is doing: open, closing, settling, holding, slipping, lost, fault or released.
    #[getter]
    fn state(&self) -> Option<&'static str> {
        self.0.engine.pipeline.grip_state().map(|state| state.name())
    }

    /// Slips so far.
    #[getter]
    fn slips(&self) -> u64 {
        self.0.engine.log.slips()
    }
}

/// Slips in a recording, or in an array of shape (rows, channels) or (rows,) at `rate_hz` (Hz).
///
/// times: (rows,) in s, otherwise row i is at i / rate_hz; control: with the force controller, as `gripctl replay`
/// has it without --observe; bands: also gives the energy of each band. Other arguments as for `Detector`.
#[pyfunction]
#[pyo3(signature = (
    data, rate_hz=None, channels=None, *, times=None, config=None, calibration=None, model=None, control=false, bands=false
))]
pub(crate) fn detect(
    py: Python<'_>,
    data: &Bound<'_, PyAny>,
    rate_hz: Option<f64>,
    channels: Option<Names>,
    times: Option<&Bound<'_, PyAny>>,
    config: Option<Config<'_>>,
    calibration: Option<CalibrationLike<'_>>,
    model: Option<ModelLike<'_>>,
    control: bool,
    bands: bool,
) -> PyResult<Detection> {
    let settings = Settings::new(config, calibration, model)?;
    if let Ok(recording) = data.cast::<Recording>() {
        if rate_hz.is_some() || channels.is_some() || times.is_some() {
            return Err(refused(
                "a recording has its own rate, channels and times: leave them out",
            ));
        }
        return of_recording(py, &recording.get().inner, &settings, control, bands);
    }
    let Some(rate_hz) = rate_hz else {
        return Err(no_rate(data));
    };
    let channels = channels.unwrap_or_else(Names::vibration);
    let mut stream = Stream::new(channels, rate_hz, &settings, control)?;
    let block = Block::new(data, &stream.channels)?;
    if block.rows() == 0 {
        return Err(refused("data: it has no rows"));
    }
    let mut trace = Trace::of(block.rows(), bands);
    let events = stream.push(py, &block, times, Some(&mut trace))?;
    stream.engine.detection(py, &events, trace)
}

fn of_recording(
    py: Python<'_>,
    recording: &grip_record::Recording,
    settings: &Settings,
    control: bool,
    bands: bool,
) -> PyResult<Detection> {
    let mut engine = Engine::new(settings, recording, control)?;
    let mut trace = Trace::of(recording.samples.len(), bands);
    let mut events = Events::new();
    let taxels = recording.taxels.as_ref();
    for (at, part) in recording.samples.chunks(ROWS_A_TURN).enumerate() {
        py.detach(|| {
            for (at, sample) in (at * ROWS_A_TURN..).zip(part) {
                let frame = taxels.map_or(&[] as &[f32], |taxels| taxels.frame(at));
                engine.take(sample, frame, &mut events, Some(&mut trace));
            }
        });
        py.check_signals()?;
    }
    engine.detection(py, &events, trace)
}

/// An .mcap of gripd, replayed with the settings and the model that are recorded in it: the events of `replay` with
/// the number of their row, and what each row led to. Rows are those of `read`.
#[pyfunction]
pub(crate) fn trace(py: Python<'_>, path: PathBuf) -> PyResult<Detection> {
    exists(&path)?;
    let (mut events, mut trace) = (Events::new(), Trace::default());
    let played = py.detach(|| {
        let mut tape = Tape::new(TapeOptions::default());
        let mut count = 0;
        tape.play(&path, &mut |played| match played {
            Played::Line(event) => events.push((count, *event)),
            Played::Step { step, .. } => {
                trace.take(step);
                count += 1;
            }
            _ => {}
        })?;
        Ok::<_, grip_session::tape::TapeError>(tape.summary())
    });
    let summary = played.map_err(refused)?;
    if summary.pipelines != 1 {
        let count = summary.pipelines;
        return Err(refused(format!(
            "{}: it has {count} pipelines of gripd; one is needed",
            path.display()
        )));
    }
    let commands = !trace.command_n.is_empty();
    trace.learning = summary.learning;
    trace.detection(py, &events, commands, [summary.slips, summary.unusable, summary.floor_lowered])
}
