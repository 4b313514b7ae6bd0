//! The tables of a log's facts, for a person.

use std::fmt::Write as _;

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

use super::Info;
use super::channels::ChannelFacts;
use super::motion::OdometryFacts;
use super::sonars::{MountFacts, SonarFacts};
use super::statistics::{fraction, median, seconds};
use crate::core::legible::{one_line, shortened};
use crate::core::rounding::fixed;
use crate::core::wording::counted;

/// Widest line, columns.
const WIDTH: u16 = 100;
/// Longest name in a table, characters: wrapping costs more than its length.
pub const LONGEST_NAME: usize = 100;

/// Widest name beside all that is told of echoes, characters.
const ECHOES_NAME: usize = 20;

/// A table with a head; the first `left` columns are text, the others numbers.
pub fn table(head: &[&str], left: usize) -> Table {
    let mut table = Table::new();
    table
        .load_preset(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(WIDTH)
        .set_header(head);
    for (index, column) in table.column_iter_mut().enumerate() {
        // Two blanks before every column but none behind it.
        column.set_padding((2, 0));
        if index >= left {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// A name from a log as a cell shows it.
fn name(name: &str) -> String {
    shortened(&one_line(name), LONGEST_NAME, LONGEST_NAME)
}

/// Names that are too long for a column without what all of them begin with, if that is enough; else as
/// they are, which the column wraps. Another table has them whole.
fn fitting(names: Vec<String>, room: usize) -> Vec<String> {
    let length = |name: &str| name.chars().count();
    if names.len() < 2 || names.iter().all(|name| length(name) <= room) {
        return names;
    }
    let first: Vec<char> = names
        .first()
        .map(|n| n.chars().collect())
        .unwrap_or_default();
    let common = names.iter().fold(first.len(), |common, name| {
        let same = name.chars().zip(&first).take_while(|(a, b)| a == *b);
        common.min(same.count())
    });
    let longest = names.iter().map(|name| length(name)).max().unwrap_or(0);
    // As much as has to go, and no more.
    let cut = (longest + 3).saturating_sub(room);
    if cut > common {
        return names;
    }
    let shown = names
        .iter()
        .map(|name| name.chars().skip(cut).collect::<String>());
    shown.map(|rest| format!("...{rest}")).collect()
}

/// A table as text, without blanks at the ends of lines.
pub fn render(table: &Table) -> String {
    table
        .to_string()
        .lines()
        .fold(String::new(), |mut text, line| {
            text.push_str(line.trim_end());
            text.push('\n');
            text
        })
}

/// What each channel is.
pub fn channels(info: &Info) -> String {
    let mut table = table(
        &[
            "topic", "type", "encoding", "read as", "messages", "Hz", "from s", "to s",
        ],
        4,
    );
    let start = info.channels.iter().map(|c| c.first_ns).min().unwrap_or(0);
    for channel in &info.channels {
        table.add_row([
            name(&channel.topic),
            if channel.type_name.is_empty() {
                "(none)".to_owned()
            } else {
                name(&channel.type_name)
            },
            name(&channel.encoding),
            read_as(channel).to_owned(),
            channel.messages.to_string(),
            optional(channel.rate, 1),
            format!("{:.1}", seconds(start, channel.first_ns)),
            format!("{:.1}", seconds(start, channel.last_ns)),
        ]);
    }
    render(&table)
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
pub fn sonars(sonars: &[SonarFacts]) -> String {
    let mut table = table(
        &[
            "sonar", "topic", "x m", "y m", "yaw deg", "beam deg", "min m", "max m", "readings",
            "Hz",
        ],
        2,
    );
    for sonar in sonars {
        let mount = |of: fn(&MountFacts) -> f64, decimals| {
            sonar
                .mount
                .as_ref()
                .map_or_else(|| "?".to_owned(), |m| fixed(of(m), decimals))
        };
        let beam = sonar.beam_width.map(f64::to_degrees);
        table.add_row([
            name(&sonar.name),
            name(&sonar.topic),
            mount(|m| m.x, 3),
            mount(|m| m.y, 3),
            mount(|m| m.yaw.to_degrees(), 1),
            beam.map_or_else(|| "?".to_owned(), |beam| fixed(beam, 1)),
            fixed(sonar.min_range, 2),
            fixed(sonar.max_range, 2),
            sonar.readings.to_string(),
            optional(sonar.rate, 1),
        ]);
    }
    render(&table)
}

/// What came back to each sonar.
pub fn echoes(sonars: &[SonarFacts]) -> String {
    let mut table = table(
        &[
            "sonar",
            "echo\n%",
            "none\n%",
            "invalid\n%",
            "shortest\nm",
            "median\nm",
            "longest\nm",
            "step\nmm",
            "noise\nmm",
            "repeats\n%",
            "apart\nm",
        ],
        1,
    );
    let names: Vec<String> = sonars.iter().map(|sonar| name(&sonar.name)).collect();
    for (sonar, name) in sonars.iter().zip(fitting(names, ECHOES_NAME)) {
        let share = |count| format!("{:.0}", 100.0 * fraction(count, sonar.readings));
        let step = match sonar.resolution {
            Some(resolution) if resolution.quantised => fixed(resolution.step * 1e3, 1),
            Some(_) => "fine".to_owned(),
            None => "-".to_owned(),
        };
        table.add_row([
            name,
            share(sonar.echoes),
            share(sonar.no_echoes),
            share(sonar.invalid),
            optional(sonar.shortest, 2),
            optional(sonar.median, 2),
            optional(sonar.longest, 2),
            step,
            sonar
                .scatter
                .map_or_else(|| "-".to_owned(), |s| fixed(s * 1e3, 1)),
            if sonar.moved > 0 {
                format!("{:.0}", 100.0 * sonar.repeated())
            } else {
                "-".to_owned()
            },
            optional(sonar.baseline, 3),
        ]);
    }
    let mut text = render(&table);
    text.push_str(
        "  step: raster of the ranges; noise: how far they scatter along walls, standard deviation;\n  \
         repeats: the same echo again although the sensor moved;\n  \
         apart: from one reading to the next while moving\n",
    );
    text
}

/// The odometry in a few lines.
pub fn motion(info: &Info, odometry: &OdometryFacts) -> String {
    let mut text = format!(
        "  {}: {}, {} Hz, {:.1} m driven, {:.0} deg turned\n",
        name(&odometry.topic),
        counted(odometry.samples, "sample"),
        optional(odometry.rate, 1),
        odometry.distance,
        odometry.turning.to_degrees(),
    );
    if let (Some(gap), Some(jump)) = (odometry.longest_gap, odometry.largest_jump) {
        let _ = writeln!(
            text,
            "  longest time between samples {:.3} s at {} s; longest way {:.3} m at {} s",
            gap.seconds,
            fixed(seconds(info.start_ns, gap.stamp_ns), 1),
            jump.distance,
            fixed(seconds(info.start_ns, jump.stamp_ns), 1),
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
pub fn clocks(info: &Info) -> String {
    let mut table = table(
        &[
            "",
            "delay ms",
            "largest",
            "no stamp",
            "backward",
            "twice",
            "out of order",
        ],
        1,
    );
    for role in ["range", "odometry"] {
        let channels: Vec<&ChannelFacts> = info
            .channels
            .iter()
            .filter(|c| c.used && c.role == Some(role))
            .collect();
        if channels.is_empty() {
            continue;
        }
        let sum =
            |of: fn(&ChannelFacts) -> u64| channels.iter().map(|c| of(c)).sum::<u64>().to_string();
        let mut delays: Vec<f64> = channels.iter().filter_map(|c| c.median_delay).collect();
        delays.sort_by(f64::total_cmp);
        let largest = channels
            .iter()
            .filter_map(|c| c.extreme_delay)
            .max_by(|a, b| a.abs().total_cmp(&b.abs()));
        table.add_row([
            role.to_owned(),
            optional(median(&delays).map(|d| d * 1e3), 1),
            optional(largest.map(|d| d * 1e3), 1),
            sum(|c| c.unstamped),
            sum(|c| c.backward_stamps),
            sum(|c| c.repeated_stamps),
            sum(|c| c.out_of_order),
        ]);
    }
    let mut text = render(&table);
    text.push_str("  delay: from a message's stamp to its recording\n");
    text
}

fn optional(x: Option<f64>, decimals: usize) -> String {
    x.map_or_else(|| "-".to_owned(), |x| fixed(x, decimals))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_lose_what_they_share() {
        let names = |tails: &[&str]| -> Vec<String> {
            tails
                .iter()
                .map(|t| format!("robot/ultrasonic_ring{t}"))
                .collect()
        };
        let short = fitting(names(&["[0]", "[10]"]), 12);
        assert_eq!(
            short,
            ["...c_ring[0]", "...c_ring[10]"].map(|s| s.replacen("c_", "_", 1))
        );
        assert_eq!(fitting(names(&["[0]"]), 12), names(&["[0]"]));
        let different = vec!["a".repeat(20), "b".repeat(20)];
        assert_eq!(fitting(different.clone(), 12), different);
    }

    #[test]
    fn long_cells_are_wrapped_within_the_width() {
        let mut long = table(&["a", "b"], 2);
        long.add_row(["word ".repeat(60), "y".repeat(150)]);
        let text = render(&long);
        assert!(
            text.lines().all(|line| line.chars().count() <= 100),
            "{text}"
        );
    }
}
