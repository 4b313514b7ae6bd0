//! How a golden file looks: one line per feature and per sonar, so that a changed wall is one
//! changed line in a review; numbers without exponents.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::{Formatter, PrettyFormatter};

/// What lies deeper than this stands on one line.
const OPEN_LEVELS: usize = 3;

/// The file's text, with one newline at its end.
///
/// # Errors
/// When a value cannot be JSON.
pub fn render(value: &impl Serialize) -> Result<Vec<u8>, serde_json::Error> {
    let mut out = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut out, Layout::default());
    value.serialize(&mut serializer)?;
    out.push(b'\n');
    Ok(out)
}

#[derive(Default)]
struct Layout {
    depth: usize,
    pretty: PrettyFormatter<'static>,
}

impl Layout {
    fn open(&self) -> bool {
        self.depth <= OPEN_LEVELS
    }

    fn separate<W: ?Sized + Write>(&self, out: &mut W, first: bool) -> io::Result<()> {
        if first { Ok(()) } else { out.write_all(b", ") }
    }
}

impl Formatter for Layout {
    fn write_f64<W: ?Sized + Write>(&mut self, out: &mut W, value: f64) -> io::Result<()> {
        out.write_all(decimal(value).as_bytes())
    }

    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth += 1;
        if self.open() {
            self.pretty.begin_array(out)
        } else {
            out.write_all(b"[")
        }
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        let open = self.open();
        self.depth -= 1;
        if open {
            self.pretty.end_array(out)
        } else {
            out.write_all(b"]")
        }
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        if self.open() {
            self.pretty.begin_array_value(out, first)
        } else {
            self.separate(out, first)
        }
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if self.open() {
            self.pretty.end_array_value(out)
        } else {
            Ok(())
        }
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.depth += 1;
        if self.open() {
            self.pretty.begin_object(out)
        } else {
            out.write_all(b"{")
        }
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        let open = self.open();
        self.depth -= 1;
        if open {
            self.pretty.end_object(out)
        } else {
            out.write_all(b"}")
        }
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        if self.open() {
            self.pretty.begin_object_key(out, first)
        } else {
            self.separate(out, first)
        }
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        out.write_all(b": ")
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        if self.open() {
            self.pretty.end_object_value(out)
        } else {
            Ok(())
        }
    }
}

/// A number without exponent, and with a decimal point.
fn decimal(value: f64) -> String {
    let text = value.to_string();
    if text.contains('.') {
        text
    } else {
        format!("{text}.0")
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
