//! What crosses the border is what the Rust pipeline makes of the same samples; what cannot be is refused, and nothing
//! is allocated.

#![expect(clippy::unwrap_used, reason = "a test")]

use core::{ffi::CStr, fmt::Debug, mem::MaybeUninit, ptr};
use grip_record::{CsvOptions, StylusKind, read_recording};
use grip_session::{
    HostConfig,
    calibration::Calibration,
    model,
    replay::{pipeline_config, stylus_config},
    report::{Condition, Event, EventLog},
};
use grip_sim::{Grasp, Scene};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};
use rand_core::Rng as _;
use slip::*;
use slip_core::{
    Arrival, NeededForce, Pipeline, PipelineConfig, Sample, Step,
    detector::FloorHealth,
    esc::EscSums,
    grip::GripEvent,
    units::{Hertz, Micros},
};
use std::{env, fs, path::PathBuf, sync::Arc};

const DEFAULTS: SlipOptions = SlipOptions {
    rate_hz: 10_000.0,
    signal: SlipSignal::Displacement as u32,
    control: 0,
    settings: ptr::null(),
    calibration: ptr::null(),
    model: ptr::null(),
};
/// More than a pipeline needs.
type Memory = MaybeUninit<[u64; 16_384]>;

fn create(memory: &mut Memory, options: &SlipOptions) -> Result<*mut SlipPipeline, String> {
    let mut why = [0; 256];
    let mut made = ptr::null_mut();
    // SAFETY: all of it is ours.
    let status = unsafe {
        let size = size_of::<Memory>();
        slip_create(memory.as_mut_ptr().cast(), size, options, why.as_mut_ptr(), 256, &raw mut made)
    };
    // SAFETY: `slip_create` writes a zero byte, or it is there already.
    let why = unsafe { CStr::from_ptr(why.as_ptr()) };
    if status == SlipStatus::Ok {
        Ok(made)
    } else {
        Err(format!("{status:?} {}", why.to_string_lossy()))
    }
}

/// Columns of samples, NaN for what is not there.
struct Table {
    t_us: Vec<u64>,
    /// In the order of [`SlipBlock`].
    columns: [Vec<f32>; CHANNELS],
    arrived_us: Option<Vec<u64>>,
    age_us: Option<Vec<u64>>,
}

const CHANNELS: usize = 13;

impl Table {
    fn new(samples: &[Sample]) -> Self {
        let column = |of: fn(&Sample) -> Option<f32>| {
            samples.iter().map(|sample| of(sample).unwrap_or(f32::NAN)).collect()
        };
        let arrival = |of: fn(Arrival) -> Micros| {
            samples.iter().map(|sample| sample.arrival.map(|arrival| of(arrival).0)).collect()
        };
        let columns = [
            column(|s| Some(s.stylus)),
            column(|s| Some(s.stylus_axes[0])),
            column(|s| Some(s.stylus_axes[1])),
            column(|s| s.normal_force_n),
            column(|s| s.tangential_n),
            column(|s| s.travel_m),
            column(|s| s.velocity_m_s),
            column(|s| s.second_stylus),
            column(|s| s.reference),
            column(|s| Some(s.reference_axes[0])),
            column(|s| Some(s.reference_axes[1])),
            column(|s| s.pressure),
            column(|s| s.motion),
        ];
        Self {
            t_us: samples.iter().map(|sample| sample.t.0).collect(),
            columns,
            arrived_us: arrival(|arrival| arrival.at),
            age_us: arrival(|arrival| arrival.age),
        }
    }

    /// Rows from `begin` to `end`.
    fn block(&self, begin: usize, end: usize) -> SlipBlock {
        let start = |column: &Vec<f32>| match column.get(begin..end) {
            Some(rows) => rows.as_ptr(),
            None => ptr::null(),
        };
        let time = |column: &Option<Vec<u64>>| {
            column.as_ref().map_or(ptr::null(), |c| c[begin..].as_ptr())
        };
        let [stylus, stylus_y, stylus_z, normal_force_n, tangential_n, travel_m, rest @ ..] =
            self.columns.each_ref().map(start);
        let [velocity_m_s, second_stylus, reference, reference_y, reference_z, pressure, motion] =
            rest;
        SlipBlock {
            rows: end - begin,
            t_us: self.t_us[begin..end].as_ptr(),
            stylus,
            stylus_y,
            stylus_z,
            normal_force_n,
            tangential_n,
            travel_m,
            velocity_m_s,
            second_stylus,
            reference,
            reference_y,
            reference_z,
            pressure,
            motion,
            arrived_us: time(&self.arrived_us),
            age_us: time(&self.age_us),
            ..SlipBlock::default()
        }
    }
}

/// Results of a block of `rows`.
fn push(
    pipeline: *mut SlipPipeline,
    block: &SlipBlock,
) -> Result<(Vec<SlipEvent>, Vec<f32>, SlipState), SlipStatus> {
    let mut events = Vec::with_capacity(7 * block.rows);
    let (mut statistic, mut command_n) = (vec![0.0; block.rows], vec![0.0; block.rows]);
    let mut result = SlipResult {
        events: events.as_mut_ptr(),
        room: events.capacity(),
        statistic: statistic.as_mut_ptr(),
        command_n: command_n.as_mut_ptr(),
        ..SlipResult::default()
    };
    // SAFETY: all of it is ours.
    let status = unsafe { slip_push(pipeline, block, &raw mut result) };
    if status != SlipStatus::Ok {
        return Err(status);
    }
    // SAFETY: so many were written.
    unsafe { events.set_len(result.found) };
    command_n.extend(statistic);
    Ok((events, command_n, result.state))
}

/// What the object in hand needs.
fn needed(pipeline: *mut SlipPipeline) -> Result<SlipNeed, SlipStatus> {
    let mut need = SlipNeed::from(Some(NeededForce::default()));
    // SAFETY: all of it is ours, or null.
    let status = unsafe { slip_needed(pipeline, &raw mut need) };
    if status == SlipStatus::Ok { Ok(need) } else { Err(status) }
}

type Twin = Pipeline<Arc<[f32]>>;

fn rust(config: PipelineConfig) -> (Twin, EventLog) {
    (Pipeline::new(config, Some(model::default_estimator().unwrap())).unwrap(), EventLog::default())
}

/// What [`SlipEvent`] is to hold of `event`.
fn expected(event: &Event, row: u64) -> SlipEvent {
    let (long, short) = (f64::NAN, f32::NAN);
    let other = |kind, t: Micros, sensor, code, command_n: Option<f32>| SlipEvent {
        t_us: t.0,
        row,
        kind,
        sensor,
        code,
        command_n: command_n.unwrap_or(short),
        esc_w: long,
        esc: long,
        duration_s: long,
        statistic: short,
        confidence: short,
        speed_m_s: short,
        speed_sigma_m_s: short,
        moved_m: short,
        estimate_n: short,
        estimate_sigma_n: short,
        certified_s: short,
        ..SlipEvent::default()
    };
    match event {
        Event::Slip(slip) => SlipEvent {
            esc_w: slip.esc_w.unwrap_or(f64::NAN),
            esc: slip.esc.unwrap_or(f64::NAN),
            duration_s: slip.duration_s.unwrap_or(f64::NAN),
            irregularities: slip.irregularities.unwrap_or(0),
            phase: slip.phase.code(),
            method: slip.method.code(),
            speed_source: slip.speed_source.code(),
            reading: slip.esc_kind.code(),
            esc_flags: slip.esc_flags,
            notes: slip.notes,
            ruled_out: slip.ruled_out,
            possible: slip.possible,
            first: u8::from(slip.first),
            statistic: slip.statistic.unwrap_or(f32::NAN),
            confidence: slip.confidence.unwrap_or(f32::NAN),
            speed_m_s: slip.speed_m_s.unwrap_or(f32::NAN),
            speed_sigma_m_s: slip.speed_sigma_m_s.unwrap_or(f32::NAN),
            moved_m: slip.moved_m.unwrap_or(f32::NAN),
            estimate_n: slip.estimate_n.unwrap_or(f32::NAN),
            estimate_sigma_n: slip.estimate_sigma_n.unwrap_or(f32::NAN),
            certified_s: slip.certified_s.unwrap_or(f32::NAN),
            ..other(1, slip.t, 0, 0, slip.command_n)
        },
        Event::Grip { t, event, command_n } => {
            let code = match event {
                GripEvent::Empty => 1,
                GripEvent::Lost => 2,
                GripEvent::Regrasped => 3,
                GripEvent::Persistent => 4,
                GripEvent::Found => 5,
                GripEvent::Limited => 6,
            };
            other(2, *t, 0, code, *command_n)
        }
        Event::Health { t, condition: Condition::Sensor(sensor, health) } => {
            other(3, *t, sensor.code(), health.code(), None)
        }
        Event::Health { t, condition: Condition::Floor(floor) } => {
            other(4, *t, 0, u8::from(*floor == FloorHealth::Doubtful), None)
        }
        Event::Health { condition: Condition::Clock(_), .. } => {
            unreachable!("the pipeline judges no clock")
        }
    }
}

/// Every field is the same to the last bit: the shortest text of a number that is read as the same number is so.
fn assert_same(ours: &impl Debug, theirs: &impl Debug) {
    assert_eq!(format!("{ours:?}"), format!("{theirs:?}"));
}

fn state_of(step: &Step, twin: &Twin) -> SlipState {
    SlipState {
        t_us: step.t.0,
        statistic: step.statistic,
        command_n: step.command.map_or(f32::NAN, |command| command.0),
        scene: step.scene.code(),
        grip: twin.grip_state().unwrap_or_default().code(),
        sensors: step.sensors.map(|health| health.code()),
        floor: u8::from(step.floor_health == FloorHealth::Doubtful),
    }
}

/// Pushes `samples` in blocks of random lengths, where they are evenly spaced without times now and then; gives all
/// events where all is as in `config`'s pipeline.
fn agree(
    samples: &[Sample],
    options: &SlipOptions,
    config: PipelineConfig,
    seed: u64,
) -> Vec<SlipEvent> {
    let mut memory = Memory::uninit();
    let pipeline = create(&mut memory, options).unwrap();
    let (mut twin, mut log) = rust(config);
    let table = Table::new(samples);
    let period_us = 1e6 / options.rate_hz;
    let even = samples.windows(2).all(|pair| pair[1].t.since(pair[0].t).0 as f32 == period_us);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut all = Vec::new();
    let mut begin = 0;
    while begin < samples.len() {
        let end = (begin + 1 + random.next_u32() as usize % 500).min(samples.len());
        let mut block = table.block(begin, end);
        if even && begin > 0 && random.next_u32().is_multiple_of(3) {
            block.t_us = ptr::null();
        }
        let (events, values, state) = push(pipeline, &block).unwrap();
        let mut ours = events.iter();
        for (at, sample) in samples[begin..end].iter().enumerate() {
            let step = twin.handle(sample);
            for theirs in log.events(&step).iter().flatten() {
                assert_same(ours.next().unwrap(), &expected(theirs, at as u64));
            }
            let theirs = state_of(&step, &twin);
            assert_same(&values[at], &theirs.command_n);
            assert_same(&values[end - begin + at], &theirs.statistic);
            if begin + at + 1 == end {
                assert_same(&state, &theirs);
                assert_same(&needed(pipeline).unwrap(), &SlipNeed::from(step.need));
            }
        }
        assert!(ours.next().is_none());
        all.extend(events);
        begin = end;
    }
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
    all
}

/// Slips among events.
fn slips(events: &[SlipEvent]) -> usize {
    events.iter().filter(|event| event.first == 1).count()
}

fn scene(name: &str) -> Scene {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.toml"));
    Scene::from_toml(&fs::read_to_string(file).unwrap()).unwrap()
}

#[test]
fn simulated_slips_are_those_of_the_rust_pipeline() {
    for (seed, name) in ["default", "shaken", "oily_steel"].into_iter().enumerate() {
        let mut grasp = Grasp::new(&scene(name).reseeded(3000 + seed as u64).unwrap());
        let needed_n = grasp.truth().force_needed_n.max(1.0);
        let samples: Vec<_> = (0..20_000)
            .map(|at| grasp.step_sample(needed_n * if at < 8000 { 1.3 } else { 0.8 }))
            .collect();
        let config =
            stylus_config(StylusKind::Displacement, Hertz(10_000.0), &HostConfig::default());
        let observing = PipelineConfig { grip: None, ..config };
        let observed = slips(&agree(&samples, &DEFAULTS, observing, 1));
        let commanded = slips(&agree(&samples, &SlipOptions { control: 1, ..DEFAULTS }, config, 2));
        assert!(observed > 0 && commanded > 0, "{name}: {observed}, {commanded}");
        let text = include_str!("../../grip-session/tests/config/good/beside/cal.toml");
        let config = Calibration::parse(text).unwrap().apply(observing);
        let text = format!("{text}\0");
        agree(&samples, &SlipOptions { calibration: text.as_ptr().cast(), ..DEFAULTS }, config, 3);
    }
}

#[test]
#[ignore = "needs the recordings (CONTRIBUTING.md, Data)"]
fn recorded_slips_are_those_of_gripctl_replay() {
    let project = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let data =
        env::var_os("GRIP_DATA").map_or_else(|| project.join("../shared/data"), PathBuf::from);
    let folder = data.join("biotac_slide");
    let files =
        fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let (mut read, mut found) = (0, 0);
    for file in files.map(|entry| entry.unwrap().path()) {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        if !name.starts_with('m') || name.contains("electrodes") || name.contains("pose") {
            continue;
        }
        let recording = read_recording(&file, &CsvOptions::default()).unwrap();
        let config = pipeline_config(&recording, &HostConfig::default(), true);
        let signal = SlipSignal::Vibration as u32;
        let options = SlipOptions { rate_hz: recording.rate_hz, signal, ..DEFAULTS };
        found += slips(&agree(&recording.samples, &options, config, read));
        read += 1;
    }
    println!("{read} recordings, {found} slips");
    assert!(read >= 50 && found >= 50, "{read} recordings, {found} slips");
}

/// Samples of a grasp whose object begins to slip after 0.8 s, with something of its own in every channel.
fn every_channel(seed: u64) -> Vec<Sample> {
    let mut grasp = Grasp::new(&scene("default").reseeded(seed).unwrap());
    let needed_n = grasp.truth().force_needed_n.max(1.0);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noise =
        |deviation: f32| deviation * (random.next_u32() as f32 / 2.0_f32.powi(31) - 1.0);
    let mut first = Vec::new();
    (0..20_000)
        .map(|at: usize| {
            let share = if at < 8000 { 1.3 } else { 0.8 };
            let sample = grasp.step_sample(needed_n * share);
            first.push(sample.stylus);
            let slides = at > 8000;
            let own = if slides { 30.0 } else { 1.0 };
            Sample {
                stylus_axes: [noise(2e-7 * own), noise(3e-7 * own)],
                tangential_n: Some(1.0 + noise(0.1)),
                velocity_m_s: Some(if slides { 0.02 + noise(1e-3) } else { 0.0 }),
                second_stylus: Some(first[at.saturating_sub(100)]),
                reference: Some(noise(0.4)),
                reference_axes: [noise(0.5), noise(0.6)],
                pressure: Some(7.0 + noise(0.1)),
                motion: Some(f32::from(u8::from((9000..9500).contains(&at)))),
                arrival: Some(Arrival {
                    at: Micros(sample.t.0 + 5_000_000),
                    age: Micros(sample.t.0 / 100 % 7),
                }),
                ..sample
            }
        })
        .collect()
}

#[test]
fn every_channel_reaches_the_pipeline() {
    let samples = every_channel(3000);
    for (signal, kind) in [
        (SlipSignal::Displacement, StylusKind::Displacement),
        (SlipSignal::Vibration, StylusKind::Vibration),
    ] {
        let options = SlipOptions { signal: signal as u32, control: 1, ..DEFAULTS };
        let config = stylus_config(kind, Hertz(10_000.0), &HostConfig::default());
        assert!(slips(&agree(&samples, &options, config, 4)) > 0);
        let mut memory = Memory::uninit();
        let mut outcome = |without: &[usize]| {
            let pipeline = create(&mut memory, &options).unwrap();
            let mut table = Table::new(&samples);
            without.iter().for_each(|channel| table.columns[*channel].clear());
            let out = format!("{:?}", push(pipeline, &table.block(0, samples.len())).unwrap());
            // SAFETY: made by `create`.
            assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
            out
        };
        let (second_stylus, pressure) = (7, 11);
        for channel in (1..CHANNELS).filter(|channel| *channel != pressure) {
            // Two styli give the speed where neither travel nor velocity does. No stage reads the pressure yet.
            let others = if channel == second_stylus { &[5, 6][..] } else { &[] };
            let without = outcome(&[others, &[channel]].concat());
            assert!(without != outcome(others), "{signal:?}: channel {channel} changes nothing");
        }
    }
}

#[test]
fn old_evidence_raises_no_force() {
    let config = stylus_config(StylusKind::Displacement, Hertz(10_000.0), &HostConfig::default());
    let options = SlipOptions { control: 1, ..DEFAULTS };
    let command_n = [0, 200_000].map(|age| {
        let mut samples = every_channel(3000);
        for sample in &mut samples[8000..] {
            sample.arrival = sample.arrival.map(|arrival| Arrival { age: Micros(age), ..arrival });
        }
        let events = agree(&samples, &options, config, 5);
        assert!(slips(&events) > 0);
        events.iter().map(|event| event.command_n).fold(0.0, f32::max)
    });
    assert!(command_n[1] < command_n[0], "{command_n:?}");
}

#[test]
fn nothing_is_allocated_after_create() {
    let mut memory = Memory::uninit();
    let options = SlipOptions { control: 1, ..DEFAULTS };
    let pipeline = create(&mut memory, &options).unwrap();
    let mut grasp = Grasp::new(&scene("default").reseeded(3000).unwrap());
    let mut events = Vec::with_capacity(64);
    let (mut command_n, mut slips) = (0.0, 0);
    for _ in 0..20_000 {
        let table = Table::new(&[grasp.step_sample(f64::from(command_n))]);
        let block = table.block(0, 1);
        let mut result = SlipResult {
            events: events.as_mut_ptr(),
            room: events.capacity(),
            command_n: &raw mut command_n,
            ..SlipResult::default()
        };
        let seen = allocation_counter::measure(|| {
            // SAFETY: all of it is ours.
            assert_eq!(unsafe { slip_push(pipeline, &block, &raw mut result) }, SlipStatus::Ok);
        });
        assert_eq!(seen.count_total, 0);
        slips += result.found;
    }
    let truth = grasp.truth();
    assert!(slips > 0 && truth.lifted() && !truth.dropped() && !truth.crushed, "{truth:?}");
    // SAFETY: made by `create`; the second time there is none.
    let ends = [(); 2].map(|()| unsafe { slip_destroy(pipeline) });
    assert_eq!(ends, [SlipStatus::Ok, SlipStatus::NotCreated]);
}

#[test]
fn options_that_do_not_fit_are_named() {
    let mut memory = Memory::uninit();
    let mut refused = |options: &SlipOptions| create(&mut memory, options).unwrap_err();
    for (rate_hz, stated) in
        [(f32::NAN, "NaN"), (0.0, "0"), (f32::INFINITY, "inf"), (1e6, "1000000")]
    {
        let text = refused(&SlipOptions { rate_hz, ..DEFAULTS });
        assert_eq!(text, format!("Options sample_rate_hz = {stated} is outside 20 to 50000"));
    }
    let text = refused(&SlipOptions { signal: 7, ..DEFAULTS });
    assert_eq!(text, "Options signal = 7 is none of SLIP_SIGNAL_*");
    let signal = SlipSignal::Absent as u32;
    assert!(refused(&SlipOptions { signal, control: 1, ..DEFAULTS }).contains("needs a stylus"));
    let settings = c"[grip]\nforce = 3\n".as_ptr();
    let text = refused(&SlipOptions { settings, ..DEFAULTS });
    assert!(text.starts_with("Options settings:2:1: unknown field `force`"), "{text}");
    let calibration = c"floor = 1".as_ptr();
    assert!(refused(&SlipOptions { calibration, ..DEFAULTS }).starts_with("Options calibration: "));
    let model = c"{}".as_ptr();
    assert!(refused(&SlipOptions { model, ..DEFAULTS }).contains("no model file"));
    let model = c"\xff".as_ptr();
    assert_eq!(refused(&SlipOptions { model, ..DEFAULTS }), "Text a text is not UTF-8");
    for key in ["calibration", "model"] {
        let settings = format!("{key} = \"file\"\0");
        let settings = settings.as_ptr().cast();
        let text = refused(&SlipOptions { settings, ..DEFAULTS });
        let sentence = "no file is read, its text is given in slip_options";
        assert_eq!(text, format!("Options settings:1:1: {key}: {sentence}"));
    }
}

#[test]
fn every_failure_of_create_has_a_sentence_and_no_pipeline() {
    let mut memory = Memory::uninit();
    let misaligned = memory.as_mut_ptr().cast::<u8>().wrapping_add(1);
    let memory = memory.as_mut_ptr().cast::<u8>();
    let mut made = ptr::dangling_mut();
    let mut why = [0; 64];
    let mut call = |memory: *mut u8, size, options, made: *mut *mut SlipPipeline| {
        // SAFETY: all of it is ours, null, or misaligned.
        let status =
            unsafe { slip_create(memory.cast(), size, options, why.as_mut_ptr(), 64, made) };
        // SAFETY: ends with a zero byte, or holds nothing else.
        let why = unsafe { CStr::from_ptr(why.as_ptr()) };
        // SAFETY: a text of the library.
        assert_eq!(why, unsafe { CStr::from_ptr(slip_error_text(status as i32)) });
        status
    };
    let (size, options, null) = (slip_size(), ptr::from_ref(&DEFAULTS), ptr::null_mut());
    assert_eq!(call(memory, size, options, null), SlipStatus::Null);
    for (memory, size, options, status) in [
        (null.cast(), size, options, SlipStatus::Null),
        (misaligned, size, options, SlipStatus::Align),
        (memory, size - 1, options, SlipStatus::Size),
        (memory, size, ptr::null(), SlipStatus::Null),
    ] {
        assert_eq!(call(memory, size, options, &raw mut made), status);
        assert!(made.is_null());
        made = ptr::dangling_mut();
    }
}

#[test]
fn settings_of_a_file_are_in_force() {
    let text = "[grip]\nf_max_n = 2.0\ntrial_force_n = 1.0\n";
    let mut memory = Memory::uninit();
    let settings = format!("{text}\0");
    let options = SlipOptions { control: 1, settings: settings.as_ptr().cast(), ..DEFAULTS };
    let pipeline = create(&mut memory, &options).unwrap();
    let t_us: Vec<_> = (0..20_000).map(|at| 100 * at).collect();
    let mut random = ChaCha8Rng::seed_from_u64(3000);
    let noise = |_: &u64| 1e-9 * (random.next_u32() % 100) as f32;
    let stylus: Vec<_> = t_us.iter().map(noise).collect();
    let force = vec![1.0; t_us.len()];
    let block = SlipBlock {
        rows: t_us.len(),
        stylus: stylus.as_ptr(),
        normal_force_n: force.as_ptr(),
        ..SlipBlock::default()
    };
    // SAFETY: made by `create`.
    let command = |operation, force_n| unsafe { slip_command(pipeline, operation, force_n) };
    assert_eq!(command(1, 50.0), SlipStatus::Ok);
    let (_, values, state) = push(pipeline, &block).unwrap();
    let most = values[..t_us.len()].iter().copied().fold(0.0, f32::max);
    assert_eq!((most, state.command_n, state.t_us), (2.0, 2.0, 1_999_900), "spaced by the rate");
    assert_eq!(command(2, f32::NAN), SlipStatus::Ok);
    assert_eq!(push(pipeline, &block).unwrap().2.command_n, 0.0);
    for refused in [command(1, f32::NAN), command(1, -1.0), command(4, 0.0), command(99, 0.0)] {
        assert_eq!(refused, SlipStatus::Value);
    }
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
}

#[test]
fn esc_is_that_of_the_rust_sums() {
    let (delta_m, spacing_m) = ([1e-6, 2e-6, 3e-6], [1e-4, 1.5e-4, 2e-4]);
    let trial = SlipTrial {
        force_n: 2.0,
        speed_m_s: 0.01,
        damping_n_s_m: 0.14,
        noise: 0.01,
        common_noise: 0.0,
    };
    let mut sums = EscSums::default();
    for (delta_m, spacing_m) in delta_m.into_iter().zip(spacing_m) {
        sums.push(delta_m, spacing_m);
    }
    let mut value = MaybeUninit::<SlipEsc>::uninit();
    let mut call = |n, reading| {
        let [delta_m, spacing_m] = [delta_m.as_ptr(), spacing_m.as_ptr()];
        // SAFETY: all of it is ours.
        let status = unsafe {
            slip_esc(delta_m, spacing_m, n, &raw const trial, reading, value.as_mut_ptr())
        };
        // SAFETY: written where the status is Ok.
        (status == SlipStatus::Ok).then(|| unsafe { value.assume_init() }).ok_or(status)
    };
    for reading in slip_core::esc::Reading::ALL {
        let (ours, theirs) =
            (call(3, reading.code()).unwrap(), sums.value(reading, &trial.into()).unwrap());
        assert_eq!(
            (ours.value, ours.lo, ours.hi, ours.n),
            (theirs.value, theirs.lo, theirs.hi, 3),
            "{reading:?}"
        );
    }
    assert_eq!(call(0, 1).unwrap_err(), SlipStatus::NoValue);
    assert_eq!(call(3, 0).unwrap_err(), SlipStatus::Value);
}

/// Status, `found` and state of a block, with a result that held something else before.
fn outcome(pipeline: *mut SlipPipeline, block: *const SlipBlock) -> (SlipStatus, usize, SlipState) {
    let mut result = SlipResult { found: 99, ..SlipResult::default() };
    // SAFETY: all of it is ours, or null.
    let status = unsafe { slip_push(pipeline, block, &raw mut result) };
    (status, result.found, result.state)
}

#[test]
fn a_time_that_does_not_rise_refuses_the_whole_block() {
    let mut memory = Memory::uninit();
    let pipeline = create(&mut memory, &DEFAULTS).unwrap();
    let push = |t_us: &[u64]| {
        let stylus = vec![1e-9; t_us.len()];
        let (rows, t_us) = (t_us.len(), t_us.as_ptr());
        let (status, _, state) = outcome(
            pipeline,
            &SlipBlock { rows, t_us, stylus: stylus.as_ptr(), ..SlipBlock::default() },
        );
        (status, state.t_us)
    };
    let untimed = || {
        let (status, _, state) = outcome(
            pipeline,
            &SlipBlock { rows: 1, stylus: [1e-9].as_ptr(), ..SlipBlock::default() },
        );
        (status, state.t_us)
    };
    let (ok, value) = (SlipStatus::Ok, SlipStatus::Value);
    assert_eq!(push(&[0, 100, 200]), (ok, 200));
    assert_eq!(push(&[200]), (value, 200), "the clock stands");
    assert_eq!(push(&[100]), (value, 200), "the clock was set back");
    assert_eq!(push(&[300, 400, 400]), (value, 200), "the block is refused whole");
    assert_eq!(push(&[300, 400]), (ok, 400));
    assert_eq!(untimed(), (ok, 500), "a row without a time follows by the rate");
    assert_eq!(push(&[500]), (value, 500));
    assert_eq!(push(&[u64::MAX]), (ok, u64::MAX), "a jump ahead is a gap");
    assert_eq!(push(&[600]), (value, u64::MAX), "which no time follows");
    assert_eq!(untimed(), (value, u64::MAX));
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
}

#[test]
fn the_state_is_always_written_and_found_too() {
    let mut memory = Memory::uninit();
    let options = SlipOptions { control: 1, ..DEFAULTS };
    let pipeline = create(&mut memory, &options).unwrap();
    let empty = SlipBlock::default();
    let (status, found, state) = outcome(pipeline, &empty);
    assert_eq!((status, found, state.command_n, state.grip), (SlipStatus::Ok, 0, 0.0, 1), "open");
    assert!(needed(pipeline).unwrap().median_n.is_nan(), "nothing is held");
    assert_eq!(needed(ptr::null_mut()).unwrap_err(), SlipStatus::Null);
    // SAFETY: made by `create`; null is refused.
    assert_eq!(unsafe { slip_needed(pipeline, ptr::null_mut()) }, SlipStatus::Null);
    let (stylus, force) = ([0.0; 2000], [2.0; 2000]);
    let (stylus, normal_force_n) = (stylus.as_ptr(), force.as_ptr());
    let block = SlipBlock { rows: 2000, stylus, normal_force_n, ..SlipBlock::default() };
    let last = outcome(pipeline, &block).2;
    assert!(last.command_n > 0.0 && last.t_us == 199_900, "{last:?}");
    let refused = SlipBlock { taxel_count: 257, ..block };
    let no_stylus = SlipBlock { stylus: ptr::null(), ..block };
    for (block, expected) in [
        (&raw const empty, SlipStatus::Ok),
        (&raw const refused, SlipStatus::Size),
        (&raw const no_stylus, SlipStatus::Null),
        (ptr::null(), SlipStatus::Null),
    ] {
        let (status, found, state) = outcome(pipeline, block);
        assert_eq!((status, found), (expected, 0));
        assert_eq!(format!("{state:?}"), format!("{last:?}"), "as after the last row");
    }
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
    assert_eq!(outcome(pipeline, &block).1, 0, "of a pipeline that has ended");
    let signal = SlipSignal::Absent as u32;
    let pipeline = create(&mut memory, &SlipOptions { signal, ..DEFAULTS }).unwrap();
    let nothing = SlipBlock { rows: 1, ..SlipBlock::default() };
    assert_eq!(outcome(pipeline, &nothing).0, SlipStatus::Null, "rows with no channel");
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
    let pipeline = create(&mut memory, &DEFAULTS).unwrap();
    assert!(outcome(pipeline, &empty).2.command_n.is_nan(), "no controller, no command");
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
}

#[test]
fn memory_of_malloc_is_aligned_and_every_status_has_a_sentence() {
    assert!(slip_align() <= 16 && slip_size() <= size_of::<Memory>(), "{}", slip_size());
    // SAFETY: texts of the library.
    let text = |status| unsafe { CStr::from_ptr(slip_error_text(status)) }.to_str().unwrap();
    let all: std::collections::BTreeSet<_> =
        (-1..=SlipStatus::Panicked as i32 + 1).map(text).collect();
    assert_eq!(all.len(), SlipStatus::Panicked as usize + 2, "{all:?}");
    assert_eq!(text(i32::MIN), "no status of this library");
}

#[test]
fn taxels_and_arrivals_reach_the_pipeline() {
    const ROWS: usize = 6000;
    let signal = SlipSignal::Absent as u32;
    let rate_hz = 1000.0;
    let mut memory = Memory::uninit();
    let pipeline = create(&mut memory, &SlipOptions { rate_hz, signal, ..DEFAULTS }).unwrap();
    let config = stylus_config(StylusKind::Absent, Hertz(rate_hz), &HostConfig::default());
    let (mut twin, mut log) = rust(PipelineConfig { grip: None, ..config });
    let mut random = ChaCha8Rng::seed_from_u64(3000);
    // The pattern turns from the first taxels to the last ones after 4 s.
    let taxels: Vec<f32> = (0..4 * ROWS)
        .map(|at| {
            let share = if at < 16_000 { 0.0 } else { (at - 16_000) as f32 / 8000.0 };
            let taxel = (at % 4) as f32;
            10.0 * (3.0 - taxel) * (1.0 - share)
                + 10.0 * taxel * share
                + 1e-3 * (random.next_u32() % 100) as f32
        })
        .collect();
    let arrived_us: Vec<u64> = (0..ROWS as u64).map(|at| 5_000_000 + 1000 * at).collect();
    let (age_us, force_n) = (vec![300; ROWS], vec![2.0; ROWS]);
    let block = SlipBlock {
        rows: ROWS,
        taxels: taxels.as_ptr(),
        taxel_count: 4,
        normal_force_n: force_n.as_ptr(),
        arrived_us: arrived_us.as_ptr(),
        age_us: age_us.as_ptr(),
        ..SlipBlock::default()
    };
    let (events, values, _) = push(pipeline, &block).unwrap();
    let mut events = events.iter();
    for (at, frame) in taxels.chunks(4).enumerate() {
        let sample = Sample {
            normal_force_n: Some(2.0),
            arrival: Some(Arrival { at: Micros(arrived_us[at]), age: Micros(300) }),
            ..Sample::stylus(Micros(1000 * at as u64), 0.0)
        };
        let step = twin.handle_with(&sample, frame);
        for theirs in log.events(&step).iter().flatten() {
            assert_same(events.next().unwrap(), &expected(theirs, at as u64));
        }
        assert_eq!(values[ROWS + at].to_bits(), step.statistic.to_bits());
    }
    assert!(events.next().is_none() && log.slips() > 0, "{} slips", log.slips());
    let too_many = SlipBlock { taxel_count: 257, ..block };
    assert_eq!(push(pipeline, &too_many).unwrap_err(), SlipStatus::Size);
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
}
