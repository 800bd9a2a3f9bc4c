//! Measured force and command in; the force of the fingers during a slip, also where the sensor has failed, out.
//!
//! Where no reading comes, or the same one for [`FROZEN_S`] although the command moved on, the force is that of the command through a first-order
//! lag, `F' = (C - F) / T` with the delay T that the gripper showed when it closed. It takes over from the last good reading.

/// The same reading for this long (s) ...
const FROZEN_S: f32 = 0.015;
/// ... while the command moves the fingers by more than this share of it, and this much (N), is none.
const FROZEN_SHARE: f32 = 0.2;
const FROZEN_N: f32 = 0.3;

/// The force of one finger during a slip.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GripForce {
    /// By the command (N), since the reading last changed.
    modelled_n: f32,
    reading_n: Option<f32>,
    same_s: f32,
    frozen: bool,
}

impl GripForce {
    /// A slip begins under this command (N).
    pub(super) fn begin(&mut self, command_n: f32) {
        *self = Self { modelled_n: command_n, ..Self::default() };
    }

    /// Takes the next reading (N), the command of the sample before it (N), and the delay of the gripper (s); gives the force (N).
    pub(super) fn step(
        &mut self,
        reading_n: Option<f32>,
        command_n: f32,
        (dt_s, lag_s): (f32, f32),
    ) -> f32 {
        let share = if lag_s > dt_s { dt_s / lag_s } else { 1.0 };
        self.modelled_n += share * (command_n - self.modelled_n);
        match reading_n {
            Some(force_n) if self.reading_n != Some(force_n) => {
                self.reading_n = reading_n;
                (self.modelled_n, self.same_s, self.frozen) = (force_n, 0.0, false);
                return force_n;
            }
            Some(force_n) => {
                self.same_s += dt_s;
                let moved_n = (self.modelled_n - force_n).abs();
                self.frozen |=
                    self.same_s >= FROZEN_S && moved_n > (FROZEN_SHARE * force_n).max(FROZEN_N);
                if !self.frozen {
                    return force_n;
                }
            }
            None => self.reading_n = None,
        }
        self.modelled_n
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::GripForce;
    use std::vec::Vec;

    const STEP: (f32, f32) = (1e-3, 5e-3);

    #[test]
    fn a_good_reading_is_the_force_and_a_missing_one_goes_on_from_it() {
        let mut force = GripForce::default();
        force.begin(2.0);
        for i in 0..50_u8 {
            let reading = 2.0 + 0.1 * f32::from(i);
            assert_eq!(force.step(Some(reading), 8.0, STEP), reading);
        }
        let first = force.step(None, 8.0, STEP);
        assert!((first - 6.9).abs() < 0.4, "{first}");
        let last = (0..50).map(|_| force.step(None, 8.0, STEP)).last().unwrap();
        assert!((last - 8.0).abs() < 1e-3, "{last}");
    }

    #[test]
    fn a_reading_that_stands_while_the_command_rises_is_none_and_one_that_may_stand_is_the_force() {
        let mut force = GripForce::default();
        force.begin(2.0);
        let stuck: Vec<f32> = (0..40).map(|_| force.step(Some(2.0), 6.0, STEP)).collect();
        assert!(stuck[..15].iter().all(|f| *f == 2.0) && stuck[39] > 5.5, "{stuck:?}");
        assert_eq!(force.step(Some(5.0), 6.0, STEP), 5.0, "it is back");
        let mut calm = GripForce::default();
        calm.begin(2.0);
        assert!((0..500).all(|_| calm.step(Some(2.0), 2.1, STEP) == 2.0));
    }
}
