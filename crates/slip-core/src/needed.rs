//! The force that the object in hand needs, as it is reported.

/// Standard gravity (m/s^2).
const GRAVITY_M_S2: f32 = 9.806_65;

/// Quantiles of the normal force of one finger that the object needs at full weight, and what the commanded force allows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeededForce {
    /// 10 % quantile (N).
    pub low_n: f32,
    /// Median (N).
    pub median_n: f32,
    /// 90 % quantile (N).
    pub high_n: f32,
    /// How hard the arm may accelerate beside gravity, in any direction (m/s^2): [`Self::admissible`] at the commanded force.
    pub admissible_m_s2: f32,
}

impl NeededForce {
    /// The acceleration (m/s^2, at least 0) that the force `command_n` (N) holds the object against with a probability of 90 %, where the 90 %
    /// quantile of the needed force is `high_n` (N): `g (command / high - 1)`. The worst direction is that of gravity; any other loads the
    /// contact less. 0 where either is no force.
    #[must_use]
    pub fn admissible(command_n: f32, high_n: f32) -> f32 {
        let share = command_n / high_n;
        if share.is_finite() && high_n > 0.0 { GRAVITY_M_S2 * (share - 1.0).max(0.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::NeededForce;
    use crate::{Pipeline, PipelineConfig, PipelineState, Sample, Signal, Step};
    use slip_msg::units::{Hertz, Micros};

    #[test]
    fn the_acceleration_that_a_command_allows_brings_the_load_up_to_it() {
        for (command_n, high_n, wanted) in
            [(4.0, 4.0, 0.0), (6.0, 4.0, 4.903_325), (8.0, 4.0, 9.806_65), (3.0, 4.0, 0.0)]
        {
            let admissible = NeededForce::admissible(command_n, high_n);
            assert!((admissible - wanted).abs() < 1e-5, "{command_n} of {high_n} N: {admissible}");
            // An object that needs the quantile, accelerated so much along gravity, needs the command and no more.
            let needs_n = high_n * (1.0 + admissible / 9.806_65);
            assert!((needs_n - command_n.max(high_n)).abs() < 1e-5, "{needs_n} N");
        }
    }

    #[test]
    fn what_is_no_force_allows_nothing() {
        let odd = [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        for command_n in odd {
            for high_n in odd.into_iter().chain([4.0]) {
                let admissible = NeededForce::admissible(command_n, high_n);
                assert_eq!(admissible.to_bits(), 0, "{command_n} of {high_n} N: {admissible}");
            }
        }
        for high_n in odd.into_iter().chain([f32::MIN_POSITIVE * 1e-6]) {
            let admissible = NeededForce::admissible(4.0, high_n);
            assert_eq!(admissible.to_bits(), 0, "4 of {high_n} N: {admissible}");
        }
    }

    #[test]
    fn a_state_has_what_its_step_knows_of_the_object() {
        let config = PipelineConfig::observing(Signal::Vibration, Hertz(1000.0));
        let mut pipeline = Pipeline::<&[f32]>::new(config, None).unwrap();
        let step = pipeline.handle(&Sample::stylus(Micros(5), 0.0));
        assert_eq!(step.need, None, "nothing is held");
        let need = NeededForce { low_n: 3.0, median_n: 4.0, high_n: 5.5, admissible_m_s2: 2.25 };
        let shown = |need| {
            let state: PipelineState = Step { need, ..step }.state(None, None, None);
            [state.need_low_n, state.need_n, state.need_high_n, state.admissible_m_s2]
        };
        assert_eq!(shown(Some(need)), [3.0, 4.0, 5.5, 2.25].map(Some));
        assert_eq!(shown(None), [None; 4]);
    }
}
