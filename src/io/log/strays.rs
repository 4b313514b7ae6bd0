//! Names that only a handful of messages have beside many good ones: damage that no checksum caught.

use std::collections::BTreeMap;

use super::sonars::{Source, SourceKey};
use super::transforms::TransformTree;
use crate::core::config::Config;
use crate::core::event::{RangeReading, SonarId};
use crate::core::wording::counted;

/// So many messages may be a handful.
const FEW: usize = 3;
/// Or one in so many of the usual ones.
const SHARE: usize = 100;
/// The usual ones are so many times as many.
const USUAL: usize = 10;

/// Whether so many messages with one name are a handful beside so many with the usual one.
pub fn is_handful(count: usize, usual: usize) -> bool {
    count <= FEW.max(usual / SHARE) && count.saturating_mul(USUAL) <= usual
}

/// `a, b and 3 more`.
pub fn few(names: &[String]) -> String {
    const SHOWN: usize = 3;
    let shown = names
        .get(..SHOWN.min(names.len()))
        .unwrap_or_default()
        .join(", ");
    match names.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// Takes out readings whose frame only a handful of their topic's messages name, where neither a
/// transform nor the configuration knows it, or where it is that of another topic. What is told of them
/// is returned.
pub fn take_out(
    sources: &mut Vec<Source>,
    readings: &mut Vec<RangeReading>,
    transforms: &TransformTree,
    config: &Config,
) -> Vec<String> {
    let mut counts = vec![0_usize; sources.len()];
    for reading in &*readings {
        if let Some(count) = counts.get_mut(reading.sonar.index()) {
            *count += 1;
        }
    }
    let mut usual = BTreeMap::<&str, Usual>::new();
    for (source, count) in sources.iter().zip(&counts) {
        let usual = usual.entry(&source.key.topic).or_default();
        if *count > usual.most {
            (usual.frame, usual.most) = (&source.key.frame, *count);
        }
        usual.all += count;
    }
    let is_of_another = |source: &Source| {
        let SourceKey { topic, frame, .. } = &source.key;
        let is_its = |(other, usual): (&&str, &Usual)| *other != topic && usual.frame == frame;
        usual.iter().any(is_its) && !config.sonar.contains_key(&format!("{topic}:{frame}"))
    };
    let frames = transforms.frames();
    let is_stray = |source: &Source, count: usize| {
        let frame = &source.key.frame;
        let most = usual
            .get(source.key.topic.as_str())
            .map_or(0, |usual| usual.most);
        let described = |name: &String| name == frame || name.contains(&format!(":{frame}"));
        let is_unknown = || {
            frames.binary_search(&frame.as_str()).is_err()
                && !config.sonar.keys().any(described)
                && config.input.robot_frame.as_ref() != Some(frame)
        };
        is_handful(count, most) && (is_unknown() || is_of_another(source))
    };
    let strays: Vec<bool> = sources
        .iter()
        .zip(&counts)
        .map(|(s, count)| is_stray(s, *count))
        .collect();
    if !strays.contains(&true) {
        return Vec::new();
    }
    let mut told = BTreeMap::<(&str, bool), (usize, Vec<String>)>::new();
    for ((source, count), _) in sources
        .iter()
        .zip(&counts)
        .zip(&strays)
        .filter(|(_, stray)| **stray)
    {
        let (lost, names) = told
            .entry((&source.key.topic, is_of_another(source)))
            .or_default();
        *lost += count;
        names.push(format!("`{}`", source.key.frame));
    }
    let told = told
        .into_iter()
        .map(|((topic, is_of_another), (lost, names))| {
            let all = usual.get(topic).map_or(0, |usual| usual.all);
            format!(
                "{lost} of {} on {topic} {} the frame {}, which {}",
                counted(all as u64, "reading"),
                if lost == 1 { "names" } else { "name" },
                few(&names),
                if is_of_another {
                    "is another topic's: they are taken for damaged and left out"
                } else {
                    "nothing else does: they are taken for damaged and left out. If it is a sonar's, give its \
                     mount under [sonar.\"NAME\"]"
                }
            )
        })
        .collect();
    keep(sources, readings, &strays);
    told
}

/// What most readings on a topic name.
#[derive(Default)]
struct Usual<'a> {
    frame: &'a str,
    most: usize,
    all: usize,
}

/// Takes out sources, and their readings; the ids of the others follow.
fn keep(sources: &mut Vec<Source>, readings: &mut Vec<RangeReading>, strays: &[bool]) {
    let mut ids = Vec::with_capacity(strays.len());
    let mut next = 0_u16;
    for stray in strays {
        ids.push((!stray).then_some(SonarId(next)));
        next += u16::from(!stray);
    }
    readings.retain_mut(|reading| match ids.get(reading.sonar.index()) {
        Some(Some(id)) => {
            reading.sonar = *id;
            true
        }
        _ => false,
    });
    let mut stray = strays.iter();
    sources.retain(|_| stray.next() == Some(&false));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_handful_is_few_beside_many() {
        for (count, usual, expected) in [
            (1, 9, false),
            (1, 10, true),
            (3, 30, true),
            (4, 40, false),
            (4, 400, true),
            (40, 400, false),
        ] {
            assert_eq!(is_handful(count, usual), expected, "{count} beside {usual}");
        }
    }

    #[test]
    fn lists_end() {
        let names: Vec<String> = ["a", "b", "c", "d", "e"].map(String::from).to_vec();
        assert_eq!(few(&names), "a, b, c and 2 more");
        assert_eq!(few(&names[..2]), "a, b");
    }
}
