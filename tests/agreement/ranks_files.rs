//! The files of several ranks: joined they are the problem that one rank poses, the judge of one file judges them, and load steps
//! go on from them on any number of ranks.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use stiction::contact::ContactProblem;
use stiction::friction::Status;
use stiction::io::case::{self, Case};
use stiction::io::pieces::read_pieces;
use stiction::ranks::threads;
use stiction::run::{
    AnswerRecord, ForPeople, Keep, Named, Origin, SUMS, StepRecord, Summary, check, prepare, solve_steps_on_ranks,
    write_on_ranks,
};

#[cfg(feature = "report")]
use serde_json::Value;
use stiction_fixtures::random_case;

use super::ranks::case_of;
use super::ranks_bolts::joint;

const STEEL: &str = "[materials.steel]\nyoung = 21.19e10\npoisson = 0.277\ndensity = 7800\n";

/// A block held at one end on another one with a mesh of its own, beside a wall; a plane of symmetry and prescribed
/// displacements.
fn blocks(element: &str) -> String {
    format!(
        "[mesh.parts.a]\nblock = {{ size = [2, 1, 1], cells = [12, 6, 6], element = \"{element}\" }}\n\
         [mesh.parts.b]\nblock = {{ size = [2.2, 1, 0.5], cells = [9, 5, 3], element = \"hex8\" }}\nmove = [0, 0, -0.5]\n{STEEL}\
         [[fix]]\non = \"a.x-min\"\n[[fix]]\non = \"b.z-min\"\nvalue = [0, 0, 1e-6]\n\
         [[fix]]\non = [\"a.y-min\", \"b.y-min\"]\ncondition = \"symmetry\"\n[[load]]\ngravity = [0, 0, -9.81]\n\
         [[load]]\non = \"a.z-max\"\ntraction = [2e5, 0, \"-1e6*(2 - x)\"]\n\
         [[contact]]\nname = \"wall\"\non = \"a.x-max\"\nfriction = \"none\"\n\
         against = {{ plane = {{ point = [2, 0, 0], normal = [-1, 0, 0] }} }}\n\
         [[contact]]\nname = \"blocks\"\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = {{ coulomb = [0.5, 0.2], direction = [1, 0.5, 0] }}\n"
    )
}

/// The brick pressed, then pulled along its foundation and back: what is open, sticks and slips changes with every increment.
fn stepped() -> String {
    format!(
        "[mesh]\nblock = {{ size = [3, 1, 1], cells = [18, 6, 6], element = \"hex8\" }}\n{STEEL}\
         [[fix]]\non = \"x-min\"\ncomponents = \"y\"\n[[fix]]\non = \"z-max\"\nvalue = [\"1e-5*max(0, t - 1)*(3 - t)\", 0, \"-1e-5*min(t, 1)\"]\n\
         [[load]]\non = \"x-max\"\ntraction = [0, \"3e5*t\", 0]\n\
         [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ coulomb = 0.3 }}\n[[step]]\nname = \"press\"\nuntil = 1\nincrements = 2\n\
         [[step]]\nname = \"pull\"\nuntil = 3\nincrements = 3\n"
    )
}

pub(super) fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("ranks-files-{name}"));
    let _ = fs::remove_dir_all(&folder);
    folder
}

/// Solves on ranks and writes the folder, without pictures and report.
pub(super) fn solved(case: &Case, size: usize, folder: &Path, resume: bool) -> Summary {
    solved_for(ForPeople::default(), case, size, folder, resume)
}

/// Solves on ranks and writes the folder.
pub(super) fn solved_for(wanted: ForPeople, case: &Case, size: usize, folder: &Path, resume: bool) -> Summary {
    let keep = Keep { folder: folder.to_path_buf(), resume, tell: |_| {} };
    let mut all = threads(size, |ranks| {
        let mut answer = solve_steps_on_ranks(case, &ranks, Some(&keep), &mut |_| ControlFlow::Continue(())).unwrap();
        write_on_ranks(&mut answer, folder, &Origin::default(), wanted, &*ranks).unwrap();
        answer.summary
    });
    all.swap_remove(0)
}

/// Load steps without what differs from run to run: time and memory.
pub(super) fn without_costs(steps: &[StepRecord]) -> Vec<StepRecord> {
    let without = |step: &StepRecord| {
        let (none, answer) = (Named::default(), step.answer.clone());
        let answer = AnswerRecord { seconds: none.clone(), cpu_seconds: none, peak_memory_bytes: None, ..answer };
        StepRecord { answer, ..step.clone() }
    };
    steps.iter().map(without).collect()
}

pub(super) fn passes(folder: &Path) {
    let checked = check(folder).unwrap_or_else(|error| panic!("{error}"));
    let steps: Vec<_> =
        checked.steps.iter().map(|step| (step.number, step.certificate.worst, &step.differences)).collect();
    assert!(checked.passed(), "{:?} {:?} {:?} {steps:?}", checked.certificate, checked.differences, checked.files);
}

fn same(found: &[f64], expected: &[f64]) {
    let largest = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert_eq!(found.len(), expected.len());
    let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart <= 1e-13 * largest, "{apart:e} of {largest:e}");
}

/// Numbers that no two unknowns share.
fn numbers(count: usize) -> Vec<f64> {
    (0..count).map(|i| ((i * 7919 % 1009) as f64 - 500.0) / 503.0).collect()
}

/// What does not depend on the order of the points.
fn as_the_one_of_one_rank(found: &ContactProblem, expected: &ContactProblem) {
    let (x, m) = (numbers(expected.unknowns()), expected.points());
    same(&found.elastic.K.times(&x), &expected.elastic.K.times(&x));
    same(&found.elastic.f, &expected.elastic.f);
    assert_eq!(found.elastic.node_of, expected.elastic.node_of);
    let motions = |p: &ContactProblem| p.elastic.near_kernel.as_ref().unwrap().as_flattened().to_vec();
    same(&motions(found), &motions(expected));
    let (held, of) = (found.labels.supports.as_ref().unwrap(), expected.labels.supports.as_ref().unwrap());
    let y = numbers(of.load.len());
    same(&held.K.times(&x), &of.K.times(&x));
    same(&held.K_own.times(&y), &of.K_own.times(&y));
    same(&held.displacement, &of.displacement);
    same(&[&held.load[..], &held.free_load].concat(), &[&of.load[..], &of.free_load].concat());
    assert_eq!(found.labels.bodies, expected.labels.bodies);
    assert_eq!(found.labels.pairs, expected.labels.pairs);
    assert_eq!(found.contact.orthotropy.is_some(), expected.contact.orthotropy.is_some());
    // Each point by the numbers that it has: gap, area, what its rows make of the displacements, its law.
    let points = |p: &ContactProblem| {
        let (jump, held) = (p.contact.B.times(&x), p.labels.supports.as_ref().unwrap().B.times(&y));
        let of_point = |j: usize| {
            let across = p.contact.orthotropy.as_ref().map_or(1.0, |across| across[j]);
            let [a, b, c] = [j, m + j, 2 * m + j];
            let pair = p.labels.pairs.partition_point(|pair| pair.points.end <= j) as f64;
            let law = format!("{:?}", p.contact.friction[j]).len() as f64;
            [
                pair,
                jump[a],
                jump[b],
                jump[c],
                held[a],
                held[b],
                p.contact.gap[j],
                p.labels.area[j],
                p.labels.unity_sum[j],
                across,
                law,
            ]
        };
        let mut all: Vec<[f64; 11]> = (0..m).map(of_point).collect();
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all
    };
    let close = |a: &f64, b: &f64| (a - b).abs() <= 1e-12 * (1.0 + b.abs());
    let pairs = points(found).into_iter().zip(points(expected));
    pairs.for_each(|(a, b)| assert!(a.iter().zip(&b).all(|(a, b)| close(a, b)), "{a:?} {b:?}"));
}

#[test]
fn the_pieces_make_the_problem_of_one_rank_and_pass_its_judge() {
    for element in ["hex8", "tet4", "tet10"] {
        let case = case_of(&blocks(element), "1e-8");
        let prepared = prepare(&case).unwrap();
        for size in [1, 3, 6] {
            let folder = folder(&format!("{element}-{size}"));
            let summary = solved(&case, size, &folder, false);
            passes(&folder);
            let whole = read_pieces(&folder).unwrap();
            assert_eq!(whole.tolerance, 1e-8);
            as_the_one_of_one_rank(&whole.problem, &prepared.problem);
            let lambda = whole.solution(&folder).unwrap().1;
            let force: f64 = lambda.iter().zip(&whole.problem.labels.unity_sum).map(|(l, share)| l * share).sum();
            assert!((force - summary.answer.contact.normal_force).abs() <= 1e-12 * force);
        }
    }
}

/// What `check` says of a folder: an error, or what is wrong.
fn complaint(folder: &Path) -> String {
    match check(folder) {
        Err(error) => error.to_string(),
        Ok(checked) => {
            assert!(!checked.passed());
            format!("{:?} {:?}", checked.files, checked.differences)
        }
    }
}

#[test]
fn a_flipped_bit_a_missing_piece_and_a_piece_of_another_run_are_named() {
    let (case, home) = (case_of(&blocks("hex8"), "1e-8"), folder("damage"));
    solved(&case, 3, &home, false);
    passes(&home);
    let names: Vec<String> =
        fs::read_dir(&home).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    for kind in ["problem-0002.npz", "solution-0000.npz", "result-0001.vtu", "contact.pvtu", "summary.json"] {
        assert!(names.iter().any(|name| name == kind), "{names:?}");
    }
    for name in names.iter().filter(|name| *name != SUMS) {
        let (path, bytes) = (home.join(name), fs::read(home.join(name)).unwrap());
        for place in [bytes.len() / 3, bytes.len() / 2, bytes.len() - 3] {
            let mut wrong = bytes.clone();
            wrong[place] ^= 4;
            fs::write(&path, wrong).unwrap();
            let said = complaint(&home);
            assert!(said.contains(name.as_str()), "{name} at {place}: {said}");
        }
        fs::remove_file(&path).unwrap();
        let said = complaint(&home);
        assert!(said.contains(name.as_str()) || name == "summary.json", "{name}: {said}");
        fs::write(&path, bytes).unwrap();
    }
    passes(&home);
    // The same case with another load, its pieces listed as if they were of this run.
    let other = folder("other");
    solved(&case_of(&blocks("hex8").replace("2e5", "1e5"), "1e-8"), 3, &other, false);
    for name in ["problem-0001.npz", "solution-0002.npz"] {
        let bytes = fs::read(home.join(name)).unwrap();
        fs::copy(other.join(name), home.join(name)).unwrap();
        let (sums, theirs) =
            (fs::read_to_string(home.join(SUMS)).unwrap(), fs::read_to_string(other.join(SUMS)).unwrap());
        let line = |text: &str| text.lines().find(|line| line.ends_with(name)).unwrap().to_string();
        fs::write(home.join(SUMS), sums.replace(&line(&sums), &line(&theirs))).unwrap();
        let said = complaint(&home);
        assert!(said.contains(name) && said.contains("another run than problem-0000.npz"), "{said}");
        fs::write(home.join(name), bytes).unwrap();
        fs::write(home.join(SUMS), sums).unwrap();
    }
    // A run of fewer ranks in the same folder leaves nothing of this one.
    solved(&case, 2, &home, false);
    passes(&home);
    assert!(!home.join("problem-0002.npz").exists() && !home.join("result-0002.vtu").exists());
}

/// Files of a run on one machine that the list names go; what it does not name, and the case, stay.
#[test]
fn a_folder_of_one_machine_becomes_one_of_ranks() {
    let (case, home) = (case_of(&blocks("hex8"), "1e-8"), folder("before"));
    fs::create_dir_all(&home).unwrap();
    let listed = ["result.pvd", "log.jsonl", "pressure.png", "solution-2.npz", "case.toml"];
    listed.iter().chain(&["mine.png"]).for_each(|name| fs::write(home.join(name), "of before").unwrap());
    let sums: String = listed.iter().map(|name| format!("{}  {name}\n", "0".repeat(64))).collect();
    fs::write(home.join(SUMS), sums).unwrap();
    solved(&case, 2, &home, false);
    passes(&home);
    let stays = |name: &&str| home.join(name).exists();
    assert!(!listed[..4].iter().any(stays) && ["case.toml", "mine.png"].iter().all(stays));
}

/// Load steps on ranks as [`solved`] writes them, up to the increment in which the run is killed.
pub(super) fn killed(case: &Case, size: usize, folder: &Path, resume: bool, increments: usize) {
    killed_when(case, size, folder, resume, &|seen| seen > increments);
}

/// The same where the number of solves that have begun says it.
pub(super) fn killed_when(
    case: &Case,
    size: usize,
    folder: &Path,
    resume: bool,
    ends: &(dyn Fn(usize) -> bool + Sync),
) {
    let keep = Keep { folder: folder.to_path_buf(), resume, tell: |_| {} };
    let found = threads(size, |ranks| {
        // Where a run is killed the list has what was finished before.
        let mut seen = 0;
        let answer = solve_steps_on_ranks(case, &ranks, Some(&keep), &mut |progress| {
            seen += usize::from(progress.iteration == 0);
            if ends(seen) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        answer.unwrap().summary.answer.status
    });
    assert!(found.iter().all(|status| *status == stiction::Status::Interrupted), "{found:?}");
    assert!(folder.join("steps.json").exists() && !folder.join("summary.json").exists());
    let said = check(folder).unwrap_err().to_string();
    assert!(said.contains("--resume"), "{said}");
}

#[test]
fn load_steps_go_on_from_their_files_on_any_number_of_ranks() {
    let (case, whole) = (case_of(&stepped(), "1e-10"), folder("steps"));
    let expected = solved(&case, 3, &whole, false);
    assert_eq!(expected.steps.len(), 5);
    passes(&whole);
    assert_eq!(check(&whole).unwrap().steps.len(), 5);
    let answer = |folder: &Path| read_pieces(folder).unwrap().solution(folder).unwrap();
    let (u, lambda) = answer(&whole);
    for size in [3, 1, 4] {
        let part = folder(&format!("steps-{size}"));
        killed(&case, 3, &part, false, 2);
        // Killed a second time, on other ranks.
        killed(&case, size, &part, true, 1);
        let found = solved(&case, size, &part, true);
        passes(&part);
        assert_eq!(found.steps.len(), 5);
        let (other_u, other_lambda) = answer(&part);
        let bits = |list: &[f64]| list.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
        if size == 3 {
            // The same ranks: as if nothing had happened.
            assert!(bits(&u) == bits(&other_u) && bits(&lambda) == bits(&other_lambda));
            assert_eq!(without_costs(&found.steps), without_costs(&expected.steps));
            continue;
        }
        for (found, expected) in [(&other_u, &u), (&other_lambda, &lambda)] {
            let largest = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart <= 1e-8 * largest, "{size} ranks: {apart:e} of {largest:e}");
        }
    }
}

/// A bolt goes on from its shortening, and the start from the line through the last two answers.
#[test]
fn a_bolted_joint_goes_on_from_its_files_and_passes_its_judge() {
    let case = joint(&[("step.0.increments", "2")]);
    let whole = folder("bolted");
    let expected = solved(&case, 3, &whole, false);
    passes(&whole);
    assert_eq!(expected.steps.len(), 3);
    for size in [3, 2] {
        let part = folder(&format!("bolted-{size}"));
        killed(&case, 3, &part, false, 2);
        let found = solved(&case, size, &part, true);
        passes(&part);
        if size == 3 {
            assert_eq!(without_costs(&found.steps), without_costs(&expected.steps));
        }
        for (found, expected) in found.steps.iter().zip(&expected.steps) {
            let (found, expected) = (&found.answer.bolts[0], &expected.answer.bolts[0]);
            assert!((found.force / expected.force - 1.0).abs() < 1e-8, "{size} ranks: {found:?} {expected:?}");
            assert!(
                (found.shortening / expected.shortening - 1.0).abs() < 1e-8,
                "{size} ranks: {found:?} {expected:?}"
            );
        }
    }
}

#[test]
fn steps_of_another_case_are_refused_and_damaged_ones_solved_again() {
    let (case, home) = (case_of(&stepped(), "1e-8"), folder("steps-damaged"));
    killed(&case, 2, &home, false, 3);
    for (from, to) in [
        ("3e5", "2e5"),
        ("[18, 6, 6]", "[18, 6, 7]"),
        ("coulomb = 0.3", "coulomb = 0.31"),
        ("[3, 1, 1]", "[3, 1, 1.1]"),
    ] {
        let other = case_of(&stepped().replace(from, to), "1e-8");
        let keep = Keep { folder: home.clone(), resume: true, tell: |_| {} };
        let errors = threads(3, |ranks| {
            solve_steps_on_ranks(&other, &ranks, Some(&keep), &mut |_| ControlFlow::Continue(()))
                .map(|_| ())
                .unwrap_err()
        });
        assert!(errors.iter().all(|error| *error == errors[0]));
        assert!(errors[0].what.contains("of another case") && errors[0].place.contains("steps.json"), "{}", errors[0]);
    }
    // A comment is no part of a case, a bit of a finished step is.
    let path = home.join("step-0002-0001.npz");
    let mut bytes = fs::read(&path).unwrap();
    let place = bytes.len() / 2;
    bytes[place] ^= 1;
    fs::write(&path, bytes).unwrap();
    let found = solved(&case_of(&format!("# Once more.\n\n{}", stepped()), "1e-8"), 4, &home, true);
    assert_eq!(found.steps.len(), 5);
    passes(&home);
    assert!(!path.with_file_name("step-0002-0004.npz").exists());
    // A run that is not resumed begins anew, and one rank can have the folder after several.
    solved(&case, 2, &home, false);
    passes(&home);
    assert!(!home.join("step-0001-0003.npz").exists());
}

/// On four ranks the active sets of this mesh go round. Rank 0 finds all increments alone; all ranks judge and keep them, and others go on
/// from them.
#[test]
fn load_steps_that_rank_0_solves_alone_are_kept() {
    let text = random_case::text(803) + "[[step]]\nuntil = 1\nincrements = 2\n";
    // Ranks that go nowhere are told so early.
    let few = [("solver.max_iterations".to_string(), "60".to_string())];
    let (case, folder) = (case::parse(&text, "case.toml", &few).unwrap(), folder("alone"));
    let found = solved(&case, 4, &folder, false);
    assert!(found.found_by_first() && found.answer.status == Status::Solved, "{found}");
    assert_eq!(found.steps.iter().map(|step| step.t).collect::<Vec<_>>(), [0.5, 1.0]);
    passes(&folder);
    let again = solved(&case, 2, &folder, true);
    assert_eq!((again.answer.status, &again.steps[..1]), (Status::Solved, &found.steps[..1]), "{again}");
    passes(&folder);
}

/// The view of a report, as the page holds it.
#[cfg(feature = "report")]
fn view_of(folder: &Path) -> Value {
    let page = fs::read_to_string(folder.join(stiction::run::REPORT)).unwrap();
    assert!(page.contains("Solved and certified.") && !page.contains(">NaN"));
    let (_, rest) = page.split_once("id=\"view-data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

/// The pieces of ranks join to the whole that one rank has as one piece: tetrahedra beside hexahedra, two bodies, load steps.
#[cfg(feature = "report")]
#[test]
fn the_report_of_several_ranks_shows_what_that_of_one_does() {
    for (name, text) in [("tet4", blocks("tet4")), ("steps", stepped())] {
        let case = case_of(&text, "1e-10");
        let of = |size: usize| {
            let folder = folder(&format!("report-{name}-{size}"));
            solved_for(ForPeople { report: true, pictures: false }, &case, size, &folder, false);
            let at_once = view_of(&folder);
            passes(&folder);
            // From the files of all ranks.
            fs::remove_file(folder.join(stiction::run::REPORT)).unwrap();
            stiction::run::write_report(&folder).unwrap_or_else(|error| panic!("{error}"));
            let view = view_of(&folder);
            passes(&folder);
            agree(&at_once, &view);
            if size > 1 {
                // Without a piece there is no whole.
                fs::remove_file(folder.join("result-0001.vtu")).unwrap();
                assert!(stiction::run::write_report(&folder).is_err());
            }
            view
        };
        agree(&of(1), &of(3));
    }
}

/// Whether two views show the same: their orders differ, not what there is.
#[cfg(feature = "report")]
fn agree(one: &Value, other: &Value) {
    for key in ["firstContactFace", "low", "high", "fields"] {
        assert_eq!(one[key], other[key], "{key}");
    }
    let length = |view: &Value| view["faces"].as_str().map_or(0, str::len);
    assert!(length(one) > 1000 && length(other) == length(one));
    let count = one["fields"].as_array().unwrap().len();
    let (one, other) = (&one["frames"][0], &other["frames"][0]);
    let same = |a: &Value, b: &Value, of: f64| {
        // Displacements are some 1e-5; the gap of what all touches is rounding.
        assert!((a.as_f64().unwrap() - b.as_f64().unwrap()).abs() <= 1e-6 * of + 1e-15, "{a} {b}");
    };
    same(&one["largest"], &other["largest"], one["largest"].as_f64().unwrap());
    let (fields, others) = (one["values"].as_array().unwrap(), other["values"].as_array().unwrap());
    assert_eq!([fields.len(), others.len()], [count; 2]);
    // Stress and pressure; where all touches, gaps are rounding.
    assert!(fields[..2].iter().all(|field| field["high"].as_f64().unwrap() > 1e5));
    for (a, b) in fields.iter().zip(others) {
        let high = a["high"].as_f64().unwrap();
        ["low", "high"].iter().for_each(|end| same(&a[end], &b[end], high));
    }
}

/// Byte for byte the pictures of one machine, which draws them from the whole mesh: of several bodies with quadratic cells, of load steps.
#[cfg(feature = "plots")]
#[test]
fn the_pictures_of_several_ranks_are_those_of_one_machine() {
    use stiction::run::{Event, Origin, Prepared, Settings, Step, begin_steps, keep_step, solve, solve_steps, write};

    for (name, text, drawn) in [
        (
            "blocks",
            blocks("tet10"),
            &["deformed", "pressure-wall", "pressure-blocks", "shear-blocks", "status-blocks"][..],
        ),
        ("steps", stepped(), &["deformed", "pressure", "shear", "status"]),
    ] {
        let case = case_of(&text, "1e-11");
        let of_one = folder(&format!("pictures-{name}-serial"));
        let mut prepared = prepare(&case).unwrap();
        let (settings, go_on) = (Settings::of(&case.solver), &mut |_: &Event| ControlFlow::Continue(()));
        let mut outcome = if case.steps.is_empty() {
            solve(&prepared, &settings, go_on).unwrap()
        } else {
            let (mut files, _) = begin_steps(&prepared, &of_one, false).unwrap();
            let mut keep = |prepared: &Prepared, step: &Step| keep_step(&mut files, prepared, step);
            solve_steps(&mut prepared, &settings, None, &mut keep, go_on).unwrap()
        };
        write(&prepared, &mut outcome, &Origin::default(), &of_one).unwrap();
        for size in [1, 3] {
            let here = folder(&format!("pictures-{name}-{size}"));
            let wanted = ForPeople { pictures: true, report: false };
            solved_for(wanted, &case, size, &here, false);
            passes(&here);
            for name in drawn {
                let of = |folder: &Path| fs::read(folder.join(format!("{name}.png"))).unwrap();
                assert!(of(&here) == of(&of_one), "{name} on {size} ranks");
            }
            assert!(here.join("convergence.png").exists());
            assert_eq!(here.join("history.png").exists(), !case.steps.is_empty());
        }
    }
}
