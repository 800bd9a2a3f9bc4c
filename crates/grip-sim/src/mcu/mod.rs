//! A gripper's microcontroller around a simulated grasp: bytes to the host, from bytes of the host and the time.
//!
//! The virtual device speaks the real protocol through [`grip_link::device::DeviceLink`], which also enforces limits
//! and failsafe; the force it allows drives the [`Grasp`], whose samples go out in batches. Nothing here reads a
//! clock: [`VirtualMcu::advance`] states what time it is. The same scene, identity and bytes at the same times give
//! the same answer, byte for byte.
//!
//! Opening and torque off both mean no force: the object falls unless its support still stands.

mod fault;
mod identity;
mod peer;
mod row;
mod watch;

pub use fault::{Sensor, SensorFault};
pub use grip_link::device::DeviceConfigError;
pub use peer::peer;
pub use watch::Task;

use crate::grasp::{Grasp, Truth};
use crate::scene::Scene;
use fault::SensorFaults;
use grip_link::device::{DeviceEvent, DeviceLink, Drive, RowError};
use grip_link::frame::MAX_WIRE;
use grip_link::message::{DeviceState, FaultCode, ResetReason};
use identity::{Reading, device_config, readings};
use row::RowFormat;
use slip_core::sample::Sample;
use slip_core::units::Micros;
use watch::SensorWatch;

/// The watchdog restarts the device when a task has not run for this long.
const WATCHDOG: Micros = Micros(100_000);
/// After a restart the device is deaf for this long.
const BOOT_TIME: Micros = Micros(20_000);

/// A simulated gripper with its microcontroller.
#[derive(Clone, Debug)]
pub struct VirtualMcu {
    scene: Scene,
    boot_id: u32,
    grasp: Grasp,
    link: DeviceLink,
    readings: Vec<Reading>,
    row: RowFormat,
    watch: SensorWatch,
    faults: SensorFaults,
    hung: Option<Task>,
    booted_at: Micros,
    fed_at: Micros,
    target_n: f64,
    /// Rows since CONFIG: reports how full the open batch is.
    rows: u32,
    refused_rows: u32,
}

impl VirtualMcu {
    /// The gripper of `scene`, powered on at time zero, idle. `boot_id` should differ from start to start.
    ///
    /// # Errors
    /// [`DeviceConfigError`] where the scene's limits do not make a device, such as a force of over 2 MN.
    pub fn new(scene: &Scene, boot_id: u32) -> Result<Self, DeviceConfigError> {
        let mut link = DeviceLink::new(device_config(scene, boot_id, ResetReason::PowerOn))?;
        link.ready(0);
        Ok(Self {
            scene: scene.clone(),
            boot_id,
            grasp: Grasp::new(scene),
            link,
            readings: readings(scene.config()),
            row: RowFormat::default(),
            watch: SensorWatch::new(scene),
            faults: SensorFaults::new(scene),
            hung: None,
            booted_at: Micros(0),
            fed_at: Micros(0),
            target_n: 0.0,
            rows: 0,
            refused_rows: 0,
        })
    }

    /// Lets the world go on to `now`, sample by sample; a time in the past changes nothing.
    pub fn advance(&mut self, now: Micros) {
        while self.grasp.next_sample_at() <= now {
            self.sample();
        }
        self.serve(now, &[]);
    }

    /// Takes bytes of the host that arrived at `now`, after going on to that time.
    pub fn receive(&mut self, now: Micros, bytes: &[u8]) {
        self.advance(now);
        self.serve(now, bytes);
    }

    /// Writes the next frame that is due into `out` and returns its length. Call it whenever the port can take one; while
    /// it cannot, the device keeps a few batches and drops the oldest.
    pub fn poll_transmit(&mut self, now: Micros, out: &mut [u8; MAX_WIRE]) -> Option<usize> {
        if self.hung == Some(Task::Link) {
            return None;
        }
        self.link.poll_transmit(self.tick(now), out)
    }

    /// Appends all frames that are due to `out`.
    pub fn transmit(&mut self, now: Micros, out: &mut Vec<u8>) {
        let mut frame = [0; MAX_WIRE];
        while let Some(length) = self.poll_transmit(now, &mut frame) {
            out.extend(frame.iter().take(length));
        }
    }

    /// Time of the sample that completes the next batch: nothing but received bytes changes what is sent before.
    #[must_use]
    pub fn next_due(&self) -> Micros {
        let next = self.grasp.next_sample_at();
        let period = next.since(self.grasp.now());
        let more = self.link.in_force().map_or(0, |config| {
            let batch = u32::from(config.batch).max(1);
            batch - 1 - self.rows % batch
        });
        // A batch ends after 1 ms at the latest, and failsafe times run in milliseconds.
        next.plus(Micros(u64::from(more) * period.0).min(Micros(1000).since(period)))
    }

    /// The truth behind the samples.
    #[must_use]
    pub fn truth(&self) -> Truth {
        self.grasp.truth()
    }

    /// Takes the support of a touched object away, whenever the scene would.
    pub fn lift(&mut self) {
        self.grasp.lift();
    }

    /// The simulated grasp.
    #[must_use]
    pub fn grasp(&self) -> &Grasp {
        &self.grasp
    }

    /// The device's end of the link: state, fault, counters.
    #[must_use]
    pub fn link(&self) -> &DeviceLink {
        &self.link
    }

    /// Rows the link refused although it was sampling; stays 0.
    #[must_use]
    pub fn refused_rows(&self) -> u32 {
        self.refused_rows
    }

    /// Force that the device asks of its drive (N); the fingers follow with the lag of the drive.
    #[must_use]
    pub fn commanded_n(&self) -> f64 {
        self.target_n
    }

    /// Rows given to the link since CONFIG, whether they were sent or dropped.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Number of this start.
    #[must_use]
    pub fn boot_id(&self) -> u32 {
        self.boot_id
    }

    fn tick(&self, now: Micros) -> u64 {
        now.since(self.booted_at).0
    }

    fn sample(&mut self) {
        let Self { grasp, link, booted_at, hung, target_n, .. } = self;
        let sample = grasp.step_sample_with(|t| {
            if *hung != Some(Task::Control) {
                *target_n = newtons(link.drive(t.since(*booted_at).0));
            }
            *target_n
        });
        let sample = self.faults.apply(sample);
        let moving = self.grasp.fingers_travel(self.target_n);
        self.link.report_motion(self.tick(sample.t), moving);
        if self.hung != Some(Task::Sampling) {
            self.push(&sample);
            self.judge(&sample);
        }
        self.feed_watchdog(sample.t);
    }

    fn push(&mut self, sample: &Sample) {
        let tick = self.tick(sample.t);
        if let Some(force_n) = sample.normal_force_n {
            self.link.report_force(row::milli(force_n));
        }
        match self.row.push(&mut self.link, tick, sample) {
            Ok(()) => self.rows = self.rows.wrapping_add(1),
            Err(RowError::NotSampling) => {}
            Err(_) => self.refused_rows = self.refused_rows.saturating_add(1),
        }
    }

    /// What the firmware itself notices: no usable slip sensor while sampling, and fingers that meet without an object.
    fn judge(&mut self, sample: &Sample) {
        let fault = self.watch.push(&self.row.shown(sample));
        if let Some(fault) = fault.filter(|_| self.link.in_force().is_some()) {
            self.raise_fault(fault);
        }
        if self.grasp.truth().dropped() && self.target_n > 0.0 {
            self.raise_fault(FaultCode::OBJECT_LOST);
        }
    }

    fn feed_watchdog(&mut self, now: Micros) {
        if self.link.take_alive() {
            self.fed_at = now;
        }
        if now.since(self.fed_at) > WATCHDOG {
            self.restart(now, ResetReason::Watchdog);
        }
    }

    /// The link task: BOOT ends, bytes are read, and what the host wants is done.
    fn serve(&mut self, now: Micros, mut bytes: &[u8]) {
        if self.hung == Some(Task::Link) {
            return;
        }
        let tick = self.tick(now);
        if self.link.state() == DeviceState::Boot && tick >= BOOT_TIME.0 {
            self.link.ready(tick);
        }
        while let Some(event) = self.link.receive(tick, &mut bytes) {
            if let DeviceEvent::Configured(config) = event {
                self.grasp.set_sample_rate(config.sample_rate_hz);
                self.rows = 0;
                self.row = RowFormat::new(&self.readings, &config, self.scene.config());
                self.watch = SensorWatch::new(&self.scene).at_rate(config.sample_rate_hz);
            }
        }
    }
}

/// Trouble on demand.
impl VirtualMcu {
    /// Breaks the stylus, or repairs it with `None`.
    pub fn break_stylus(&mut self, fault: Option<SensorFault>) {
        self.break_sensor(Sensor::Stylus, fault);
    }

    /// Breaks a sensor from the next sample on, or repairs it with `None`. A sensor that the gripper does not have stays absent.
    pub fn break_sensor(&mut self, sensor: Sensor, fault: Option<SensorFault>) {
        self.faults.set(sensor, fault);
    }

    /// Keeps the true readings of the last `memory`: [`SensorFault::Late`] then has its delay from its first sample on; without it
    /// the reading stands still until that much is known.
    pub fn remember_readings(&mut self, memory: Micros) {
        self.faults.remember(memory);
    }

    /// Hangs a task of the firmware until the watchdog restarts it.
    pub fn hang(&mut self, task: Task) {
        self.hung = Some(task);
    }

    /// Latches a fault as the firmware does when it finds one.
    pub fn raise_fault(&mut self, fault: FaultCode) {
        if self.link.fault() != fault {
            self.link.raise_fault(self.tick(self.grasp.now()), fault);
        }
    }

    /// Restarts the device in the middle of whatever it does: torque off, ticks from zero, another `boot_id`.
    pub fn reset(&mut self) {
        self.restart(self.grasp.now(), ResetReason::Pin);
    }

    fn restart(&mut self, now: Micros, reason: ResetReason) {
        self.boot_id = self.boot_id.wrapping_add(1);
        // The same limits were accepted at the first start, so this cannot fail; if it did, the watchdog would
        // call again.
        let Ok(link) = DeviceLink::new(device_config(&self.scene, self.boot_id, reason)) else {
            return;
        };
        self.link = link;
        self.row = RowFormat::default();
        self.hung = None;
        self.booted_at = now;
        self.fed_at = now;
        self.target_n = 0.0;
    }
}

fn newtons(drive: Drive) -> f64 {
    f64::from(drive.force_mn()) * 1e-3
}

#[cfg(test)]
mod tests;
