//! What a source reports, as text: `scope_look SOURCE [SECONDS]` looks at an address, a recording, a study or the demo for so long (5 s unless
//! given) and prints channels, events and notices.
#![expect(clippy::disallowed_methods, clippy::print_stdout, reason = "for people at a terminal")]

use core::time::Duration;
use grip_scope::{Model, SourceHandle, SourceSpec};

fn main() {
    if let Err(error) = look() {
        println!("{error}");
    }
}

fn look() -> Result<(), Box<dyn core::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let spec = SourceSpec::parse(arguments.first().map_or("", String::as_str))?;
    let seconds = arguments.get(1).map_or(Ok(5.0), |text| text.parse())?;
    let mut model = Model::new(200_000_000);
    let mut handle = SourceHandle::spawn(spec, grip_sim::mcu::peer, || {})?;
    let until = std::time::Instant::now() + Duration::try_from_secs_f64(seconds)?;
    let mut status = String::new();
    while std::time::Instant::now() < until {
        handle.drain(&mut model, 1000);
        if model.status().sentence() != status {
            status = model.status().sentence();
            println!("status: {status}");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    if let Some(daemon) = &model.info().daemon {
        println!("daemon: {} at {}, commands {}", daemon.name, daemon.place, daemon.may_command);
    }
    for channel in model.channels() {
        let Some(series) = model.series(channel) else { continue };
        let stats = series.span().and_then(|span| series.stats(span));
        let Some(stats) = stats else { continue };
        println!(
            "{:24} {:8} samples, {:.4e} to {:.4e} {}",
            channel.column(),
            stats.count,
            stats.min,
            stats.max,
            channel.unit()
        );
    }
    model.events().iter().for_each(|mark| println!("{:9.4} s  {}", mark.t_s, mark.text));
    model.notices().for_each(|line| println!("{:?}: {}", line.level, line.text));
    println!(
        "{} spectra, {} bytes, {} items dropped, {} late rows",
        model.spectrogram().len(),
        model.bytes(),
        handle.dropped(),
        model.health().late_rows()
    );
    if let Some(health) = model.health().latest() {
        println!("{health:?}");
    }
    Ok(())
}
