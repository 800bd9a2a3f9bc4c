//! A recording of a Robotiq TSF-85 in: one finger's dynamic channel as vibration, its taxels as a pressure distribution.
//!
//! Layout, as the maker's `record_data.py` writes it: `;` between cells, `Time(ms)`, then for each finger f its dynamic
//! channel `D0_f`, taxels `S0_f` to `S27_f`, acceleration `Axf Ayf Azf` and angular rate `Gxf Gyf Gzf`, in counts. The
//! first row is a baseline and no sample. The acceleration of the finger itself shows a slip as well, so nobody takes
//! it for motion but `--map reference_x=Ax1 ...`.

use crate::find::Signal;

/// Taxels of a finger.
const TAXELS: usize = 28;

/// Which columns are those of the finger.
#[derive(Debug)]
pub(crate) struct Layout {
    finger: u32,
    fingers: Vec<u32>,
}

impl Layout {
    /// `None` where these are not the names of such a recording.
    ///
    /// # Errors
    /// Where the finger asked for is not among them.
    pub(crate) fn of(names: &[String], finger: Option<u32>) -> Result<Option<Self>, String> {
        let fingers: Vec<u32> =
            names.iter().filter_map(|name| name.strip_prefix("D0_")?.parse().ok()).collect();
        let has = |finger: &u32| names.contains(&format!("S{}_{finger}", TAXELS - 1));
        if !(names.iter().any(|name| name == "Time(ms)")
            && !fingers.is_empty()
            && fingers.iter().all(has))
        {
            return match finger {
                Some(finger) => Err(format!("--finger {finger}: this is no recording of a TSF-85")),
                None => Ok(None),
            };
        }
        let chosen = finger.or_else(|| fingers.first().copied()).unwrap_or_default();
        if !fingers.contains(&chosen) {
            return Err(format!("--finger {chosen}: the recording has the fingers {fingers:?}"));
        }
        Ok(Some(Self { finger: chosen, fingers }))
    }

    /// Marks which signals are those of the finger; what else is to be known.
    pub(crate) fn apply(&self, signals: &mut [Signal]) -> Vec<String> {
        let finger = self.finger;
        for signal in signals {
            signal.unit = Some("counts".to_owned());
            if signal.name == format!("D0_{finger}") {
                signal.known = Some("vibration".to_owned());
            } else if let Some(taxel) =
                (0..TAXELS).find(|k| signal.name == format!("S{k}_{finger}"))
            {
                signal.known = Some(format!("pressure_{taxel}"));
            }
        }
        let others: Vec<String> =
            self.fingers.iter().filter(|other| **other != finger).map(u32::to_string).collect();
        let mut notes = vec!["the first row is the baseline, no sample".to_owned()];
        if !others.is_empty() {
            notes.push(format!(
                "finger {finger} is used; --finger chooses another one ({})",
                others.join(", ")
            ));
        }
        notes
    }
}
