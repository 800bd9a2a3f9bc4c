//! Models that came over the network in; put in force by the hot thread, in the recording and in the settings, out.

use super::{Pending, Service};
use crate::fleet::{Desk, Wanted};
use grip_daemon::{HotCounters, hot, log::LogLevel};
use grip_session::{SessionError, exit::message};

impl Service {
    fn desk(&mut self) -> Option<&mut Desk> {
        self.servers.fleet.as_mut()?.desk.as_mut()
    }

    /// Sends the next model to the hot thread, as soon as it has answered whatever was sent before.
    pub(super) fn serve_models(&mut self) {
        if !self.pending.is_empty() || self.ends.settings.is_full() {
            return;
        }
        let Some(wanted) = self.desk().and_then(|desk| desk.wanted()) else { return };
        let config = self.settings.config.clone();
        let estimator = wanted.model.estimator.clone();
        self.attach(&Ok(vec![crate::settings::model_file(wanted.model.text.clone().into_bytes())]));
        let settings = hot::Settings { config, estimator, refused: None };
        // There is room: nobody else sends settings.
        let _sent = self.ends.settings.push(Box::new(settings));
        self.pending.push_back(Pending::Model(Box::new(wanted)));
    }

    /// The hot thread has taken a model, or has not.
    pub(super) fn model_swapped(&mut self, wanted: Wanted, refused: Option<&SessionError>) {
        let outcome = match refused {
            None => {
                self.settings.deployed = wanted.deployed.then_some(wanted.model);
                Ok(())
            }
            Some(error) => {
                self.attach(&self.settings.attachments());
                Err(message(error))
            }
        };
        let now_us = self.clock.now_us();
        if let Some(desk) = self.desk() {
            desk.swapped(outcome, now_us);
        }
    }

    /// Other settings are in force; `model` says that the configuration names another model.
    pub(super) fn settings_changed(&mut self, model: bool) {
        if model && self.settings.deployed.is_some() {
            let text = "the model that came over the network stays in force; that of the configuration is what it gives way to";
            self.console.say(LogLevel::Warn, text);
        }
        if self.desk().is_none() {
            return;
        }
        match self.settings.configured_model() {
            Ok(model) => {
                if let Some(desk) = self.desk() {
                    desk.reloaded(model);
                }
            }
            Err(error) => self.console.say(LogLevel::Error, &message(&error)),
        }
    }

    /// What there was to slip, and what slipped.
    pub(super) fn count_for_models(&mut self, counters: &HotCounters) {
        let rate_hz = self.board.state().map_or(0, |state| state.rate_hz);
        let faults = self.board.link().faults.0;
        if let Some(desk) = self.desk() {
            desk.count(counters, rate_hz, faults);
        }
    }
}
