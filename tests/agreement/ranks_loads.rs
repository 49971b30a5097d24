//! Temperatures, forces with moments and arrays of the mesh on several ranks: against closed forms, and against the same case on
//! one.

use std::path::Path;

use stiction::io::case::Case;
use stiction::io::vtu::{Array, Grid, write};
use stiction::io::vtu_read::{Over, read_fields};
use stiction::mesh::{Block, BlockElement, block};
use stiction::run::{Keep, prepare};

use super::ranks::{agrees, agrees_case, case_of, on_ranks, refusal};
use super::ranks_bolts::{bolts_agree, joint};
use super::ranks_files::{folder, killed, passes, solved};

const STEEL: &str = "[materials.steel]\nyoung = 2e11\npoisson = 0.3\nexpansion = 12e-6\nreference_temperature = 20\n";
const STEPS: &str = "[[step]]\nname = \"heat\"\nuntil = 1\nincrements = 2\n[[step]]\nname = \"cool\"\nuntil = 2\n";

/// A heated bar between planes of symmetry and a wall, which touches its end or is far away.
fn bar(element: &str, wall: f64) -> String {
    format!(
        "[mesh]\nblock = {{ size = [3, 1, 1], cells = [9, 3, 3], element = \"{element}\" }}\n{STEEL}\
         [[fix]]\non = \"x-min\"\ncondition = \"symmetry\"\n[[fix]]\non = \"y-min\"\ncondition = \"symmetry\"\n\
         [[fix]]\non = \"z-min\"\ncondition = \"symmetry\"\n[[load]]\ntemperature = \"20 + 100*t\"\n\
         [[contact]]\non = \"x-max\"\nfriction = \"none\"\n\
         against = {{ plane = {{ point = [{wall}, 0, 0], normal = [-1, 0, 0] }} }}\n"
    )
}

/// The brick of the other tests of ranks, pressed on its foundation and warmed from one end; the temperature goes up and halfway
/// down again.
fn warmed(element: &str, temperature: &str) -> String {
    format!(
        "[mesh]\nblock = {{ size = [3, 1, 1], cells = [18, 6, 6], element = \"{element}\" }}\n{STEEL}\
         [[fix]]\non = \"x-min\"\n[[load]]\non = \"z-max\"\ntraction = [0, 0, -1e7]\n[[load]]\ntemperature = {temperature}\n\
         [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ coulomb = 0.3 }}\n"
    )
}

const UP_AND_DOWN: &str = "\"20 + (1 + x)*40*min(t, 1.5 - 0.5*t)\"";

/// The largest distance of a component of stress from `along` for xx and zero for the others, in the files of all ranks. The
/// equivalent stress would not tell: a strain that is the same in all directions does not change it.
fn stress_off(folder: &Path, size: usize, along: f64) -> f64 {
    let of_rank = |rank: usize| {
        let path = folder.join(format!("result-{rank:04}.vtu"));
        // A rank at an end may have no cell of its own.
        let fields = path.exists().then(|| read_fields(&path, &[(Over::Cells, "stress")]).unwrap());
        fields.map_or(Vec::new(), |fields| fields.arrays[0].clone().unwrap())
    };
    let all: Vec<f64> = (0..size).flat_map(of_rank).collect();
    assert_eq!(all.len(), 6 * 81);
    let off = all.iter().enumerate().map(|(k, stress)| (stress - if k % 6 == 0 { along } else { 0.0 }).abs());
    // `f64::max` would leave out what is not a number.
    off.fold(0.0, |most: f64, off| if off <= most { most } else { off })
}

#[test]
fn a_bar_that_expands_freely_has_no_stress_on_ranks() {
    let home = folder("free-bar");
    let case = case_of(&bar("hex8", 3.1), "1e-10");
    let (u, summary) = on_ranks(&case, 4);
    assert_eq!(summary.answer.contact.normal_force, 0.0);
    let far = u.iter().map(|u| u[0]).fold(0.0, f64::max);
    assert!((far / (3.0 * 12e-6 * 100.0) - 1.0).abs() < 1e-9, "{far}");
    solved(&case, 4, &home, false);
    passes(&home);
    let off = stress_off(&home, 4, 0.0);
    assert!(off < 1e-6 * 2e11 * 12e-4, "{off}");
}

/// The wall bears Young's modulus times the strain that it takes from the bar, and so does each cell.
#[test]
fn a_heated_bar_before_a_wall_presses_it_by_its_strain_on_ranks() {
    let expected = 2e11 * 12e-6 * 100.0;
    for element in ["hex8", "tet10"] {
        for steps in ["", "[[step]]\nname = \"heat\"\nuntil = 1\nincrements = 2\n"] {
            let case = case_of(&(bar(element, 3.0) + steps), "1e-10");
            for size in [1, 3] {
                let force = on_ranks(&case, size).1.answer.contact.normal_force;
                assert!((force / expected - 1.0).abs() < 1e-9, "{element}, {size} ranks: {force}");
            }
        }
    }
    let home = folder("pressed-bar");
    solved(&case_of(&bar("hex8", 3.0), "1e-10"), 3, &home, false);
    passes(&home);
    let off = stress_off(&home, 3, -expected);
    assert!(off < 1e-6 * expected, "{off} {expected}");
}

#[test]
fn temperatures_that_differ_by_place_and_step_are_the_same_on_ranks() {
    agrees(&warmed("hex8", "\"20 + 40*(1 + x)*(1 + y*z)\""), &[1, 4]);
    agrees(&(warmed("hex8", UP_AND_DOWN) + STEPS), &[1, 2, 4]);
    agrees(&(warmed("tet10", UP_AND_DOWN).replace("[18, 6, 6]", "[9, 3, 3]") + STEPS), &[2]);
}

#[test]
fn a_heated_case_passes_its_judge_and_goes_on_from_its_files() {
    let case = case_of(&(warmed("hex8", UP_AND_DOWN) + STEPS), "1e-10");
    let whole = folder("heated");
    let expected = solved(&case, 3, &whole, false);
    passes(&whole);
    let part = folder("heated-on");
    killed(&case, 3, &part, false, 2);
    let found = solved(&case, 2, &part, true);
    passes(&part);
    let forces =
        |steps: &[stiction::run::StepRecord]| steps.iter().map(|s| s.answer.contact.normal_force).collect::<Vec<_>>();
    let pairs = forces(&found.steps).into_iter().zip(forces(&expected.steps));
    pairs.for_each(|(a, b)| assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}"));
}

/// A bolt that is tightened to a force and cools afterwards, its plates do not.
#[test]
fn a_bolt_that_cools_is_the_same_on_ranks() {
    let cooled = |temperature: &str| {
        let pull = "{ on = 'high.end', force = ['400*max(t - 1, 0)', 0, 0] }";
        joint(&[("load", &format!("[{pull}, {{ on = 'bolt', temperature = '{temperature}' }}]"))])
    };
    let case = cooled("-30*max(t - 1, 0)");
    agrees_case(&case, &[1, 3]);
    bolts_agree(&case, &[2, 4], 1e-8);
    // Tightened while it is cold already, its own strain is part of its force.
    bolts_agree(&cooled("-30*t"), &[3], 1e-8);
}

#[test]
fn cells_with_two_temperatures_and_materials_without_expansion_are_refused_by_ranks_too() {
    let twice = bar("hex8", 3.0) + "[[load]]\ntemperature = 50\n";
    let none = bar("hex8", 3.0).replace("expansion = 12e-6\n", "");
    for (text, what) in [(twice, "have a temperature already"), (none, "no expansion")] {
        let case = case_of(&text, "1e-8");
        let expected = prepare(&case).unwrap_err();
        assert!(expected.what.contains(what), "{expected}");
        let found = refusal(&case, 3, None);
        assert_eq!((&found.what, &found.place), (&expected.what, &expected.place));
    }
}

/// The ranks at one end have cells without mass only.
#[test]
fn weight_of_a_part_is_the_same_on_ranks() {
    let part = |name: &str, at: f64| {
        format!(
            "[mesh.parts.{name}]\nblock = {{ size = [2, 1, 1], cells = [8, 4, 4], element = \"hex8\" }}\nmove = [{at}, 0, 0]\n"
        )
    };
    let floor = "against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\nfriction = { coulomb = 0.3 }\n";
    let text = format!(
        "{}{}[materials.heavy]\nyoung = 2e9\npoisson = 0.3\ndensity = 7800\non = \"a\"\n\
         [materials.light]\nyoung = 2e9\npoisson = 0.3\non = \"b\"\n[[fix]]\non = [\"a.y-min\", \"b.y-min\"]\n\
         [[load]]\ngravity = [2, 0, -9.81]\n[[contact]]\non = \"a.z-min\"\n{floor}[[contact]]\non = \"b.z-min\"\n{floor}",
        part("a", 0.0),
        part("b", 3.0)
    );
    agrees(&text, &[1, 4]);
    let none = text.replace("[[load]]\n", "[[load]]\non = \"b\"\n");
    let error = refusal(&case_of(&none, "1e-8"), 4, None);
    assert!(error.what.contains("cells without mass"), "{error}");
}

/// A brick with a force and a moment on the end that is not held.
fn with_moment(element: &str, more: &str) -> String {
    format!(
        "[mesh]\nblock = {{ size = [3, 1, 1], cells = [18, 6, 6], element = \"{element}\" }}\n{STEEL}\
         [[fix]]\non = \"x-min\"\n[[load]]\non = \"z-max\"\ntraction = [0, 0, -1e7]\n\
         [[load]]\non = [\"x-max\", \"y-max\"]\nforce = [2e6, \"1e6*t\", 0]\nmoment = [\"1e6*t\", -3e6, 2e6]\n{more}\
         [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ coulomb = 0.3 }}\n"
    )
}

#[test]
fn a_force_with_a_moment_is_the_same_on_ranks() {
    agrees(&with_moment("hex8", ""), &[1, 2, 4]);
    agrees(&(with_moment("hex8", "about = [3, 0, 0]\n") + STEPS), &[3]);
    agrees(&with_moment("tet10", "").replace("[18, 6, 6]", "[9, 3, 3]"), &[2]);
}

/// The brick in a file with arrays on points and cells, one of which is `warmer`.
fn with_arrays(name: &str, more: &str, warmer: f64) -> Case {
    let [size, origin, grading] = [[3.0, 1.0, 1.0], [0.0; 3], [1.0; 3]];
    let mesh = block(&Block { size, origin, grading, cells: [18, 6, 6], element: BlockElement::Hex8 }).unwrap();
    let of_points: Vec<f64> = mesh.nodes.iter().map(|x| 20.0 + 40.0 * (1.0 + x[0]) * (1.0 + x[1] * x[2])).collect();
    let force: Vec<f64> = mesh.nodes.iter().map(|x| 300.0 * x[0] * x[2]).collect();
    let mut of_cells: Vec<f64> = (0..mesh.cell_count()).map(|cell| 20.0 + (cell % 7) as f64).collect();
    of_cells[300] += warmer;
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ranks-{name}.vtu"));
    let points = [Array::scalar("warm", &of_points), Array::scalar("push", &force), Array::scalar("idle", &force)];
    write(&path, &Grid::from_mesh(&mesh), &points, &[Array::scalar("patchy", &of_cells)]).unwrap();
    let text = format!(
        "[mesh]\nfile = {:?}\n{STEEL}[[fix]]\non = {{ box = [[0, 0, 0], [0, 1, 1]] }}\n\
         [[load]]\non = {{ box = [[0, 0, 1], [3, 1, 1]] }}\ntraction = [0, 0, -1e7]\n{more}\
         [[contact]]\non = {{ box = [[0, 0, 0], [3, 1, 0]] }}\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ coulomb = 0.3 }}\n",
        path.display()
    );
    case_of(&text, "1e-10")
}

#[test]
fn arrays_of_the_mesh_are_the_same_on_ranks() {
    let nodes = "[[load]]\ntemperature = { array = \"warm\" }\n";
    let case = with_arrays("warm", nodes, 0.0);
    agrees_case(&case, &[1, 4]);
    // It is the temperature of the expression that the array was made with.
    let (u, _) = on_ranks(&case, 2);
    let (expected, _) = on_ranks(&case_of(&warmed("hex8", "\"20 + 40*(1 + x)*(1 + y*z)\""), "1e-10"), 3);
    let apart = u.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let largest = expected.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(apart < 1e-8 * largest, "{apart} {largest}");
    let cells = "[[load]]\ntemperature = { array = \"patchy\", ramp = \"min(t, 1.5 - 0.5*t)\" }\n";
    agrees_case(&with_arrays("patchy", &format!("{cells}{STEPS}"), 0.0), &[3]);
    let forces = "[[load]]\nnodal = [{ array = \"push\" }, 20, { array = \"push\", ramp = \"-0.5*t\" }]\n";
    agrees_case(&with_arrays("push", forces, 0.0), &[1, 4]);
}

/// What a run goes on from depends on the numbers in an array, not on its name.
#[test]
fn steps_of_another_array_are_refused_by_ranks() {
    let more = format!("[[load]]\ntemperature = {{ array = \"patchy\", ramp = \"t\" }}\n{STEPS}");
    let home = folder("arrays");
    killed(&with_arrays("mended", &more, 0.0), 2, &home, false, 2);
    let keep = Keep { folder: home, resume: true, tell: |_| {} };
    let error = refusal(&with_arrays("mended", &more, 1e-3), 3, Some(&keep));
    assert!(error.what.contains("of another case"), "{error}");
}

/// What an interface presses and shears from the beginning is a load that its contact forces balance; an end is lifted then.
#[test]
fn interfaces_with_an_initial_stress_are_the_same_on_ranks() {
    let stress = "initial_stress = [0, -7e5, \"-1e6*(1 + 0.2*x)\", 1e5, \"2e5*x\", 3e5]\n";
    let steel = "[materials.steel]\nyoung = 2e11\npoisson = 0.3\n";
    let floor = "against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n";
    for steps in ["", "[[step]]\nuntil = 1\nincrements = 2\n"] {
        let brick = format!(
            "[mesh]\nblock = {{ size = [3, 1, 1], cells = [18, 6, 6], element = \"hex8\" }}\n{steel}\
             [[fix]]\non = \"x-min\"\n[[load]]\non = \"x-max\"\ntraction = [0, 0, \"1.5e6*t\"]\n\
             [[contact]]\non = \"z-min\"\n{floor}friction = {{ coulomb = 0.4, cohesion = 1e5 }}\n{stress}{steps}"
        );
        agrees(&brick, &[1, 3, 4]);
    }
    let bodies = format!(
        "[mesh.parts.a]\nblock = {{ size = [3, 1, 1], cells = [9, 4, 3], element = \"tet10\" }}\n\
         [mesh.parts.b]\nblock = {{ size = [3.2, 1, 0.5], cells = [8, 3, 2], element = \"hex8\" }}\nmove = [0, 0, -0.5]\n{steel}\
         [[fix]]\non = \"a.x-min\"\n[[fix]]\non = \"b.z-min\"\n[[load]]\non = \"a.x-max\"\ntraction = [0, 2e5, 1e6]\n\
         [[contact]]\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = {{ coulomb = 0.5 }}\n{stress}"
    );
    agrees(&bodies, &[2, 4]);
}

#[test]
fn a_body_without_contact_is_the_same_on_ranks() {
    let body = |element: &str, more: &str| {
        format!(
            "[mesh]\nblock = {{ size = [3, 1, 1], cells = [24, 8, 8], element = \"{element}\" }}\n[materials.s]\nyoung = 1e3\npoisson = 0.3\n\
             [[fix]]\non = \"x-min\"\n[[load]]\non = \"x-max\"\ntraction = [0, 0, \"-t\"]\n{more}"
        )
    };
    agrees(&body("hex8", ""), &[1, 2, 4]);
    agrees(&body("tet10", "[[step]]\nuntil = 1\nincrements = 2\n"), &[2]);
}
