//! What speaks for the label of every arc and against it, as numbers and words beside the arcs, so
//! that selecting one shows them. Named as in the trace.

use std::sync::Arc as Shared;

use rerun::external::arrow::array::{
    ArrayRef, BooleanArray, Float32Array, StringArray, UInt32Array,
};
use rerun::{ArchetypeName, ComponentDescriptor, ComponentIdentifier, SerializedComponentBatch};

use crate::core::rounding::rounded;
use crate::core::tmam::hypothesis::HypothesisTest;
use crate::core::tmam::report::ArcReport;
use crate::core::tmam::triple::TripleTest;

/// What is known of an arc of the sonar with this name.
#[derive(Debug)]
pub struct Known {
    pub sensor: String,
    pub report: ArcReport,
}

impl Known {
    fn triple(&self) -> Option<&TripleTest> {
        self.report.triple.as_ref()
    }

    /// What three readings, the widest window and the whole run support.
    fn test(&self) -> Option<&HypothesisTest> {
        Some(&self.triple()?.test)
    }

    fn wide(&self) -> Option<&HypothesisTest> {
        self.report.window.as_ref()
    }

    fn run(&self) -> Option<&HypothesisTest> {
        self.report.run.as_ref()?.test.as_deref()
    }
}

/// A column for every piece of evidence.
pub fn batches(arcs: &[Known]) -> Vec<SerializedComponentBatch> {
    let column =
        |name: &str, array: ArrayRef| SerializedComponentBatch::new(array, descriptor(name));
    let word = |name, of: fn(&Known) -> Option<&str>| {
        let words: StringArray = arcs.iter().map(of).collect();
        column(name, Shared::new(words))
    };
    let number = |name, of: fn(&Known) -> Option<f64>| {
        // Infinite where the beams have no place for such a feature: no number either.
        let numbers = arcs.iter().map(|arc| of(arc).filter(|x| x.is_finite()));
        let numbers = numbers.map(|number| number.map(|x| rounded(x) as f32));
        column(name, Shared::new(numbers.collect::<Float32Array>()))
    };
    let count = |name, of: fn(&Known) -> Option<u32>| {
        let counts: UInt32Array = arcs.iter().map(of).collect();
        column(name, Shared::new(counts))
    };
    let suspects = arcs.iter().map(|arc| Some(arc.report.is_suspect()));
    vec![
        word("sensor", |arc| Some(&arc.sensor)),
        word("label", |arc| Some(arc.report.label.name())),
        word("reason", |arc| Some(arc.report.label.reason()?.name())),
        number("theta_c", |arc| Some(arc.triple()?.angles.theta_c)),
        number("theta_c_sigma", |arc| arc.triple()?.spread.theta_c()),
        number("theta_i", |arc| Some(arc.triple()?.angles.theta_i)),
        number("theta_i_sigma", |arc| arc.triple()?.spread.theta_i()),
        number("margin", |arc| arc.report.angle_margin()),
        number("chi2_margin", |arc| arc.report.chi2_margin()),
        word("opinion", |arc| Some(arc.test()?.support.name())),
        number("chi2_line", |arc| Some(arc.test()?.chi2_line)),
        number("chi2_point", |arc| Some(arc.test()?.chi2_point)),
        count("readings", |arc| u32::try_from(arc.wide()?.readings).ok()),
        word("wide_opinion", |arc| Some(arc.wide()?.support.name())),
        number("wide_chi2_line", |arc| Some(arc.wide()?.chi2_line)),
        number("wide_chi2_point", |arc| Some(arc.wide()?.chi2_point)),
        word("map_opinion", |arc| Some(arc.report.map?.support.name())),
        count("feature", |arc| Some(arc.report.run.as_ref()?.extraction)),
        word("run_opinion", |arc| Some(arc.run()?.support.name())),
        number("run_chi2_line", |arc| Some(arc.run()?.chi2_line)),
        number("run_chi2_point", |arc| Some(arc.run()?.chi2_point)),
        column("suspect", Shared::new(suspects.collect::<BooleanArray>())),
    ]
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

#[cfg(test)]
mod tests;
