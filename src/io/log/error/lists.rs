//! Lists in what is said, as long as anyone reads them.

use crate::core::legible::one_line;

/// A line for every item, as far as anyone reads them.
pub fn itemised(items: &[String]) -> String {
    const SHOWN: usize = 10;
    let mut text: String = items
        .iter()
        .take(SHOWN)
        .map(|item| format!("\n  - {}", one_line(item)))
        .collect();
    if let more @ 1.. = items.len().saturating_sub(SHOWN) {
        text.push_str(&format!(
            "\n  - and {more} more; `tmam info --json` lists all of them"
        ));
    }
    text
}

pub(super) fn because(asked: &[String]) -> String {
    if asked.is_empty() {
        String::new()
    } else {
        format!(" on the topics asked for ({})", asked.join(", "))
    }
}

/// `base_link` in `odom`, a line for each.
pub(super) fn moves(edges: &[(String, String)]) -> String {
    let named = edges
        .iter()
        .map(|(parent, child)| format!("`{child}` in `{parent}`"));
    itemised(&named.collect::<Vec<_>>())
}

/// What was not taken for odometry.
pub(super) fn carried(edges: &[(String, String)]) -> String {
    if edges.is_empty() {
        return String::new();
    }
    let world = edges.first().map_or("odom", |(_, child)| child);
    format!(
        "\nTransforms that move, and were not taken for odometry because the sonars' frame carries them:{}\nIf one \
         of them is what the robot moves in, name it, and it is taken the other way round: input.world_frame = {}",
        moves(edges),
        one_line(&toml::Value::from(world).to_string())
    )
}

/// A line for each of some items, as far as anyone reads them.
pub(super) fn lines(head: &str, items: &[String]) -> String {
    match items {
        [] => format!("{head} nothing."),
        _ => format!("{head}:{}", itemised(items)),
    }
}

pub(super) fn list(head: &str, items: &[String]) -> String {
    const SHOWN: usize = 16;
    let more = items.len().saturating_sub(SHOWN);
    let tail = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    match items {
        [] => format!("{head} nothing."),
        _ => format!(
            "{head} {}{tail}.",
            items
                .iter()
                .take(SHOWN)
                .cloned()
                .collect::<Vec<_>>()
                .join(", ")
        ),
    }
}
