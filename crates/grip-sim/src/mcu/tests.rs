use super::*;
use grip_link::host::{GripCommand, HostConfig, HostEvent, HostLink};
use grip_link::message::{ChannelKind, Config, LossAction, SampleFormat, Status};

const STEP: Micros = Micros(1000);

fn config() -> Config {
    Config {
        sample_rate_hz: 10_000,
        batch: 10,
        format: SampleFormat::I16,
        ttl_ms: 50,
        channel_mask: u32::MAX,
        force_max_mn: 60_000,
        slew_mn_s: 2_000_000,
        hold_cap_mn: 60_000,
        loss_after_ms: 1000,
        loss_action: LossAction::Hold,
    }
}

fn scene() -> Scene {
    Scene::from_toml(
        "name = \"t\"\nmass_kg = 0.4\nfriction = 0.3\nroughness_ra_um = 1.6\nlift_at_s = 0.2\n",
    )
    .unwrap()
}

/// Host and device in lockstep, a millisecond a turn.
struct Bench {
    mcu: VirtualMcu,
    host: HostLink,
    now: Micros,
    rows: Vec<Row>,
    status: Option<Status>,
    wire: Vec<u8>,
}

impl Bench {
    fn new(scene: &Scene, config: Config) -> Self {
        let mut host = HostLink::new(HostConfig::new(config)).unwrap();
        host.open(0, 0xBEEF).unwrap();
        let mcu = VirtualMcu::new(scene, 7).unwrap();
        Self { mcu, host, now: Micros(0), rows: Vec::new(), status: None, wire: Vec::new() }
    }

    fn turn(&mut self, force_n: Option<f32>) {
        self.now = self.now.plus(STEP);
        let mut out = [0; MAX_WIRE];
        let mut to_device = Vec::new();
        if let Some(command) = force_n.and_then(GripCommand::newtons)
            && let Some(length) = self.host.grip(self.now.0, &command, &mut out)
        {
            to_device.extend_from_slice(&out[..length]);
        }
        while let Some(length) = self.host.poll_transmit(self.now.0, &mut out) {
            to_device.extend_from_slice(&out[..length]);
        }
        self.mcu.receive(self.now, &to_device);
        let mut from_device = Vec::new();
        self.mcu.transmit(self.now, &mut from_device);
        self.wire.extend_from_slice(&from_device);
        let mut input = from_device.as_slice();
        while let Some(event) = self.host.receive(self.now.0, &mut input) {
            match event {
                HostEvent::Samples { header, .. } => {
                    let samples = self.host.samples(header).unwrap();
                    self.rows.extend(samples.rows().map(|row| {
                        let force = row.read(ChannelKind::NormalForce).unwrap_or(f32::NAN);
                        (row.tick, row.read(ChannelKind::Stylus).unwrap(), force)
                    }));
                }
                HostEvent::Status(status) => self.status = Some(status),
                _ => {}
            }
        }
    }

    fn run(&mut self, force_n: Option<f32>, turns: u32) {
        (0..turns).for_each(|_| self.turn(force_n));
    }
}

#[test]
fn a_host_connects_streams_and_grips() {
    let mut bench = Bench::new(&scene(), config());
    bench.run(Some(8.0), 600);
    assert!(bench.mcu.truth().lifted() && !bench.mcu.truth().dropped());
    assert!((bench.mcu.truth().applied_n - 8.0).abs() < 0.01, "{:?}", bench.mcu.truth());
    let rows = &bench.rows;
    assert!(rows.len() > 5500, "{}", rows.len());
    assert!(rows.windows(2).all(|w| w[1].0 == w[0].0 + 100));
    assert!((rows.last().unwrap().2 - 8.0).abs() < 0.05);
    assert!((rows.last().unwrap().1 - 200e-6).abs() < 20e-6);
    assert_eq!((bench.host.loss().lost, bench.mcu.refused_rows()), (0, 0));
    assert_eq!(bench.status.unwrap().state, DeviceState::Active);
}

#[test]
fn i16_rows_agree_with_f32_rows() {
    let mut coarse = Bench::new(&scene(), config());
    let mut fine = Bench::new(&scene(), Config { format: SampleFormat::F32, ..config() });
    coarse.run(Some(4.0), 400);
    fine.run(Some(4.0), 400);
    assert_eq!(coarse.rows.len(), fine.rows.len());
    for (c, f) in coarse.rows.iter().zip(&fine.rows) {
        assert_eq!(c.0, f.0);
        assert!((c.1 - f.1).abs() < 0.02e-6 && (c.2 - f.2).abs() < 1.5e-3, "{c:?} {f:?}");
    }
}

#[test]
fn the_same_commands_give_the_same_bytes() {
    let play = |boot_id| {
        let mut bench = Bench::new(&scene(), config());
        bench.mcu = VirtualMcu::new(&scene(), boot_id).unwrap();
        bench.run(Some(2.0), 350);
        bench.run(Some(9.0), 150);
        bench.wire
    };
    let first = play(7);
    assert!(first.len() > 20_000);
    assert!(first == play(7) && first != play(8));
}

#[test]
fn how_often_time_advances_does_not_matter() {
    let mut steady = VirtualMcu::new(&scene(), 1).unwrap();
    let mut jumpy = VirtualMcu::new(&scene(), 1).unwrap();
    (1..=300).for_each(|ms| steady.advance(Micros::from_millis(ms)));
    for time in [77, 150_001, 150_000, 300_000] {
        jumpy.advance(Micros(time));
    }
    assert_eq!(steady.truth(), jumpy.truth());
}

#[test]
fn the_next_due_time_is_the_end_of_a_batch() {
    let mut bench = Bench::new(&scene(), config());
    bench.run(Some(4.0), 300);
    bench.mcu.advance(bench.now.plus(Micros(1234)));
    let due = bench.mcu.next_due();
    let mut out = Vec::new();
    bench.mcu.transmit(bench.now.plus(Micros(1234)), &mut out);
    out.clear();
    bench.mcu.advance(Micros(due.0 - 1));
    bench.mcu.transmit(Micros(due.0 - 1), &mut out);
    assert!(out.len() < 100, "a STATUS at most before {due:?}, {} bytes", out.len());
    bench.mcu.advance(due);
    bench.mcu.transmit(due, &mut out);
    assert!(out.len() >= 80);
}

#[test]
fn another_rate_mask_and_batch_are_followed() {
    let asked = Config { sample_rate_hz: 2000, batch: 2, channel_mask: 1, ..config() };
    let mut bench = Bench::new(&scene(), asked);
    bench.run(Some(4.0), 400);
    assert!(bench.rows.windows(2).all(|w| w[1].0 == w[0].0 + 500));
    assert!(bench.rows.iter().all(|row| row.2.is_nan()) && bench.rows.len() > 600);
    assert_eq!(bench.mcu.refused_rows(), 0);
}

/// Time (us), stylus (m) and force (N) of a row.
type Row = (u64, f32, f32);

/// What the host reads before and from a fault that begins 0.5 s after the start.
fn shown(sensor: Sensor, fault: SensorFault) -> (Vec<Row>, Vec<Row>) {
    let mut bench = Bench::new(&scene(), Config { format: SampleFormat::F32, ..config() });
    bench.mcu.remember_readings(Micros(50_000));
    bench.run(Some(8.0), 500);
    bench.mcu.break_sensor(sensor, Some(fault));
    bench.run(Some(9.0), 200);
    let begun = bench.rows.iter().position(|row| row.0 > 500_000).unwrap();
    let after = bench.rows.split_off(begun);
    (bench.rows, after)
}

#[test]
fn a_broken_sensor_shows_its_fault_and_no_other_sensor_does() {
    let well = shown(Sensor::Stylus, SensorFault::Gain(0));
    assert!(well.1.len() > 1900 && well == shown(Sensor::NormalForce, SensorFault::Gain(0)));
    for sensor in [Sensor::Stylus, Sensor::NormalForce] {
        let stylus = sensor == Sensor::Stylus;
        let of = |row: &Row| if stylus { row.1 } else { row.2 };
        let rows = |fault| {
            let (before, after) = shown(sensor, fault);
            assert_eq!(before, well.0, "{fault:?}");
            let same =
                |(a, b): (&Row, &Row)| a.0 == b.0 && if stylus { a.2 == b.2 } else { a.1 == b.1 };
            assert!(after.iter().zip(&well.1).all(same), "{sensor:?} {fault:?}");
            after.iter().map(of).collect::<Vec<f32>>()
        };
        let right: Vec<f32> = well.1.iter().map(of).collect();
        assert!(rows(SensorFault::Dead).iter().all(|x| x.is_nan()));
        assert!(rows(SensorFault::Infinite).iter().all(|x| *x == f32::INFINITY));
        let last = of(well.0.last().unwrap());
        assert!(rows(SensorFault::Stuck).iter().all(|x| *x == last));
        let gain = rows(SensorFault::Gain(-30));
        assert!(gain.iter().zip(&right).all(|(a, b)| (a / b - 0.7).abs() < 1e-5));
        let all: Vec<f32> = well.0.iter().chain(&well.1).map(of).collect();
        let late = rows(SensorFault::Late(Micros(50_000)));
        assert_eq!(late, all[well.0.len() - 500..][..late.len()], "{sensor:?}");
        let noisy = rows(SensorFault::Noise);
        let apart = noisy.iter().zip(&right).map(|(a, b)| f64::from(a - b).powi(2));
        let rms = (apart.sum::<f64>() / noisy.len() as f64).sqrt();
        let expected = if stylus { 30.0 * 0.1e-6 } else { 30.0 * 5e-3 };
        assert!((rms / expected - 1.0).abs() < 0.05, "{sensor:?}: {rms} of {expected}");
        assert_eq!(noisy, rows(SensorFault::Noise), "the same again");
    }
}

#[test]
fn a_noisy_travel_sensor_keeps_its_resolution_and_an_absent_sensor_stays_absent() {
    let mut faults = SensorFaults::new(&scene());
    let sample = Sample { travel_m: Some(1e-3), ..Sample::stylus(Micros(100), 0.0) };
    faults.set(Sensor::Travel, Some(SensorFault::Noise));
    faults.set(Sensor::TangentialForce, Some(SensorFault::Dead));
    for _ in 0..100 {
        let shown = faults.apply(sample);
        let steps = f64::from(shown.travel_m.unwrap()) / 1e-6;
        assert!((steps - steps.round()).abs() < 1e-3 && shown.tangential_n.is_none());
    }
    faults.set(Sensor::Travel, None);
    assert_eq!(faults.apply(sample), sample);
}
