//! What the documents say of files and keys: links lead somewhere, and the case files they show are understood.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use stiction::io::case;

/// The Markdown files of the repository, with their texts.
fn documents() -> Vec<(PathBuf, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().to_string();
            if path.is_dir() && name != "target" && !name.starts_with('.') {
                walk(&path, found);
            } else if name.ends_with(".md") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    let mut found = Vec::new();
    // Folders of results that a user writes into the clone are none of ours.
    for folder in ["docs", "cases", "bench", "crates", "tests"] {
        walk(&root.join(folder), &mut found);
    }
    found.extend(["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md"].map(|name| root.join(name)));
    found.into_iter().map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect()
}

/// The text outside of blocks of code, and the blocks that begin with `kind`.
fn blocks(text: &str, kind: &str) -> (String, Vec<String>) {
    let (mut prose, mut found, mut inside) = (String::new(), Vec::new(), None);
    for line in text.lines() {
        match (&mut inside, line.trim_start().strip_prefix("```")) {
            (Some(_), Some(_)) => inside = None,
            (None, Some(name)) => {
                inside = Some(name == kind);
                if name == kind {
                    found.push(String::new());
                }
            }
            (Some(true), None) => *found.last_mut().unwrap() += &format!("{line}\n"),
            (Some(false), None) => {}
            (None, None) => prose += &format!("{line}\n"),
        }
    }
    (prose, found)
}

/// The anchor of a heading, as GitHub makes it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_relative_link_of_the_documents_leads_to_a_file_and_a_heading() {
    let mut seen = 0;
    for (path, text) in documents() {
        let (prose, _) = blocks(&text, "");
        for (start, _) in prose.match_indices("](") {
            let link = prose[start + 2..].split(')').next().unwrap();
            if link.contains("://") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            let shown = path.display();
            assert!(target.exists(), "{shown}: {link}");
            if !heading.is_empty() {
                let (prose, _) = blocks(&fs::read_to_string(&target).unwrap(), "");
                let headings: HashSet<String> =
                    prose.lines().filter(|l| l.starts_with('#')).map(|l| anchor(l.trim_start_matches('#'))).collect();
                assert!(headings.contains(heading), "{shown}: {link}");
            }
            seen += 1;
        }
    }
    assert!(seen > 40, "{seen}");
}

/// What stands between backticks.
fn spans(prose: &str) -> impl Iterator<Item = &str> {
    prose.split('`').skip(1).step_by(2)
}

#[test]
fn every_file_that_a_page_for_users_or_the_map_of_the_code_names_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    let mut seen = 0;
    for (path, text) in documents() {
        // A dated note keeps the names of its day.
        if path.parent().unwrap().ends_with("notes") {
            continue;
        }
        let map = path.ends_with("ARCHITECTURE.md");
        let (prose, _) = blocks(&text, "");
        for span in spans(&prose) {
            let from_root =
                ["docs/", "crates/", "bench/", "cases/", "tests/"].iter().any(|folder| span.starts_with(folder));
            let of_the_map = map && span.ends_with(".rs") && span.contains('/') && !span.contains("NAME");
            if span.contains(' ') || !(from_root || of_the_map) {
                continue;
            }
            let file = if from_root { root.join(span) } else { root.join("crates/stiction/src").join(span) };
            assert!(file.exists(), "{}: {span}", path.display());
            seen += 1;
        }
    }
    assert!(seen > 30, "{seen}");
}

/// A block of a document completed to a case by the tables it leaves out.
fn completed(block: &str) -> String {
    let mut text = block.to_string();
    let missing = |header: &str| !block.contains(header);
    if missing("[mesh") {
        text += "[mesh]\nblock = { size = [1, 1, 1], cells = [1, 1, 1] }\n";
    }
    if missing("[materials") {
        text += "[materials.any]\nyoung = 1\npoisson = 0.3\n";
    }
    if block.contains("[accuracy]") && missing("[[contact]]") {
        text += "[[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\nfriction = \"none\"\n";
    }
    let mut steps: Vec<&str> = Vec::new();
    for line in block.lines() {
        let Some((key, value)) = line.split_once(" = \"") else { continue };
        if let Some((name, _)) = value.split_once('"')
            && ["lock", "from", "until"].contains(&key)
            && !steps.contains(&name)
        {
            steps.push(name);
        }
    }
    if missing("[[step]]") && !steps.is_empty() {
        for (number, name) in steps.iter().enumerate() {
            text += &format!("[[step]]\nname = \"{name}\"\nuntil = {}\n", number + 1);
        }
        text += &format!("[[step]]\nuntil = {}\n", steps.len() + 1);
    }
    text
}

#[test]
fn every_case_the_documents_show_is_understood() {
    let mut seen = 0;
    for (path, text) in documents() {
        for block in blocks(&text, "toml").1 {
            let name = path.display().to_string();
            case::parse(&completed(&block), &name, &[]).unwrap_or_else(|e| panic!("{e}\nin\n{block}"));
            seen += 1;
        }
    }
    assert!(seen > 10, "{seen}");
}
