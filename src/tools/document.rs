//! JSON documents: what stands at their head, and how they look where people review them.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::Formatter;

use crate::core::tool::Tool;

#[derive(Serialize)]
struct Document<'a, T> {
    schema: &'static str,
    tool: Tool,
    #[serde(flatten)]
    content: &'a T,
}

/// Writes a document, pretty and with a newline at its end.
///
/// # Errors
/// When `out` cannot be written to.
pub fn write<T: Serialize>(
    out: &mut dyn Write,
    schema: &'static str,
    content: &T,
) -> io::Result<()> {
    let document = Document {
        schema,
        tool: Tool::THIS,
        content,
    };
    serde_json::to_writer_pretty(&mut *out, &document)?;
    out.write_all(b"\n")
}

/// What lies deeper than this stands on one line.
const OPEN_LEVELS: usize = 3;

/// The text of a golden file, with one newline at its end: one line per feature and per sonar, so that a
/// changed wall is one changed line in a review; numbers without exponents.
///
/// # Errors
/// When a value cannot be JSON.
pub fn render(value: &impl Serialize) -> Result<Vec<u8>, serde_json::Error> {
    let mut out = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut out, ReviewLayout::default());
    value.serialize(&mut serializer)?;
    out.push(b'\n');
    Ok(out)
}

/// A value on one line, as it stands in such a text.
///
/// # Errors
/// When it cannot be JSON.
pub fn row(value: &impl Serialize) -> Result<String, serde_json::Error> {
    let mut out = Vec::new();
    let layout = ReviewLayout {
        depth: OPEN_LEVELS,
        is_empty: false,
    };
    value.serialize(&mut Serializer::with_formatter(&mut out, layout))?;
    Ok(String::from_utf8_lossy(&out).into_owned())
}

#[derive(Default)]
struct ReviewLayout {
    depth: usize,
    is_empty: bool,
}

impl ReviewLayout {
    fn open<W: ?Sized + Write>(&mut self, out: &mut W, bracket: &[u8]) -> io::Result<()> {
        (self.depth, self.is_empty) = (self.depth + 1, true);
        out.write_all(bracket)
    }

    fn close<W: ?Sized + Write>(&mut self, out: &mut W, bracket: &[u8]) -> io::Result<()> {
        let is_open = self.depth <= OPEN_LEVELS && !self.is_empty;
        (self.depth, self.is_empty) = (self.depth - 1, false);
        if is_open {
            self.new_line(out)?;
        }
        out.write_all(bracket)
    }

    fn separate<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.is_empty = false;
        match (self.depth <= OPEN_LEVELS, first) {
            (true, true) => self.new_line(out),
            (true, false) => out.write_all(b",").and_then(|()| self.new_line(out)),
            (false, true) => Ok(()),
            (false, false) => out.write_all(b", "),
        }
    }

    fn new_line<W: ?Sized + Write>(&self, out: &mut W) -> io::Result<()> {
        write!(out, "\n{:1$}", "", 2 * self.depth)
    }
}

impl Formatter for ReviewLayout {
    fn write_f64<W: ?Sized + Write>(&mut self, out: &mut W, value: f64) -> io::Result<()> {
        let text = value.to_string();
        let point = if text.contains('.') { "" } else { ".0" };
        write!(out, "{text}{point}")
    }

    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.open(out, b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.close(out, b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.separate(out, first)
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.open(out, b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.close(out, b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.separate(out, first)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        out.write_all(b": ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn features_stand_on_one_line_and_numbers_have_no_exponent() {
        let value = serde_json::json!({
            "map": {"lines": [{"rho": 2.0, "mid": [0.000001, -3.25]}, {"rho": 1e-5}], "points": []}
        });
        let text = String::from_utf8(render(&value).unwrap()).unwrap();
        let expected = "{\n  \"map\": {\n    \"lines\": [\n      {\"mid\": [0.000001, -3.25], \"rho\": 2.0},\n      \
                        {\"rho\": 0.00001}\n    ],\n    \"points\": []\n  }\n}\n";
        assert_eq!(text, expected);
        assert_eq!(
            serde_json::from_str::<serde_json::Value>(&text).unwrap(),
            value
        );
    }
}
