//! The windows that the rule looked at around an arc, and why it looked no further.

use serde::Serialize;

use super::history::chi2;
use super::sequences::SonarEntry;
use crate::core::config::TestBounds;
use crate::core::rounding::{number, optional};
use crate::core::tmam::circle::FEWEST;
use crate::core::tmam::hypothesis::{HypothesisTest, Support};
use crate::core::tmam::label::{Kind, Label, Reason};
use crate::core::tmam::report::ArcReport;
use crate::tools::tables::{TableColumn, listed};

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
    /// Where circles are asked for; a circle explains the readings when it is below `gate_circle`.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional")]
    pub chi2_circle: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "optional")]
    pub gate_circle: Option<f64>,
    /// A model explains the readings when its chi2 is below this.
    #[serde(serialize_with = "number")]
    pub gate: f64,
    pub support: Support,
    /// What they decide, if they do.
    pub decides: Option<Kind>,
}

impl Window {
    /// The windows with these tests around the arc at `place` of a sequence, narrowest first.
    pub fn all(
        tests: &[HypothesisTest],
        sequence: &[SonarEntry<'_>],
        place: usize,
        decisive: f64,
    ) -> Vec<Self> {
        let frame = |at: usize| sequence.get(at).map_or(0, |given| given.frame);
        let windows = (1..).zip(tests);
        windows
            .map(|(half_width, test)| {
                let frames = [place.saturating_sub(half_width), place + half_width].map(frame);
                Self::new(half_width, test, frames, decisive)
            })
            .collect()
    }

    fn new(half_width: usize, test: &HypothesisTest, frames: [u32; 2], decisive: f64) -> Self {
        let [first_frame, last_frame] = frames;
        Self {
            half_width,
            first_frame,
            last_frame,
            chi2_line: test.chi2_line,
            chi2_point: test.chi2_point,
            chi2_circle: test.chi2_circle,
            gate_circle: test.chi2_circle.map(|_| test.gate_circle),
            gate: test.gate,
            support: test.support,
            decides: test.decided(decisive),
        }
    }

    /// What the last of the windows around an arc came to.
    pub fn decision_of(report: &ArcReport, bounds: &TestBounds) -> Option<String> {
        let (test, frame) = (report.window.as_ref()?, report.arc.id.frame);
        let last = Self::new(test.half_width(), test, [frame; 2], bounds.decisive);
        Self::decision(&[last], end(report, bounds), bounds.decisive)
    }

    fn readings(&self) -> usize {
        2 * self.half_width + 1
    }

    /// A number of the circle; of so few readings that one always fits them there is none.
    fn of_circle(&self, number: Option<f64>) -> String {
        let number = number.filter(|_| self.readings() >= FEWEST);
        number.map_or_else(|| "-".to_owned(), chi2)
    }

    /// The tests, window by window.
    pub fn text(windows: &[Self]) -> String {
        let mut columns: Vec<TableColumn<'_, Self>> = vec![
            ("readings", &|w: &Self| w.readings().to_string()),
            ("frames", &|w| format!("{}-{}", w.first_frame, w.last_frame)),
            ("chi2 line", &|w| chi2(w.chi2_line)),
            ("chi2 point", &|w| chi2(w.chi2_point)),
            ("gate", &|w| chi2(w.gate)),
            ("supports", &|w| w.support.name().to_owned()),
        ];
        if windows.iter().any(|window| window.chi2_circle.is_some()) {
            let circle: [TableColumn<'_, Self>; 2] = [
                ("circle", &|w| w.of_circle(w.chi2_circle)),
                ("gate", &|w| w.of_circle(w.gate_circle)),
            ];
            columns.splice(5..5, circle);
        }
        listed(0, &columns, windows)
    }

    /// What the widest window came to, and why none is wider.
    pub fn decision(windows: &[Self], end: Option<&str>, decisive: f64) -> Option<String> {
        let last = windows.last()?;
        let [line, point, gate] = [last.chi2_line, last.chi2_point, last.gate].map(chi2);
        let lead = (last.chi2_line - last.chi2_point).abs();
        let wider = match end {
            Some("max-half-width") => "opinion.max_half_width ends it",
            _ => "there are no more",
        };
        let readings = last.readings();
        let both =
            format!("line chi2 {line}, point chi2 {point}, gate {gate} in {readings} readings");
        Some(match (last.support, last.decides) {
            (_, Some(Kind::Circle)) => format!(
                "{readings} readings fit a circle (chi2 {}, gate {}), and a line ({line}) and a point ({point}) \
                 worse by {decisive} or more",
                last.of_circle(last.chi2_circle),
                last.of_circle(last.gate_circle),
            ),
            (_, Some(kind)) => {
                let (other, own, against) = match kind {
                    Kind::Line => ("point", line, point),
                    Kind::Point | Kind::Circle => ("line", point, line),
                };
                let fit = format!(
                    "{readings} readings fit a {} (chi2 {own}, gate {gate})",
                    kind.name()
                );
                if lead.is_finite() {
                    format!(
                        "{fit} and no {other} ({against}): a lead of {lead:.2}, {decisive} decide"
                    )
                } else {
                    format!("{fit}; their beams have no place for a {other}")
                }
            }
            (Support::Ambiguous, None) => format!("Both still fit: {both}; {wider}"),
            (Support::Neither, None) => format!("Neither fits: {both}"),
            (Support::Line, None) if lead >= decisive => format!(
                "{readings} readings fit only a line, but best with its foot beside the beam; {wider}"
            ),
            (Support::Circle, None) => format!(
                "{readings} readings fit only a circle, but not so much better than line and point that it is \
                 decided: {both}; {wider}"
            ),
            (Support::Line | Support::Point, None) => format!(
                "{readings} readings fit only a {}, with a lead of {lead:.2} where {decisive} are needed; {wider}",
                last.support.name()
            ),
        })
    }
}

/// Why no wider window was looked at: `decided`, `neither`, `max-half-width` or `no-more-readings`.
pub fn end(report: &ArcReport, bounds: &TestBounds) -> Option<&'static str> {
    let last = report.window?;
    Some(match last.label(bounds.decisive) {
        Label::Contact | Label::Intersection | Label::Circle => "decided",
        Label::Unidentified(Reason::Neither) => "neither",
        Label::Unidentified(_) if last.half_width() == bounds.max_half_width => "max-half-width",
        Label::Unidentified(_) => "no-more-readings",
    })
}
