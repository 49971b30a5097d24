//! `stiction paper`.

use crate::folder::Folder;

#[test]
fn tables_and_figures_that_the_paper_has_not_are_refused() {
    let folder = Folder::new("paper-numbers", "");
    folder.run(&["paper", "--table", "13"]).ends(2, &["--table 13", "no table 13", "1 to 12"]);
    folder.run(&["paper", "--table", "1", "--table", "0"]).ends(2, &["--table 0", "1 to 12"]);
    folder.run(&["paper", "--figure", "7"]).ends(2, &["--figure 7", "1 to 6"]);
    folder.run(&["paper", "--table", "first"]).ends(2, &["first", "--table"]);
    folder.write("taken", "");
    folder.run(&["paper", "--table", "1", "-o", "taken/report"]).ends(2, &["taken/report", "-o DIR"]);
    assert_eq!(folder.names(), ["case.toml", "taken"], "nothing is written");
}

#[test]
fn a_quick_run_writes_a_report_with_its_fits_and_verdicts() {
    let folder = Folder::new("paper-quick", "");
    let figures = ["--figure", "1", "--figure", "5"];
    let arguments =
        [&["paper", "--quick", "--table", "10", "--table", "9", "--progress", "plain"][..], &figures].concat();
    let run = folder.run(&arguments);
    run.ends(0, &["table  9: CFS1", "table 10: CFS2, rho 1e-10", "figure 5"]);
    assert!(run.out.contains("10 of 10 judged numbers within their bands"), "{run:#?}");
    let names = ["figure01.png", "figure01.svg", "figure05.png", "figure05.svg", "report.html", "report.md"];
    assert_eq!(folder.names_in("paper"), [&names[..], &["table09.csv", "table10.csv"]].concat());
    let read = |name: &str| std::fs::read_to_string(folder.path.join("paper").join(name)).unwrap();
    let html = read("report.html");
    // Self-contained: nothing is fetched, both figures are inside.
    assert!(!html.contains("src=") && !html.contains("<link") && html.matches("<svg ").count() == 2);
    for text in [&html, &read("report.md")] {
        assert!(text.contains("FITTED") && text.contains("loads times 4") && text.contains("0.0244"), "{text}");
    }
    let csv = read("table09.csv");
    let changes: Vec<&str> =
        csv.lines().filter(|line| line.contains("Rel error") && line.contains(",within,")).collect();
    assert_eq!(changes.len(), 2, "{csv}");
    assert!(changes[0].starts_with("N = 4,Rel error,fitted,0.0244,0.02"), "{csv}");
    // Once more into the same folder: replaced, not refused; nothing said on request.
    let again = folder.run(&["paper", "--quick", "--table", "9", "--progress", "none"]);
    again.ends(0, &[]);
    assert!(again.err.is_empty());
}
