//! The commands of the README and the documentation, run as the pages have them.
//!
//! Every line of a `sh` block and every `tmam` command of a `yaml` block runs, page by page, in a
//! folder with the files that the pages take for granted. Those of `cargo` are for `.ci/run`.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{Bench, sample};

/// The pages: the README, and all of `docs/`.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = fs::read_dir(root.join("docs")).unwrap();
    let docs = docs.map(|entry| entry.unwrap().path());
    let mut pages: Vec<_> = docs
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .collect();
    pages.push(root.join("README.md"));
    pages.sort();
    pages
}

/// The blocks of a kind on a page.
fn blocks<'a>(page: &'a str, kind: &str) -> Vec<&'a str> {
    let begin = format!("\n```{kind}\n");
    let after = page.split(&begin).skip(1);
    after
        .map(|text| text.split("```").next().unwrap())
        .collect()
}

/// The commands on a page, in order.
fn commands(page: &str) -> Vec<String> {
    let mut commands = Vec::new();
    for line in blocks(page, "sh").into_iter().flat_map(str::lines) {
        if !line.starts_with("cargo ") {
            commands.push(line.to_owned());
        }
    }
    for block in blocks(page, "yaml") {
        let mut lines = block.lines().map(str::trim).peekable();
        while let Some(line) = lines.next() {
            let line = line.trim_start_matches("- ").trim_start_matches("run: ");
            if line.starts_with("tmam ") {
                let mut command = line.to_owned();
                while let Some(more) = lines.next_if(|line| line.starts_with("--")) {
                    command = format!("{command} {more}");
                }
                commands.push(command.replace("${{ matrix.part }}", "1"));
            }
        }
    }
    commands
}

/// A folder with the sample logs, and with the names that the pages give to logs of the reader's own.
fn folder() -> Bench {
    let bench = Bench::new();
    fs::create_dir(bench.path("drives")).unwrap();
    for log in ["room_step.mcap", "room_drive.mcap"] {
        fs::copy(sample(log), bench.path(log)).unwrap();
    }
    fs::create_dir(bench.path("sample_logs")).unwrap();
    let trouble = "room_trouble.mcap";
    fs::copy(sample(trouble), bench.path("sample_logs").join(trouble)).unwrap();
    let drive = sample("room_drive.mcap");
    for copy in ["drive.mcap", "drives/monday.mcap", "drives/tuesday.mcap"] {
        fs::copy(&drive, bench.path(copy)).unwrap();
    }
    let walls = r#"{"walls": [[0,0,4,0],[4,0,4,2],[4,2,8,2],[8,2,8,5],[8,5,0,5],[0,5,0,0]]}"#;
    bench.put("walls.json", walls);
    let blessed = bench.sh("tmam check drives/*.mcap --golden golden --bless");
    assert_eq!(blessed.code, 0, "{}", blessed.stderr);
    bench
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn every_command_of_the_pages_runs() {
    std::thread::scope(|scope| {
        for page in pages() {
            scope.spawn(move || every_command_runs(&page));
        }
    });
}

fn every_command_runs(page: &Path) {
    let text = fs::read_to_string(page).unwrap();
    let bench = folder();
    for command in commands(&text) {
        // As a runner of GitLab has it.
        let run = bench.sh(&format!("CI_NODE_INDEX=1 CI_NODE_TOTAL=2; {command}"));
        // `diff` ends in 1 where it has something to show.
        let differs = command.starts_with("tmam diff") && run.code == 1;
        assert!(
            run.code == 0 || differs,
            "{}: {command}\n{}{}",
            page.display(),
            run.stdout,
            run.stderr
        );
    }
}

#[test]
#[cfg_attr(not(feature = "viewer"), ignore = "needs recordings")]
fn the_readme_shows_what_its_first_command_says() {
    let readme =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let run = folder().sh("tmam replay sample_logs/room_trouble.mcap");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(
        blocks(&readme, "text").contains(&run.stdout.as_str()),
        "{}",
        run.stdout
    );
}

#[test]
fn most_pages_have_commands() {
    let of_page = |page: &PathBuf| commands(&fs::read_to_string(page).unwrap()).len();
    let counts: Vec<usize> = pages().iter().map(of_page).collect();
    assert!(counts.iter().sum::<usize>() > 20, "{counts:?}");
}

/// What a heading is linked by.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase();
    let kept = kept
        .chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_link_to_a_page_or_a_file_leads_there() {
    let mut followed = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        let links = text.split("](").skip(1);
        let links = links.filter_map(|rest| rest.split_once(')').map(|(link, _)| link));
        for link in links.filter(|link| !link.contains("://")) {
            let (file, to) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => page.clone(),
                _ => page.parent().unwrap().join(file),
            };
            assert!(target.exists(), "{}: {link}", page.display());
            if !to.is_empty() {
                let headings = fs::read_to_string(&target).unwrap();
                let headings = headings.lines().filter(|line| line.starts_with('#'));
                let mut anchors = headings.map(|line| anchor(line.trim_start_matches('#').trim()));
                assert!(
                    anchors.any(|anchor| anchor == to),
                    "{}: {link}",
                    page.display()
                );
            }
            followed += 1;
        }
    }
    assert!(followed > 50, "{followed}");
}
