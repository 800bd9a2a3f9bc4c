//! A source, a model, and patience: what the tests of sources share.

use core::time::Duration;
use grip_record::mcap::{McapIndex, McapWriter, Record, SampleRecord};
use grip_scope::source::load;
use grip_scope::{Channel, Feed, Model, SourceHandle, SourceSpec};
use grip_sim::mcu::peer;
use slip_core::{PipelineState, Sample, units::Micros};
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};

/// Looks at the model after which a test has hung.
const PATIENCE: u32 = 60_000;

pub(crate) struct Watch {
    pub(crate) handle: SourceHandle,
    pub(crate) model: Model,
    feeds: Receiver<Feed>,
}

impl Watch {
    pub(crate) fn new(spec: SourceSpec) -> Self {
        let (sender, feeds) = channel();
        // Behind the end of a test nobody receives.
        let take = move |feed| sender.send(feed).unwrap_or_default();
        let handle = SourceHandle::spawn(spec, peer, take, || {}).unwrap();
        Self { handle, model: Model::new(64 << 20), feeds }
    }

    pub(crate) fn look(&mut self) {
        self.feeds.try_iter().for_each(|feed| self.model.take(feed));
    }

    /// Looks until what is waited for is there; `meanwhile` goes on beside.
    pub(crate) fn until(&mut self, mut meanwhile: impl FnMut(), done: impl Fn(&Model) -> bool) {
        for _ in 0..PATIENCE {
            self.look();
            if done(&self.model) {
                return;
            }
            meanwhile();
            pause();
        }
        panic!("it never came: {:?} {:?}", self.model.status(), self.model.channels().count());
    }
}

/// Finite samples of a channel.
pub(crate) fn samples(model: &Model, channel: Channel) -> u64 {
    let series = model.series(channel);
    series.and_then(|series| series.stats(series.span()?)).map_or(0, |stats| stats.count)
}

/// The model of a file, read in this thread.
pub(crate) fn loaded(path: &Path) -> Model {
    load(path, Model::new(64 << 20))
}

#[expect(clippy::disallowed_methods, reason = "a test may wait for another thread")]
pub(crate) fn pause() {
    std::thread::sleep(Duration::from_millis(1));
}

/// A recording of 10,000 samples with two damaged chunks, where its chunks begin, and its bytes.
pub(crate) fn damaged(path: &Path) -> (Vec<u64>, Vec<u8>) {
    recording(path, 10_000);
    let chunks = McapIndex::read(File::open(path).unwrap()).unwrap().unwrap().chunks;
    let mut bytes = fs::read(path).unwrap();
    let at = |place: u64| usize::try_from(place).unwrap();
    // Samples of one chunk, and the length of another one: there only the index shows where the next one begins.
    bytes[at(chunks[20].offset + chunks[20].len) - 40] ^= 0x55;
    bytes[at(chunks[60].offset) + 8] = 0x7f;
    fs::write(path, &bytes).unwrap();
    (chunks.iter().map(|chunk| chunk.offset).collect(), bytes)
}

/// A recording of samples a millisecond apart, the stylus counting up; a chunk and a state with the needed force each hundred.
pub(crate) fn recording(path: &Path, count: u32) {
    let out = BufWriter::new(File::create(path).unwrap());
    let mut writer = McapWriter::new(out, "test", 0).unwrap();
    for index in 0..count {
        let t = u64::from(index) * 1000;
        let value = f32::from(u16::try_from(index % 1000).unwrap());
        let normal_force_n = Some(2.0);
        let sample = Sample { normal_force_n, ..Sample::stylus(Micros(t), 1e-9 * value) };
        writer.write(t, &Record::Sample(SampleRecord { index, sample, taxels: &[] })).unwrap();
        if index % 100 == 99 {
            let state = PipelineState {
                t: Micros(t),
                need_low_n: Some(1.5),
                need_n: Some(1.75),
                need_high_n: Some(2.5),
                ..PipelineState::UNKNOWN
            };
            writer.write(t, &Record::State(state)).unwrap();
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
}
