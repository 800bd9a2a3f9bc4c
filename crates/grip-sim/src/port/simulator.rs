//! The built-in gripper: a virtual microcontroller on a thread of its own, behind a real pseudo-terminal.

use super::run;
use crate::{
    Pty, Scene, SceneError, Truth, VirtualMcu,
    mcu::DeviceConfigError,
    pty::PtyError,
    scene::{self, SceneFileError},
};
use core::{
    error::Error,
    sync::atomic::{AtomicBool, Ordering},
};
use std::{
    io,
    sync::Arc,
    thread::{self, JoinHandle},
};

/// Why the built-in gripper does not run.
#[derive(Debug, thiserror::Error)]
pub enum SimulatorError {
    /// The scene after `sim:` cannot be used.
    #[error("--port {port}: {source}")]
    Scene {
        /// The port as it was named.
        port: String,
        /// What is wrong with the scene.
        source: Box<SceneFileError>,
    },
    /// The scene cannot be drawn with that seed.
    #[error("{0}")]
    Seed(#[source] SceneError),
    /// The scene makes no gripper.
    #[error("the scene makes no gripper: {0}")]
    Device(#[source] DeviceConfigError),
    /// No pseudo-terminal for the simulator.
    #[error("cannot open a pseudo-terminal: {0}")]
    Pty(#[source] PtyError),
    /// The simulator's end of the line failed.
    #[error("the simulator's line failed: {0}")]
    Line(#[source] PtyError),
    /// The thread of the simulator failed, or could not be started.
    #[error("the simulator thread failed{}", .0.as_ref().map(|e| format!(": {e}")).unwrap_or_default())]
    Thread(#[source] Option<io::Error>),
}

/// Whether an error is one of a scene, which is the caller's to correct.
#[must_use]
pub fn is_scene_error(error: &(dyn Error + 'static)) -> bool {
    error.is::<SceneFileError>() || error.is::<Box<SceneFileError>>() || error.is::<SceneError>()
}

/// The running simulator.
#[derive(Debug)]
pub struct Simulator {
    port: String,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Result<Truth, SimulatorError>>,
}

impl Simulator {
    /// Starts the gripper that a port of the name `sim` or `sim:SCENE` means; `None` where the name is that of another port. `seed`
    /// stands for that of the scene, `clock` gives microseconds and never goes back.
    ///
    /// # Errors
    /// Where there is no such scene, or what it needs cannot be had.
    pub fn at(
        port: &str,
        seed: Option<u64>,
        clock: impl FnMut() -> u64 + Send + 'static,
    ) -> Result<Option<Self>, SimulatorError> {
        let name = match port.strip_prefix("sim:") {
            Some(name) => name,
            None if port == "sim" => "default",
            None => return Ok(None),
        };
        let scene = scene::open(name).map_err(|source| SimulatorError::Scene {
            port: port.to_owned(),
            source: Box::new(source),
        })?;
        let scene = match seed {
            Some(seed) => scene.reseeded(seed).map_err(SimulatorError::Seed)?,
            None => scene,
        };
        Self::start(&scene, clock).map(Some)
    }

    fn start(
        scene: &Scene,
        clock: impl FnMut() -> u64 + Send + 'static,
    ) -> Result<Self, SimulatorError> {
        let mut mcu = VirtualMcu::new(scene, 1).map_err(SimulatorError::Device)?;
        let pty = Pty::open(None).map_err(SimulatorError::Pty)?;
        let port = pty.port().display().to_string();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let run = move || {
            run(&mut mcu, &pty, &stopped, clock).map_err(SimulatorError::Line)?;
            Ok(mcu.truth())
        };
        let thread = thread::Builder::new()
            .name("simulator".to_owned())
            .spawn(run)
            .map_err(|error| SimulatorError::Thread(Some(error)))?;
        Ok(Self { port, stop, thread })
    }

    /// The serial device at which it answers.
    #[must_use]
    pub fn port(&self) -> &str {
        &self.port
    }

    /// Ends it and asks what became of the object.
    ///
    /// # Errors
    /// Where its thread failed.
    pub fn stop(self) -> Result<Truth, SimulatorError> {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().map_err(|_| SimulatorError::Thread(None))?
    }
}

#[cfg(test)]
mod tests {
    use super::{Simulator, is_scene_error};

    #[test]
    fn an_unknown_scene_is_the_callers_mistake_and_named_once() {
        let error = Simulator::at("sim:nope", None, || 0).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with("--port sim:nope: "), "{text}");
        assert_eq!(text.matches("built in are").count(), 1, "{text}");
        assert!(is_scene_error(core::error::Error::source(&error).unwrap()));
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn other_ports_are_no_simulator_and_the_simulator_ends() {
        assert!(Simulator::at("/dev/ttyACM0", None, || 0).unwrap().is_none());
        assert!(Simulator::at("simple", None, || 0).unwrap().is_none());
        let mut now = 0;
        let clock = move || {
            now += 100;
            now
        };
        let simulator = Simulator::at("sim", Some(7), clock).unwrap().unwrap();
        assert!(simulator.port().starts_with("/dev/"), "{}", simulator.port());
        assert!(!simulator.stop().unwrap().lifted());
    }
}
