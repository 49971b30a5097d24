//! The order of the modules, read from their `crate::` paths.

use std::fs;
use std::path::{Path, PathBuf};

/// What each module may use besides itself and `Error`.
const MAY_USE: &[(&str, &[&str])] = &[
    ("ranks", &[]),
    ("linalg", &["ranks"]),
    ("mesh", &["ranks"]),
    ("fem", &["linalg", "mesh"]),
    ("contact", &["ranks", "linalg", "mesh", "fem"]),
    ("accuracy", &["linalg", "mesh", "fem", "contact", "certificate"]),
    ("dual", &["linalg", "contact"]),
    ("certificate", &["ranks", "linalg", "contact"]),
    ("qp", &["linalg"]),
    ("friction", &["ranks", "linalg", "contact", "dual", "certificate", "qp"]),
    ("discrete", &["linalg", "contact", "friction"]),
    ("io", &["linalg", "mesh", "fem", "contact", "dual", "certificate", "qp", "friction", "discrete"]),
    ("solve", &["linalg", "contact", "dual", "friction"]),
    (
        "run",
        &[
            "ranks",
            "linalg",
            "mesh",
            "fem",
            "contact",
            "accuracy",
            "dual",
            "certificate",
            "qp",
            "friction",
            "discrete",
            "io",
            "solve",
        ],
    ),
];

fn sources() -> Vec<(PathBuf, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/stiction/src");
    let mut found = Vec::new();
    walk(&root, &mut found);
    found.sort();
    assert!(found.len() > 40, "{}", found.len());
    let named = |path: PathBuf| {
        let text = fs::read_to_string(&path).unwrap();
        (path.strip_prefix(&root).unwrap().to_path_buf(), text)
    };
    found.into_iter().map(named).collect()
}

/// The module a file belongs to: the first part of its path.
fn module(path: &Path) -> String {
    path.components().next().unwrap().as_os_str().to_str().unwrap().trim_end_matches(".rs").to_string()
}

/// Tests may read files and print.
fn is_test(path: &Path) -> bool {
    path.components().any(|c| c.as_os_str().to_str().unwrap().trim_end_matches(".rs").ends_with("tests"))
}

/// Comments do not import anything.
fn code(text: &str) -> String {
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or("").trim());
    lines.collect::<Vec<_>>().join(" ")
}

/// Names after `crate::`, those of a group `crate::{a::.., b}` included.
fn crate_names(code: &str) -> Vec<String> {
    names_after("crate::", code)
}

fn names_after(prefix: &str, code: &str) -> Vec<String> {
    let mut names = Vec::new();
    for (start, _) in code.match_indices(prefix) {
        let rest = &code[start + prefix.len()..];
        let Some(group) = rest.strip_prefix('{') else {
            names.push(rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect());
            continue;
        };
        let (mut depth, mut at_name, mut name) = (0, true, String::new());
        for c in group.chars() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    names.push(std::mem::take(&mut name));
                    at_name = true;
                    continue;
                }
                _ => {}
            }
            at_name &= c.is_alphanumeric() || c == '_' || c == ' ';
            if at_name && c != ' ' && depth == 0 {
                name.push(c);
            }
        }
        names.push(name);
    }
    names.into_iter().filter(|n| !n.is_empty()).collect()
}

#[test]
fn the_reader_of_paths_understands_groups() {
    let text = "use crate::{Error, fem::{Fix, Load}, mesh::Mesh}; let x = crate::io::read(crate::Error::new());";
    assert_eq!(crate_names(text), ["Error", "fem", "mesh", "io", "Error"]);
}

#[test]
fn every_arrow_between_modules_follows_the_order() {
    let mut arrows = 0;
    for (path, text) in sources() {
        let here = module(&path);
        if here == "lib" || here == "error" {
            continue;
        }
        let allowed = MAY_USE.iter().find(|(name, _)| *name == here).unwrap_or_else(|| panic!("{here} has no place")).1;
        for name in crate_names(&code(&text)) {
            let free = name == here || name == "Error";
            arrows += usize::from(!free);
            let shown = path.display();
            assert!(free || allowed.contains(&name.as_str()), "{shown}: {here} must not use {name}");
        }
    }
    assert!(arrows > 20, "{arrows}");
}

/// The rooms of `run`, the way through all of them, and that of several ranks: each uses those before it. Paths into another room are written in full.
#[test]
fn a_case_is_posed_then_solved_then_written() {
    const ROOMS: [&str; 6] = ["pose", "solve", "refine", "results", "whole", "ranks"];
    let mut arrows = 0;
    for (path, text) in sources() {
        let parts: Vec<&str> = path.iter().filter_map(|part| part.to_str()).collect();
        let ["run", room, ..] = parts[..] else { continue };
        let room = room.trim_end_matches(".rs");
        if room == "mod" {
            continue;
        }
        let (shown, code) = (path.display(), code(&text));
        let place = ROOMS.iter().position(|r| *r == room).unwrap_or_else(|| panic!("{shown} is in no room of run"));
        for name in names_after("crate::run::", &code) {
            arrows += usize::from(name != room);
            assert!(ROOMS[..=place].contains(&name.as_str()), "{shown}: {room} must not use {name}");
        }
        assert!(!code.contains("super::super::"), "{shown}: write the path from the root");
    }
    assert!(arrows > 20, "{arrows}");
}

#[test]
fn only_io_and_run_open_files_and_nobody_prints() {
    for (path, text) in sources() {
        let here = module(&path);
        let code = code(&text);
        let shown = path.display();
        for word in ["println!", "eprintln!", "print!", "eprint!", "dbg!"] {
            assert!(is_test(&path) || !code.contains(word), "{shown} uses {word}");
        }
        for word in ["std::fs", " fs::", "(fs::", " File::", "(File::"] {
            let opens = code.contains(word) && !is_test(&path);
            assert!(!opens || here == "io" || here == "run", "{shown} uses {word}");
        }
    }
}

#[test]
fn the_certificate_shares_no_code_with_the_solvers() {
    for (path, text) in sources() {
        if module(&path) == "certificate" {
            let code = code(&text);
            let names = crate_names(&code);
            // Of the ranks their messages alone: the plans of values at borders are the solver's.
            let mine = ["contact", "linalg", "ranks", "Error", "certificate"];
            assert!(names.iter().all(|n| mine.contains(&n.as_str())) && !code.contains("Halo"), "{names:?}");
        }
    }
}

#[test]
fn files_are_small() {
    for (path, text) in sources() {
        assert!(text.lines().count() < 600, "{}", path.display());
    }
}
