//! `tmam diff`

use std::path::{Path, PathBuf};

use serde_json::json;

use super::check::Compared;
use super::parameters::{MethodName, Parameters};
use crate::cli::error::Error;
use crate::cli::named::ending_in;
use crate::core::exit::Exit;
use crate::core::legible::inert_line;
use crate::io::config::file::assignment;
use crate::io::log::container::is_one_recording;
use crate::io::output::{Output, print, show};
use crate::io::outputs::{Settled, refuse_collisions};
use crate::observe::report::written;
use crate::tools::diff::drawing::write;
use crate::tools::diff::folders::Folders;
use crate::tools::diff::{Diff, Terms, together};
use crate::tools::golden::SHOWN;

/// Compare two results: of logs, recordings, feature files or golden files
///
/// Lines are paired with lines and points with points by nearness; labels are compared by sonar and
/// stamp where both sides have them (all but feature files do). Ids and order do not matter.
///
/// A log beside a recording, a features.json or a golden file is replayed with the configuration recorded there,
/// other logs with the defaults; the parameters that are given stand over either.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    override_usage = "\
tmam diff [OPTIONS] <A> <B>
       tmam diff [OPTIONS] <LOG> <--set-b KEY=VALUE|--config-b FILE.toml|--method-b METHOD>",
    after_help = "\
Exit codes: 0 nothing differs; 1 something does; 2 usage or a file that cannot be read; 3 a log is \
incomplete, or neither side holds a feature.

Examples:
  tmam diff before.features.json after.features.json
  tmam diff monday.rrd tuesday.rrd                          what two recordings carry
  tmam diff drive.mcap --set-b frames.step=0.15             one log under two configurations
  tmam diff drive.mcap --method-a tmam --method-b tbf       one log by two methods
  tmam diff out-main out-branch                             two folders, by the names of their files
  tmam diff monday.rrd tuesday.rrd -o both.rrd              both maps over each other"
)]
pub struct Args {
    /// A log, a recording, a features.json or a golden file; or a folder of them
    a: PathBuf,
    /// Another one [default: the same log, with --set-b, --config-b or --method-b]
    #[arg(required_unless_present_any = ["config_b", "set_b", "method_a", "method_b"])]
    b: Option<PathBuf>,
    /// Configuration file for B
    #[arg(long, value_name = "FILE.toml")]
    config_b: Option<PathBuf>,
    /// A key of the configuration that is otherwise for B, repeatable: triple.gamma=8
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment)]
    set_b: Vec<String>,
    /// Method that A is replayed with [default: that of both]
    #[arg(long, value_name = "METHOD", value_enum, hide_short_help = true)]
    method_a: Option<MethodName>,
    /// Method that B is replayed with [default: that of both]
    #[arg(long, value_name = "METHOD", value_enum, hide_short_help = true)]
    method_b: Option<MethodName>,
    /// Write a recording of the differences here
    ///
    /// They are drawn over the run of B where B is a log, else over that of A, else both maps over each other.
    #[arg(short, long = "output", value_name = "FILE.rrd", value_parser = ending_in("rrd"))]
    output: Option<PathBuf>,
    /// A tolerance, repeatable: rho=0.02 (metres and radians)
    ///
    /// Those that are not given are of the golden file, if one is compared.
    #[arg(long, value_name = "KEY=VALUE")]
    tolerance: Vec<String>,
    /// What to compare
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = Compared::All)]
    compare: Compared,
    /// Borderline labels are differences, too
    #[arg(long, hide_short_help = true)]
    strict: bool,
    /// Say nothing: the exit code tells
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
    /// Print the differences in JSON (tmam.diff/1): SI units and radians
    #[arg(long)]
    json: bool,
    /// How many differences of a kind to print
    #[arg(long, value_name = "N", default_value_t = SHOWN)]
    show: usize,
    #[command(flatten)]
    parameters: Parameters,
}

impl Args {
    pub fn run(self) -> Result<Exit, Error> {
        let mut both = self.parameters.layers()?;
        both.extend(self.method_a.map(MethodName::layer));
        let mut b = self
            .parameters
            .varied_layers(self.config_b.clone(), &self.set_b)?;
        b.extend(self.method_b.map(MethodName::layer));
        let b_differs =
            self.config_b.is_some() || !self.set_b.is_empty() || self.method_b.is_some();
        let terms = Terms {
            both,
            b,
            b_differs,
            tolerances: self.tolerance.clone(),
            only_map: self.compare == Compared::Map,
            drawn: self.output.is_some(),
        };
        let b = self.b.as_ref().unwrap_or(&self.a);
        if [&self.a, b].iter().all(|path| is_folder(path)) {
            let folders = Folders::of(&self.a, b)?;
            // Too many runs to keep, and one recording shows one.
            let terms = Terms {
                drawn: false,
                ..terms
            };
            return self.of_folders(&folders, &terms);
        }
        let out = self.open(&[self.a.as_path(), b])?;
        let diff = Diff::new(&self.a, self.b.as_deref(), &terms)?;
        self.say(&if self.json {
            format!("{:#}\n", diff.json(self.strict))
        } else {
            diff.text(self.show, self.strict)
        })?;
        let exit = diff.exit(self.strict);
        self.draw(&[diff], out)?;
        Ok(exit)
    }

    fn of_folders(&self, folders: &Folders, terms: &Terms) -> Result<Exit, Error> {
        let inputs = folders.pairs.iter().flatten().map(PathBuf::as_path);
        let out = self.open(&inputs.collect::<Vec<_>>())?;
        let mut all = Vec::new();
        for [a, b] in &folders.pairs {
            let diff = Diff::new(a, Some(b), terms)?;
            if !self.json {
                self.say(&format!("{}\n", diff.text(self.show, self.strict)))?;
            }
            all.push(diff);
        }
        let alone = folders.alone.iter().map(|file| file.display().to_string());
        let alone: Vec<String> = alone.collect();
        let exits: Vec<Exit> = all.iter().map(|diff| diff.exit(self.strict)).collect();
        let exit = if exits.contains(&Exit::Differs) || !alone.is_empty() {
            Exit::Differs
        } else {
            Exit::of_whole(!exits.is_empty() && !exits.contains(&Exit::Incomplete))
        };
        if self.json {
            let pairs = all.iter().map(|diff| diff.json(self.strict));
            let pairs: Vec<_> = pairs.collect();
            let said = json!({ "exit_code": exit.code(), "pairs": pairs, "alone": alone });
            self.say(&format!("{said:#}\n"))?;
        } else {
            for file in alone {
                self.say(&format!(
                    "{} has nothing of its name or its drive beside it\n",
                    inert_line(&file)
                ))?;
            }
            self.say(&together(&all))?;
        }
        self.draw(&all, out)?;
        Ok(exit)
    }

    fn say(&self, text: &str) -> Result<(), Error> {
        match self.quiet {
            true => Ok(()),
            false => Ok(print(text)?),
        }
    }

    /// Opens the output, which is none of what is read.
    fn open(&self, read: &[&Path]) -> Result<Option<Output>, Error> {
        let configs = self.parameters.file().into_iter();
        let configs = configs.chain(self.config_b.as_deref());
        let inputs: Vec<&Path> = read.iter().copied().chain(configs).collect();
        let json = self.json.then(|| Path::new("-"));
        refuse_collisions(&inputs, &[json, self.output.as_deref()])?;
        Ok(self.output.as_deref().map(Output::create).transpose()?)
    }

    /// Writes the recording, where one is asked for.
    fn draw(&self, all: &[Diff], out: Option<Output>) -> Result<(), Error> {
        let Some(mut out) = out else {
            return Ok(());
        };
        write(all, &mut out)?;
        let output = Settled::new([out])?;
        if !self.quiet {
            show(&written(&output.files()), self.json)?;
        }
        Ok(output.commit()?)
    }
}

/// Whether it holds files to be compared, each for itself.
fn is_folder(path: &Path) -> bool {
    path.is_dir() && !is_one_recording(path)
}
