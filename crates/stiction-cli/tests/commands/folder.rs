//! A folder of its own for each test, and the command run in it.

use std::ops::Deref;
use std::process::{Command, Output};

pub use stiction_fixtures::case_run::CASE;

/// A folder with a case file in it; removed at the end.
pub struct Folder(stiction_fixtures::folder::Folder);

impl Deref for Folder {
    type Target = stiction_fixtures::folder::Folder;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl Folder {
    /// `name` is that of the test.
    pub fn new(name: &str, case: &str) -> Folder {
        let folder = stiction_fixtures::folder::Folder::new(name);
        folder.write("case.toml", case);
        Folder(folder)
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
        command.args(arguments).current_dir(&self.path);
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::of(self.command(arguments).output().unwrap())
    }

    /// `summary.json` of a result folder.
    pub fn summary(&self, results: &str) -> serde_json::Value {
        let text = std::fs::read_to_string(self.path.join(results).join("summary.json")).unwrap();
        serde_json::from_str(&text).unwrap()
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
