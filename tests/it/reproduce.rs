//! `tmam reproduce`: the page of the paper's experiment is what the command makes.

use std::fs;
use std::path::Path;

use crate::support::Bench;

#[test]
fn the_page_and_its_figures_are_what_the_command_makes() {
    let bench = Bench::new();
    fs::create_dir(bench.path("docs")).unwrap();
    let run = bench.sh("tmam reproduce -o docs");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    for name in ["table1.md", "figure5.svg", "figure6.svg"] {
        let made = bench.bytes(&format!("docs/{name}"));
        if std::env::var_os("TMAM_UPDATE_DOCS").is_some() {
            fs::write(docs.join(name), made).unwrap();
        } else {
            let held = fs::read(docs.join(name)).unwrap();
            assert!(
                held == made,
                "docs/{name} is another one: tmam reproduce -o docs"
            );
        }
    }
}
