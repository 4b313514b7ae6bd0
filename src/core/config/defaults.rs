//! What holds where nothing is said.

use std::collections::BTreeMap;

use super::{
    Config, Frames, Input, Map, Method, Noise, NoiseAwareOptions, Poses, Rule, Sequence,
    SonarDefaults, StampsFrom, TestBounds, Triple,
};

impl Default for Config {
    fn default() -> Self {
        Self {
            method: Method::Tmam,
            rule: Rule::NoiseAware,
            poses: Poses::Joint,
            input: Input::default(),
            frames: Frames::default(),
            sequence: Sequence::default(),
            triple: Triple::default(),
            noise: Noise::default(),
            opinion: TestBounds::default(),
            map: Map::default(),
            noise_aware: NoiseAwareOptions::default(),
            sonars: SonarDefaults::default(),
            sonar: BTreeMap::new(),
            channel: BTreeMap::new(),
        }
    }
}

impl Default for Frames {
    fn default() -> Self {
        Self {
            step: 0.10,
            step_angle: 10_f64.to_radians(),
            max_odometry_gap: 0.5,
            max_extrapolation: 0.0,
        }
    }
}

impl Default for Sequence {
    fn default() -> Self {
        Self {
            max_gap: 5.0,
            max_baseline: 0.5,
        }
    }
}

impl Default for Triple {
    fn default() -> Self {
        Self {
            alpha: 0.5,
            beta: 2.0,
            gamma: 10_f64.to_radians(),
            turn_tolerance: 5_f64.to_radians(),
            bend_tolerance: 10_f64.to_radians(),
        }
    }
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            trust_variance: true,
            sigma_abs: None,
            sigma_rel: 0.0,
            sigma_pose: 0.0,
            odometry_distance: None,
            odometry_heading: None,
            odometry_turn: None,
        }
    }
}

impl Default for TestBounds {
    fn default() -> Self {
        // One in a hundred triples of one target lies beyond.
        Self {
            gate: 6.63,
            decisive: 13.0,
            max_half_width: 10,
        }
    }
}

impl Default for Input {
    fn default() -> Self {
        Self {
            range_topics: Vec::new(),
            odometry_topics: Vec::new(),
            transform_topics: Vec::new(),
            sonars: Vec::new(),
            start: None,
            end: None,
            robot_frame: None,
            world_frame: None,
            mounts_from: None,
            odometry_track: None,
            odometry_jumps: None,
            drop_repeats: false,
            trust_unchecked: false,
            max_readings: 2_000_000,
            range_stamps: StampsFrom::default(),
            odometry_stamps: StampsFrom::default(),
            odometry_from_speeds: false,
            range_delay: 0.0,
            range_clock_rate: 0.0,
            odometry_scale: 1.0,
            odometry_turn_scale: 1.0,
        }
    }
}

impl Default for Map {
    fn default() -> Self {
        Self {
            match_distance: 0.2,
            gate: 25.0,
            max_wall_gap: 1.0,
            confirm_runs: 2,
            confirm_readings: 8,
        }
    }
}

impl Default for NoiseAwareOptions {
    fn default() -> Self {
        Self {
            label_by_opinion: true,
            converge: true,
            reject_misfits: true,
            break_runs: true,
            reject_mirrored: true,
            fuse_by_information: true,
            merge: true,
            confirm: true,
            end_at_corners: true,
            gather: true,
            join_corners: true,
            crossings: true,
            oblique_walls: false,
            circles: false,
        }
    }
}
