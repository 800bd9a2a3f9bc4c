use super::{Calibration, Evidence, LEAST, StylusCalibration, TESTS, thresholds, thresholds_of};
use slip_core::{
    PipelineConfig, Signal,
    detector::{BANDS, DetectorConfig},
    units::Hertz,
};

#[test]
fn without_motion_no_threshold_goes_below_its_default() {
    let defaults = thresholds_of(&DetectorConfig::default());
    // Rest: the four bands of motion and the cumulative sum were never received.
    let mut second = [0.0; TESTS];
    (second[0], second[1]) = (1.5, 1.4);
    let seconds = [second; 60];
    assert_eq!(thresholds(&seconds, 60.0, &defaults, false), defaults);
    let moved = thresholds(&seconds, 60.0, &defaults, true);
    assert_eq!(moved[..2], [LEAST; 2]);
    assert_eq!(moved[2..], defaults[2..], "never heard");
}

#[test]
fn lower_thresholds_leave_the_release_level_above_the_noise() {
    let config = PipelineConfig::observing(Signal::Displacement, Hertz(10_000.0));
    let release = |thresholds: [f32; BANDS]| {
        let evidence = Evidence {
            wanted_interval_s: 60.0,
            rest_s: 60.0,
            unexplained_s: 0.0,
            unexplained_longest: None,
            motion_s: 0.0,
            judged_s: 0.0,
            alarms: 0,
            interval_low_s: 0.0,
            interval_high_s: None,
            extrapolation: 1.0,
            claimed_s: None,
            smallest_rest: None,
            smallest_motion: None,
        };
        let calibration = StylusCalibration {
            sample_rate_hz: 10_000.0,
            vibration: false,
            floor: [1.0; BANDS],
            reference_floor: None,
            gain: None,
            thresholds,
            cusum_threshold: 22.0,
            tail: None,
            evidence,
            certificate: None,
            certified: None,
            taxels: None,
        };
        Calibration::Stylus(calibration).apply(config).detector.release
    };
    let detector = config.detector;
    let unchanged = detector.bands().map(|band| band.threshold);
    assert_eq!(release(unchanged), detector.release);
    assert_eq!(release(unchanged.map(|h| 0.5 * h)), 2.0 * detector.release);
    assert_eq!(release([LEAST; BANDS]), 0.8);
    assert_eq!(release(unchanged.map(|h| 2.0 * h)), detector.release);
}
