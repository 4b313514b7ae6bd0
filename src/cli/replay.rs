//! `tmam replay`

use std::io;
use std::path::PathBuf;

use super::parameters::{Parameters, quoted};
use crate::cli::error::Error;
use crate::cli::named::ending_in;
use crate::core::exit::Exit;
use crate::core::least_explained::least_explained;
use crate::core::observer::{Observer, Setting};
use crate::core::replay::Replay;
use crate::io::log::survey;
use crate::io::output::show;
use crate::io::outputs::Requested;
use crate::observe::causes;
use crate::observe::drawing::Overlay;
use crate::observe::features;
use crate::observe::path_file::{self, PathFormat};
use crate::observe::progress::Progress;
use crate::observe::recording::{Live, Recording};
use crate::observe::report;
use crate::observe::trace;
use crate::observe::viewer::{self, DEFAULT_URL};
use crate::tools::findings::examined::Examined;
use crate::tools::findings::facts::Facts;
use crate::tools::findings::trial::attempted;
use crate::tools::findings::{findings, to_warn_of, warnings};
use crate::tools::golden::carried;

/// Replay a log: record what was seen and decided, extract features
///
/// With no output named, writes LOG.rrd and LOG.features.json into the current directory; otherwise
/// exactly the outputs that are named. `-` is standard output, for one of them.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "\
Exit codes: 0 done; 2 usage, configuration or input that cannot be read; 3 done, but the log is \
incomplete (2 with --strict) or holds no echo, or there was nothing to replay.

Examples:
  tmam replay drive.mcap                          drive.rrd and drive.features.json
  tmam replay drive.mcap --trace drive.jsonl      only the trace: why each arc was labelled so
  tmam replay drive.mcap --path drive.tum         the path used, for evo
  tmam replay drive.mcap --start 30 --end 60 --sensor 'sonar_0*' -o part.rrd"
)]
pub struct Args {
    /// The MCAP log
    log: PathBuf,
    /// Write the recording for the Rerun viewer here
    #[arg(
        short,
        long = "output",
        value_name = "FILE.rrd",
        value_parser = ending_in("rrd"),
        conflicts_with = "no_recording"
    )]
    output: Option<PathBuf>,
    /// Write the extracted features and the map here
    #[arg(long, value_name = "FILE.json", value_parser = ending_in("json"))]
    features: Option<PathBuf>,
    /// Write a line per arc here: its pose, angles and label, and why
    #[arg(long, value_name = "FILE.jsonl", value_parser = ending_in("jsonl"))]
    trace: Option<PathBuf>,
    /// Write the path that was used here, a pose per odometry sample: as TUM, or as nav_msgs/Odometry
    /// where the name ends in .mcap
    #[arg(long, value_name = "FILE.tum", value_parser = path_file)]
    path: Option<PathBuf>,
    /// Write no recording
    #[arg(long)]
    no_recording: bool,
    /// Show the recording in an open viewer while it is made; files are then written only where
    /// they are named
    #[arg(
        long,
        value_name = "URL",
        num_args = 0..=1,
        default_missing_value = DEFAULT_URL,
        conflicts_with = "no_recording"
    )]
    connect: Option<String>,
    /// The same, and start a viewer (`rerun`) if none is open
    #[arg(long, conflicts_with = "no_recording")]
    spawn: bool,
    /// Do not look for what is off: mounts, beams, clocks, scales
    #[arg(long)]
    no_causes: bool,
    /// Refuse a log that cannot be read whole, instead of using what can be read of it
    #[arg(long)]
    strict: bool,
    /// Say nothing but what went wrong
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let config = self.parameters.configuration()?;
        let survey = survey::as_it_is(&self.log, &config)?;
        let log = &survey.log;
        if self.strict && !log.losses.is_empty() {
            return Err(Error::Incomplete {
                file: log.file.clone(),
                losses: log.losses.clone(),
            });
        }
        let replay = Replay::new(log, &config)?;
        let setting = replay.setting();
        let requested = Requested {
            recording: self.output,
            features: self.features,
            trace: self.trace,
            path: self.path,
            inputs: self
                .parameters
                .file()
                .map(PathBuf::from)
                .into_iter()
                .collect(),
            no_recording: self.no_recording || !viewer::IS_BUILT_IN,
            live: self.connect.is_some() || self.spawn,
            ..Requested::default()
        };
        let mut outputs = requested.open(&self.log)?;
        let url = self.connect.or(self.spawn.then(|| DEFAULT_URL.to_owned()));
        let viewer = url.map(|url| Live::connect(&url, self.spawn)).transpose()?;

        let mut lost = None;
        let named = quoted(&self.log.display().to_string());
        let named = format!("{named}{}", self.parameters.as_typed());
        let (outcome, source, warned) = {
            let mut progress = Progress::new(&setting);
            let file = outputs.recording.as_mut();
            let file = file.map(|out| out as &mut dyn io::Write);
            let mut recording = None;
            if file.is_some() || viewer.is_some() {
                let overlay = Overlay::default();
                recording = Some(Recording::new(file, viewer, setting, overlay)?);
            }
            let mut observers: Vec<&mut dyn Observer> = vec![&mut progress];
            observers.extend(recording.as_mut().map(|r| r as &mut dyn Observer));
            let mut outcome = replay.run(&mut observers)?;
            if !self.no_causes {
                outcome.causes = causes::look_for(&replay, &outcome);
            }
            outcome.stretch = least_explained(&setting, &outcome);
            let mut facts = Facts::new(&survey, Some(outcome));
            let found = findings(&Examined {
                facts: &facts,
                survey: &survey,
                attempt: &|config| attempted(&self.log, config),
            });
            let outcome = facts.replay.outcome.take().unwrap_or_default();
            let serious = to_warn_of(&found);
            let mut source = setting.source.clone();
            source
                .notes
                .extend(serious.iter().map(|finding| finding.line()));
            if let Some(mut recording) = recording {
                recording.tell(&outcome)?;
                let setting = Setting {
                    source: &source,
                    ..setting
                };
                let carried = carried(&setting, &outcome)?;
                lost = recording.close(Some(&carried))?;
            }
            (outcome, source, warnings(&serious, &named))
        };
        let setting = Setting {
            source: &source,
            ..setting
        };
        if let Some(out) = &mut outputs.features {
            features::write(&mut *out, &setting, &outcome).map_err(|source| out.failed(source))?;
        }
        if let Some(out) = &mut outputs.trace {
            trace::write(&mut *out, setting.sonars, &outcome).map_err(|s| out.failed(s))?;
        }
        if let Some(out) = &mut outputs.path {
            path_file::write(out, &replay, &outcome).map_err(|source| out.failed(source))?;
        }
        let written = outputs.commit()?;

        show(&report::problems(log, &setting, &outcome), true)?;
        show(&warned, true)?;
        if let Some(lost) = lost {
            show(&format!("warning: {lost}; the file has it all\n"), true)?;
        }
        if !self.quiet {
            let text = report::closing(&setting, &outcome, &named, &written.files);
            show(&text, written.to_stdout)?;
        }
        let whole = setting.source.complete && outcome.tally.echoes > 0;
        Ok(Exit::of_whole(whole))
    }
}

fn path_file(name: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(name);
    match PathFormat::of(&file) {
        Some(_) => Ok(file),
        None => Err("the name of a path ends in .tum, .txt or .mcap".to_owned()),
    }
}
