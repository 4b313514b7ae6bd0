use super::*;
use crate::tools::simulate::random::tests::mean_and_deviation;

#[test]
fn without_noise_an_echo_is_itself() {
    let mut sonar = NoisySonar::new(RangeNoise::default(), 1);
    let mut range = |echo| sonar.measure(echo, &Ring::default()).range;
    assert_eq!(range(Some(2.5)), 2.5);
    assert_eq!(range(None), f32::INFINITY);
    assert_eq!(range(Some(0.1)), f32::NEG_INFINITY);
    // Rounded to 32 bits this is the maximum range, so no echo.
    assert_eq!(range(Some(9.999_999_99)), f32::INFINITY);
}

#[test]
fn readings_go_missing_and_astray_as_often_as_asked() {
    let noise = RangeNoise {
        sigma: 0.003,
        no_echo: 0.2,
        outliers: 0.1,
    };
    let mut sonar = NoisySonar::new(noise, 3);
    let readings: Vec<_> = (0..10_000)
        .map(|_| sonar.measure(Some(3.0), &Ring::default()))
        .collect();
    let share = |predicate: fn(&Measured) -> bool| {
        readings.iter().filter(|m| predicate(m)).count() as f64 / 10_000.0
    };
    assert!((share(|m| m.outlier) - 0.1).abs() < 0.02);
    assert!((share(|m| m.range == f32::INFINITY) - 0.9 * 0.2).abs() < 0.02);
    let good = readings
        .iter()
        .filter(|m| !m.outlier && m.range.is_finite());
    let errors: Vec<_> = good.map(|m| f64::from(m.range) - 3.0).collect();
    let (mean, deviation) = mean_and_deviation(&errors);
    assert!(mean.abs() < 2e-4 && (deviation - 0.003).abs() < 2e-4);
}

#[test]
fn impossible_noise_is_refused() {
    for (sigma, no_echo, outliers) in [
        (-0.1, 0.0, 0.0),
        (f64::NAN, 0.0, 0.0),
        (0.0, 1.1, 0.0),
        (0.0, 0.0, -0.1),
        (0.0, 0.0, f64::NAN),
    ] {
        let noise = RangeNoise {
            sigma,
            no_echo,
            outliers,
        };
        assert!(noise.validate().is_err(), "{noise:?}");
    }
}

#[test]
fn odometry_drifts_with_the_root_of_the_way() {
    let noise = OdometryNoise {
        distance: 0.02,
        heading: 0.0,
        turn: 0.01,
    };
    let ends: Vec<_> = (0..2000)
        .map(|seed| {
            let mut odometry = DriftingOdometry::new(noise, [1.0, 1.0], seed);
            let poses = (0..=40).map(|i| Pose2::new(0.1 * f64::from(i), 0.0, 0.0));
            poses.map(|pose| odometry.sample(pose).x).last().unwrap()
        })
        .collect();
    let (mean, deviation) = mean_and_deviation(&ends);
    assert!((mean - 4.0).abs() < 0.005);
    assert!((deviation - 0.02 * 2.0).abs() < 0.003, "{deviation}");
}

#[test]
fn perfect_odometry_is_the_truth_to_the_last_bit() {
    let mut odometry = DriftingOdometry::new(OdometryNoise::default(), [1.0, 1.0], 1);
    for i in 0..100 {
        let pose = Pose2::new(0.1 * f64::from(i), 0.3, 0.7 * f64::from(i));
        assert_eq!(odometry.sample(pose), pose);
    }
}
