//! Tables for a person, within 100 columns.

use std::fmt::Write as _;

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table, Width, presets};

use crate::core::legible::{one_line, shortened};
use crate::core::rounding::fixed;

/// Widest line, columns.
const WIDTH: u16 = 100;
/// Longest name in a table, characters: wrapping costs more than its length.
pub const LONGEST_NAME: usize = 100;

/// Words up to this stay whole, even where the table then is wider, characters.
const LONGEST_WORD: usize = 48;
/// Blanks before each column.
const PADDING: u16 = 2;

/// The head of a column and its cell for each row.
pub type TableColumn<'a, T> = (&'a str, &'a dyn Fn(&T) -> String);

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
        column.set_padding((PADDING, 0));
        if index >= left {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// A table as text, without blanks at the ends of lines.
pub fn render(table: &Table) -> String {
    let table = table.to_string();
    let lines = table.lines();
    lines.map(|line| format!("{}\n", line.trim_end())).collect()
}

/// Rows as a table; the first `left` columns are text, the others numbers.
pub fn listed<'r, T: 'r>(
    left: usize,
    columns: &[TableColumn<'_, T>],
    rows: impl IntoIterator<Item = &'r T>,
) -> String {
    let head: Vec<&str> = columns.iter().map(|(head, _)| *head).collect();
    let mut table = table(&head, left);
    let longest_word = |text: &str| {
        let words = text.split_whitespace();
        words.map(|word| word.chars().count()).max().unwrap_or(0)
    };
    let mut longest: Vec<usize> = head.iter().map(|head| longest_word(head)).collect();
    for row in rows {
        let cells: Vec<String> = columns.iter().map(|(_, cell)| cell(row)).collect();
        for (longest, cell) in longest.iter_mut().zip(&cells) {
            *longest = longest_word(cell).max(*longest);
        }
        table.add_row(cells);
    }
    let widths = table.column_max_content_widths();
    let natural = widths
        .iter()
        .map(|width| u32::from(*width) + u32::from(PADDING));
    let fits = natural.sum::<u32>() <= u32::from(WIDTH);
    if fits {
        return render(&table);
    }
    // A name or a key that goes on in the next line is none that can be copied.
    for (column, longest) in table.column_iter_mut().zip(longest) {
        let width = u16::try_from(longest.min(LONGEST_WORD)).unwrap_or(u16::MAX);
        column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(
            width + PADDING,
        )));
    }
    render(&table)
}

/// Adds a part of a text under its title.
pub fn section(text: &mut String, title: &str, body: &str) {
    // Writing into a string cannot fail.
    let _ = write!(text, "\n{title}\n{body}");
}

/// A name from a log as a cell shows it.
pub fn name(name: &str) -> String {
    shortened(&one_line(name), LONGEST_NAME, LONGEST_NAME)
}

/// A number with so many decimals; `-` where there is none.
pub fn optional(x: Option<f64>, decimals: usize) -> String {
    x.map_or_else(|| "-".to_owned(), |x| fixed(x, decimals))
}

/// A share in per cent; `-` of nothing.
pub fn percent(share: Option<f64>) -> String {
    optional(share.map(|share| 100.0 * share), 1)
}

/// Names that are too long for a column without what all of them begin with, if that is enough; else as
/// they are, which the column wraps. Another table has them whole.
pub fn fitting(names: Vec<String>, room: usize) -> Vec<String> {
    let length = |name: &String| name.chars().count();
    let longest = names.iter().map(length).max().unwrap_or(0);
    let (Some(first), true) = (names.first(), names.len() > 1 && longest > room) else {
        return names;
    };
    let common = names.iter().fold(usize::MAX, |common, name| {
        let same = name.chars().zip(first.chars()).take_while(|(a, b)| a == b);
        common.min(same.count())
    });
    // As much as has to go, and no more.
    let cut = (longest + 3).saturating_sub(room);
    if cut > common {
        return names;
    }
    let rest = |name: &String| name.chars().skip(cut).collect::<String>();
    names
        .iter()
        .map(|name| format!("...{}", rest(name)))
        .collect()
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
    fn a_word_is_whole_where_it_is_not_very_long() {
        let words = ["sonar.sonar_04.yaw=97.69", "a_drive_of_this_morning"];
        let filler: TableColumn<'_, &str> = ("n", &|_| "12345678".to_owned());
        let word: TableColumn<'_, &str> = ("word", &|word| (*word).to_owned());
        let text = listed(
            2,
            &[
                word, filler, filler, filler, filler, filler, filler, filler, word,
            ],
            &words,
        );
        for whole in words {
            assert_eq!(text.matches(whole).count(), 2, "{text}");
        }
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
