//! Labels against labels, arc by arc: an arc is known by its sonar and its stamp.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use super::difference::{LabelChange, LabelRun, StrayedArc};
use super::results::{LabelledArc, Labels, Margin};
use super::tolerance::Tolerance;

/// The labels that differ, and those that flipped with less than the tolerance to spare.
pub fn compare_labels(
    golden: &Labels,
    actual: &Labels,
    tolerance: &Tolerance,
) -> (Vec<LabelRun>, Vec<LabelRun>) {
    let (mut clear, mut near): (Vec<LabelRun>, Vec<LabelRun>) = Default::default();
    let sonars: BTreeSet<&String> = golden.sonars.keys().chain(actual.sonars.keys()).collect();
    for sonar in sonars {
        let arcs = |labels: &'_ Labels| labels.sonars.get(sonar).cloned().unwrap_or_default();
        // What went before it decides whether an arc goes on with a run.
        let mut going = None;
        for pair in by_stamp(&arcs(golden), &arcs(actual)) {
            let Some((change, arc)) = strayed(pair, actual) else {
                going = None;
                continue;
            };
            let is_near = matches!(change, LabelChange::Flipped { .. })
                && arc
                    .margin
                    .is_some_and(|margin| is_borderline(margin, tolerance));
            let runs = if is_near { &mut near } else { &mut clear };
            match runs.last_mut() {
                Some(run) if going == Some((change, is_near)) => run.arcs.push(arc),
                _ => runs.push(LabelRun {
                    sensor: sonar.clone(),
                    change,
                    arcs: vec![arc],
                }),
            }
            going = Some((change, is_near));
        }
    }
    (clear, near)
}

fn is_borderline(margin: Margin, tolerance: &Tolerance) -> bool {
    match margin {
        Margin::Angle(radians) => radians < tolerance.borderline,
        Margin::Chi2(chi2) => chi2 < tolerance.borderline_chi2,
    }
}

/// The arcs of two lists, those of one stamp together.
fn by_stamp(
    golden: &[LabelledArc],
    actual: &[LabelledArc],
) -> Vec<(Option<LabelledArc>, Option<LabelledArc>)> {
    let (mut golden, mut actual) = (golden.iter().peekable(), actual.iter().peekable());
    let mut pairs = Vec::new();
    loop {
        let order = match (golden.peek(), actual.peek()) {
            (Some(g), Some(a)) => g.stamp_ns.cmp(&a.stamp_ns),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) => return pairs,
        };
        pairs.push((
            golden.next_if(|_| order.is_le()).copied(),
            actual.next_if(|_| order.is_ge()).copied(),
        ));
    }
}

fn strayed(
    pair: (Option<LabelledArc>, Option<LabelledArc>),
    actual: &Labels,
) -> Option<(LabelChange, StrayedArc)> {
    let (change, arc) = match pair {
        (Some(g), Some(a)) if g.mark == a.mark => return None,
        (Some(g), Some(a)) => {
            let change = LabelChange::Flipped {
                golden: g.mark,
                actual: a.mark,
                reason: a.reason,
            };
            (change, a)
        }
        (Some(g), None) => (LabelChange::Gone(g.mark), g),
        (None, Some(a)) => (LabelChange::New(a.mark), a),
        (None, None) => return None,
    };
    let strayed = StrayedArc {
        stamp_ns: arc.stamp_ns,
        frame: arc.frame.or_else(|| actual.frame_at(arc.stamp_ns)),
        margin: arc
            .margin
            .filter(|_| matches!(change, LabelChange::Flipped { .. })),
    };
    Some((change, strayed))
}

#[cfg(test)]
mod tests {
    use super::super::results::Mark::{self, Contact, Intersection, Unidentified};
    use super::*;

    fn labels(arcs: &[(i64, Mark, f64)]) -> Labels {
        let arcs = arcs.iter().map(|(stamp_ns, mark, margin)| LabelledArc {
            stamp_ns: *stamp_ns,
            mark: *mark,
            frame: None,
            margin: Some(Margin::Angle(*margin)),
            reason: None,
        });
        Labels {
            sonars: [("a".to_owned(), arcs.collect())].into(),
            frame_stamps: vec![0, 20, 40],
            ..Labels::default()
        }
    }

    fn borderline(borderline: f64) -> Tolerance {
        Tolerance {
            borderline,
            ..Tolerance::default()
        }
    }

    #[test]
    fn each_kind_of_margin_has_a_tolerance_of_its_own() {
        let tolerance = Tolerance {
            borderline: 0.001,
            borderline_chi2: 0.1,
            ..Tolerance::default()
        };
        assert!(is_borderline(Margin::Chi2(0.05), &tolerance));
        assert!(!is_borderline(Margin::Angle(0.05), &tolerance));
        assert!(!is_borderline(Margin::Chi2(0.2), &tolerance));
    }

    #[test]
    fn a_lost_reading_does_not_shift_the_labels_after_it() {
        let golden = labels(&[
            (1, Contact, 0.1),
            (2, Contact, 0.1),
            (3, Intersection, 0.1),
            (30, Contact, 0.1),
        ]);
        let actual = labels(&[
            (1, Contact, 0.1),
            (3, Intersection, 0.1),
            (30, Contact, 0.1),
            (50, Contact, 0.1),
        ]);
        let (clear, near) = compare_labels(&golden, &actual, &borderline(0.0));
        let changes: Vec<_> = clear
            .iter()
            .map(|run| (run.change, run.arcs[0].stamp_ns, run.arcs[0].frame))
            .collect();
        assert_eq!(
            changes,
            [
                (LabelChange::Gone(Contact), 2, Some(0)),
                (LabelChange::New(Contact), 50, Some(2))
            ]
        );
        assert!(near.is_empty());
    }

    #[test]
    fn neighbours_that_changed_alike_are_one_run_and_borderline_ones_are_apart() {
        let golden = labels(&[
            (1, Contact, 0.1),
            (2, Contact, 0.1),
            (3, Contact, 0.1),
            (4, Contact, 0.1),
            (5, Contact, 0.1),
        ]);
        let actual = labels(&[
            (1, Unidentified, 0.1),
            (2, Unidentified, 0.2),
            (3, Unidentified, 0.0001),
            (4, Unidentified, 0.3),
            (5, Contact, 0.1),
        ]);
        let (clear, near) = compare_labels(&golden, &actual, &borderline(0.001));
        assert_eq!(
            clear.iter().map(|run| run.arcs.len()).collect::<Vec<_>>(),
            [2, 1]
        );
        assert_eq!(near.len(), 1);
        assert_eq!(near[0].arcs[0].stamp_ns, 3);
        assert_eq!(
            compare_labels(&golden, &golden, &borderline(0.001)),
            (vec![], vec![])
        );
    }
}
