//! What each phase of a run asks for before it begins is as much as it then takes, and not far more.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use stiction::io::case::{self, Case};
use stiction::run::{
    Ahead, Origin, Outcome, Prepared, Settings, Step, begin_steps, check, keep_step, prepare, solve, solve_steps,
    write_report_on, write_with,
};
use stiction_fixtures::counting::{Memory, measured};

use crate::ALONE;

/// Below this a phase may ask for several times what it takes: constants are those of the worst case.
const SMALL: f64 = 100e6;
/// Most of what is asked for over what is taken beyond that.
const MOST: f64 = 2.0;

/// Every phase of a run, with the memory it took.
fn phases(name: &str, case: &Case) -> Vec<(&'static str, Memory)> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("predictions-{}", name.replace('/', "-")));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let (prepared, posing) = measured(|| prepare(case).unwrap());
    let mut prepared = prepared;
    let settings = Settings::of(&case.solver);
    let (outcome, solving) = measured(|| solved(case, &mut prepared, &settings, &folder));
    let mut outcome = outcome;
    let write = || write_with(&prepared, &mut outcome, &Origin::default(), &folder, Ahead::default()).unwrap();
    let (_, writing) = measured(write);
    let quiet = Settings { pictures: false, ..settings.clone() };
    let bare = || write_with(&prepared, &mut outcome, &Origin::default(), &folder, Ahead::of(&quiet)).unwrap();
    let (_, writing_without_pictures) = measured(bare);
    let (_, reporting) = measured(|| write_report_on(&folder, Some(&prepared.mesh)).unwrap());
    let (_, again) = measured(|| write_report_on(&folder, None).unwrap());
    let (_, checking) = measured(|| check(&folder).unwrap());
    std::fs::remove_dir_all(&folder).unwrap();
    vec![
        ("posing", posing),
        ("solving", solving),
        ("writing", writing),
        ("writing without pictures", writing_without_pictures),
        ("reporting", reporting),
        ("reporting again", again),
        ("checking", checking),
    ]
}

fn solved(case: &Case, prepared: &mut Prepared, settings: &Settings, folder: &Path) -> Outcome {
    let go_on = &mut |_: &stiction::run::Event| ControlFlow::Continue(());
    if case.steps.is_empty() {
        return solve(prepared, settings, go_on).unwrap();
    }
    let (mut files, _) = begin_steps(prepared, folder, false).unwrap();
    let mut keep = |prepared: &Prepared, step: &Step| keep_step(&mut files, prepared, step);
    solve_steps(prepared, settings, None, &mut keep, go_on).unwrap()
}

fn holds(name: &str, case: &Case) {
    for (phase, Memory { peak, asked, .. }) in phases(name, case) {
        assert!(asked >= peak, "{name}: {phase} took {peak} bytes and asked for {asked}");
        let most = MOST * (peak as f64).max(SMALL);
        assert!(asked as f64 <= most, "{name}: {phase} took {peak} bytes and asked for {asked}");
    }
}

#[test]
fn the_shipped_cases_take_no_more_than_they_ask_for() {
    let _alone = ALONE.lock();
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases");
    let mut cases = 0;
    for entry in std::fs::read_dir(&base).unwrap().flatten().filter(|entry| entry.path().is_dir()) {
        let name = entry.file_name().into_string().unwrap();
        holds(&name, &case::read(entry.path().join(format!("{name}.toml")), &[]).unwrap());
        cases += 1;
    }
    assert!(cases >= 14, "{cases}");
}

fn brick(element: &str, cells: [usize; 3], path: &str) -> Case {
    let text = format!(
        r#"
[mesh]
block = {{ size = [3, 1, 1], cells = {cells:?}, element = "{element}" }}
[materials.steel]
young = 21.19e10
poisson = 0.277
[[fix]]
on = "x-min"
[[load]]
on = "z-max"
traction = [0, 0, "-2/3*1e6*(3 - x)"]
[[contact]]
on = "z-min"
against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}
friction = {{ coulomb = 0.35 }}
[solver]
path = "{path}"
tolerance = 1e-4
"#
    );
    case::parse(&text, "case.toml", &[]).unwrap()
}

#[test]
fn every_element_and_path_takes_no_more_than_it_asks_for() {
    let _alone = ALONE.lock();
    // Plates of flat cells have the largest coarse levels.
    let tries =
        [("multigrid", [32, 16, 16]), ("multigrid", [40, 40, 4]), ("dense", [24, 12, 12]), ("solves", [24, 12, 12])];
    for element in ["hex8", "tet4", "hex20", "tet10"] {
        for (path, cells) in tries {
            let cells = if element.ends_with('0') { cells.map(|n| n / 2) } else { cells };
            holds(&format!("{element}/{path}/{cells:?}"), &brick(element, cells, path));
        }
    }
}

/// By its counts, before the mesh: nothing of its size is allocated or asked for.
#[test]
fn what_no_path_can_solve_is_refused_before_its_mesh_is_made() {
    let _alone = ALONE.lock();
    let refused = |element: &str, cells: [usize; 3], path: &str, gigabytes: f64| {
        let mut case = brick(element, cells, path);
        case.solver.memory = Some(gigabytes);
        let (prepared, Memory { peak, asked, .. }) = measured(|| prepare(&case).map(|_| ()));
        let said = prepared.expect_err(path).to_string();
        assert!(peak < 1 << 20 && asked < 1 << 20, "{element}/{path}: {peak} bytes, {asked} asked for: {said}");
        assert!(said.contains("may be used (`memory` under [solver])"), "{said}");
        assert!(said.contains("coarsen the mesh to less than"), "{said}");
        said
    };
    // 19 million unknowns: the mesh with its matrix would fit.
    let said = refused("hex8", [320, 140, 140], "auto", 15.0);
    assert!(said.contains("multigrid for at least"), "{said}");
    refused("hex8", [320, 140, 140], "multigrid", 15.0);
    // The factor alone is too large, and multigrid would do.
    for path in ["dense", "solves"] {
        let said = refused("tet10", [120, 40, 40], path, 10.0);
        assert!(said.contains("Cholesky factor of at least") && said.contains("leave `path` under [solver]"), "{said}");
    }
}

/// Memory in which every phase fits is enough.
#[test]
fn what_fits_is_not_refused_by_its_counts() {
    let _alone = ALONE.lock();
    let tries = [("hex8", "solves", [24, 12, 12]), ("tet10", "multigrid", [16, 8, 8]), ("tet4", "dense", [30, 30, 4])];
    for (element, path, cells) in tries {
        let mut case = brick(element, cells, path);
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
        let (_, all) = measured(|| {
            let mut prepared = prepare(&case).unwrap();
            solved(&case, &mut prepared, &Settings::of(&case.solver), &folder)
        });
        case.solver.memory = Some(1.02e-9 * all.asked.max(all.peak) as f64);
        let prepared = prepare(&case).unwrap_or_else(|error| panic!("{element}/{path}: {error}"));
        solve(&prepared, &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(())).unwrap();
    }
}
