//! Runs of the command that are killed, told to stop, or whose disk fails: what stands afterwards is a true result or is
//! refused, and a run that goes on from it ends with the same bits as one that nothing disturbed.
//!
//! The faults come from a library that is loaded before the C library, `faults.c`. Those at a call of a given number are
//! the same in every campaign of the same seed, except where threads of one run write at the same time.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use stiction::run;

use crate::case_run::CASE;
use crate::folder::Folder;
use crate::fuzz::Random;
use crate::tamper::stepped_case;

/// Cases with options of the command; the other ends of the same kinds are results that lie in the folder before.
fn scenes() -> Vec<(&'static str, String, &'static [&'static str])> {
    let smaller = |text: &str| text.replace("[9, 3, 3]", "[6, 2, 2]");
    let blocks = "[mesh.parts.a]\nblock = { size = [10, 10, 10], cells = [3, 3, 3], element = \"hex8\" }\n\
         [mesh.parts.b]\nblock = { size = [10, 10, 10], cells = [2, 2, 2], element = \"hex8\", origin = [0, 0, 14] }\n\
         [materials.s]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"a.z-min\"\n[[fix]]\non = \"b.z-max\"\n\
         value = [0, 0, \"-6*t\"]\n[[contact]]\non = \"b.z-min\"\nagainst = \"a.z-max\"\nfriction = { coulomb = 0.3 }\n\
         [[step]]\nuntil = 1\nincrements = 3\n";
    vec![
        ("static", smaller(CASE), &[]),
        ("steps", smaller(&stepped_case()), &[]),
        // Of other forces: how a case is solved may change when it is resumed, and then the last digits do.
        (
            "steps, multigrid",
            smaller(&stepped_case()).replace("0.35", "0.3"),
            &["--set", "solver.path=multigrid", "--no-report"],
        ),
        // Solved once more with contact that the first run did not look for.
        ("steps, widened", blocks.into(), &["--no-report"]),
    ]
}

/// What is done at the n-th call, and what is done after a time.
const AT_A_CALL: [&str; 8] = ["enospc", "eio", "full", "dead", "kill", "half", "term", "int"];
const AFTER_A_TIME: [&str; 3] = ["kill", "term", "int"];
/// A run takes a fraction of a second.
const HANGS: Duration = Duration::from_secs(60);

/// What came of a campaign.
#[derive(Debug, Default)]
pub struct Report {
    /// Disturbed runs by case, fault and how they ended.
    pub runs: BTreeMap<String, usize>,
    /// What did not hold.
    pub findings: Vec<String>,
}

/// Files of a result folder by their names, without times.
type Contents = BTreeMap<String, Vec<u8>>;

struct Scene {
    name: &'static str,
    arguments: Vec<String>,
    stepped: bool,
    /// Calls on files of the folder, and time, of a run that nothing disturbs.
    calls: usize,
    micros: usize,
    /// Files as they are, and without times.
    files: Contents,
    result: Contents,
}

/// Disturbs `count` runs of `command`, each followed by one that is left alone.
pub fn campaign(command: &Path, seed: u64, count: usize) -> Report {
    let folder = Folder::new("faults");
    let (source, shim) = (folder.write("faults.c", include_str!("faults.c")), folder.at("faults.so"));
    let made = Command::new("cc").args(["-shared", "-fPIC", "-O1", "-o"]).args([&shim, &source]).status();
    assert!(made.is_ok_and(|status| status.success()), "cc cannot make the library of faults");
    let runner = Runner { command, folder: &folder, shim };
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let scenes: Vec<Scene> = scenes().into_iter().enumerate().map(|(k, scene)| runner.scene(k, scene)).collect();
    let mut report = Report::default();
    while report.runs.values().sum::<usize>() < count {
        runner.trial(&scenes, &mut random, &mut report);
    }
    report
}

struct Runner<'a> {
    command: &'a Path,
    folder: &'a Folder,
    shim: PathBuf,
}

/// How a run ended: its exit code, none after a signal, and what it said on standard error.
struct Ended {
    code: Option<i32>,
    err: String,
    hung: bool,
}

impl Runner<'_> {
    fn run(&self, arguments: &[String], fault: &[(&str, String)]) -> Ended {
        let mut command = Command::new(self.command);
        command.args(arguments).current_dir(&self.folder.path).stdout(Stdio::null());
        let log = self.folder.at("err.txt");
        command.stderr(fs::File::create(&log).expect("a file for messages"));
        if !fault.is_empty() {
            let results = format!("{}/r", self.folder.path.display());
            command.env("LD_PRELOAD", &self.shim).env("SHIM_FOLDER", results).envs(fault.iter().cloned());
        }
        let mut child = command.spawn().unwrap_or_else(|e| panic!("{}: {e}", self.command.display()));
        let begin = Instant::now();
        loop {
            let status = child.try_wait().expect("a child is waited for");
            let hung = status.is_none() && begin.elapsed() > HANGS;
            if hung {
                let _ = child.kill();
            }
            if status.is_some() || hung {
                let err = fs::read(&log).map_or(String::new(), |bytes| String::from_utf8_lossy(&bytes).into_owned());
                return Ended { code: status.and_then(|status| status.code()), err, hung };
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn results(&self) -> PathBuf {
        self.folder.at("r")
    }

    fn scene(&self, number: usize, (name, text, options): (&'static str, String, &[&str])) -> Scene {
        let case = format!("case-{number}.toml");
        self.folder.write(&case, &text);
        let plain = ["solve", &case, "-o", "r", "--progress", "none", "--threads", "1"];
        let arguments: Vec<String> = plain.iter().chain(options).map(|word| (*word).to_string()).collect();
        let count = self.folder.at("count");
        let begin = Instant::now();
        let ended = self.run(&arguments, &[("SHIM_COUNT", count.display().to_string())]);
        let micros = begin.elapsed().as_micros() as usize;
        assert_eq!(ended.code, Some(0), "{name}: {}", ended.err);
        assert!(passes(&self.results()), "{name}: the undisturbed run does not pass");
        let calls = fs::read_to_string(count).ok().and_then(|text| text.parse().ok()).unwrap_or(0);
        assert!(calls > 20, "{name}: {calls} calls seen");
        let (files, result) = (contents(&self.results(), false), contents(&self.results(), true));
        let _ = fs::remove_dir_all(self.results());
        Scene { name, arguments, stepped: text.contains("[[step]]"), calls, micros, files, result }
    }

    /// One to three disturbed runs in a folder, and one that ends their work.
    fn trial(&self, scenes: &[Scene], random: &mut Random, report: &mut Report) {
        let scene = &scenes[random.below(scenes.len())];
        // The folder is new, or holds another result, or an earlier one of this case.
        let before = [None, Some(&scenes[random.below(scenes.len())])][usize::from(random.below(3) == 0)];
        let _ = fs::remove_dir_all(self.results());
        if let Some(before) = before {
            fs::create_dir(self.results()).expect("a new folder");
            before.files.iter().for_each(|(name, bytes)| drop(self.folder.write(&format!("r/{name}"), bytes)));
        }
        let mut told = false;
        let mut story = format!("{} after {}", scene.name, before.map_or("nothing", |before| before.name));
        for _ in 0..[1, 1, 1, 2, 3][random.below(5)] {
            let resume = scene.stepped && random.below(2) == 0;
            let arguments = scene.with(resume);
            let timed = random.below(3) == 0;
            let (what, fault) = if timed {
                let what = AFTER_A_TIME[random.below(3)];
                (what, ("SHIM_AFTER", random.below(scene.micros).to_string()))
            } else {
                (AT_A_CALL[random.below(8)], ("SHIM_AT", (1 + random.below(scene.calls)).to_string()))
            };
            story += &format!("; {what} {} {}{}", fault.0, fault.1, if resume { " of --resume" } else { "" });
            let ended = self.run(&arguments, &[("SHIM_DO", what.to_string()), fault]);
            let end = ended.code.map_or("killed".to_string(), |code| format!("exit {code}"));
            let moment = if timed { " at a time" } else { "" };
            *report.runs.entry(format!("{}: {what}{moment}: {end}", scene.name)).or_default() += 1;
            told |= ["term", "int"].contains(&what);
            let wrong = ended.wrong(what).or_else(|| self.stands(scenes, scene, ended.code, told));
            if let Some(wrong) = wrong {
                report.findings.push(format!("{story}: {wrong}\n{}", ended.err));
                return;
            }
        }
        if let Some(wrong) = self.finish(scene) {
            report.findings.push(format!("{story}: {wrong}"));
        }
    }

    /// What is wrong with the folder after a disturbed run: it passes its check and is no result of any of the cases, or
    /// the run claims to have ended well and has not. One that was `told` to stop may have left out what a run estimates of
    /// other solutions in the end.
    fn stands(&self, scenes: &[Scene], scene: &Scene, code: Option<i32>, told: bool) -> Option<String> {
        let path = self.results();
        let passed = passes(&path);
        if code == Some(0) && !passed {
            return Some("the run ended well and its folder does not pass".into());
        }
        let truth = if code == Some(0) { std::slice::from_ref(scene) } else { scenes };
        if !passed {
            return None;
        }
        let mut found = contents(&path, true);
        // What a run that was killed leaves behind for the next one to remove.
        found.retain(|name, _| !name.starts_with('.'));
        if interrupted(&found) {
            // The steps that were finished, and nothing that claims to be more. Before a case is solved again with a
            // wider search its steps are others.
            if scene.name.ends_with("widened") {
                return None;
            }
            let steps = found.iter().filter(|(name, _)| name.contains("-000"));
            let wrong: Vec<&String> =
                steps.filter(|(name, bytes)| scene.result.get(*name) != Some(bytes)).map(|(name, _)| name).collect();
            return (!wrong.is_empty()).then(|| format!("steps of an interrupted run differ: {wrong:?}"));
        }
        let differs = truth.iter().map(|scene| {
            let without = || difference(&unestimated(&scene.result), &unestimated(&found));
            difference(&scene.result, &found).filter(|_| !told || without().is_some())
        });
        // Names of the files that differ from the result of this case.
        let wrong: Option<Vec<String>> = differs.collect();
        wrong.map(|wrong| format!("a folder that is no result passes: {}", wrong.join(" | ")))
    }

    /// Goes on without a fault. What is wrong with the result.
    fn finish(&self, scene: &Scene) -> Option<String> {
        let mut ended = self.run(&scene.with(true), &[]);
        if scene.stepped && ended.code == Some(2) && ended.err.contains("--resume") {
            // Steps of another case, which is told with the remedy.
            ended = self.run(&scene.with(false), &[]);
        }
        if ended.code != Some(0) || ended.hung {
            return Some(format!("the next run ends with {:?}: {}", ended.code, ended.err));
        }
        if !passes(&self.results()) {
            return Some("the result of the next run does not pass".into());
        }
        let wrong = difference(&scene.result, &contents(&self.results(), true));
        wrong.map(|wrong| format!("the next run has another result: {wrong}"))
    }
}

impl Scene {
    fn with(&self, resume: bool) -> Vec<String> {
        let more = (resume && self.stepped).then(|| "--resume".to_string());
        self.arguments.iter().cloned().chain(more).collect()
    }
}

impl Ended {
    /// What is wrong with how it ended.
    fn wrong(&self, what: &str) -> Option<String> {
        let told = self.err.contains("error: ") && self.err.contains("remedy: ");
        match self.code {
            _ if self.hung => Some("the run hangs".into()),
            None if ["kill", "half"].contains(&what) => None,
            Some(0) => None,
            Some(2) if told => None,
            Some(130) if ["term", "int"].contains(&what) => None,
            code => Some(format!("the run ends with {code:?}")),
        }
    }
}

fn passes(folder: &Path) -> bool {
    run::check(folder).is_ok_and(|checked| checked.passed())
}

/// Whether the summary says that the run was told to stop.
fn interrupted(result: &Contents) -> bool {
    let summary = result.get("summary.json").and_then(|text| serde_json::from_slice::<Value>(text).ok());
    summary.is_some_and(|summary| summary[0]["status"] == "interrupted")
}

/// The same with a summary that says nothing of other solutions.
fn unestimated(contents: &Contents) -> Contents {
    let mut contents = contents.clone();
    if let Some(bytes) = contents.get_mut("summary.json")
        && let Ok(mut summary) = serde_json::from_slice::<Value>(bytes)
    {
        take_estimates(&mut summary);
        *bytes = summary.to_string().into_bytes();
    }
    contents
}

fn take_estimates(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.retain(|key, _| !["coulomb", "coulomb_products"].contains(&&key[..]));
            map.values_mut().for_each(take_estimates);
        }
        Value::Array(list) => {
            list.retain(|row| row["label"] != "uniqueness");
            list.iter_mut().for_each(take_estimates);
        }
        _ => {}
    }
}

/// The first file that differs; none if all are equal.
fn difference(wanted: &Contents, found: &Contents) -> Option<String> {
    let names: Vec<&String> = wanted.keys().chain(found.keys()).collect();
    names.into_iter().find(|name| wanted.get(*name) != found.get(*name)).map(|name| {
        let say = |contents: &Contents| contents.get(name).map_or("missing", |_| "there");
        format!("{name}, wanted {}, found {}", say(wanted), say(found))
    })
}

/// The files of a folder; without times those that hold them are left out or freed of them.
fn contents(folder: &Path, without_times: bool) -> Contents {
    let entries = fs::read_dir(folder).map(|entries| entries.flatten().collect()).unwrap_or_else(|_| Vec::new());
    let files = entries.iter().filter_map(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        let bytes = fs::read(entry.path()).ok()?;
        Some((name, bytes))
    });
    if !without_times {
        return files.collect();
    }
    let timeless = |(name, bytes): (String, Vec<u8>)| match &name[..] {
        // Checksums of files with times, and a page with times.
        "SHA256SUMS" | "report.html" => None,
        "summary.json" | "steps.json" | "log.jsonl" => {
            let text = String::from_utf8_lossy(&bytes).into_owned();
            let values = serde_json::Deserializer::from_str(&text).into_iter::<Value>();
            let values: Result<Vec<Value>, _> = values.collect();
            let values = values.map(|mut values| {
                values.iter_mut().for_each(strip);
                Value::Array(values).to_string().into_bytes()
            });
            Some((name, values.unwrap_or(bytes)))
        }
        _ => Some((name, bytes)),
    };
    files.filter_map(timeless).collect()
}

/// Takes times, memory and what depends on them from a value.
fn strip(value: &mut Value) {
    match value {
        Value::Object(map) => {
            for key in ["seconds", "cpu_seconds", "peak_memory_bytes", "command", "log", "checksum"] {
                map.remove(key);
            }
            map.values_mut().for_each(strip);
        }
        Value::Array(list) => list.iter_mut().for_each(strip),
        _ => {}
    }
}
