//! The windows that the rule looked at around an arc, and why it looked no further.

use std::fmt::Write as _;

use serde::Serialize;

use super::history::chi2;
use super::sequences::SonarEntry;
use crate::core::config::TestBounds;
use crate::core::rounding::number;
use crate::core::tmam::hypothesis::{HypothesisTest, Support};
use crate::core::tmam::label::{Kind, Label, Reason};
use crate::core::tmam::report::ArcReport;
use crate::tools::tables::listed;

/// The readings `k-m ..= k+m` around an arc, and what they support.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Window {
    /// Readings to either side: m.
    pub half_width: usize,
    pub first_frame: u32,
    pub last_frame: u32,
    /// Squares that remain of the best line.
    #[serde(serialize_with = "number")]
    pub chi2_line: f64,
    #[serde(serialize_with = "number")]
    pub chi2_point: f64,
    /// A model explains the readings when its chi2 is below this.
    #[serde(serialize_with = "number")]
    pub gate: f64,
    pub support: Support,
    /// What they decide, if they do.
    pub decides: Option<Kind>,
}

impl Window {
    /// The windows that were looked at around the arc at `place` of a sequence.
    pub fn looked_at(
        tests: &[HypothesisTest],
        sequence: &[SonarEntry<'_>],
        place: usize,
        decisive: f64,
    ) -> Vec<Self> {
        let frame = |at: usize| sequence.get(at).map_or(0, |given| given.frame);
        let windows = (1..).zip(tests);
        windows
            .map(|(half_width, test)| Self {
                half_width,
                first_frame: frame(place.saturating_sub(half_width)),
                last_frame: frame(place + half_width),
                chi2_line: test.chi2_line,
                chi2_point: test.chi2_point,
                gate: test.gate,
                support: test.support,
                decides: test.decided(decisive),
            })
            .collect()
    }

    fn readings(&self) -> usize {
        2 * self.half_width + 1
    }

    /// The second opinion, window by window, and why it ended.
    pub fn text(windows: &[Self], end: Option<&str>, decisive: f64) -> String {
        let mut text = listed(
            0,
            &[
                ("readings", &|w: &Self| w.readings().to_string()),
                ("frames", &|w| format!("{}-{}", w.first_frame, w.last_frame)),
                ("chi2 line", &|w| chi2(w.chi2_line)),
                ("chi2 point", &|w| chi2(w.chi2_point)),
                ("gate", &|w| chi2(w.gate)),
                ("supports", &|w| w.support.name().to_owned()),
            ],
            windows,
        );
        let Some(last) = windows.last() else {
            return text;
        };
        let readings = last.readings();
        let lead = (last.chi2_line - last.chi2_point).abs();
        let _ = match (end, last.decides.map(Kind::name)) {
            (_, Some(kind)) if lead.is_finite() => writeln!(
                text,
                "  {readings} readings decide: a {kind}, ahead by {lead:.2} (opinion.decisive is {decisive})"
            ),
            (_, Some(kind)) => writeln!(
                text,
                "  {readings} readings decide: a {kind}; the beams have no place for the other"
            ),
            (Some("neither"), _) => writeln!(
                text,
                "  {readings} readings fit neither a line nor a point: no wider window is asked"
            ),
            (Some("max-half-width"), _) => writeln!(
                text,
                "  undecided within opinion.max_half_width: a lead of {lead:.2}, {decisive} is needed"
            ),
            _ => writeln!(
                text,
                "  undecided, and the sequence has no more readings: a lead of {lead:.2}, {decisive} is \
                 needed"
            ),
        };
        text
    }
}

/// Why no wider window was looked at: `decided`, `neither`, `max-half-width` or `no-more-readings`.
pub fn end(report: &ArcReport, bounds: &TestBounds) -> Option<&'static str> {
    let last = report.window()?;
    Some(match last.label(bounds.decisive) {
        Label::Contact | Label::Intersection => "decided",
        Label::Unidentified(Reason::Neither) => "neither",
        Label::Unidentified(_) if report.windows.len() == bounds.max_half_width => "max-half-width",
        Label::Unidentified(_) => "no-more-readings",
    })
}
