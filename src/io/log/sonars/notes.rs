//! What a person is told of mounts and beams, once for all sonars of which it is true.

use super::source::is_senseless;
use super::{Named, Placing};
use crate::core::wording::{counted, plural};
use crate::io::log::strays::few;
use crate::io::log::transforms::Mount;

/// What a note on beams that no sonar has says of them.
pub const TOO_WIDE: &str = "wider than any sonar's";

/// Mounts that are not what they are taken for.
pub fn on_mounts(mounts: &[(&Named<'_>, Mount)]) -> Vec<String> {
    let of = |test: &dyn Fn(&(&Named<'_>, Mount)) -> bool| {
        let some = mounts.iter().filter(|mount| test(mount));
        some.map(|(sonar, _)| *sonar).collect::<Vec<_>>()
    };
    let mut notes = Vec::new();
    let tilted = of(&|(_, mount)| mount.tilt.is_some());
    let tilts = mounts.iter().filter_map(|(_, mount)| mount.tilt);
    let most = tilts.max_by(|a, b| a.abs().total_cmp(&b.abs()));
    if let Some(most) = most {
        let (is, its, upto) = match tilted.len() {
            1 => ("is", "its mount is projected and its", ""),
            _ => ("are", "their mounts are projected and their", "up to "),
        };
        notes.push(format!(
            "{} {is} tilted {upto}{:.1} deg out of the plane; {its} ranges are taken as they are",
            which(&tilted),
            most.to_degrees()
        ));
    }
    let moved = of(&|(_, mount)| mount.moved);
    if !moved.is_empty() {
        let (mounts, first) = match moved.len() {
            1 => ("mount", "moves on /tf; its first pose is"),
            _ => ("mounts", "move on /tf; their first poses are"),
        };
        notes.push(format!(
            "the {mounts} of {} {first} taken for the whole log",
            which(&moved)
        ));
    }
    let turned = of(&|(sonar, _)| sonar.source.turned);
    if !turned.is_empty() {
        let (beams, first) = match turned.len() {
            1 => ("beam", "turns in its messages; its first bearing is"),
            _ => ("beams", "turn in their messages; their first bearings are"),
        };
        notes.push(format!(
            "the {beams} of {} {first} taken for the whole log",
            which(&turned)
        ));
    }
    notes
}

/// Readings without beam width, of sonars whose other readings have one; `lacking` counts them sonar by
/// sonar.
pub fn on_missing_widths(named: &[Named<'_>], lacking: &[u64]) -> Option<String> {
    let some: Vec<(&Named<'_>, u64)> = (named.iter().zip(lacking.iter().copied()))
        .filter(|(_, lacking)| *lacking > 0)
        .collect();
    let readings = some.iter().map(|(_, lacking)| lacking).sum();
    let widths = some.iter().filter_map(|(sonar, _)| sonar.source.beam_width);
    let first = widths.clone().next()?.to_degrees();
    let all_same = widths.clone().all(|width| width.to_degrees() == first);
    let sonars: Vec<&Named<'_>> = some.iter().map(|(sonar, _)| *sonar).collect();
    let whose = if sonars.len() == 1 { "its" } else { "their" };
    let taken = if all_same {
        format!("the {first:.1} deg that {whose} others give are taken")
    } else {
        format!("what {whose} others give is taken")
    };
    let verb = if readings == 1 { "gives" } else { "give" };
    Some(format!(
        "{} of {} {verb} no beam width; {taken}",
        counted(readings, "reading"),
        which(&sonars)
    ))
}

/// Beams as wide as no sonar's is, which the configuration does not overrule.
pub fn on_senseless_widths(placed: &[&Named<'_>], placing: &Placing<'_>) -> Option<String> {
    let read = |sonar: &Named<'_>| sonar.source.beam_width.filter(|width| is_senseless(*width));
    let overruled = |sonar: &Named<'_>, width| placing.overruling(sonar, width).is_some();
    let sonars: Vec<&Named<'_>> = (placed.iter().copied())
        .filter(|sonar| read(sonar).is_some_and(|width| !overruled(sonar, width)))
        .collect();
    let width = sonars.iter().find_map(|sonar| read(sonar))?;
    // What is beyond half a turn can only be meant in degrees.
    let likely = if width > std::f64::consts::PI {
        width as f32 // as the driver wrote it
    } else {
        22.5
    };
    Some(format!(
        "the {} of {} {} {:.0} deg wide by {} messages ({width:.3} rad), {TOO_WIDE}: if the driver \
         writes degrees, sonars.beam_width = {likely} (deg) in the configuration overrules it",
        plural(sonars.len() as u64, "beam"),
        which(&sonars),
        if sonars.len() == 1 { "is" } else { "are" },
        width.to_degrees(),
        if sonars.len() == 1 { "its" } else { "their" },
    ))
}

/// ``sonar `a` ``; ``16 sonars (`a`, `b`, `c` and 13 more)``.
fn which(sonars: &[&Named<'_>]) -> String {
    let names: Vec<String> = sonars.iter().map(|s| format!("`{}`", s.name)).collect();
    match names.as_slice() {
        [one] => format!("sonar {one}"),
        _ => format!("{} ({})", counted(names.len() as u64, "sonar"), few(&names)),
    }
}
