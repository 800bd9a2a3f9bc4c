//! Server of recordings: answers to questions for them, one piece at a time, so that nothing else waits for a disk or a file.

use grip_fleet::{
    net::{NetError, Question},
    recordings::{Reading, Shelf},
};
use grip_session::{HostConfig, exit::message};
use std::collections::VecDeque;

/// Answers that are under way at once; who asks for more has to ask again.
const MOST_READINGS: usize = 8;

/// The recordings of gripd, or why there are none. They need not be given away to be replayed here.
pub(super) fn own_recordings(config: &HostConfig) -> Result<Shelf, String> {
    let Some(template) = &config.record else {
        return Err("nothing is recorded here; record = \"...\" does that".to_owned());
    };
    Shelf::new(template).map_err(|error| error.to_string())
}

/// The recordings of gripd, as far as the configuration gives them away.
#[derive(Debug)]
pub(super) struct Lending {
    /// Or why there are none.
    shelf: Result<Shelf, String>,
    open: VecDeque<(Question, Reading)>,
}

impl Lending {
    pub(super) fn new(config: &HostConfig) -> Self {
        let shelf = if !config.fleet.recordings {
            Err("recordings are not given away here; fleet.recordings = true does that".to_owned())
        } else {
            own_recordings(config)
        };
        Self { shelf, open: VecDeque::new() }
    }

    /// What the person who allowed it should know: why there are none all the same.
    pub(super) fn trouble(&self, config: &HostConfig) -> Option<&str> {
        self.shelf.as_ref().err().filter(|_| config.fleet.recordings).map(String::as_str)
    }

    /// Answers at once, or begins to.
    pub(super) fn take(&mut self, question: Question) -> Result<(), NetError> {
        let shelf = match &self.shelf {
            Ok(shelf) => shelf,
            Err(reason) => return question.refuse(reason),
        };
        if question.parameter("name").is_none() {
            return match shelf.reported() {
                Ok(parts) => parts.iter().try_for_each(|part| question.reply(part)),
                Err(error) => question.refuse(&format!("the recordings cannot be read: {error}")),
            };
        }
        if self.open.len() >= MOST_READINGS {
            return question.refuse("too many ask for recordings; ask again");
        }
        match shelf.read(&|name| question.parameter(name)) {
            Ok(reading) => self.open.push_back((question, reading)),
            Err(error) => return question.refuse(&message(&error)),
        }
        Ok(())
    }

    /// Whether there is a next piece.
    pub(super) fn is_answering(&self) -> bool {
        !self.open.is_empty()
    }

    /// Sends one piece of one answer. Dropped, a question is answered.
    pub(super) fn go_on(&mut self) -> Result<(), NetError> {
        let Some((question, mut reading)) = self.open.pop_front() else { return Ok(()) };
        match reading.next_piece() {
            Ok(Some(piece)) => {
                question.reply(&piece)?;
                self.open.push_back((question, reading));
                Ok(())
            }
            Ok(None) => Ok(()),
            Err(error) => question.refuse(&format!("the recording cannot be read: {error}")),
        }
    }
}
