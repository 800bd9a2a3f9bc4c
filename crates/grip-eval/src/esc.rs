//! Output lines of every reading of E_sc, from irregularities. Names and units of the JSON fields are a contract.

use serde::Serialize;
use slip_core::esc::{Esc, EscSums, Flag, Reading, Trial, literal::PreciseSum};

/// One reading of E_sc, as it is printed. JSON shows what is not finite as `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EscLine {
    /// Name of the reading.
    pub reading: &'static str,
    /// Its value; `None` without a usable irregularity, or where it is not finite.
    pub value: Option<f64>,
    /// The exact value is not below this.
    pub lo: Option<f64>,
    /// The exact value is not above this.
    pub hi: Option<f64>,
    /// `W` or `J`.
    pub unit: &'static str,
    /// Irregularities that entered.
    pub n: u32,
    /// Irregularities left out.
    pub degenerate: u32,
    /// Relative condition number with respect to the sum of the reading.
    pub condition: Option<f64>,
    /// Deviation of that sum caused by the sensor noise.
    pub sigma_s: Option<f64>,
    /// What is wrong with the value.
    pub flags: Vec<&'static str>,
}

/// Every reading for `irregularities` (height and spacing in m) in the order of [`Reading::ALL`], the literal one in
/// double-double arithmetic.
pub fn readings(
    irregularities: impl IntoIterator<Item = (f64, f64)>,
    trial: &Trial,
) -> Vec<EscLine> {
    let (mut literal, mut sums) = (PreciseSum::default(), EscSums::default());
    let (mut taken, mut degenerate) = (0_u32, 0_u32);
    for (delta_m, spacing_m) in irregularities {
        literal.push(delta_m, spacing_m);
        let counted = if sums.push(delta_m, spacing_m) { &mut taken } else { &mut degenerate };
        *counted = counted.saturating_add(1);
    }
    let value = |reading| match reading {
        Reading::Literal => literal.value(trial),
        other => sums.value(other, trial),
    };
    let line = |reading: Reading| match value(reading) {
        Some(esc) => known(&esc),
        None => unknown(reading, taken, degenerate),
    };
    Reading::ALL.into_iter().map(line).collect()
}

fn known(esc: &Esc) -> EscLine {
    EscLine {
        reading: esc.reading.name(),
        value: Some(esc.value),
        lo: Some(esc.lo),
        hi: Some(esc.hi),
        unit: esc.reading.unit(),
        n: esc.n,
        degenerate: esc.degenerate,
        condition: Some(esc.condition),
        sigma_s: Some(esc.sigma_s),
        flags: esc.flags.iter().map(Flag::name).collect(),
    }
}

fn unknown(reading: Reading, n: u32, degenerate: u32) -> EscLine {
    EscLine {
        reading: reading.name(),
        value: None,
        lo: None,
        hi: None,
        unit: reading.unit(),
        n,
        degenerate,
        condition: None,
        sigma_s: None,
        flags: if degenerate > 0 { vec![Flag::Degenerate.name()] } else { Vec::new() },
    }
}

#[cfg(test)]
mod tests {
    use super::readings;
    use slip_core::esc::Trial;

    #[test]
    fn every_reading_has_its_value_by_the_plain_formula() {
        let (force, speed) = (2.0, 0.05);
        let list = [(20e-6, 100e-6), (30e-6, 50e-6), (5e-6, 80e-6)];
        let sum = |f: fn(f64, f64) -> f64| list.iter().map(|&(d, s)| f(d, s)).sum::<f64>();
        let lines = readings(list, &Trial::new(force, speed).with_noise(0.01));
        let expected = [
            ("literal", "W", 3.0 * force * speed * sum(|d, s| 1.0 / (d / s).tan()).tan()),
            ("arc_cot", "W", 3.0 * force * speed * sum(|d, s| (s / d).atan()).tan()),
            ("slope_power", "W", force * speed * sum(|d, s| 2.0 * d / s)),
            ("lift_work", "J", force * sum(|d, _| d)),
        ];
        for (line, (name, unit, value)) in lines.iter().zip(expected) {
            let got = line.value.unwrap();
            assert_eq!((line.reading, line.unit, line.n), (name, unit, 3));
            assert!((got / value - 1.0).abs() < 1e-11, "{name}: {got} {value}");
            assert!(line.lo.unwrap() <= got && got <= line.hi.unwrap(), "{line:?}");
        }
        assert_eq!(lines.len(), 5);
    }

    #[test]
    fn nothing_usable_gives_no_value() {
        let lines = readings([(0.0, 1.0), (f64::NAN, 1.0)], &Trial::new(1.0, 1.0));
        assert!(
            lines
                .iter()
                .all(|l| l.value.is_none() && l.flags == ["degenerate"] && l.degenerate == 2)
        );
        let none = readings([], &Trial::new(1.0, 1.0));
        assert!(none.iter().all(|l| l.value.is_none() && l.flags.is_empty() && l.n == 0));
    }
}
