//! A folder of its own for each test, and the command run in it.

// Each test file uses its own part of this.
#![allow(dead_code)]

use std::path::PathBuf;
use std::process::{Command, Output};

/// A block on a plane with sticking, slipping and opening points.
pub const CASE: &str = r#"
title = "Block"
units = "m, N, Pa"

[mesh]
block = { size = [3, 1, 1], cells = [9, 3, 3], element = "hex8" }

[materials.steel]
young = 21.19e10
poisson = 0.277

[[fix]]
on = "x-min"

[[load]]
on = "z-max"
traction = [0, 0, "-2/3*1e6*(3 - x)"]

[[load]]
on = "x-max"
traction = [0, 0, 1e6]

[[contact]]
on = "z-min"
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = { coulomb = 0.35 }
"#;

/// A folder with a case file in it; removed at the end.
pub struct Folder {
    pub path: PathBuf,
}

impl Folder {
    /// `name` is that of the test.
    pub fn new(name: &str, case: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("stiction-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        let folder = Folder { path };
        folder.write("case.toml", case);
        folder
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path.join(name), text).unwrap();
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
        command.args(arguments).current_dir(&self.path);
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::of(self.command(arguments).output().unwrap())
    }

    pub fn exists(&self, name: &str) -> bool {
        self.path.join(name).exists()
    }

    /// Names of all files and folders in it, sorted.
    pub fn names(&self) -> Vec<String> {
        self.names_in("")
    }

    /// The same of a folder in it.
    pub fn names_in(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path.join(folder)).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// `summary.json` of a result folder.
    pub fn summary(&self, results: &str) -> serde_json::Value {
        let text = std::fs::read_to_string(self.path.join(results).join("summary.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.path);
    }
}

/// How a command ended.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Run {
    pub fn of(output: Output) -> Run {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Run { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    /// Asserts the exit code and that standard error says all of `words`.
    #[track_caller]
    pub fn ends(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{self:#?}");
        words.iter().for_each(|word| assert!(self.err.contains(word), "{word:?} is not in {self:#?}"));
    }
}

/// Two cubes on top of each other, with groups of the bottom, of the top, of the face between them and of all cells.
pub fn two_cubes() -> String {
    let mut text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n4\n2 1 \"bottom\"\n2 2 \"middle\"\n2 3 \
                    \"top\"\n3 4 \"body\"\n$EndPhysicalNames\n$Nodes\n12\n"
        .to_string();
    for z in 0..3 {
        for (i, [x, y]) in [[0, 0], [1, 0], [1, 1], [0, 1]].into_iter().enumerate() {
            text += &format!("{} {x} {y} {z}\n", 4 * z + i + 1);
        }
    }
    text += "$EndNodes\n$Elements\n5\n";
    for z in 0..3 {
        let n: Vec<String> = (1..=4).map(|i| (4 * z + i).to_string()).collect();
        text += &format!("{} 3 2 {} {} {}\n", z + 1, z + 1, z + 1, n.join(" "));
    }
    for z in 0..2 {
        let n: Vec<String> = (1..=8).map(|i| (4 * z + i).to_string()).collect();
        text += &format!("{} 5 2 4 4 {}\n", z + 4, n.join(" "));
    }
    text + "$EndElements\n"
}
