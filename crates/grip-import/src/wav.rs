//! A WAV file in: one signal a channel, as share of full scale.

use crate::{
    error::ImportError,
    stream::{Room, Stream, Times},
};
use grip_record::files;
use hound::{SampleFormat, WavReader};
use std::{io::BufReader, path::Path};

pub(crate) fn read(file: &Path) -> Result<Vec<Stream>, ImportError> {
    let unusable = |error: hound::Error| match error {
        hound::Error::IoError(source) => ImportError::Unreadable { file: file.to_owned(), source },
        other => ImportError::nothing(file, &format!("is no WAV file that can be read: {other}")),
    };
    let input = files::open(file).map_err(ImportError::unreadable(file))?;
    let reader = WavReader::new(BufReader::new(input)).map_err(unusable)?;
    let spec = reader.spec();
    let channels = usize::from(spec.channels).max(1);
    let names = (1..=channels).map(|k| format!("channel_{k}")).collect();
    let mut stream = Stream::new("", names);
    stream.units = vec![Some("share of full scale"); channels];
    stream.times = Times::Rate(f64::from(spec.sample_rate));
    let kind = if spec.sample_format == SampleFormat::Float { "floats" } else { "integers" };
    stream.clock =
        format!("the header: {} Hz, {kind} of {} bits", spec.sample_rate, spec.bits_per_sample);
    let mut room = Room::default();
    let mut put = |at: usize, value: f32| {
        room.take(file, 1)?;
        if let Some(values) = stream.values.get_mut(at % channels) {
            values.push(value);
        }
        Ok::<(), ImportError>(())
    };
    match spec.sample_format {
        SampleFormat::Float => {
            for (at, value) in reader.into_samples::<f32>().enumerate() {
                put(at, value.map_err(unusable)?)?;
            }
        }
        SampleFormat::Int => {
            let scale = 1.0 / 2.0_f32.powi(i32::from(spec.bits_per_sample.clamp(1, 32)) - 1);
            for (at, value) in reader.into_samples::<i32>().enumerate() {
                #[expect(clippy::cast_precision_loss, reason = "24 bits are kept")]
                let value = value.map_err(unusable)? as f32;
                put(at, value * scale)?;
            }
        }
    }
    Ok(vec![stream.without_names()])
}
