//! Units in which lengths are written that should be metres.

/// Units of length in use, in metres.
pub const UNITS: [(&str, f64); 5] = [
    ("millimetres", 0.001),
    ("centimetres", 0.01),
    ("inches", 0.0254),
    ("decimetres", 0.1),
    ("feet", 0.3048),
];
