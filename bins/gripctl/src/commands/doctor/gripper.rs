//! Check of the gripper at a port: what it reports of itself, and how well samples and clocks come through in some seconds. Nothing is commanded.

use super::{
    super::attach::Attached,
    finding::{Finding, Verdict},
    rate::Arrivals,
};
use crate::cli::DoctorArgs;
use anyhow::anyhow;
use grip_link::host::HostLink;
use grip_session::{HostConfig, Session, exit::message};

/// Longest wait for the first sample (us): a board that restarts when its port is opened needs some of it.
const PATIENCE_US: u64 = 6_000_000;

/// What is to be listened to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inquiry<'a> {
    pub(crate) name: &'a str,
    pub(crate) args: &'a DoctorArgs,
    pub(crate) config: &'a HostConfig,
    pub(crate) seconds: f64,
}

/// What was received.
#[derive(Debug)]
struct Received {
    session: Session,
    arrivals: Arrivals,
    latency_timer_ms: Option<u16>,
}

/// Attaches as gripd does, but never sends a force.
pub(crate) fn findings(inquiry: &Inquiry<'_>) -> Vec<Finding> {
    match listen(inquiry) {
        Ok(received) => judge(inquiry.config, &received),
        Err(error) => {
            let text = message(error.as_ref());
            let first = if text.contains("busy") {
                "stop the program that holds the port"
            } else {
                "power, cable and --baud of the gripper"
            };
            let remedy = format!("{first}; then: gripctl doctor {} --seconds 10", inquiry.name);
            vec![Finding::fault("gripper", text, remedy)]
        }
    }
}

fn listen(inquiry: &Inquiry<'_>) -> anyhow::Result<Received> {
    let mut gripper = Attached::open(inquiry.name, None, inquiry.args.baud, inquiry.config)?;
    let latency_timer_ms = gripper.line.latency_timer_ms();
    let mut arrivals = Arrivals::default();
    while arrivals.span_s() < inquiry.seconds {
        let mut samples = 0;
        let now_us = gripper.turn(&mut |_| samples += 1)?;
        arrivals.push(now_us, samples);
        if arrivals.rate_hz().is_none() && now_us > PATIENCE_US {
            return Err(anyhow!("no samples came for {} s", PATIENCE_US / 1_000_000));
        }
    }
    Ok(Received { session: gripper.close()?, arrivals, latency_timer_ms })
}

fn judge(config: &HostConfig, received: &Received) -> Vec<Finding> {
    let link = received.session.link();
    let mut findings = vec![identity(link), rate(config, received)];
    findings.push(arrivals(&received.arrivals, link));
    findings.push(checksums(link));
    findings.push(clocks(link));
    if let Some(ms) = received.latency_timer_ms.filter(|ms| *ms > 1) {
        let text = format!("the converter still holds bytes back for {ms} ms");
        let remedy = "install the udev rule of the package, and plug it in again";
        findings.push(Finding::warning("latency timer", text, remedy.to_owned()));
    }
    findings
}

fn identity(link: &HostLink) -> Finding {
    let Some(ident) = link.ident() else {
        let remedy = "restart the gripper".to_owned();
        return Finding::fault("gripper", "it has lost its settings".to_owned(), remedy);
    };
    let uid: String = ident.uid.iter().map(|byte| format!("{byte:02x}")).collect();
    let firmware = ident.firmware;
    let text = format!(
        "firmware {}.{}.{}, uid {uid}, start {}, {} channels, at most {} Hz",
        firmware.major,
        firmware.minor,
        firmware.patch,
        ident.boot_id,
        ident.channel_count,
        ident.limits.rate_max_hz
    );
    if ident.fault.0 == 0 {
        return Finding::ok("gripper", text);
    }
    let text = format!("{text}; it reports fault {:04X}", ident.fault.0);
    let remedy = "find its cause in the gripper's manual, then restart the gripper";
    Finding::fault("gripper", text, remedy.to_owned())
}

fn rate(config: &HostConfig, received: &Received) -> Finding {
    let check = "sample rate";
    let wanted = config.link.sample_rate_hz;
    let given = received.session.link().in_force().map_or(0, |config| config.sample_rate_hz);
    let measured = received.arrivals.rate_hz().unwrap_or(0.0);
    let text = format!(
        "{measured:.0} Hz measured over {:.1} s, {given} Hz in force, {wanted} Hz configured",
        received.arrivals.span_s()
    );
    let near = (measured / f64::from(given.max(1)) - 1.0).abs() < 0.01;
    if !near {
        let remedy = "a faster line (--baud) or a lower [link] sample_rate_hz";
        return Finding::fault(check, text, remedy.to_owned());
    }
    let remedy = format!("[link] sample_rate_hz = {given} in the configuration");
    Finding::judge(given == wanted, check, text, &remedy)
}

fn arrivals(arrivals: &Arrivals, link: &HostLink) -> Finding {
    let loss = link.loss();
    let text = format!(
        "{} samples lost ({} of them dropped by the gripper), longest pause {:.1} ms",
        loss.lost,
        loss.dropped_by_mcu,
        arrivals.longest_ms()
    );
    let remedy =
        "an idle computer, gripd --realtime warn, another cable; with FTDI the latency timer";
    if loss.lost > 0 {
        return Finding::fault("gaps", text, remedy.to_owned());
    }
    Finding::judge(arrivals.longest_ms() < 10.0, "gaps", text, remedy)
}

fn checksums(link: &HostLink) -> Finding {
    let counters = link.counters();
    // The frame in flight when the line was opened is cut.
    let text = format!(
        "{} good frames, {} damaged ({} wrong checksums), {} bytes of garbage",
        counters.ok,
        counters.bad_blocks(),
        counters.crc,
        counters.garbage_bytes
    );
    let remedy =
        "a shorter or shielded cable, the same --baud on both sides, no second program on the port";
    Finding::judge(counters.bad_blocks() <= 1, "frames", text, remedy)
}

fn clocks(link: &HostLink) -> Finding {
    let check = "clock";
    let Some(clock) = link.clock().filter(|clock| clock.uncertainty_us().is_finite()) else {
        let remedy = "listen longer (--seconds 10); then update the gripper's firmware".to_owned();
        return Finding::warning(check, "the gripper has answered no PING".to_owned(), remedy);
    };
    let uncertainty_us = clock.uncertainty_us();
    let drift = clock
        .drift_ppm()
        .map_or_else(|| "not known yet".to_owned(), |ppm| format!("{ppm:+.1} ppm"));
    let text = format!(
        "round trip {:.0} us, offset known to {uncertainty_us:.0} us, drift {drift} from {} answers",
        2.0 * uncertainty_us,
        clock.points()
    );
    let remedy = "with FTDI the latency timer; a socket of the computer itself instead of a hub";
    let mut finding = Finding::judge(uncertainty_us < 5000.0, check, text, remedy);
    // An honest crystal is within 100 ppm; a resonator within 5000.
    if clock.drift_ppm().is_some_and(|ppm| ppm.abs() > 5000.0) && clock.points() >= 8 {
        finding.verdict = Verdict::Warning;
        finding.remedy = Some(
            "the gripper's clock is far off: its firmware may name a wrong tick rate".to_owned(),
        );
    }
    finding
}
