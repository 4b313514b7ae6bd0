//! What speaks for the label of every arc and against it, as numbers and words beside the arcs, so
//! that selecting one shows them. Named as in the trace.
//!
//! All is known of an arc only when its run has closed, frames after it was drawn: these are rows of
//! their own, at the entity and the moment of the arcs, an instance for each arc in their order.

use std::collections::{BTreeMap, VecDeque};
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
use crate::core::tmam::triple::Evidence;

/// What is known of an arc of the sonar with this name.
struct Known {
    sensor: String,
    judgement: ArcReport,
}

impl Known {
    fn evidence(&self, of: fn(&Evidence) -> Option<f64>) -> Option<f64> {
        self.judgement.verdict.evidence.as_ref().and_then(of)
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
        let suspects = arcs.iter().map(|arc| Some(arc.judgement.is_suspect()));
        [
            word("sensor", |arc| Some(&arc.sensor)),
            word("label", |arc| Some(arc.judgement.verdict.label.name())),
            word("reason", |arc| {
                Some(arc.judgement.verdict.label.reason()?.name())
            }),
            number("theta_c", |arc| arc.evidence(|e| Some(e.angles.theta_c))),
            number("theta_c_sigma", |arc| arc.evidence(|e| e.spread.theta_c)),
            number("theta_i", |arc| arc.evidence(|e| Some(e.angles.theta_i))),
            number("theta_i_sigma", |arc| arc.evidence(|e| e.spread.theta_i)),
            number("margin", |arc| arc.judgement.verdict.margin),
            number("chi2_margin", |arc| arc.judgement.verdict.chi2_margin),
            word("opinion", |arc| {
                let evidence = arc.judgement.verdict.evidence.as_ref()?;
                Some(evidence.opinion.support.name())
            }),
            number("chi2_line", |arc| {
                arc.evidence(|e| Some(e.opinion.chi2_line))
            }),
            number("chi2_point", |arc| {
                arc.evidence(|e| Some(e.opinion.chi2_point))
            }),
            count("readings", |arc| {
                u32::try_from(arc.judgement.wide?.readings).ok()
            }),
            word("wide_opinion", |arc| {
                Some(arc.judgement.wide?.support.name())
            }),
            number("wide_chi2_line", |arc| Some(arc.judgement.wide?.chi2_line)),
            number("wide_chi2_point", |arc| {
                Some(arc.judgement.wide?.chi2_point)
            }),
            word("map_opinion", |arc| Some(arc.judgement.map?.support.name())),
            count("feature", |arc| Some(arc.judgement.run?.extraction)),
            word("run_opinion", |arc| {
                Some(arc.judgement.run?.opinion.support.name())
            }),
            number("run_chi2_line", |arc| {
                Some(arc.judgement.run?.opinion.chi2_line)
            }),
            number("run_chi2_point", |arc| {
                Some(arc.judgement.run?.opinion.chi2_point)
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
    waiting: VecDeque<(Moment, Vec<ArcId>)>,
    judged: BTreeMap<ArcId, ArcReport>,
    table: Table<Known>,
}

impl EvidenceTable {
    /// An empty table for these sonars.
    pub fn new(sonars: &[Sonar]) -> Self {
        Self {
            sonars: sonars.iter().map(|sonar| sonar.name.clone()).collect(),
            waiting: VecDeque::new(),
            judged: BTreeMap::new(),
            table: Table::new(ARCS),
        }
    }

    /// Adds a frame that is drawn, with its arcs.
    pub fn await_frame(&mut self, at: Moment, arcs: Vec<ArcId>) {
        self.waiting.push_back((at, arcs));
    }

    /// Takes in what is known of arcs of such frames, and writes the frames of which all is known.
    pub fn push<'j, W: Write>(
        &mut self,
        judgements: impl Iterator<Item = &'j ArcReport>,
        lines: Timelines,
        out: &mut RrdWriter<W>,
    ) -> Result<(), Error> {
        self.judged.extend(judgements.map(|j| (j.arc.id, *j)));
        while let Some((at, arcs)) = self.waiting.pop_front() {
            if !arcs.iter().all(|arc| self.judged.contains_key(arc)) {
                self.waiting.push_front((at, arcs));
                break;
            }
            let known: Vec<Known> = arcs
                .iter()
                .filter_map(|arc| {
                    let judgement = self.judged.remove(arc)?;
                    let sensor = self.sonars.get(arc.sonar.index()).cloned();
                    let sensor = sensor.unwrap_or_default();
                    Some(Known { sensor, judgement })
                })
                .collect();
            self.table.push(at, known, lines, out)?;
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
