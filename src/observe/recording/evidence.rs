//! What speaks for the label of every arc and against it, as numbers and words beside the arcs, so
//! that selecting one shows them. Named as in the trace.
//!
//! All is known of an arc only at the end of the log, after it was drawn: these are rows of their own,
//! at the entity and the moment of the arcs, an instance for each arc in their order.

use std::io::Write;
use std::sync::Arc as Shared;

use rerun::external::arrow::array::{
    ArrayRef, BooleanArray, Float32Array, StringArray, UInt32Array,
};
use rerun::{
    ArchetypeName, ComponentDescriptor, ComponentIdentifier, SerializationResult,
    SerializedComponentBatch, SerializedComponentColumn,
};

use super::Error;
use super::arcs::ARCS;
use super::encode::RrdWriter;
use super::table::{Instance, Moment, Table, Timelines};
use crate::core::event::Sonar;
use crate::core::rounding::rounded;
use crate::core::tmam::arc::ArcId;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::TripleTest;

/// What is known of an arc of the sonar with this name.
struct Known {
    sensor: String,
    report: ArcReport,
}

impl Known {
    fn triple(&self, of: fn(&TripleTest) -> Option<f64>) -> Option<f64> {
        self.report.triple.as_ref().and_then(of)
    }
}

impl Instance for Known {
    fn columns(
        arcs: Vec<Self>,
        lengths: &[usize],
    ) -> SerializationResult<Vec<SerializedComponentColumn>> {
        let column = |name: &str, array: ArrayRef| {
            SerializedComponentBatch::new(array, descriptor(name))
                .partitioned(lengths.iter().copied())
        };
        let word = |name, of: fn(&Known) -> Option<&str>| {
            column(
                name,
                Shared::new(arcs.iter().map(of).collect::<StringArray>()),
            )
        };
        let number = |name, of: fn(&Known) -> Option<f64>| {
            // Infinite where the beams have no place for such a feature: no number either.
            let numbers = arcs.iter().map(|arc| of(arc).filter(|x| x.is_finite()));
            let numbers = numbers.map(|number| number.map(|x| rounded(x) as f32));
            column(name, Shared::new(numbers.collect::<Float32Array>()))
        };
        let count = |name, of: fn(&Known) -> Option<u32>| {
            column(
                name,
                Shared::new(arcs.iter().map(of).collect::<UInt32Array>()),
            )
        };
        let suspects = arcs.iter().map(|arc| Some(arc.report.is_suspect()));
        [
            word("sensor", |arc| Some(&arc.sensor)),
            word("label", |arc| Some(arc.report.label.name())),
            word("reason", |arc| Some(arc.report.label.reason()?.name())),
            number("theta_c", |arc| arc.triple(|e| Some(e.angles.theta_c))),
            number("theta_c_sigma", |arc| arc.triple(|e| e.spread.theta_c)),
            number("theta_i", |arc| arc.triple(|e| Some(e.angles.theta_i))),
            number("theta_i_sigma", |arc| arc.triple(|e| e.spread.theta_i)),
            number("margin", |arc| arc.report.margin),
            number("chi2_margin", |arc| arc.report.chi2_margin),
            word("opinion", |arc| {
                let triple = arc.report.triple.as_ref()?;
                Some(triple.test.support.name())
            }),
            number("chi2_line", |arc| arc.triple(|e| Some(e.test.chi2_line))),
            number("chi2_point", |arc| arc.triple(|e| Some(e.test.chi2_point))),
            count("readings", |arc| {
                u32::try_from(arc.report.window()?.readings).ok()
            }),
            word("wide_opinion", |arc| {
                Some(arc.report.window()?.support.name())
            }),
            number("wide_chi2_line", |arc| Some(arc.report.window()?.chi2_line)),
            number("wide_chi2_point", |arc| {
                Some(arc.report.window()?.chi2_point)
            }),
            word("map_opinion", |arc| Some(arc.report.map?.support.name())),
            count("feature", |arc| Some(arc.report.run?.extraction)),
            word("run_opinion", |arc| {
                Some(arc.report.run?.test.support.name())
            }),
            number("run_chi2_line", |arc| Some(arc.report.run?.test.chi2_line)),
            number("run_chi2_point", |arc| {
                Some(arc.report.run?.test.chi2_point)
            }),
            column("suspect", Shared::new(suspects.collect::<BooleanArray>())),
        ]
        .into_iter()
        .collect()
    }
}

/// What a piece of evidence is called.
fn descriptor(name: &str) -> ComponentDescriptor {
    let archetype = ArchetypeName::from("tmam.Evidence");
    ComponentDescriptor {
        archetype: Some(archetype),
        component: ComponentIdentifier::from_archetype_field(archetype, name),
        component_type: None,
    }
}

/// The evidence of every arc.
pub struct EvidenceTable {
    sonars: Vec<String>,
    frames: Vec<(Moment, Vec<ArcId>)>,
    table: Table<Known>,
}

impl EvidenceTable {
    /// An empty table for these sonars.
    pub fn new(sonars: &[Sonar]) -> Self {
        Self {
            sonars: sonars.iter().map(|sonar| sonar.name.clone()).collect(),
            frames: Vec::new(),
            table: Table::new(ARCS),
        }
    }

    /// Adds a frame that is drawn, with its arcs.
    pub fn add_frame(&mut self, at: Moment, arcs: Vec<ArcId>) {
        self.frames.push((at, arcs));
    }

    /// Writes the frames, once there is a report on every arc.
    pub fn push<W: Write>(
        &mut self,
        reports: &[ArcReport],
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        if reports.is_empty() {
            return Ok(());
        }
        for (at, arcs) in std::mem::take(&mut self.frames) {
            let known = arcs.iter().filter_map(|arc| {
                let place = reports.binary_search_by_key(arc, |report| report.arc.id);
                let sensor = self.sonars.get(arc.sonar.index()).cloned();
                Some(Known {
                    sensor: sensor.unwrap_or_default(),
                    report: reports.get(place.ok()?)?.clone(),
                })
            });
            self.table.push(at, known.collect::<Vec<_>>(), lines, out)?;
        }
        Ok(())
    }

    /// Writes what waits.
    pub fn flush<W: Write>(
        &mut self,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.table.flush(lines, out)
    }
}

#[cfg(test)]
mod tests;
