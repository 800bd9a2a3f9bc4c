//! Models that clients bring: put in force by the hot thread, in the recording and in the settings, or as a shadow here.

use super::{Pending, Service};
use crate::settings::{Loaded, model_file};
use core::sync::atomic::Ordering;
use grip_daemon::{clients::Loading, hot, log::LogLevel};
use grip_link::message::NackReason;
use grip_session::{SessionError, exit::message};

impl Service {
    /// Sends the next model to the hot thread, as soon as it has answered whatever was sent before.
    pub(super) fn serve_models(&mut self) {
        if !self.pending.is_empty() || self.ends.settings.is_full() {
            return;
        }
        let clients = self.servers.clients.as_mut();
        let Some(mut load) = clients.and_then(|clients| clients.next_load()) else { return };
        let taken =
            if load.is_shadow() { self.cast_shadow(&mut load) } else { self.send_model(&mut load) };
        if let Err(reason) = taken {
            self.refuse_model(&load, NackReason::Malformed, &reason);
        }
    }

    fn send_model(&mut self, load: &mut Loading) -> Result<(), String> {
        if load.model.is_none() && self.settings.loaded.is_none() {
            // It is in force: a swap would make the detector learn anew.
            if let Some(clients) = &mut self.servers.clients {
                clients.loaded(load, Ok(false));
            }
            return Ok(());
        }
        let model = self.read_model(load)?;
        let estimator = self.settings.estimator_with(model.as_ref());
        let text = self.settings.model_text(model.as_ref());
        self.attach(&Ok(vec![model_file(text)]));
        let config = self.settings.live();
        let settings = hot::Settings { config, estimator, refused: None };
        // There is room: nobody else sends settings.
        let _sent = self.ends.settings.push(Box::new(settings));
        self.pending.push_back(Pending::Model(Box::new((load.clone(), model))));
        Ok(())
    }

    /// The model that a client has brought, where it has brought one: signed where that is wanted.
    fn read_model(&self, load: &mut Loading) -> Result<Option<Loaded>, String> {
        let keys = self.settings.keys()?;
        load.model.take().map(|model| Loaded::new(model, &keys, &self.accepted)).transpose()
    }

    /// A model that is asked about slips from now on, in this thread; or none any more.
    fn cast_shadow(&mut self, load: &mut Loading) -> Result<(), String> {
        let model = self.read_model(load)?;
        let text = match &model {
            Some(model) => {
                let (name, signer) = (model.name(), model.signer());
                format!("model {name} estimates beside the one in force{signer}")
            }
            None => "no model estimates beside the one in force any more".to_owned(),
        };
        if model.is_some() || self.shadow.is_some() {
            self.console.log(LogLevel::Info, &text);
        }
        self.shadow = model.map(Loaded::into_estimator);
        let is_there = self.shadow.is_some();
        self.ends.shared.wants_evidence.store(is_there, Ordering::Relaxed);
        if let Some(clients) = &mut self.servers.clients {
            clients.loaded(load, Ok(is_there));
        }
        Ok(())
    }

    /// The hot thread has taken a model, or has not.
    pub(super) fn model_swapped(
        &mut self,
        load: &Loading,
        model: Option<Loaded>,
        refused: Option<&SessionError>,
    ) {
        if let Some(error) = refused {
            self.attach(&self.settings.attachments());
            return self.refuse_model(load, NackReason::WrongState, &message(error));
        }
        self.settings.loaded = model;
        let loaded = self.settings.loaded.as_ref();
        let signer = loaded.map_or_else(String::new, Loaded::signer);
        let kept = loaded.map_or(Ok(()), |loaded| self.accepted.note(loaded.sha256()));
        let text = format!("model {} is in force{signer}", self.settings.model_name());
        self.console.log(LogLevel::Info, &text);
        if let Err(error) = kept {
            let text =
                format!("that this model was in force is not kept for the next start: {error}");
            self.console.log(LogLevel::Warn, &text);
        }
        self.report_setup();
        if let Some(clients) = &mut self.servers.clients {
            clients.loaded(load, Ok(self.settings.loaded.is_some()));
        }
    }

    fn refuse_model(&mut self, load: &Loading, reason: NackReason, text: &str) {
        let what = if load.is_shadow() { "taken as a shadow" } else { "put in force" };
        let text = format!("the model that a client asked for is not {what}: {text}");
        self.console.log(LogLevel::Warn, &text);
        if let Some(clients) = &mut self.servers.clients {
            clients.loaded(load, Err(reason));
        }
    }

    /// Other settings are in force; `model` states that the configuration names another model.
    pub(super) fn settings_changed(&mut self, model: bool) {
        if model && self.settings.loaded.is_some() {
            let text = "the model that a client brought stays in force; that of the configuration is what it gives way to";
            self.console.log(LogLevel::Warn, text);
        }
        self.report_setup();
    }

    fn report_setup(&mut self) {
        let setup = self.settings.setup(self.board.about.reloads.0);
        if let Some(clients) = &mut self.servers.clients {
            clients.set_setup(setup);
        }
    }
}
