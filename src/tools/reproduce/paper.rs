//! What the paper says of its experiment.

use std::f64::consts::FRAC_PI_2;

/// A feature of the paper's Table I.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableRow {
    /// Its number there.
    pub number: u8,
    /// What the paper estimated: rho in metres, and alpha of a point or theta of a line in radians.
    pub estimated: (f64, f64),
    /// What the paper calls actual, with a right angle in full.
    pub actual: (f64, f64),
}

const fn row(number: u8, estimated: (f64, f64), actual: (f64, f64)) -> TableRow {
    TableRow {
        number,
        estimated,
        actual,
    }
}

/// The corners, in the order of the built-in room.
pub const POINTS: [TableRow; 6] = [
    row(1, (0.045_357, -0.8192), (0.0, 0.0)),
    row(3, (4.0522, 0.004), (4.0, 0.0)),
    row(5, (4.444, 0.4605), (4.472_136, 0.46)),
    row(7, (8.2413, 0.2442), (8.246_211, 0.245)),
    row(9, (9.4311, 0.5628), (9.433_981, 0.5586)),
    row(11, (5.0629, 1.5735), (5.0, FRAC_PI_2)),
];

/// The walls, in the same order.
pub const LINES: [TableRow; 6] = [
    row(2, (0.005_839, 1.5686), (0.0, FRAC_PI_2)),
    row(4, (4.0273, 0.0161), (4.0, 0.0)),
    row(6, (1.9798, 1.5754), (2.0, FRAC_PI_2)),
    row(8, (8.0712, 0.0222), (8.0, 0.0)),
    row(10, (5.0045, 1.5702), (5.0, FRAC_PI_2)),
    row(12, (0.020_828, 0.006), (0.0, 0.0)),
];

/// What it counts of its readings.
pub const READINGS: u64 = 2400;
/// Of these, the ones that are associated with features.
pub const ASSOCIATED: u64 = 524;
/// Points and lines that were extracted,
pub const EXTRACTED: [u64; 2] = [20, 17];
/// and that are in its map.
pub const REGISTERED: [u64; 2] = [6, 6];
