//! Ranges in steps that are too coarse.

use super::examined::Examined;
use super::finding::{Finding, Weight};
use super::sonars::SonarFacts;

/// Where more is explained, a raster does no harm.
const WELL: f64 = 0.97;

/// Whether the raster of the ranges hides what tells a wall from a corner: `d^2 / 2r`.
pub fn check(of: &Examined<'_>) -> Option<Finding> {
    // Without noise, ranges come in the steps of the robot.
    if of
        .explained()
        .is_some_and(|explained| explained.share > WELL)
    {
        return None;
    }
    let facts = of.facts;
    let step = facts.replay.config.frames.step;
    let sagitta = |range: f64, baseline: f64| baseline * baseline / (2.0 * range);
    let ratio = |sonar: &SonarFacts| {
        let raster = sonar.resolution.filter(|r| r.quantised)?.step;
        let (range, baseline) = (sonar.median?, sonar.baseline?.max(step));
        Some((raster / sagitta(range, baseline), raster, range, baseline))
    };
    let mut ratios: Vec<(f64, f64, f64, f64)> = facts.sonars.iter().filter_map(ratio).collect();
    if ratios.len() * 2 < facts.sonars.len() {
        return None;
    }
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = ratios.get(ratios.len() / 2);
    let &(_, raster, range, baseline) = middle.filter(|(ratio, ..)| *ratio > 0.5)?;
    // Where the difference is two steps of the raster.
    let wider = libm::ceil(libm::sqrt(4.0 * raster * range) * 20.0) / 20.0;
    let tried = of.tried(&format!("frames.step = {wider}"));
    Some(Finding::new(
        Weight::Serious,
        "coarse-ranges",
        format!(
            "ranges come in steps of {:.1} mm; at {baseline:.2} m from arc to arc and {range:.2} m range, \
             a wall and a corner differ by {:.1} mm",
            raster * 1e3,
            sagitta(range, baseline) * 1e3
        ),
        "many labels depend on rounding",
        match &tried {
            Some(tried) => format!(
                "set frames.step = {wider}{tried}; a driver that publishes finer ranges is better"
            ),
            None => "a driver that publishes finer ranges; a wider frames.step does not help here"
                .to_owned(),
        },
    )
    .with(tried))
}
