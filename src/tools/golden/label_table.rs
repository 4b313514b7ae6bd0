//! The labels of a golden file: a row per sonar, and counts that must agree with the rows.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::coding::{MOST_ARCS, decode_marks, decode_steps, encode_marks, encode_steps};
use super::file::Contradiction;
use super::results::{LabelledArc, Labels, Mark, Measured};

/// The labels of a golden file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelTable {
    contact: u64,
    intersection: u64,
    unidentified: u64,
    #[serde(deserialize_with = "each_once")]
    sonars: BTreeMap<String, SonarRow>,
}

/// Rows by sonar. A row that is there twice, as after a merge, is refused: the last one would hide the
/// others.
fn each_once<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<BTreeMap<String, SonarRow>, D::Error> {
    struct EachOnce;
    impl<'de> Visitor<'de> for EachOnce {
        type Value = BTreeMap<String, SonarRow>;

        fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
            to.write_str("a row for each sonar")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut rows = BTreeMap::new();
            while let Some((sonar, row)) = map.next_entry::<String, SonarRow>()? {
                if rows.contains_key(&sonar) {
                    let twice = format!("sonar `{sonar}` is there twice");
                    return Err(serde::de::Error::custom(twice));
                }
                rows.insert(sonar, row);
            }
            Ok(rows)
        }
    }
    deserializer.deserialize_map(EachOnce)
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SonarRow {
    /// Where the sonar is and what it measures; not known of files from before they held it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    measured: Option<Measured>,
    labels: String,
    first_ns: i64,
    steps_ms: String,
}

impl From<&Labels> for LabelTable {
    fn from(labels: &Labels) -> Self {
        let counts = labels.counts();
        let count = |mark| counts.get(&mark).copied().unwrap_or_default();
        let rows = labels.sonars.iter().filter_map(|(sonar, arcs)| {
            let stamps: Vec<i64> = arcs.iter().map(|arc| arc.stamp_ns).collect();
            let row = SonarRow {
                measured: labels.measured.get(sonar).copied(),
                labels: encode_marks(arcs.iter().map(|arc| arc.mark)),
                first_ns: *stamps.first()?,
                steps_ms: encode_steps(&stamps),
            };
            Some((sonar.clone(), row))
        });
        Self {
            contact: count(Mark::Contact),
            intersection: count(Mark::Intersection),
            unidentified: count(Mark::Unidentified),
            sonars: rows.collect(),
        }
    }
}

impl LabelTable {
    /// The labels behind it.
    ///
    /// # Errors
    /// Where it contradicts itself.
    pub fn open(self) -> Result<Labels, Contradiction> {
        let mut labels = Labels::default();
        let mut arcs_so_far = 0;
        for (sonar, row) in self.sonars {
            let wrong = |what: String| Contradiction(format!("labels of sonar `{sonar}`: {what}"));
            let marks = decode_marks(&row.labels).map_err(wrong)?;
            arcs_so_far += marks.len();
            if arcs_so_far > MOST_ARCS {
                return Err(wrong(format!(
                    "with it, there are more than {MOST_ARCS} arcs"
                )));
            }
            let stamps = decode_steps(row.first_ns, &row.steps_ms).map_err(wrong)?;
            if marks.len() != stamps.len() {
                return Err(wrong(format!(
                    "there are {} labels and {} stamps",
                    marks.len(),
                    stamps.len()
                )));
            }
            let arcs = marks
                .into_iter()
                .zip(stamps)
                .map(|(mark, stamp_ns)| LabelledArc {
                    stamp_ns,
                    mark,
                    frame: None,
                    margin: None,
                    reason: None,
                });
            if let Some(measured) = row.measured {
                let numbers = measured.mount.into_iter().chain([measured.mean_range]);
                if numbers.into_iter().any(|number| !number.is_finite()) {
                    return Err(wrong("a number in `measured` is not finite".to_owned()));
                }
                labels.measured.insert(sonar.clone(), measured);
            }
            labels.sonars.insert(sonar, arcs.collect());
        }
        let counts = labels.counts();
        for (mark, said) in [
            (Mark::Contact, self.contact),
            (Mark::Intersection, self.intersection),
            (Mark::Unidentified, self.unidentified),
        ] {
            let found = counts.get(&mark).copied().unwrap_or_default();
            if found != said {
                return Err(Contradiction(format!(
                    "labels: {said} {} are counted, but the sonars have {found}",
                    mark.name()
                )));
            }
        }
        Ok(labels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_sonars_cannot_fill_the_memory_either() {
        let row = r#"{"labels": "3000000u", "first_ns": 0, "steps_ms": "1x2999999"}"#;
        let table = |names: &[&str]| {
            let rows: Vec<String> = names
                .iter()
                .map(|name| format!("\"{name}\": {row}"))
                .collect();
            let count = 3_000_000 * names.len();
            let text = format!(
                "{{\"contact\": 0, \"intersection\": 0, \"unidentified\": {count}, \"sonars\": {{{}}}}}",
                rows.join(", ")
            );
            serde_json::from_str::<LabelTable>(&text).unwrap().open()
        };
        assert_eq!(
            table(&["a"]).ok().map(|labels| labels.len()),
            Some(3_000_000)
        );
        let refused = table(&["a", "b"]).err().map(|error| error.0).unwrap();
        assert!(
            refused.contains("sonar `b`") && refused.contains("5000000"),
            "{refused}"
        );
    }
}
