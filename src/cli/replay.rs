//! `tmam replay`

use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::parameters::Parameters;
use crate::error::{DONE, Error, INCOMPLETE};
use crate::features;
use crate::log::{self, Log};
use crate::output::{Output, is_stdout};
use crate::progress::Progress;
use crate::recording::Recording;
use crate::replay::{Observer, Replay};
use crate::report::{VIEWER_VERSION, summary};
use crate::trace::Trace;

/// Replay a log: record what was seen and decided, extract features
///
/// With no output named, writes LOG.rrd and LOG.features.json into the current directory; otherwise
/// exactly the outputs that are named. `-` is standard output, for one of them.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Exit codes: 0 done; 2 usage, configuration or input that cannot be read; 3 done, but the log is \
incomplete (2 with --strict) or holds no echo, or there was nothing to replay.

Examples:
  tmam replay drive.mcap                          drive.rrd and drive.features.json
  tmam replay drive.mcap --trace drive.jsonl      only the trace: why each arc was labelled so
  tmam replay drive.mcap --start 30 --end 60 --sensor 'sonar_0*' -o part.rrd")]
pub struct Args {
    /// The MCAP log
    log: PathBuf,
    /// Write the recording for the Rerun viewer here
    #[arg(
        short,
        long = "output",
        value_name = "FILE.rrd",
        conflicts_with = "no_recording"
    )]
    output: Option<PathBuf>,
    /// Write the extracted features and the map here
    #[arg(long, value_name = "FILE.json")]
    features: Option<PathBuf>,
    /// Write a line per arc here: its pose, angles and label, and why
    #[arg(long, value_name = "FILE.jsonl")]
    trace: Option<PathBuf>,
    /// Write no recording
    #[arg(long)]
    no_recording: bool,
    /// Refuse a log that cannot be read whole, instead of using what can be read of it
    #[arg(long)]
    strict: bool,
    /// Say nothing but what went wrong
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    parameters: Parameters,
}

/// The outputs to write.
struct Outputs {
    recording: Option<Output>,
    features: Option<Output>,
    trace: Option<Output>,
}

impl Args {
    pub fn run(self) -> Result<u8, Error> {
        let config = self.parameters.configuration()?;
        let log = log::read(&self.log, &config)?;
        if self.strict && !log.losses.is_empty() {
            return Err(Error::Incomplete {
                file: log.file,
                losses: log.losses,
            });
        }
        let replay = Replay::new(&log, &config)?;
        let setting = replay.setting();
        let mut outputs = self.outputs()?;

        let mut progress = Progress::new(&setting);
        let mut trace = outputs.trace.as_mut().map(|out| {
            let path = out.path().to_owned();
            Trace::new(out, path, setting)
        });
        let mut recording = outputs
            .recording
            .as_mut()
            .map(|out| Recording::new(out, setting))
            .transpose()?;
        let mut observers: Vec<&mut dyn Observer> = vec![&mut progress];
        observers.extend(recording.as_mut().map(|r| r as &mut dyn Observer));
        observers.extend(trace.as_mut().map(|t| t as &mut dyn Observer));
        let outcome = replay.run(&mut observers)?;
        drop(recording);
        drop(trace);
        if let Some(out) = &mut outputs.features {
            features::write(&mut *out, &setting, &outcome).map_err(|source| out.failed(source))?;
        }
        let (written, to_stdout) = outputs.commit()?;

        report_problems(&log);
        if !self.quiet {
            let mut text = summary(&setting, &outcome);
            for path in &written {
                text.push_str(&format!("wrote      {}\n", path.display()));
                if path.extension().is_some_and(|e| e == "rrd") {
                    text.push_str(&how_to_open(path));
                }
            }
            if to_stdout {
                eprint!("{text}");
            } else {
                let _ = std::io::stdout().write_all(text.as_bytes());
            }
        }
        if outcome.tally.echoes == 0 {
            eprintln!(
                "warning: not one reading is an echo; look at range, min_range and max_range"
            );
        }
        let judged = setting.source.complete && outcome.tally.echoes > 0;
        Ok(if judged { DONE } else { INCOMPLETE })
    }

    fn outputs(&self) -> Result<Outputs, Error> {
        let none_named = [&self.output, &self.features, &self.trace]
            .iter()
            .all(|o| o.is_none());
        let named_after_log = |extension: &str| {
            let stem = self.log.file_stem().unwrap_or(self.log.as_os_str());
            let mut name = stem.to_owned();
            name.push(extension);
            none_named.then(|| PathBuf::from(name))
        };
        let recording = match (&self.output, self.no_recording) {
            (Some(path), _) => Some(path.clone()),
            (None, true) => None,
            (None, false) => named_after_log(".rrd"),
        };
        let features = self
            .features
            .clone()
            .or_else(|| named_after_log(".features.json"));
        self.refuse_collisions(&[
            recording.as_deref(),
            features.as_deref(),
            self.trace.as_deref(),
        ])?;
        let create = |path: Option<&Path>| path.map(Output::create).transpose();
        Ok(Outputs {
            recording: create(recording.as_deref())?,
            features: create(features.as_deref())?,
            trace: create(self.trace.as_deref())?,
        })
    }

    /// Two outputs in one file would destroy each other, and one in the log's place the log.
    fn refuse_collisions(&self, paths: &[Option<&Path>]) -> Result<(), Error> {
        let place = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let mut taken = vec![place(&self.log)];
        for path in paths.iter().flatten() {
            if taken.contains(&place(path)) {
                let path = path.display();
                return Err(Error::Usage(format!(
                    "{path} is named twice; give the log and every output a name of its own"
                )));
            }
            taken.push(place(path));
        }
        Ok(())
    }
}

impl Outputs {
    /// Gives every file its name; their paths, and whether one went to standard output.
    fn commit(self) -> Result<(Vec<PathBuf>, bool), Error> {
        let mut written = Vec::new();
        let mut to_stdout = false;
        for out in [self.recording, self.features, self.trace]
            .into_iter()
            .flatten()
        {
            let path = out.path().to_owned();
            out.commit()?;
            if is_stdout(&path) {
                to_stdout = true;
            } else {
                written.push(path);
            }
        }
        Ok((written, to_stdout))
    }
}

fn how_to_open(path: &Path) -> String {
    format!(
        "open with  rerun {}    (viewer {VIEWER_VERSION}: pip install rerun-sdk=={VIEWER_VERSION})\n",
        path.display()
    )
}

fn report_problems(log: &Log) {
    for note in &log.notes {
        eprintln!("note: {note}");
    }
    if !log.losses.is_empty() {
        let losses = log::itemised(&log.losses);
        eprintln!(
            "warning: {} could not be read whole. Lost:{losses}",
            log.file
        );
    }
}
