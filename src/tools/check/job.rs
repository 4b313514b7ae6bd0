//! One log and its golden file: held to it, or blessed with it, and what is kept of one that differs.

use std::path::{Path, PathBuf};

use super::overlay::overlay;
use super::report::{CheckError, CheckResult, Compared, Report};
use super::require::Requirements;
use crate::core::config::Config;
use crate::core::geometry::Vec2;
use crate::core::legible::inert_line;
use crate::core::log::Log;
use crate::core::observer::Kept;
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::io::config::file::{differences, layered};
use crate::io::config::idle::idle;
use crate::io::log::survey::{Survey, as_it_is};
use crate::io::log::{itemised, read};
use crate::io::output::{Output, OutputError, write_whole};
use crate::observe::recording::Recording;
use crate::observe::viewer;
use crate::tools::golden::{
    Comparison, Difference, Feature, Golden, GoldenError, Quality, Tolerance, all_results,
    as_recorded, carried, compare, drawn, farthest, headline, relabelled, settled,
};
use crate::tools::report::change;

/// On what terms a log is held to its golden file.
#[derive(Debug, Clone, Copy)]
pub struct Terms<'a> {
    /// Borderline labels are differences, too.
    pub strict: bool,
    /// Only the confirmed features of the map are compared.
    pub only_map: bool,
    /// The configuration that ships, as texts each over the one before, where that is to be held instead of the
    /// golden file's.
    pub shipped: Option<&'a [String]>,
    pub required: &'a Requirements,
    pub artifacts: Option<&'a Artifacts>,
}

/// A log and its golden file.
#[derive(Debug, Clone)]
pub struct Job {
    pub log: PathBuf,
    /// What the log is called among those of the run.
    pub name: String,
    /// By the name of the log.
    pub golden: PathBuf,
    /// One of another name that is there in its place, and was made from the same drive.
    pub renamed: Option<PathBuf>,
}

impl Job {
    /// The golden file that the log is held to.
    fn held(&self) -> &Path {
        self.renamed.as_ref().unwrap_or(&self.golden)
    }

    /// Replays the log with the configuration of its golden file, or with that which ships, and compares.
    pub fn check(&self, terms: &Terms<'_>) -> Report {
        if let Some(artifacts) = terms.artifacts {
            artifacts.clear(&self.name);
        }
        self.compared(terms)
            .unwrap_or_else(|error| self.report(error))
    }

    fn compared(&self, terms: &Terms<'_>) -> Result<Report, CheckError> {
        let Terms {
            strict,
            only_map,
            shipped,
            required,
            artifacts,
        } = *terms;
        std::fs::metadata(&self.log).map_err(|source| GoldenError::Read {
            path: self.log.clone(),
            source,
        })?;
        if !self.held().exists() {
            return Ok(self.without_golden(artifacts));
        }
        let (golden, unknown) = Golden::read(self.held())?;
        let (Some(config), Some(_)) = (&golden.config, golden.log()) else {
            return Err(self.of_a_test());
        };
        let shipped = shipped.map(|text| shipped_for(config, text)).transpose()?;
        let changed = shipped.as_ref().map(|shipped| differences(config, shipped));
        let config = shipped.as_ref().unwrap_or(config);
        let survey = as_it_is(&self.log, config)?;
        let replay = Replay::new(&survey.log, config)?;
        let mut kept = Kept::default();
        let outcome = match artifacts {
            Some(_) => replay.run(&mut [&mut kept])?,
            None => replay.run(&mut [])?,
        };
        fit_to_compare(&survey.log, &outcome)?;
        if golden.results.is_empty() {
            return Err(CheckError::Nothing(format!(
                "{} holds no feature; bless it again from a log that gives some",
                self.held().display()
            )));
        }
        let (actual, outcome) = all_results(&self.log, &survey, &replay, outcome)?;
        let mut found = match only_map {
            true => compare(
                &golden.results.map_alone(),
                &actual.map_alone(),
                &golden.tolerances,
            ),
            false => compare(&golden.results, &actual, &golden.tolerances),
        };
        let by = (unknown.is_empty() && !only_map).then_some(golden.written_by.version.as_str());
        found.blame(&changed.unwrap_or_default(), true, by);
        let quality = actual.quality;
        let missed = self.missed(required, quality).into_iter();
        let missed = missed.map(|text| Difference::Requirement { text });
        found.differences.splice(0..0, missed);
        let mut report = self.report(match found.matches(strict) {
            true => CheckResult::Matches,
            false => CheckResult::Differs,
        });
        report.quality = quality;
        report.notes = notes(&golden, &unknown);
        report.notes.extend(shipped.as_ref().and_then(idle));
        if let Some(renamed) = &self.renamed {
            report.golden.clone_from(renamed);
            report.notes.push(format!(
                "{} was made from this drive, by the digest of its events, when the log was called {}; name it {}",
                renamed.display(),
                golden.log().map_or("", |log| &log.file),
                self.golden.display()
            ));
        }
        if let (Some(artifacts), CheckResult::Differs) = (artifacts, &report.result) {
            let config = Some(config.clone());
            let settled = settled(&golden.results, actual, &golden.tolerances);
            let new = Golden::new(config, golden.tolerances, settled);
            let replayed = (&replay, &outcome, &kept);
            match artifacts.write(&self.name, replayed, &golden, &new, &found) {
                Ok((new, picture, recording)) => {
                    let seen = recording.clone().into_iter().chain(picture);
                    report.artifacts = seen.chain([new]).collect();
                    report.recording = recording;
                }
                Err(error) => report.result = error.into(),
            }
        }
        let map = golden.results.map;
        report.compared = Some(Compared { map, found });
        Ok(report)
    }

    /// There is nothing to compare, but what would be blessed is kept. A log that cannot be read is
    /// unusable whoever blesses it.
    fn without_golden(&self, artifacts: Option<&Artifacts>) -> Report {
        let mut report = self.report(CheckResult::Nothing(format!(
            "there is no golden file {}; write it with --bless and commit it",
            self.golden.display()
        )));
        let config = Config::default();
        let by_default = || {
            let survey = as_it_is(&self.log, &config)?;
            let replay = Replay::new(&survey.log, &config)?;
            self.new_golden(&config, Tolerance::default(), &survey, &replay)
        };
        let kept = match artifacts {
            Some(artifacts) => by_default()
                .and_then(|(golden, _)| artifacts.write_golden(&self.name, &golden).map(Some)),
            None => read(&self.log, &config)
                .map(|_| None)
                .map_err(CheckError::from),
        };
        match kept {
            Ok(new) => report.artifacts.extend(new),
            Err(CheckError::Nothing(_)) => {}
            Err(error) if error.wants_configuration() => report.notes.push(format!(
                "the default configuration does not do for this log, so give what it needs with --bless: {error}"
            )),
            Err(error) => report.result = error.into(),
        }
        report
    }

    /// Writes or updates the golden file.
    ///
    /// What is given of the configuration and the tolerances stands over what the old file records, and
    /// that over the defaults.
    pub fn bless(
        &self,
        layers: &[String],
        tolerances: &[String],
        required: &Requirements,
    ) -> Report {
        let blessed = self.blessed(layers, tolerances, required);
        blessed.unwrap_or_else(|error| {
            self.report(match error {
                CheckError::Nothing(why) => CheckResult::Nothing(format!("not blessed: {why}")),
                error => error.into(),
            })
        })
    }

    fn blessed(
        &self,
        layers: &[String],
        tolerances: &[String],
        required: &Requirements,
    ) -> Result<Report, CheckError> {
        let old = match self.held().exists() {
            true => Some(Golden::read(self.held())?.0),
            false => None,
        };
        let (recorded, before) = match old
            .as_ref()
            .map(|old| (old.log(), &old.config, old.tolerances))
        {
            None => (Config::default(), Tolerance::default()),
            Some((Some(_), Some(config), tolerances)) => (config.clone(), tolerances),
            Some(_) => return Err(self.of_a_test()),
        };
        let tolerances = tolerances.iter().try_fold(before, Tolerance::with)?;
        let config = as_recorded(&layered(recorded, layers)?)?;
        let survey = as_it_is(&self.log, &config)?;
        let replay = Replay::new(&survey.log, &config)?;
        let (mut new, outcome) = self.new_golden(&config, tolerances, &survey, &replay)?;
        let mut notes = kept_beyond(layers, &config, old.is_some())?;
        notes.extend(Some(&config).filter(|_| !layers.is_empty()).and_then(idle));
        if self.log.is_dir() {
            notes.push(format!(
                "{} is held as one drive, whose parts are the files in it; where these are drives of their own, name \
                 them one by one",
                self.log.display()
            ));
        }
        if let Some(renamed) = &self.renamed {
            notes.push(format!(
                "blessed on the terms of {}, which was made from the same drive: remove that",
                renamed.display()
            ));
        }
        let missed = self.missed(required, new.results.quality).into_iter();
        notes.extend(missed.map(|text| format!("a check will fail, for {text}")));
        let found = old
            .as_ref()
            .map(|old| compare(&old.results, &new.results, &tolerances));
        if let Some(old) = &old {
            new.results = settled(&old.results, new.results, &tolerances);
        }
        let bytes = new.render()?;
        // A new version that finds the same rewrites nothing.
        let same = |old: &Golden| {
            let mut old = old.clone();
            old.written_by = new.written_by.clone();
            old.render().is_ok_and(|old| old == bytes)
        };
        if self.renamed.is_none() && old.as_ref().is_some_and(same) {
            return Ok(Report {
                notes,
                ..self.report(CheckResult::Unchanged)
            });
        }
        write_whole(&self.golden, &bytes)?;
        let mut report = self.report(CheckResult::Blessed);
        report.quality = new.results.quality;
        report.notes = notes;
        if let Some(old) = old {
            report.notes.extend(changed_terms(&old, &new));
            let mut found = found.unwrap_or_default();
            let configs = old.config.as_ref().zip(new.config.as_ref());
            let changed = configs.map_or_else(Vec::new, |(then, now)| differences(then, now));
            found.blame(&changed, true, Some(&old.written_by.version));
            let map = old.results.map;
            let picture = picture_of(&self.golden);
            let drawn = draw(&picture, &self.name, (&replay, &outcome), &map, &found)?;
            report.artifacts.extend(drawn);
            report.compared = Some(Compared { map, found });
        }
        Ok(report)
    }

    /// The golden file of a whole log that gives something; the outcome is given back.
    fn new_golden(
        &self,
        config: &Config,
        tolerances: Tolerance,
        survey: &Survey,
        replay: &Replay<'_>,
    ) -> Result<(Golden, Outcome), CheckError> {
        let outcome = replay.run(&mut [])?;
        fit_to_compare(&survey.log, &outcome)?;
        let (results, outcome) = all_results(&self.log, survey, replay, outcome)?;
        if results.is_empty() {
            return Err(CheckError::Nothing(format!(
                "{} gives no feature, and an empty result can never differ",
                survey.log.file
            )));
        }
        let golden = Golden::new(Some(config.clone()), tolerances, results);
        Ok((golden, outcome))
    }

    /// What of the requirements results do not meet, in words.
    fn missed(&self, required: &Requirements, quality: Option<Quality>) -> Vec<String> {
        quality.map_or_else(Vec::new, |quality| required.missed(&self.name, &quality))
    }

    fn of_a_test(&self) -> CheckError {
        CheckError::OfATest {
            golden: self.held().to_owned(),
        }
    }

    /// A report without a comparison.
    fn report(&self, result: impl Into<CheckResult>) -> Report {
        Report {
            log: self.log.clone(),
            golden: self.golden.clone(),
            result: result.into(),
            notes: Vec::new(),
            compared: None,
            quality: None,
            artifacts: Vec::new(),
            recording: None,
            seconds: 0.0,
        }
    }
}

/// Only a whole log with echoes is compared.
fn fit_to_compare(log: &Log, outcome: &Outcome) -> Result<(), CheckError> {
    let file = &log.file;
    let lost = itemised(&log.losses);
    Err(CheckError::Nothing(if !log.losses.is_empty() {
        format!("{file} could not be read whole. Lost:{lost}")
    } else if outcome.tally.echoes == 0 {
        format!("not one reading of {file} is an echo")
    } else {
        return Ok(());
    }))
}

fn notes(golden: &Golden, unknown: &[String]) -> Vec<String> {
    let mut notes = Vec::new();
    let (then, now) = (&golden.written_by.version, env!("CARGO_PKG_VERSION"));
    if then != now {
        notes.push(format!("blessed with tmam {then}, checked with {now}"));
    }
    if !unknown.is_empty() {
        notes.push(format!(
            "the golden file is from before it recorded {}; of parameters the present defaults hold. Bless again to \
             record all of it",
            inert_line(&unknown.join(", "))
        ));
    }
    notes
}

/// The configuration that ships, for a log of which the golden file holds a part.
fn shipped_for(golden: &Config, texts: &[String]) -> Result<Config, CheckError> {
    let mut part = Config::default();
    part.input.start = golden.input.start;
    part.input.end = golden.input.end;
    part.input.sonars.clone_from(&golden.input.sonars);
    Ok(as_recorded(&layered(part, texts)?)?)
}

/// What of a configuration the golden file alone says, where something is given over it.
fn kept_beyond(
    layers: &[String],
    config: &Config,
    is_old: bool,
) -> Result<Vec<String>, CheckError> {
    if layers.is_empty() || !is_old {
        return Ok(Vec::new());
    }
    let given = as_recorded(&layered(Config::default(), layers)?)?;
    let kept = differences(&given, config);
    let note = || {
        format!(
            "the golden file keeps of its own configuration what nothing that is given says otherwise: {}; take a \
             line out of its `config` and bless again to drop it",
            kept.join("; ")
        )
    };
    Ok(Vec::from_iter((!kept.is_empty()).then(note)))
}

/// What is otherwise on the terms of the comparison.
fn changed_terms(old: &Golden, new: &Golden) -> Vec<String> {
    let mut notes = Vec::new();
    let [before, after] =
        [old, new].map(|golden| serde_json::to_value(golden.tolerances).unwrap_or_default());
    for (key, value) in after.as_object().into_iter().flatten() {
        if let Some(was) = before.get(key).filter(|was| *was != value) {
            notes.push(format!("tolerance {key} {was} -> {value}"));
        }
    }
    notes
}

/// A directory for artefacts.
#[derive(Debug)]
pub struct Artifacts {
    pub directory: PathBuf,
    /// Record only so many frames about each difference.
    pub around: Option<u32>,
}

impl Artifacts {
    /// Writes the golden file that would make the log pass, the picture, and the recording, where this tmam writes
    /// recordings. What to mark in that is known only at the end of a replay, so all that it brought about
    /// was kept.
    ///
    /// # Errors
    /// When one of them cannot be written.
    fn write(
        &self,
        name: &str,
        (replay, outcome, kept): (&Replay<'_>, &Outcome, &Kept),
        golden: &Golden,
        new: &Golden,
        found: &Comparison,
    ) -> Result<(PathBuf, Option<PathBuf>, Option<PathBuf>), CheckError> {
        let [_, picture, path] = artifacts_of(name, &self.directory);
        let map = &golden.results.map;
        let picture = draw(&picture, name, (replay, outcome), map, found)?;
        let written = self.write_golden(name, new)?;
        if !viewer::IS_BUILT_IN {
            return Ok((written, picture, None));
        }
        let mut out = Output::create(&path)?;
        let setting = replay.setting();
        let over = overlay(golden, &new.results, found, self.around);
        let mut recording = Recording::new(Some(&mut out), None, setting, over)?;
        kept.show(&mut recording).map_err(ReplayError::from)?;
        let carried = carried(&setting, outcome)?;
        recording.close(Some(&carried))?;
        out.commit()?;
        Ok((written, picture, Some(path)))
    }

    /// Writes a golden file that a log could have.
    ///
    /// # Errors
    /// When it cannot be written.
    fn write_golden(&self, name: &str, golden: &Golden) -> Result<PathBuf, CheckError> {
        let [path, ..] = artifacts_of(name, &self.directory);
        write_whole(&path, &golden.render()?)?;
        Ok(path)
    }

    /// Takes away what an earlier run left of a log.
    fn clear(&self, name: &str) {
        for path in artifacts_of(name, &self.directory) {
            // What is not there need not go.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Draws what differs from a map, where something of it is to be seen; gives back the picture, if there is one.
fn draw(
    picture: &Path,
    name: &str,
    (replay, outcome): (&Replay<'_>, &Outcome),
    map: &[Feature],
    found: &Comparison,
) -> Result<Option<PathBuf>, OutputError> {
    let over = drawn(map, found);
    let arcs = relabelled(&over, replay.setting().sonars, outcome);
    if found.elsewhere().next().is_none() && arcs.is_empty() {
        // One of an earlier blessing shows what that changed.
        let _ = std::fs::remove_file(picture);
        return Ok(None);
    }
    let quality = found.quality.map(|[then, now]| headline(&then, &now));
    let (trend, numbers) = quality
        .as_deref()
        .and_then(|text| text.split_once(": "))
        .unzip();
    let title = [Some(name), trend].into_iter().flatten();
    let title = inert_line(&title.collect::<Vec<_>>().join(": "));
    let cause = found
        .causes()
        .next()
        .map(|cause| format!("cause: {}", cause.text));
    // What is unchanged besides has no room here.
    let cause = cause
        .as_deref()
        .and_then(|text| text.split(" (unchanged").next());
    let cause = inert_line(cause.unwrap_or_default());
    let words = [title.as_ref(), numbers.unwrap_or_default(), cause.as_ref()];
    let path = replay.path(outcome).into_iter();
    let path: Vec<Vec2> = path.map(|(_, pose)| pose.position()).collect();
    let svg = change::draw(words, &path, &over, farthest(found), &arcs);
    write_whole(picture, svg.to_string().as_bytes())?;
    Ok(Some(picture.to_owned()))
}

/// Where a blessing draws what it changed: beside the golden file.
pub fn picture_of(golden: &Path) -> PathBuf {
    // Of the two endings of `drive.golden.json`, the last goes.
    golden.with_extension("svg")
}

/// The files that may be kept of a log: the golden file that it would get, the picture, and the recording.
pub fn artifacts_of(name: &str, directory: &Path) -> [PathBuf; 3] {
    [".golden.json.new", ".check.svg", ".check.rrd"]
        .map(|extension| directory.join(format!("{name}{extension}")))
}
