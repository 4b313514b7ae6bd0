//! `tmam replay`

use std::io;
use std::path::{Path, PathBuf};
use std::thread::{self, ScopedJoinHandle};

use super::parameters::Parameters;
use crate::cli::error::Error;
use crate::cli::named::{ending_in, is_folder};
use crate::core::config::Config;
use crate::core::exit::Exit;
use crate::core::least_explained::least_explained;
use crate::core::legible::quoted;
use crate::core::observer::{Observer, Setting};
use crate::core::replay::{Outcome, Replay, ReplayError};
use crate::core::tmam::arc::Arc;
use crate::io::drives::{self, Drive};
use crate::io::log::survey;
use crate::io::log::truth::RecordedTruth;
use crate::io::output::{Output, OutputError, is_stdout, print, show};
use crate::io::outputs::{Requested, Settled, partition, refuse_collisions};
use crate::observe::arc_table::{self, TableName};
use crate::observe::behind::Behind;
use crate::observe::causes;
use crate::observe::drawing::Overlay;
use crate::observe::features;
use crate::observe::path_file::{self, PathFormat};
use crate::observe::progress::{Progress, ReplaysProgress};
use crate::observe::recording::{Live, Recording};
use crate::observe::report;
use crate::observe::trace;
use crate::observe::viewer::{self, DEFAULT_URL};
use crate::tools::evaluate::Truth;
use crate::tools::evaluate::truth::AGREEING_RANGE;
use crate::tools::findings::examined::Examined;
use crate::tools::findings::facts::Facts;
use crate::tools::findings::trial::attempted;
use crate::tools::findings::{causes as causes_of, findings, to_warn_of, warnings};
use crate::tools::fleet::Fleet;
use crate::tools::fleet::lines::json_line;
use crate::tools::fleet::replayed::Replayed;
use crate::tools::golden::carried;
use crate::tools::map_file::{self, MapFormat};

/// Replay logs: record what was seen and decided, extract features
///
/// With no output named, writes LOG.rrd and LOG.features.json into the current directory; otherwise
/// exactly the outputs that are named. `-` is standard output, for one of them. Of several logs, outputs go into
/// folders: -o FOLDER takes LOG.rrd and LOG.features.json. One that fails does not stop the others, and a table has
/// the worst log first.
///
/// Exit codes: 0 done; 2 usage, configuration or input that cannot be read; 3 done, but the log is incomplete (2 with
/// --strict) or holds no echo, or there was nothing to replay. Of several logs the worst: 2, 3, 0.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "\
Examples:
  tmam replay drive.mcap                          drive.rrd and drive.features.json
  tmam replay drive.mcap --trace drive.jsonl      only the trace: why each arc was labelled so
  tmam replay drive.mcap --map drive.pgm          the map for nav2, with drive.yaml
  tmam replay drive.mcap --start 30 --end 60 --sensor 'sonar_0*' -o part.rrd
  tmam replay drives/*.mcap -o out                all of them, and a table with the worst one first
  tmam replay drives/*.mcap --arcs arcs --json | jq -r 'select(.causes != []).log'"
)]
pub struct Args {
    /// MCAP logs, folders of them, or patterns
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// Write the recording for the Rerun viewer here
    ///
    /// Of several logs it is the folder for recordings and features.
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
    /// Write the path that was used here, for evo (.tum) or Foxglove (.mcap)
    ///
    /// A pose per odometry sample: as TUM, or as nav_msgs/Odometry where the name ends in .mcap.
    #[arg(long, value_name = "FILE.tum", value_parser = path_file)]
    path: Option<PathBuf>,
    /// Write the map here: .geojson, .csv, .svg, or .pgm for nav2
    ///
    /// Beside a .pgm, a grid, the file of that name with .yaml is the one that nav2 asks for; it takes the place of any
    /// that is there.
    #[arg(long, value_name = "FILE", value_parser = map_file)]
    map: Option<PathBuf>,
    /// Write a table of arcs in Parquet here
    ///
    /// It has what the trace has, causes and the truth. Of several logs it is the folder for tables.
    #[arg(long, value_name = "FILE.parquet", value_parser = ending_in("parquet"))]
    arcs: Option<PathBuf>,
    /// Write no recording
    #[arg(long, hide_short_help = true)]
    no_recording: bool,
    /// Show the recording in an open viewer while it is made
    ///
    /// Files are then written only where they are named.
    #[arg(
        long,
        value_name = "URL",
        num_args = 0..=1,
        require_equals = true,
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
    #[arg(long, hide_short_help = true)]
    strict: bool,
    /// Say nothing but what went wrong
    #[arg(short, long)]
    quiet: bool,
    /// Tell what came of it in JSON (tmam.replayed/1), a line for each log
    ///
    /// The worst log comes first.
    #[arg(long, conflicts_with = "quiet")]
    json: bool,
    /// How many logs to replay at a time; 0: one per processor [default: 0]
    ///
    /// The outputs are the same.
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    jobs: usize,
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let config = self.parameters.configuration()?;
        let logs = drives::logs(&self.logs)?;
        match logs.as_slice() {
            [log] if !self.asks_for_folders(log) => self.one(log, &config),
            _ => self.several(&drives::drives(logs), &config),
        }
    }

    /// Whether outputs go into folders, as those of several logs do: they are named so, or the log is the only one
    /// of a folder or a pattern, which may have more tomorrow.
    fn asks_for_folders(&self, log: &Path) -> bool {
        let outputs = [&self.output, &self.features, &self.trace, &self.arcs];
        let mut named = outputs.into_iter().flatten();
        let is_there = |path: &PathBuf| path.is_dir() || path.to_string_lossy().ends_with('/');
        let is_named = self.logs.iter().any(|named| named == log);
        named.clone().any(is_there) || (!is_named && named.next().is_some())
    }

    fn one(&self, log: &Path, config: &Config) -> Result<Exit, Error> {
        let name = drives::drives(vec![log.to_owned()]).into_iter().next();
        let name = self
            .arcs
            .as_deref()
            .and_then(partition)
            .or(name.map(|drive| drive.name));
        let name = name.unwrap_or_default();
        let requested = self.requested();
        let mut outputs = requested.paths().to_vec();
        outputs.extend(self.json.then_some(Some(Path::new("-"))));
        refuse_collisions(&[], &outputs)?;
        let told = self.replay(log, &name, config, requested.clone(), true)?;
        show(&told.summary.problems, true)?;
        if self.json {
            print(&json_line(&name, Ok(&told.summary)))?;
        } else if !self.quiet {
            show(&told.closing, told.outputs.to_stdout())?;
        }
        told.outputs.commit()?;
        Ok(told.summary.exit)
    }

    fn several(&self, drives: &[Drive], config: &Config) -> Result<Exit, Error> {
        let folders = Requested {
            recording: self.output.clone().filter(|_| viewer::IS_BUILT_IN),
            features: self.features.clone().or_else(|| self.output.clone()),
            ..self.requested()
        };
        self.refuse_for_several(&folders, drives.len())?;
        let requested: Vec<Requested> = (drives.iter())
            .map(|drive| folders.of_drive(&drive.name))
            .collect();
        let inputs = drives.iter().map(|drive| drive.path.as_path());
        let inputs: Vec<&Path> = inputs.chain(self.parameters.file()).collect();
        let outputs: Vec<_> = requested.iter().flat_map(Requested::paths).collect();
        refuse_collisions(&inputs, &outputs)?;

        let progress = ReplaysProgress::new(drives.len(), "logs", !self.quiet);
        let fleet = Fleet::run(drives, self.jobs, |drive| {
            let requested = folders.of_drive(&drive.name);
            let told = self.replay(&drive.path, &drive.name, config, requested, false);
            progress.tick();
            let told = told?;
            told.outputs.commit().map_err(Error::from)?;
            Ok(told.summary)
        })?;
        drop(progress);
        show(&fleet.problems(), true)?;
        if self.json {
            print(&fleet.json_lines())?;
        } else if !self.quiet {
            show(&fleet.table(&Replayed::COLUMNS), false)?;
        }
        Ok(fleet.exit())
    }

    fn refuse_for_several(&self, folders: &Requested, logs: usize) -> Result<(), Error> {
        let is_of_one = [
            ("--path", self.path.is_some()),
            ("--map", self.map.is_some()),
            ("--connect", self.connect.is_some()),
            ("--spawn", self.spawn),
            ("-", folders.paths().into_iter().flatten().any(is_stdout)),
        ];
        let mut paths = folders.paths().into_iter().flatten();
        match is_of_one.into_iter().find(|(_, given)| *given) {
            Some((flag, _)) => Err(Error::ForOneLog { flag, logs }),
            None if let Some(path) = paths.find(|path| !is_folder(path)) => {
                let path = path.to_owned();
                Err(Error::FileOfSeveral { path, logs })
            }
            None if folders.paths().iter().all(Option::is_none) => Err(Error::NoFolder { logs }),
            None => Ok(()),
        }
    }

    /// Whether the stages of one log overlap, on threads of their own.
    fn overlaps(&self) -> bool {
        match self.jobs {
            0 => thread::available_parallelism().is_ok_and(|processors| processors.get() > 1),
            jobs => jobs > 1,
        }
    }

    fn requested(&self) -> Requested {
        Requested {
            recording: self.output.clone(),
            features: self.features.clone(),
            trace: self.trace.clone(),
            path: self.path.clone(),
            map: self.map.clone(),
            beside_map: self.map.as_deref().and_then(map_file::beside),
            arcs: self.arcs.clone(),
            inputs: self
                .parameters
                .file()
                .map(PathBuf::from)
                .into_iter()
                .collect(),
            no_recording: self.no_recording || !viewer::IS_BUILT_IN,
            live: self.connect.is_some() || self.spawn,
            ..Requested::default()
        }
    }

    /// Replays a log, called `name`, and writes its outputs, which are yet to take their names. Of one that is alone
    /// the stages overlap, and progress is shown.
    fn replay(
        &self,
        path: &Path,
        name: &str,
        config: &Config,
        mut requested: Requested,
        is_alone: bool,
    ) -> Result<Told, Error> {
        let mounts_from = config.input.mounts_from.as_ref();
        requested.inputs.extend(mounts_from.map(PathBuf::from));
        let mut truth = requested.arcs.is_some().then(RecordedTruth::default);
        let overlaps = is_alone && self.overlaps();
        let survey = survey::as_it_is_with(path, config, truth.as_mut(), overlaps)?;
        let log = &survey.log;
        if self.strict && !log.losses.is_empty() {
            return Err(Error::Incomplete {
                file: log.file.clone(),
                losses: log.losses.clone(),
            });
        }
        let replay = Replay::new(log, config)?;
        let setting = replay.setting();
        let is_partition = requested.arcs.as_deref().and_then(partition).is_some();
        let mut outputs = requested.open(path)?;
        let url = self.connect.clone();
        let url = url.or(self.spawn.then(|| DEFAULT_URL.to_owned()));
        let viewer = url.map(|url| Live::connect(&url, self.spawn)).transpose()?;

        let named = quoted(&path.display().to_string());
        let named = format!("{named}{}", self.parameters.as_typed());
        let file = outputs.recording.as_mut();
        let file = file.map(|out| out as &mut (dyn io::Write + Send));
        let mut recording = None;
        if file.is_some() || viewer.is_some() {
            let overlay = Overlay::default();
            recording = Some(Recording::new(file, viewer, setting, overlay)?);
        }
        let watched = thread::scope(|scope| {
            let mut progress = is_alone.then(|| Progress::new(&setting, !self.quiet));
            let scope = overlaps.then_some(scope);
            let mut recording = recording.map(|recording| Behind::new(recording, scope));
            let progress = progress.as_mut().map(|it| it as &mut dyn Observer);
            let mut observers: Vec<&mut dyn Observer> = progress.into_iter().collect();
            observers.extend(recording.as_mut().map(|r| r as &mut dyn Observer));
            let mut outcome = replay.run(&mut observers)?;
            outcome.stretch = least_explained(&replay, &outcome);
            let mut facts = Facts::new(&survey, Some(outcome));
            let found = findings(&Examined {
                facts: &facts,
                survey: &survey,
                attempt: &|config| attempted(path, config),
            });
            let mut outcome = facts.replay.outcome.take().unwrap_or_default();
            if !self.no_causes {
                let by_physics = causes_of(&found);
                outcome.causes = match by_physics.is_empty() {
                    true => causes::look_for(&replay, &outcome),
                    false => Some(by_physics),
                };
            }
            let serious = to_warn_of(&found);
            let mut source = setting.source.clone();
            source
                .notes
                .extend(serious.iter().map(|finding| finding.line()));
            let recording = recording.map(Behind::into_observer).transpose();
            let recording = recording.map_err(ReplayError::Observer)?.flatten();
            Ok::<_, Error>((recording, outcome, source, warnings(&serious, &named)))
        });
        let (recording, outcome, source, warned) = watched?;
        let setting = Setting {
            source: &source,
            ..setting
        };
        let (features, mut trace) = (&mut outputs.features, outputs.trace.as_mut());
        let write = |out| write_trace(out, &setting, &outcome);
        let lost = thread::scope(|scope| {
            let beside = trace.take_if(|_| overlaps);
            let beside = beside.map(|out| scope.spawn(|| write(out)));
            let mut lost = None;
            if let Some(mut recording) = recording {
                recording.tell(&outcome)?;
                let carried = carried(&setting, &outcome)?;
                lost = recording.close(Some(&carried))?;
            }
            if let Some(out) = features {
                let written = features::write(&mut *out, &setting, &outcome);
                written.map_err(|source| out.failed(source))?;
            }
            trace.map(write).transpose()?;
            beside.map(ended).transpose()?;
            Ok::<_, Error>(lost)
        })?;
        if let Some(out) = &mut outputs.path {
            path_file::write(out, &replay, &outcome).map_err(|source| out.failed(source))?;
        }
        if let Some(out) = &mut outputs.map {
            let path = replay.path(&outcome).into_iter();
            let path: Vec<_> = path.map(|(_, pose)| pose.position()).collect();
            let beside = outputs.beside_map.as_mut();
            map_file::write(out, beside, &setting, &outcome, &path)
                .map_err(|source| out.failed(source))?;
        }
        if let Some(out) = &mut outputs.arcs {
            // A truth that is of no use is none; `evaluate` says what is wrong with it.
            let truth = truth.and_then(|it| Truth::new(&replay, &it, None, AGREEING_RANGE).ok());
            let table = TableName {
                drive: name,
                is_partition,
            };
            let target = |arc: &Arc| {
                let target = truth.as_ref()?.target(arc);
                Some((target.name(), target.index()))
            };
            arc_table::write(&mut *out, table, &setting, &outcome, &target)
                .map_err(|source| out.failed(source))?;
        }
        let outputs = outputs.settle()?;

        let mut problems = report::problems(log, &setting, &outcome) + &warned;
        if let Some(lost) = lost {
            problems += &format!("warning: {lost}; the file has it all\n");
        }
        Ok(Told {
            closing: report::closing(&setting, &outcome, &named, &outputs.files()),
            outputs,
            summary: Replayed::new(&setting, &outcome, None, problems),
        })
    }
}

fn write_trace(
    out: &mut Output,
    setting: &Setting<'_>,
    outcome: &Outcome,
) -> Result<(), OutputError> {
    trace::write(&mut *out, setting.sonars, outcome).map_err(|source| out.failed(source))
}

/// What a thread came to.
fn ended<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    let ended = thread.join();
    ended.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// What is told of a log that was replayed.
struct Told {
    summary: Replayed,
    closing: String,
    outputs: Settled,
}

fn map_file(name: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(name);
    match MapFormat::of(&file) {
        Some(_) => Ok(file),
        None => Err("the name of a map ends in .geojson, .csv, .svg or .pgm".to_owned()),
    }
}

fn path_file(name: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(name);
    match PathFormat::of(&file) {
        Some(_) => Ok(file),
        None => Err("the name of a path ends in .tum, .txt or .mcap".to_owned()),
    }
}
