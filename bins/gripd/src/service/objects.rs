//! Memory of objects, by the names that clients give and what grasps show: what the next grasp begins with, and a file that people read.

use super::Service;
use core::fmt::Write as _;
use grip_daemon::{Item, clients::Naming, log::LogLevel};
use grip_link::message::NackReason;
use grip_session::{
    config::MemoryConfig,
    exit::message,
    memory::{Memory, MemoryError, Remembered},
};
use slip_core::{ClientCommand, grip::GripState};
use std::path::PathBuf;

/// The memory of gripd, where it was asked for one.
#[derive(Debug)]
pub(super) struct Objects {
    memory: Memory,
    file: PathBuf,
    /// Whether the hot thread has to know what the next grasp begins with.
    due: bool,
    /// Whether the file could not be written last time.
    failed: bool,
}

impl Objects {
    /// What the file has, with the object of the configuration in hand next; `None` where nothing is to be remembered.
    ///
    /// # Errors
    /// Where the file cannot be read, or the name of the object is none.
    pub(super) fn open(config: &MemoryConfig) -> Result<Option<Self>, MemoryError> {
        let Some(file) = config.file.clone() else {
            return if config.object.is_some() { Err(MemoryError::NoFile) } else { Ok(None) };
        };
        let mut memory = Memory::read(&file)?;
        memory.select(config.object.as_deref().unwrap_or_default())?;
        Ok(Some(Self { memory, file, due: true, failed: false }))
    }

    /// Takes what happened; gives what it has shown of the object.
    pub(super) fn take(&mut self, item: &Item<'_>) -> Option<Remembered> {
        match item {
            // Another pipeline knows nothing of the next object.
            Item::Began { .. } => self.due = true,
            Item::State(state) => match state.grip {
                GripState::Holding | GripState::Slipping | GripState::Fault | GripState::Lost => {
                    self.memory.watch(state.command_n);
                }
                _ => self.memory.begin(),
            },
            Item::Event { event, .. } => {
                let remembered = self.memory.take(event);
                self.due |= remembered.is_some();
                return remembered;
            }
            _ => {}
        }
        None
    }

    /// What is known of the object in hand or next, for people, and how many grasps have shown it.
    fn known(&self) -> (String, u32) {
        let name = match self.memory.name() {
            "" => "an object without a name",
            name => name,
        };
        let mut text = format!("{name}: ");
        let Some(object) = self.memory.objects().get(self.memory.name()) else {
            return (text + "nothing is known of it", 0);
        };
        let needed = object.needed_n;
        let _infallible = write!(
            text,
            "needs {:.2} N (+-{:.0} %), is grasped with {:.2} N",
            needed.value,
            100.0 * needed.uncertainty(),
            object.expected_n()
        );
        (text, needed.grasps)
    }
}

impl Service {
    /// What the last items have shown of the object in hand: for people and in the file.
    pub(super) fn remember(&mut self, remembered: &[Remembered]) {
        for remembered in remembered {
            let odd = matches!(remembered, Remembered::Contradicted { .. });
            let level = if odd { LogLevel::Warn } else { LogLevel::Info };
            self.console.log(level, &remembered.to_string());
        }
        let Some(objects) = self.objects.as_mut().filter(|_| !remembered.is_empty()) else {
            return;
        };
        let written = objects.memory.write(&objects.file);
        let failed = core::mem::replace(&mut objects.failed, written.is_err());
        if let Err(error) = written
            && !failed
        {
            self.console.log(LogLevel::Error, &message(&error));
        }
    }

    /// Takes the name that a client gives, and hands the hot thread what the next grasp begins with.
    pub(super) fn serve_objects(&mut self) {
        if let Some(naming) = self.servers.clients.as_mut().and_then(|clients| clients.next_name())
        {
            self.name_object(&naming);
        }
        let Some(objects) = self.objects.as_mut().filter(|objects| objects.due) else { return };
        let expected_n = objects.memory.expected_n();
        if self.ends.commands.push(ClientCommand::Expect(expected_n)).is_err() {
            // Without room it is still due.
            return;
        }
        objects.due = false;
        let (text, grasps) = objects.known();
        let now_us = self.clock.now_us();
        if let Some(clients) = &mut self.servers.clients {
            clients.object(now_us, &text, grasps);
        }
        self.board.object = Some(text);
    }

    fn name_object(&mut self, naming: &Naming) {
        let outcome = match &mut self.objects {
            None => Err(NackReason::WrongState),
            Some(objects) => match objects.memory.select(&naming.name) {
                Ok(_) => {
                    objects.due = true;
                    Ok(())
                }
                Err(_) => Err(NackReason::Malformed),
            },
        };
        if let Some(clients) = &mut self.servers.clients {
            clients.named(naming, outcome);
        }
    }
}
