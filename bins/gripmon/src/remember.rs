//! Memory of the arrangement of the window: its file, written when the window is closed and when the program is asked to end.

use crate::layout::{Layout, LayoutError};
use signal_hook::iterator::Signals;
use std::io;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// Where the arrangement is remembered, and how it is now.
#[derive(Clone, Debug)]
pub struct Remember {
    path: Option<PathBuf>,
    now: Arc<Mutex<Layout>>,
}

impl Remember {
    /// Remembers in this file; nowhere without one.
    #[must_use]
    pub fn new(path: Option<PathBuf>, layout: Layout) -> Self {
        Self { path, now: Arc::new(Mutex::new(layout)) }
    }

    /// Takes note of how it is now.
    pub fn note(&self, layout: Layout) {
        *self.now.lock().unwrap_or_else(PoisonError::into_inner) = layout;
    }

    /// Writes what was noted last.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write(&self) -> Result<(), LayoutError> {
        let now = self.now.lock().unwrap_or_else(PoisonError::into_inner).clone();
        self.path.as_ref().map_or(Ok(()), |path| now.write(path))
    }

    /// Writes it when one of these signals comes, then calls `end` with what became of it, on a thread of its own: a window that is hidden
    /// or hangs does not keep it from being written.
    ///
    /// # Errors
    /// Where the system refuses signals or threads.
    pub fn on_signals(
        &self,
        signals: &[i32],
        end: impl Fn(i32, Result<(), LayoutError>) + Send + 'static,
    ) -> io::Result<()> {
        let (remember, mut signals) = (self.clone(), Signals::new(signals)?);
        let wait = move || {
            for signal in signals.forever() {
                end(signal, remember.write());
            }
        };
        thread::Builder::new().name("signals".to_owned()).spawn(wait)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Remember;
    use crate::layout::{Layout, Look};
    use signal_hook::consts::SIGUSR1;
    use std::sync::mpsc::channel;

    #[test]
    fn a_signal_writes_what_was_noted_last() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gripmon").join("layout.toml");
        let remember = Remember::new(Some(path.clone()), Layout::default());
        let (reported, received) = channel();
        let end =
            move |signal, written: Result<(), _>| reported.send((signal, written.is_ok())).unwrap();
        remember.on_signals(&[SIGUSR1], end).unwrap();
        remember.note(Layout { theme: Look::Light, seconds: 0.25, ..Layout::default() });
        signal_hook::low_level::raise(SIGUSR1).unwrap();
        assert_eq!(received.recv().unwrap(), (SIGUSR1, true));
        let read = Layout::read(&path).unwrap();
        assert_eq!((read.theme, read.seconds), (Look::Light, 0.25));
    }
}
