//! What really echoed: the answer that a simulated log carries with each reading.

use serde::{Deserialize, Serialize};

use crate::core::world::{Echo, Reflector};

/// The kind of thing that echoed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ReflectorKind {
    /// A wall.
    Line,
    /// A diffracting point.
    Point,
}

/// The truth about one reading.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReadingTruth {
    /// The reading's stamp, nanoseconds on the log's own clock.
    pub stamp_ns: i64,
    /// The name (frame id) of the sonar that took it.
    pub sonar: String,
    /// What was there to echo; none where nothing was.
    pub kind: Option<ReflectorKind>,
    /// Which wall or point of the world, from 0.
    pub index: Option<usize>,
    /// Its distance without noise, metres, rounded to 1e-9.
    pub range: Option<f64>,
    /// Whether the reading was replaced by a random range.
    pub outlier: bool,
}

impl ReadingTruth {
    /// The truth about a reading of `sonar` at `stamp_ns` for which the world gave `echo`.
    pub fn new(stamp_ns: i64, sonar: &str, echo: Option<Echo>, outlier: bool) -> Self {
        let (kind, index) = echo
            .map(|echo| match echo.reflector {
                Reflector::Line(index) => (ReflectorKind::Line, index),
                Reflector::Point(index) => (ReflectorKind::Point, index),
            })
            .unzip();
        Self {
            stamp_ns,
            sonar: sonar.to_owned(),
            kind,
            index,
            range: echo.map(|echo| libm::round(echo.range * 1e9) / 1e9),
            outlier,
        }
    }

    /// The wall or point that echoed, as the world counts it.
    pub fn reflector(&self) -> Option<Reflector> {
        let index = self.index?;
        Some(match self.kind? {
            ReflectorKind::Line => Reflector::Line(index),
            ReflectorKind::Point => Reflector::Point(index),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_json_is_what_its_schema_says() {
        let echo = Echo {
            range: 1.234_567_890_123,
            reflector: Reflector::Point(2),
        };
        let truth = ReadingTruth::new(7, "sonar_00", Some(echo), false);
        let json = serde_json::to_string(&truth).unwrap();
        assert_eq!(
            json,
            r#"{"stamp_ns":7,"sonar":"sonar_00","kind":"point","index":2,"range":1.23456789,"outlier":false}"#
        );
        let again: ReadingTruth = serde_json::from_str(&json).unwrap();
        assert_eq!(again, truth);
        assert_eq!(again.reflector(), Some(Reflector::Point(2)));

        let silence = ReadingTruth::new(7, "sonar_00", None, true);
        let json = serde_json::to_string(&silence).unwrap();
        assert!(json.contains(r#""kind":null,"index":null,"range":null,"outlier":true"#));
        assert_eq!(silence.reflector(), None);
    }
}
