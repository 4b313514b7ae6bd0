//! A calibration for a person: one table of what all sonars share, one of the sonars, and what is off.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::{Calibration, Row, State, Why};
use crate::core::calibrate::candidate::Estimated;
use crate::core::calibrate::parameter::{Parameter, Quantity, Whose};
use crate::core::calibrate::search::Standing;
use crate::core::event::SonarId;
use crate::core::legible::one_line;
use crate::core::rounding::fixed;
use crate::core::wording::{counted, few};
use crate::observe::causes;
use crate::tools::tables::{name, render, section, table};

/// The columns of a sonar.
const COLUMNS: [(Quantity, &str); 6] = [
    (Quantity::Yaw, "yaw deg"),
    (Quantity::X, "x cm"),
    (Quantity::Y, "y cm"),
    (Quantity::RangeScale, "scale %"),
    (Quantity::RangeOffset, "offset cm"),
    (Quantity::BeamWidth, "beam deg"),
];

/// What a log says of its configuration.
pub fn text(calibration: &Calibration<'_>) -> String {
    let standings = &calibration.search.standings;
    let [configured, mended] = standings;
    let share = |at: &Standing| fixed(100.0 * at.bits.explained_share().unwrap_or(0.0), 1);
    let bits = |at: &Standing| fixed(at.bits.per_arc().unwrap_or(0.0), 2);
    let mut text = format!(
        "{}: as configured {} % of {} are explained, in {} bits an arc\n",
        one_line(calibration.file),
        share(configured),
        counted(configured.bits.arcs, "arc"),
        bits(configured),
    );
    section(
        &mut text,
        "How far each value is from what is configured, by what the log says (+- a standard deviation); * it is off, ? the log \
         cannot tell",
        &shared(calibration),
    );
    text.push('\n');
    text.push_str(&sonars(calibration));
    text.push_str(&untold(calibration));
    text.push('\n');
    let told = causes::all(&calibration.search, calibration.events, calibration.config);
    if told.is_empty() {
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "Nothing is found to be off among: {}.",
            causes::LOOKED_AT
        );
        return text;
    }
    for (place, cause) in told.iter().enumerate() {
        let _ = writeln!(text, "off {}: {}", place + 1, cause.text);
    }
    let _ = writeln!(
        text,
        "all mended: {} % are explained, in {} bits an arc; {} tried",
        share(mended),
        bits(mended),
        counted(calibration.search.replays as u64, "replay"),
    );
    for key in calibration.keys() {
        let _ = writeln!(text, "  {}    # {}", key.setting(), key.configured);
    }
    text
}

fn cell(row: Option<&Row>) -> String {
    let Some(row) = row else {
        return String::new();
    };
    let mark = match row.state {
        State::Off => "*",
        State::CannotTell(_) => "?",
        State::AsConfigured | State::NotBorneOut => "",
    };
    match (&row.estimated, row.state) {
        (Some(estimated), State::CannotTell(_)) if estimated.deviation <= 0.0 => "?".to_owned(),
        (Some(estimated), _) => format!("{}{mark}", number(estimated)),
        (None, _) => "?".to_owned(),
    }
}

/// `+3.1+-0.3` in the unit of the column.
fn number(one: &Estimated) -> String {
    let (unit, scale) = causes::unit(one.parameter);
    let decimals = match unit {
        "ms" => 0,
        "%" => 2,
        _ => 1,
    };
    let value = fixed(one.value * scale, decimals);
    let deviation = fixed(one.deviation * scale, decimals);
    let sign = if value.starts_with('-') { "" } else { "+" };
    format!("{sign}{value}+-{deviation}")
}

fn shared(calibration: &Calibration<'_>) -> String {
    let mut shown = table(&["", "by", "", "bits an arc", "state"], 5);
    for row in &calibration.rows {
        if matches!(row.parameter, Parameter::Sonar(Whose::One(_), _)) {
            continue;
        }
        let (unit, _) = causes::unit(row.parameter);
        shown.add_row([
            causes::named(row.parameter, calibration.events),
            cell(Some(row)),
            unit.to_owned(),
            fixed(row.gain, 3),
            row.state.name().replace('-', " "),
        ]);
    }
    render(&shown)
}

fn sonars(calibration: &Calibration<'_>) -> String {
    let heads: Vec<&str> = std::iter::once("sonar")
        .chain(COLUMNS.iter().map(|(_, head)| *head))
        .collect();
    let mut shown = table(&heads, 1);
    let by: BTreeMap<Parameter, &Row> = (calibration.rows.iter())
        .map(|row| (row.parameter, row))
        .collect();
    for (place, sonar) in (0..).zip(&calibration.events.sonars) {
        let whose = Whose::One(SonarId(place));
        let cells = COLUMNS
            .iter()
            .map(|(quantity, _)| cell(by.get(&Parameter::Sonar(whose, *quantity)).copied()));
        shown.add_row(std::iter::once(name(&sonar.name)).chain(cells));
    }
    render(&shown)
}

/// Why the log cannot tell what it cannot.
fn untold(calibration: &Calibration<'_>) -> String {
    let mut reasons: BTreeMap<Why, Vec<String>> = BTreeMap::new();
    for row in &calibration.rows {
        if let State::CannotTell(why) = row.state {
            let named = causes::named(row.parameter, calibration.events);
            reasons.entry(why).or_default().push(named);
        }
    }
    let reasons = reasons.into_iter();
    reasons
        .map(|(why, named)| format!("? {}: {}\n", few(&named), why.text()))
        .collect()
}
