//! A log's facts and findings for a person: metres, seconds and degrees, within 100 columns.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use comfy_table::{ColumnConstraint, Table, Width};

use super::Info;
use crate::core::legible::{legible, one_line, shortened};
use crate::core::replay::{CauseTold, Stretch};
use crate::core::rounding::fixed;
use crate::core::statistics::{fraction, median, seconds};
use crate::core::wording::counted;
use crate::observe::causes::LOOKED_AT;
use crate::tools::findings::facts::{ChannelFacts, Facts};
use crate::tools::findings::finding::{Finding, Weight};
use crate::tools::findings::odometry::OdometryFacts;
use crate::tools::findings::sonars::{MountFacts, SonarFacts};
use crate::tools::findings::trial::Replayable;
use crate::tools::tables::{LONGEST_NAME, fitting, listed, name, optional, render, section, table};

/// Longest part of a finding, characters.
const LONGEST_PART: usize = 2000;

/// Widest name beside all that is told of echoes, characters.
const ECHOES_NAME: usize = 20;

/// Everything, as text.
pub fn text(info: &Info) -> String {
    let facts = &info.facts;
    let mut text = head(facts);
    if !facts.channels.is_empty() {
        section(&mut text, "CHANNELS", &channels(facts));
    }
    if !facts.sonars.is_empty() {
        section(&mut text, "SONARS", &sonars(&facts.sonars));
        section(&mut text, "ECHOES", &echoes(&facts.sonars));
    }
    if let Some(odometry) = &facts.odometry {
        section(&mut text, "ODOMETRY", &motion(facts, odometry));
    }
    let is_stamped = |c: &ChannelFacts| c.used && c.stamped + c.unstamped > 0;
    if facts.channels.iter().any(is_stamped) {
        section(&mut text, "CLOCKS", &clocks(facts));
    }
    section(&mut text, "FINDINGS", &findings(&info.findings));
    if let Some(causes) = &info.causes {
        section(&mut text, "CAUSES", &self::causes(causes, info.stretch()));
    }
    if let Some(skeleton) = &info.skeleton {
        let title = "TMAM.TOML (print only this: --skeleton)";
        section(&mut text, title, skeleton);
    }
    legible(&text).into_owned()
}

fn head(facts: &Facts) -> String {
    let Facts { source, replay, .. } = facts;
    let mut text = format!(
        "{}: {:.1} s, {} used, {}{}\n",
        one_line(&source.file),
        seconds(source.start_ns, source.end_ns),
        counted(source.messages, "message"),
        counted(facts.sonars.len() as u64, "sonar"),
        if source.complete { "" } else { ", INCOMPLETE" },
    );
    text.push_str(match replay.possible {
        Replayable::Yes => "can be replayed",
        Replayable::InPart => {
            "can be replayed in part, without the sonars that findings name; with the configuration at the end whole"
        }
        Replayable::WithSkeleton => {
            "cannot be replayed as it is; with the configuration at the end it can"
        }
        Replayable::No => "cannot be replayed",
    });
    if let Some(outcome) = &replay.outcome {
        let [contact, intersection, unidentified] =
            ["contact", "intersection", "unidentified"].map(|label| outcome.labelled(label));
        let arcs = contact + intersection + unidentified;
        let frames = counted(outcome.frames.into(), "frame");
        let _ = write!(text, ": {frames}, {}", counted(arcs, "arc"));
        // Labels made with placeholders mean nothing.
        if replay.possible == Replayable::Yes {
            let _ = write!(text, ", {contact} contact, {intersection} intersection");
        }
    }
    text.push('\n');
    text
}

fn channels(facts: &Facts) -> String {
    let channels = &facts.channels;
    let start = channels.iter().map(|c| c.first_ns).min().unwrap_or(0);
    let after = |stamp_ns| format!("{:.1}", seconds(start, stamp_ns));
    listed::<ChannelFacts>(
        4,
        &[
            ("topic", &|c| name(&c.topic)),
            ("type", &|c| match c.type_name.as_str() {
                "" => "(none)".to_owned(),
                type_name => name(type_name),
            }),
            ("encoding", &|c| name(&c.encoding)),
            ("read as", &|c| read_as(c).to_owned()),
            ("messages", &|c| c.messages.to_string()),
            ("Hz", &|c| optional(c.rate, 1)),
            ("from s", &|c| after(c.first_ns)),
            ("to s", &|c| after(c.last_ns)),
        ],
        channels,
    )
}

fn read_as(channel: &ChannelFacts) -> &str {
    match (channel.role, channel.used) {
        (Some(role), true) => role,
        (Some(_), false) if channel.problem.is_some() => "NOT READ",
        (Some(_), false) => "left out",
        (None, _) => "-",
    }
}

/// What each sonar is and where it sits.
fn sonars(sonars: &[SonarFacts]) -> String {
    let known = |x: Option<f64>, decimals| x.map_or_else(|| "?".to_owned(), |x| fixed(x, decimals));
    let mount =
        |s: &SonarFacts, of: fn(MountFacts) -> f64, decimals| known(s.mount.map(of), decimals);
    listed::<SonarFacts>(
        2,
        &[
            ("sonar", &|s| name(&s.name)),
            ("topic", &|s| name(&s.topic)),
            ("x m", &|s| mount(s, |m| m.x, 3)),
            ("y m", &|s| mount(s, |m| m.y, 3)),
            ("yaw deg", &|s| mount(s, |m| m.yaw.to_degrees(), 1)),
            ("beam deg", &|s| known(s.beam_width.map(f64::to_degrees), 1)),
            ("min m", &|s| fixed(s.min_range, 2)),
            ("max m", &|s| fixed(s.max_range, 2)),
            ("readings", &|s| s.readings.to_string()),
            ("Hz", &|s| optional(s.rate, 1)),
        ],
        sonars,
    )
}

/// What came back to each sonar.
fn echoes(sonars: &[SonarFacts]) -> String {
    let share = |part, whole| format!("{:.0}", 100.0 * fraction(part, whole));
    let names: Vec<String> = sonars.iter().map(|sonar| name(&sonar.name)).collect();
    let names: BTreeMap<_, _> = (sonars.iter().map(|s| s.id))
        .zip(fitting(names, ECHOES_NAME))
        .collect();
    let mut text = listed::<SonarFacts>(
        1,
        &[
            ("sonar", &|s| names.get(&s.id).cloned().unwrap_or_default()),
            ("echo\n%", &|s| share(s.echoes, s.readings)),
            ("none\n%", &|s| share(s.no_echoes, s.readings)),
            ("invalid\n%", &|s| share(s.invalid, s.readings)),
            ("shortest\nm", &|s| optional(s.shortest, 2)),
            ("median\nm", &|s| optional(s.median, 2)),
            ("longest\nm", &|s| optional(s.longest, 2)),
            ("step\nmm", &|s| match s.resolution {
                Some(raster) if !raster.quantised => "fine".to_owned(),
                raster => optional(raster.map(|raster| raster.step * 1e3), 1),
            }),
            ("noise\nmm", &|s| optional(s.scatter.map(|s| s * 1e3), 1)),
            ("repeats\n%", &|s| match s.moved {
                0 => "-".to_owned(),
                moved => share(s.repeats, moved),
            }),
            ("apart\nm", &|s| optional(s.baseline, 3)),
        ],
        sonars,
    );
    text.push_str(
        "  step: raster of the ranges; noise: how far they scatter along walls, standard deviation;\n  \
         repeats: the same echo again although the sensor moved;\n  \
         apart: from one reading to the next while moving\n",
    );
    text
}

/// The odometry in a few lines.
fn motion(facts: &Facts, odometry: &OdometryFacts) -> String {
    let mut text = format!(
        "  {}: {}, {} Hz, {:.1} m driven, {:.0} deg turned\n",
        name(&odometry.topic),
        counted(odometry.samples, "sample"),
        optional(odometry.rate, 1),
        odometry.distance,
        odometry.turning.to_degrees(),
    );
    let after = |stamp_ns| fixed(seconds(facts.source.start_ns, stamp_ns), 1);
    if let (Some(gap), Some(jump)) = (odometry.longest_gap, odometry.largest_jump) {
        let _ = writeln!(
            text,
            "  longest time between samples {:.3} s at {} s; longest way {:.3} m at {} s",
            gap.seconds,
            after(gap.stamp_ns),
            jump.distance,
            after(jump.stamp_ns),
        );
    }
    if odometry.readings > 0 {
        let _ = writeln!(
            text,
            "  {} of {} with a pose",
            odometry.readings_with_pose,
            counted(odometry.readings, "reading")
        );
    }
    text
}

/// Stamps of ranges and odometry.
fn clocks(facts: &Facts) -> String {
    type OfRole<'a> = (&'a str, Vec<&'a ChannelFacts>);
    let of_role = |role| {
        let used = |c: &&ChannelFacts| c.used && c.role == Some(role);
        (role, facts.channels.iter().filter(used).collect())
    };
    let roles: Vec<OfRole<'_>> = ["range", "odometry"].map(of_role).into();
    let sum = |(_, channels): &OfRole<'_>, of: fn(&ChannelFacts) -> u64| {
        channels.iter().map(|c| of(c)).sum::<u64>().to_string()
    };
    let milliseconds = |delay: Option<f64>| optional(delay.map(|delay| delay * 1e3), 1);
    let mut text = listed::<OfRole<'_>>(
        1,
        &[
            ("", &|(role, _)| (*role).to_owned()),
            ("delay ms", &|(_, channels)| {
                let delays = channels.iter().filter_map(|c| c.median_delay);
                let mut delays: Vec<f64> = delays.collect();
                delays.sort_by(f64::total_cmp);
                milliseconds(median(&delays))
            }),
            ("largest", &|(_, channels)| {
                let delays = channels.iter().filter_map(|c| c.extreme_delay);
                milliseconds(delays.max_by(|a, b| a.abs().total_cmp(&b.abs())))
            }),
            ("no stamp", &|of_role| sum(of_role, |c| c.unstamped)),
            ("backward", &|of_role| sum(of_role, |c| c.backward_stamps)),
            ("twice", &|of_role| sum(of_role, |c| c.repeated_stamps)),
            ("out of order", &|of_role| sum(of_role, |c| c.out_of_order)),
        ],
        roles.iter().filter(|(_, channels)| !channels.is_empty()),
    );
    text.push_str("  delay: from a message's stamp to its recording\n");
    text
}

/// What is off by the ranges, tried.
fn causes(causes: &[CauseTold], stretch: Option<&Stretch>) -> String {
    let mut table = listed_below();
    for (place, cause) in causes.iter().enumerate() {
        let text = shortened(&one_line(&cause.text), LONGEST_NAME, LONGEST_PART);
        table.add_row([(place + 1).to_string(), text]);
    }
    if let Some(stretch) = stretch {
        let text = format!("{} {}", stretch.arcs, stretch.in_words());
        table.add_row(["stretch".to_owned(), text]);
    }
    if causes.is_empty() {
        table.add_row(["none", &format!("found among: {LOOKED_AT}")]);
    }
    rendered(&table)
}

fn listed_below() -> Table {
    let mut table = table(&["", ""], 2);
    if let Some(column) = table.column_mut(0) {
        column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(11)));
    }
    table
}

/// Without the line of its empty heads.
fn rendered(table: &Table) -> String {
    render(table).trim_start_matches('\n').to_owned()
}

fn findings(findings: &[Finding]) -> String {
    if findings.is_empty() {
        return "  nothing in the messages\n".to_owned();
    }
    let mut table = listed_below();
    for finding in findings {
        let weight = match finding.weight {
            Weight::Blocking => "BLOCKING",
            Weight::Serious => "serious",
            Weight::Notable => "notable",
        };
        let parts = [
            ("", &finding.what),
            ("effect: ", &finding.effect),
            ("to do: ", &finding.mend),
        ];
        let parts = parts.into_iter().filter(|(_, part)| !part.is_empty());
        let lines = parts.map(|(name, part)| {
            let part = shortened(&one_line(part), LONGEST_NAME, LONGEST_PART);
            format!("{name}{part}")
        });
        let lines: Vec<String> = lines.collect();
        table.add_row([weight.to_owned(), lines.join("\n")]);
    }
    rendered(&table)
}
