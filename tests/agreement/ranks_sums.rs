//! Sums over load steps on several ranks against those of one machine: work of friction, wear, the balance of energy, also where a run
//! goes on on other ranks; and what the judge finds from the files alone.

use std::ops::ControlFlow;
use std::path::Path;

use stiction::io::case::Case;
use stiction::linalg::Stop;
use stiction::run::{FrettingRecord, Origin, Plan, Summary, solve_case, write_with};
use stiction_fixtures::folder::Folder;

use super::ranks::case_of;
use super::ranks_files::{folder, killed_when, passes, solved};

/// The summary that one machine writes into a folder.
fn serial(case: &Case, home: &Folder) -> Summary {
    let plan = Plan { folder: Some(&home.path), ..Plan::default() };
    let go_on = &mut |_: stiction::run::Stage| ControlFlow::Continue(());
    let (prepared, mut outcome, ahead) = solve_case(case, &plan, &Stop::never(), None, go_on).unwrap();
    write_with(&prepared, &mut outcome, &Origin::default(), &home.path, ahead).unwrap();
    serde_json::from_slice(&std::fs::read(home.at("summary.json")).unwrap()).unwrap()
}

/// A block that is pressed on another one and led to and fro, warmed on its way.
fn to_and_fro(element: &str, friction: &str) -> String {
    format!(
        "[mesh.parts.a]\nblock = {{ size = [10, 10, 4], cells = [5, 4, 2], element = \"{element}\" }}\n\
         [mesh.parts.b]\nblock = {{ size = [6, 6, 4], cells = [4, 3, 2], element = \"{element}\", origin = [2, 2, 4] }}\n\
         [materials.s]\nyoung = 1000\npoisson = 0.3\nexpansion = 1e-4\n[[fix]]\non = \"a.z-min\"\n\
         [[fix]]\non = \"b.z-max\"\nvalue = [\"0.1*sin(2*t)\", \"0.02*t\", \"-0.03*min(t, 1)\"]\n\
         [[load]]\ntemperature = \"5*t*x\"\non = \"b\"\n\
         [[contact]]\nname = \"foot\"\non = \"b.z-min\"\nagainst = \"a.z-max\"\n{friction}\n\
         [[step]]\nuntil = 1\nincrements = 2\n[[step]]\nuntil = 4\nincrements = 4\n"
    )
}

fn near(found: f64, expected: f64, size: f64) -> bool {
    (found - expected).abs() <= 1e-6 * size.max(expected.abs())
}

fn same(found: &Summary, expected: &Summary) {
    let numbers = |r: &FrettingRecord| {
        let wear = [r.max_wear, r.worn_volume].map(|wear| wear.unwrap_or(-1.0));
        let most = [r.max_work, r.max_slip_amplitude, r.max_shear_amplitude, r.max_ruiz_1, r.max_ruiz_2];
        [&[r.work][..], &most, &wear].concat()
    };
    assert_eq!(found.fretting.len(), expected.fretting.len());
    for (a, b) in found.fretting.iter().zip(&expected.fretting) {
        assert!(a.name == b.name && b.work > 0.0 && b.max_ruiz_2 > 0.0, "{a:?} {b:?}");
        assert!(numbers(a).iter().zip(numbers(b)).all(|(a, b)| near(*a, b, 0.0)), "{a:?} {b:?}");
    }
    for (a, b) in found.steps.iter().zip(&expected.steps) {
        let (of, expected) = (a.balance, b.balance);
        let size = expected.work.abs().max(expected.elastic);
        for (a, b) in [
            (of.work, expected.work),
            (of.elastic, expected.elastic),
            (of.dissipation, expected.dissipation),
            (of.drift, expected.drift),
        ] {
            assert!(near(a, b, size), "{of:?} {expected:?}");
        }
        assert!(near(a.answer.energy, b.answer.energy, size), "{} {}", a.answer.energy, b.answer.energy);
    }
}

/// The head and the lines of a file of contact nodes.
fn table(path: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_string).collect()).collect()
}

/// Numbers agree to this part of the largest of their column.
const SAME: f64 = 1e-5;

/// The nodes of both sides of each pair with all that is known of them: the same lines in the same order.
fn same_tables(found: &Path, expected: &Path) {
    let [a, b] = [table(found), table(expected)];
    assert!(a.len() == b.len() && a[0] == b[0], "{} {}: {:?} {:?}", a.len(), b.len(), a[0], b[0]);
    for column in 0..a[0].len() {
        let head = &a[0][column];
        let of = |table: &[Vec<String>]| table[1..].iter().map(|line| line[column].clone()).collect::<Vec<String>>();
        let (a, b) = (of(&a), of(&b));
        let number = |text: &String| text.parse::<f64>().unwrap_or(f64::NAN);
        // Gaps of closed contact are rounding.
        let most = b.iter().map(number).fold(1e-9, |most: f64, x| most.max(x.abs()));
        for (line, (a, b)) in a.iter().zip(&b).enumerate() {
            let near = (number(a) - number(b)).abs() <= SAME * most;
            assert!(a == b || near, "{head}, line {line}: {a} {b}");
        }
    }
}

fn agrees(name: &str, case: &Case) {
    let home = Folder::new(&format!("ranks-sums-{name}"));
    let expected = serial(case, &home);
    let last = match expected.steps.len() {
        0 => "contact.csv".to_string(),
        count => format!("contact-{count:04}.csv"),
    };
    for size in [1, 3] {
        let whole = folder(&format!("sums-{name}-{size}"));
        same(&solved(case, size, &whole, false), &expected);
        same_tables(&whole.join("contact.csv"), &home.at(&last));
        passes(&whole);
    }
    if expected.steps.is_empty() {
        return;
    }
    // Begun on three ranks, ended on two.
    let part = folder(&format!("sums-{name}-part"));
    let half = format!("step-{:04}-0000.npz", expected.steps.len() / 2 + 1);
    killed_when(case, 3, &part, false, &|_| part.join(&half).exists());
    same(&solved(case, 2, &part, true), &expected);
    same_tables(&part.join("contact.csv"), &home.at(&last));
    passes(&part);
}

#[test]
fn work_of_friction_wear_and_energies_are_those_of_one_machine() {
    let worn = "friction = { coulomb = 0.3 }\nwear = 2e-6";
    agrees("hex8", &case_of(&to_and_fro("hex8", worn), "1e-10"));
    agrees("tet10", &case_of(&to_and_fro("tet10", "friction = { coulomb = 0.2 }"), "1e-10"));
}

/// Bolts that are tightened by shortening and by force store energy as well.
#[test]
fn energies_of_bolted_joints_are_those_of_one_machine() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/joint/joint.toml");
    let set = [("solver.tolerance", "1e-10"), ("solver.path", "\"multigrid\"")];
    let set = set.map(|(key, value)| (key.to_string(), value.to_string()));
    agrees("joint", &stiction::io::case::read(&path, &set).unwrap());
}

#[test]
fn nodes_of_both_sides_are_told_as_on_one_machine() {
    let (text, wall) = (
        to_and_fro("wedge15", "friction = { coulomb = 0.3 }"),
        "[[contact]]\nname = \"wall\"\non = \"b.x-max\"\n\
        against = { sphere = { center = [13.01, 5, 6], radius = 5 } }\nfriction = \"none\"\n",
    );
    let (at_once, _) = text.split_once("[[step]]").unwrap();
    let at_once = at_once.replace("sin(2*t)", "1").replace("min(t, 1)", "1").replace("*t", "");
    agrees("both", &case_of(&format!("{at_once}{wall}"), "1e-10"));
}

/// Rows of the judge: an energy that is not that of the files is told.
#[test]
fn the_judge_finds_energies_that_are_not_those_of_the_files() {
    let case = case_of(&to_and_fro("hex8", "friction = { coulomb = 0.3 }"), "1e-10");
    let home = folder("sums-judged");
    let summary = solved(&case, 2, &home, false);
    let path = home.join("summary.json");
    let [text, work] =
        [std::fs::read_to_string(&path).unwrap(), serde_json::to_string(&summary.steps[3].balance.work).unwrap()];
    assert!(text.contains(&work));
    std::fs::write(
        &path,
        text.replace(&work, &serde_json::to_string(&(1.001 * summary.steps[3].balance.work)).unwrap()),
    )
    .unwrap();
    let checked = stiction::run::check(&home).unwrap();
    let differences: Vec<&str> = checked.steps[3].differences.iter().map(|(name, ..)| name.as_str()).collect();
    assert_eq!(differences, ["work"]);
}
