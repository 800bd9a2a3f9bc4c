//! What crosses the border is what the Rust pipeline makes of the same samples; what cannot be is refused, and nothing is allocated.

#![expect(clippy::unwrap_used, reason = "a test")]

use core::{ffi::CStr, mem::MaybeUninit, ptr};
use grip_record::{CsvOptions, StylusKind, read_recording};
use grip_session::{
    HostConfig,
    calibration::Calibration,
    model,
    replay::{pipeline_config, stylus_config},
    report::{Event, EventLog},
};
use grip_sim::{Grasp, Scene};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};
use rand_core::Rng as _;
use slip::*;
use slip_core::{
    Arrival, Pipeline, PipelineConfig, Sample,
    esc::EscSums,
    units::{Hertz, Micros},
};
use std::{env, fs, path::PathBuf};

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
    columns: [Vec<f32>; 10],
}

impl Table {
    fn new(samples: &[Sample]) -> Self {
        let column = |of: fn(&Sample) -> Option<f32>| {
            samples.iter().map(|sample| of(sample).unwrap_or(f32::NAN)).collect()
        };
        let columns = [
            column(|s| Some(s.stylus)),
            column(|s| s.normal_force_n),
            column(|s| s.tangential_n),
            column(|s| s.travel_m),
            column(|s| s.velocity_m_s),
            column(|s| s.second_stylus),
            column(|s| s.reference),
            column(|s| s.pressure),
            column(|s| s.motion),
            column(|s| Some(s.stylus_axes[0])),
        ];
        Self { t_us: samples.iter().map(|sample| sample.t.0).collect(), columns }
    }

    /// Rows from `begin` to `end`.
    fn block(&self, begin: usize, end: usize) -> SlipBlock {
        let [stylus, normal, tangential, travel, velocity, second, reference, pressure, motion, y] =
            self.columns.each_ref().map(|column| column[begin..end].as_ptr());
        SlipBlock {
            rows: end - begin,
            t_us: self.t_us[begin..end].as_ptr(),
            stylus,
            stylus_y: y,
            normal_force_n: normal,
            tangential_n: tangential,
            travel_m: travel,
            velocity_m_s: velocity,
            second_stylus: second,
            reference,
            pressure,
            motion,
            ..EMPTY
        }
    }
}

const EMPTY: SlipBlock = SlipBlock {
    rows: 0,
    t_us: ptr::null(),
    stylus: ptr::null(),
    stylus_y: ptr::null(),
    stylus_z: ptr::null(),
    normal_force_n: ptr::null(),
    tangential_n: ptr::null(),
    travel_m: ptr::null(),
    velocity_m_s: ptr::null(),
    second_stylus: ptr::null(),
    reference: ptr::null(),
    reference_y: ptr::null(),
    reference_z: ptr::null(),
    pressure: ptr::null(),
    motion: ptr::null(),
    taxels: ptr::null(),
    taxel_count: 0,
    arrived_us: ptr::null(),
    age_us: ptr::null(),
};

const NO_STATE: SlipState = SlipState {
    t_us: 0,
    statistic: 0.0,
    command_n: 0.0,
    scene: 0,
    grip: 0,
    sensors: [0; 4],
    floor: 0,
};

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
        found: 0,
        state: NO_STATE,
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

fn rust(config: PipelineConfig) -> (Pipeline<std::sync::Arc<[f32]>>, EventLog) {
    (Pipeline::new(config, Some(model::default_estimator().unwrap())).unwrap(), EventLog::default())
}

/// The same values, to the last digit, of every slip.
fn assert_same(ours: &SlipEvent, event: &Event) {
    let Event::Slip(slip) = event else {
        assert_ne!(ours.kind, SlipEventKind::Slip as u32, "{event:?}");
        return;
    };
    let numbers = [
        (ours.statistic, slip.statistic),
        (ours.confidence, slip.confidence),
        (ours.speed_m_s, slip.speed_m_s),
        (ours.moved_m, slip.moved_m),
        (ours.estimate_n, slip.estimate_n),
        (ours.estimate_sigma_n, slip.estimate_sigma_n),
        (ours.command_n, slip.command_n),
        (ours.certified_s, slip.certified_s),
    ];
    for (ours, theirs) in numbers {
        assert!(ours == theirs.unwrap_or(f32::NAN) || ours.is_nan() && theirs.is_none());
    }
    for (ours, theirs) in
        [(ours.esc_w, slip.esc_w), (ours.esc, slip.esc), (ours.duration_s, slip.duration_s)]
    {
        assert!(ours == theirs.unwrap_or(f64::NAN) || ours.is_nan() && theirs.is_none());
    }
    let codes = [
        slip.phase.code(),
        slip.method.code(),
        slip.ruled_out,
        slip.possible,
        u8::from(slip.first),
    ];
    assert_eq!([ours.phase, ours.method, ours.ruled_out, ours.possible, ours.first], codes);
    assert_eq!((ours.kind, ours.t_us), (SlipEventKind::Slip as u32, slip.t.0));
}

/// Pushes `samples` in blocks of random lengths; gives how many slips there are where all is as in `config`'s pipeline.
fn agree(samples: &[Sample], options: &SlipOptions, config: PipelineConfig, seed: u64) -> usize {
    let mut memory = Memory::uninit();
    let pipeline = create(&mut memory, options).unwrap();
    let (mut twin, mut log) = rust(config);
    let table = Table::new(samples);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut begin, mut slips) = (0, 0);
    while begin < samples.len() {
        let end = (begin + 1 + random.next_u32() as usize % 500).min(samples.len());
        let (events, values, state) = push(pipeline, &table.block(begin, end)).unwrap();
        let mut events = events.iter();
        for (at, sample) in samples[begin..end].iter().enumerate() {
            let step = twin.handle(sample);
            for theirs in log.events(&step).iter().flatten() {
                let ours = events.next().unwrap();
                assert_eq!(ours.row, at as u64);
                assert_same(ours, theirs);
                slips += usize::from(matches!(theirs, Event::Slip(slip) if slip.first));
            }
            let command = step.command.map_or(f32::NAN, |command| command.0);
            assert!(values[at] == command || values[at].is_nan() && command.is_nan());
            assert_eq!(values[end - begin + at].to_bits(), step.statistic.to_bits());
            assert_eq!(state.t_us, samples[end - 1].t.0);
        }
        assert!(events.next().is_none());
        begin = end;
    }
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
    slips
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
        let slips = agree(&samples, &DEFAULTS, PipelineConfig { grip: None, ..config }, 1);
        let commanded = agree(&samples, &SlipOptions { control: 1, ..DEFAULTS }, config, 2);
        assert!(slips > 0 && commanded > 0, "{name}: {slips}, {commanded}");
        let text = include_str!("../../grip-session/tests/config/good/beside/cal.toml");
        let config =
            Calibration::parse(text).unwrap().apply(PipelineConfig { grip: None, ..config });
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
    let (mut read, mut slips) = (0, 0);
    for file in files.map(|entry| entry.unwrap().path()) {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        if !name.starts_with('m') || name.contains("electrodes") || name.contains("pose") {
            continue;
        }
        let recording = read_recording(&file, &CsvOptions::default()).unwrap();
        let config = pipeline_config(&recording, &HostConfig::default(), true);
        let signal = SlipSignal::Vibration as u32;
        let options = SlipOptions { rate_hz: recording.rate_hz, signal, ..DEFAULTS };
        slips += agree(&recording.samples, &options, config, read);
        read += 1;
    }
    println!("{read} recordings, {slips} slips");
    assert!(read >= 50 && slips >= 50, "{read} recordings, {slips} slips");
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
            statistic: ptr::null_mut(),
            command_n: &raw mut command_n,
            found: 0,
            state: NO_STATE,
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
        ..EMPTY
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
    let (events, values) = (ptr::null_mut(), ptr::null_mut());
    let mut result = SlipResult {
        events,
        room: 0,
        statistic: values,
        command_n: values,
        found: 99,
        state: NO_STATE,
    };
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
        let (status, _, state) =
            outcome(pipeline, &SlipBlock { rows, t_us, stylus: stylus.as_ptr(), ..EMPTY });
        (status, state.t_us)
    };
    let untimed = || {
        let (status, _, state) =
            outcome(pipeline, &SlipBlock { rows: 1, stylus: [1e-9].as_ptr(), ..EMPTY });
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
    let (status, found, state) = outcome(pipeline, &EMPTY);
    assert_eq!((status, found, state.command_n, state.grip), (SlipStatus::Ok, 0, 0.0, 1), "open");
    let (stylus, force) = ([0.0; 2000], [2.0; 2000]);
    let (stylus, normal_force_n) = (stylus.as_ptr(), force.as_ptr());
    let block = SlipBlock { rows: 2000, stylus, normal_force_n, ..EMPTY };
    let last = outcome(pipeline, &block).2;
    assert!(last.command_n > 0.0 && last.t_us == 199_900, "{last:?}");
    let refused = SlipBlock { taxel_count: 257, ..block };
    let no_stylus = SlipBlock { stylus: ptr::null(), ..block };
    for (block, expected) in [
        (ptr::from_ref(&EMPTY), SlipStatus::Ok),
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
    let nothing = SlipBlock { rows: 1, ..EMPTY };
    assert_eq!(outcome(pipeline, &nothing).0, SlipStatus::Null, "rows with no channel");
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
    let pipeline = create(&mut memory, &DEFAULTS).unwrap();
    assert!(outcome(pipeline, &EMPTY).2.command_n.is_nan(), "no controller, no command");
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
        ..EMPTY
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
            assert_same(events.next().unwrap(), theirs);
        }
        assert_eq!(values[ROWS + at].to_bits(), step.statistic.to_bits());
    }
    assert!(events.next().is_none() && log.slips() > 0, "{} slips", log.slips());
    let too_many = SlipBlock { taxel_count: 257, ..block };
    assert_eq!(push(pipeline, &too_many).unwrap_err(), SlipStatus::Size);
    // SAFETY: made by `create`.
    assert_eq!(unsafe { slip_destroy(pipeline) }, SlipStatus::Ok);
}
