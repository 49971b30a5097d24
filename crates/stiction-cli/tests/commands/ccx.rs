//! The command as programs around CalculiX call it, and the files they read.

use crate::folder::{CASE, Folder, Run};

/// Two cubes without lateral contraction, the upper one pressed onto the lower and shifted along it without friction. The numbers of
/// nodes and elements have gaps, and the upper cube is named first.
const BOXES: &str = "\
*HEADING
two cubes
*NODE
111, 0,0,1
112, 1,0,1
113, 1,1,1
114, 0,1,1
115, 0,0,2
116, 1,0,2
117, 1,1,2
118, 0,1,2
1, 0,0,0
2, 1,0,0
3, 1,1,0
4, 0,1,0
5, 0,0,1
6, 1,0,1
7, 1,1,1
8, 0,1,1
9, 9,9,9
*ELEMENT, TYPE=C3D8, ELSET=UP
70, 111,112,113,114,115,116,117,118
*ELEMENT, TYPE=C3D8, ELSET=LOW
3, 1,2,3,4,5,6,7,8
*NSET, NSET=BASE
1,2,3,4
*NSET, NSET=TOP
115,116,117,118
*SURFACE, NAME=SLAVE
UP,S1
*SURFACE, NAME=MASTER
LOW,S2
*MATERIAL, NAME=STEEL
*ELASTIC
1000, 0
*SOLID SECTION, ELSET=UP, MATERIAL=STEEL
*SOLID SECTION, ELSET=LOW, MATERIAL=STEEL
*CONTACT PAIR, INTERACTION=I, TYPE=SURFACE TO SURFACE
SLAVE,MASTER
*SURFACE INTERACTION, NAME=I
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD
*BOUNDARY
BASE,1,3
*STEP
*STATIC
*BOUNDARY
TOP,1,1,0.003
TOP,2,2
TOP,3,3,-0.01
*NODE FILE
U,RF
*EL FILE
S,E,ENER
*CONTACT FILE
CDIS,CSTR
*NODE PRINT, NSET=BASE, TOTALS=YES
U,RF
*NODE PRINT, NSET=TOP, TOTALS=ONLY
RF
*CONTACT PRINT, SLAVE=SLAVE, MASTER=MASTER, TOTALS=ONLY
CF
*END STEP
";

/// Half of the overlap of 0.01 over the height of 1 is the strain of each cube.
const PRESSURE: f64 = 1000.0 * 0.005;

/// The lines of a block of results: number of the node and values.
fn block(frd: &str, name: &str) -> Vec<(u32, Vec<f64>)> {
    let head = format!(" -4  {name:<8}");
    let at = frd.find(&head).unwrap_or_else(|| panic!("no {name} in\n{frd}"));
    let rows = frd[at..].lines().skip(1).skip_while(|line| line.starts_with(" -5"));
    let row = |line: &str| {
        let values = (13..line.len()).step_by(12).map(|at| line[at..at + 12].trim().parse().unwrap()).collect();
        (line[3..13].trim().parse().unwrap(), values)
    };
    rows.take_while(|line| line.starts_with(" -1")).map(row).collect()
}

fn are(values: &[f64], wanted: &[f64], scale: f64) {
    let close = |(value, wanted): (&f64, &f64)| (value - wanted).abs() <= 1e-5 * scale;
    assert!(
        values.len() == wanted.len() && values.iter().zip(wanted).all(close),
        "{values:?} where {wanted:?} is wanted"
    );
}

fn job(folder: &Folder, name: &str, text: &str, words: &[&str]) -> Run {
    folder.write(&format!("{name}.inp"), text);
    folder.run(&[&["ccx"], words].concat())
}

/// As CalculiX does: a card of a later step takes the place of those of its kind, others go on.
#[test]
fn tables_of_a_step_take_the_place_of_those_before() {
    let folder = Folder::new("ccx-tables", CASE);
    let second = "*END STEP\n*STEP\n*STATIC\n*NODE PRINT, NSET=TOP\nU\n*NODE PRINT, NSET=TOP, TOTALS=ONLY\nRF\n*END STEP\n\
                  *STEP\n*STATIC\n*END STEP\n";
    job(&folder, "steps", &BOXES.replace("*END STEP\n", second), &["-i", "steps"]).ends(0, &[]);
    let dat = std::fs::read_to_string(folder.at("steps.dat")).unwrap();
    let at = |what: &str, t: usize| dat.matches(&format!("{what} and time  0.{t}000000E+01")).count();
    assert_eq!([1, 2, 3].map(|t| at("for set BASE", t)), [3, 0, 0], "{dat}");
    assert_eq!([1, 2, 3].map(|t| at("for set TOP", t)), [1, 2, 2], "{dat}");
    assert_eq!([1, 2, 3].map(|t| dat.matches(&format!("time  0.{t}000000E+01")).count()), [5, 3, 3], "{dat}");
}

#[test]
fn the_file_of_results_has_the_closed_form_at_the_nodes_of_the_deck() {
    let folder = Folder::new("ccx", CASE);
    let run = job(&folder, "boxes", BOXES, &["-i", "boxes"]);
    run.ends(0, &[]);
    // Programs take what stands there for a failure.
    assert!(run.err.is_empty() && run.out.contains("Job finished"), "{run:#?}");
    assert!(run.out.contains("ENER of the deck's FILE or OUTPUT cards is not computed"), "{run:#?}");
    let frd = std::fs::read_to_string(folder.at("boxes.frd")).unwrap();
    assert!(frd.starts_with("    1C\n") && frd.ends_with(" -3\n 9999\n"));
    let labels = [111, 112, 113, 114, 115, 116, 117, 118, 1, 2, 3, 4, 5, 6, 7, 8];
    let upper = |node: u32| node > 100;
    let height = |node: u32| match node {
        1..=4 => 0.0,
        115.. => 2.0,
        _ => 1.0,
    };
    let displacement = block(&frd, "DISP");
    assert_eq!(displacement.iter().map(|row| row.0).collect::<Vec<_>>(), labels);
    for (node, u) in &displacement {
        are(u, &[if upper(*node) { 0.003 } else { 0.0 }, 0.0, -0.005 * height(*node)], 0.01);
    }
    for (_, stress) in block(&frd, "STRESS") {
        are(&stress, &[0.0, 0.0, -PRESSURE, 0.0, 0.0, 0.0], PRESSURE);
    }
    for (_, strain) in block(&frd, "TOSTRAIN") {
        are(&strain, &[0.0, 0.0, -0.005, 0.0, 0.0, 0.0], 0.005);
    }
    for (node, force) in block(&frd, "FORC") {
        let quarter = PRESSURE / 4.0;
        let z = [(0.0, quarter), (2.0, -quarter)].iter().find(|at| at.0 == height(node)).map_or(0.0, |at| at.1);
        are(&force, &[0.0, 0.0, z], PRESSURE);
    }
    for (node, values) in block(&frd, "CONTACT") {
        let slave = (111..=114).contains(&node);
        are(&values[..3], &if slave { [0.0, 0.003, 0.0] } else { [0.0; 3] }, 0.003);
        are(&values[3..], &if slave { [PRESSURE, 0.0, 0.0] } else { [0.0; 3] }, PRESSURE);
    }
    // The elements stand in the order of the deck.
    let elements: Vec<&str> = frd.lines().filter(|line| line.ends_with("    1    0    1")).collect();
    assert_eq!(elements, [" -1        70    1    0    1", " -1         3    1    0    1"]);
}

#[test]
fn the_tables_have_the_sums_that_were_asked_for() {
    let folder = Folder::new("ccx-tables", CASE);
    job(&folder, "boxes", BOXES, &["boxes"]).ends(0, &[]);
    let dat = std::fs::read_to_string(folder.at("boxes.dat")).unwrap();
    let after = |what: &str, lines: usize| -> Vec<f64> {
        let at = dat.find(what).unwrap_or_else(|| panic!("no {what} in\n{dat}"));
        let line = dat[at..].lines().nth(lines).unwrap();
        line.split_whitespace().map(|word| word.parse().unwrap()).collect()
    };
    are(&after("displacements (vx,vy,vz) for set BASE and time", 2), &[1.0, 0.0, 0.0, 0.0], 1.0);
    are(&after("forces (fx,fy,fz) for set BASE", 2), &[1.0, 0.0, 0.0, PRESSURE / 4.0], PRESSURE);
    are(&after("total force (fx,fy,fz) for set BASE", 2), &[0.0, 0.0, PRESSURE], PRESSURE);
    are(&after("total force (fx,fy,fz) for set TOP", 2), &[0.0, 0.0, -PRESSURE], PRESSURE);
    assert!(!dat.contains("\n forces (fx,fy,fz) for set TOP"), "{dat}");
    // The lower body pushes the slave up, at the middle of the cube's foot, which has slid by 0.003.
    let total = after("total surface force", 2);
    are(&total[..3], &[0.0, 0.0, PRESSURE], PRESSURE);
    are(&total[3..], &[0.5 * PRESSURE, -0.503 * PRESSURE, 0.0], PRESSURE);
    are(&after("center of gravity", 2), &[0.503, 0.5, 0.995, 0.0, 0.0, -1.0], 1.0);
    are(&after("area,  normal force", 2), &[1.0, -PRESSURE, 0.0], PRESSURE);
    let sta = std::fs::read_to_string(folder.at("boxes.sta")).unwrap();
    let last = sta.lines().last().unwrap();
    assert!(
        last.starts_with("     1          1     1 ") && last.ends_with("  0.100000E+01  0.100000E+01  0.100000E+01"),
        "{sta}"
    );
    assert!(std::fs::read_to_string(folder.at("boxes.cvg")).unwrap().lines().count() > 4);
}

/// Two squares, plane strain and two thick, pressed by 10: nothing acts across the plane of the deck, whose layer lies beside it.
#[test]
fn of_a_plane_deck_the_tables_have_what_acts_in_its_plane() {
    const SQUARES: &str = include_str!("../../../../tests/data/decks/plane-strain.inp");
    let prints = "*NODE PRINT, NSET=Nbottom, TOTALS=ONLY\nRF\n*CONTACT PRINT, SLAVE=Shigh, MASTER=Slow\nCF\n*END STEP";
    let folder = Folder::new("ccx-plane", CASE);
    job(&folder, "squares", &SQUARES.replace("*END STEP", prints), &["squares"]).ends(0, &[]);
    let dat = std::fs::read_to_string(folder.at("squares.dat")).unwrap();
    let after = |what: &str, lines: usize| -> Vec<f64> {
        let at = dat.find(what).unwrap_or_else(|| panic!("no {what} in\n{dat}"));
        dat[at..].lines().nth(lines).unwrap().split_whitespace().map(|word| word.parse().unwrap()).collect()
    };
    are(&after("total force (fx,fy,fz)", 2)[1..], &[20.0, 0.0], 20.0);
    // Half of the width, which grows by poisson (1 + poisson) pressure / young.
    let middle = 0.5 * 1.003125;
    are(&after("total surface force", 2), &[0.0, 20.0, 0.0, 0.0, 0.0, 20.0 * middle], 20.0);
    are(&after("center of gravity", 2), &[middle, 0.990625, 0.0, 0.0, -1.0, 0.0], 1.0);
    are(&after("area,  normal force", 2), &[2.0, -20.0, 0.0], 20.0);
}

#[test]
fn a_solve_writes_the_same_file_of_results_as_ccx() {
    let folder = Folder::new("ccx-frd", CASE);
    job(&folder, "boxes", BOXES, &["boxes"]).ends(0, &[]);
    let arguments = ["solve", "boxes.inp", "-o", "results", "--frd", "ours.frd", "--no-pictures", "--no-report"];
    folder.run(&arguments).ends(0, &[]);
    let [theirs, ours] = ["boxes.frd", "ours.frd"].map(|name| std::fs::read_to_string(folder.at(name)).unwrap());
    for name in ["DISP", "STRESS", "TOSTRAIN", "FORC", "CONTACT"] {
        assert_eq!(block(&ours, name), block(&theirs, name), "{name}");
    }
    // Of a case nodes count from 1.
    let arguments = ["solve", "case.toml", "-o", "block", "--frd", "block.frd", "--no-pictures", "--no-report"];
    folder.run(&arguments).ends(0, &[]);
    let frd = std::fs::read_to_string(folder.at("block.frd")).unwrap();
    let numbers: Vec<u32> = block(&frd, "DISP").iter().map(|row| row.0).collect();
    assert!(!numbers.is_empty() && numbers.iter().copied().eq(1..=numbers.len() as u32));
    folder.run(&["solve", "case.toml", "--frd", "missing/block.frd"]).ends(2, &["missing/block.frd"]);
}

/// A second step of two increments that pushes twice as far: blocks for each increment, with steps, increments and times of the deck.
#[test]
fn each_increment_of_each_step_has_its_blocks() {
    let folder = Folder::new("ccx-steps", CASE);
    let second = "*STEP\n*STATIC, DIRECT\n1., 2.\n*BOUNDARY\nTOP,1,1,0.003\nTOP,2,2\nTOP,3,3,-0.02\n*NODE FILE\nU,RF\n*END STEP\n";
    job(&folder, "boxes", &format!("{BOXES}{second}"), &["boxes"]).ends(0, &[]);
    let frd = std::fs::read_to_string(folder.at("boxes.frd")).unwrap();
    let increments: Vec<[&str; 2]> =
        frd.split("    1PSTEP").skip(1).map(|part| [&part[26..50], &part[73..85]]).collect();
    let wanted = [["1", "1", "1.000000000"], ["1", "2", "2.000000000"], ["2", "2", "3.000000000"]];
    for (at, [numbers, time]) in increments.iter().enumerate() {
        let [increment, step, t] = wanted[at / 5];
        assert_eq!(numbers.split_whitespace().collect::<Vec<_>>(), [increment, step], "{at}");
        assert_eq!(time.trim(), t, "{at}");
    }
    assert_eq!(increments.len(), 15);
    // The last blocks stand at the end.
    let last = &frd[frd.rfind(" -4  STRESS").unwrap()..];
    for (_, stress) in block(last, "STRESS") {
        are(&stress, &[0.0, 0.0, -2.0 * PRESSURE, 0.0, 0.0, 0.0], PRESSURE);
    }
    let sta = std::fs::read_to_string(folder.at("boxes.sta")).unwrap();
    assert!(sta.lines().last().unwrap().ends_with("  0.300000E+01  0.200000E+01  0.100000E+01"), "{sta}");
}

#[test]
fn a_deck_that_is_not_solved_ends_with_201_and_says_why_on_standard_output() {
    let folder = Folder::new("ccx-refused", CASE);
    let run = job(&folder, "wrong", &BOXES.replace("*STATIC", "*FREQUENCY"), &["-i", "wrong"]);
    run.ends(201, &[]);
    assert!(run.err.is_empty() && run.out.contains("*ERROR") && run.out.contains("*FREQUENCY"), "{run:#?}");
    for words in [&["-i", "none"][..], &["-o", "exo", "none"], &[]] {
        let run = folder.run(&[&["ccx"], words].concat());
        run.ends(201, &[]);
        assert!(run.err.is_empty(), "{run:#?}");
    }
    assert!(folder.run(&["ccx"]).out.contains("CalculiX"));
    let version = folder.run(&["ccx", "-v"]);
    version.ends(0, &[]);
    assert!(version.out.contains("Version 2."), "{version:#?}");
}

/// FreeCAD gives `-i` with a blank behind it.
#[cfg(unix)]
#[test]
fn a_link_named_ccx_behaves_as_the_command() {
    let folder = Folder::new("ccx-link", CASE);
    folder.write("boxes.inp", BOXES.replace("NODE FILE", "NODE OUTPUT").replace("EL FILE", "ELEMENT OUTPUT"));
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_stiction"), folder.at("ccx")).unwrap();
    let linked = std::process::Command::new(folder.at("ccx")).args(["-i ", "boxes"]).current_dir(&folder.path).output();
    Run::of(linked.unwrap()).ends(0, &[]);
    // Results as bytes, as the cards ask for: each node with three displacements in single precision.
    let frd = std::fs::read(folder.at("boxes.frd")).unwrap();
    let head = b"    1ALL\n";
    let at = frd.windows(head.len()).position(|bytes| bytes == head).unwrap() + head.len();
    let node = i32::from_le_bytes(frd[at..at + 4].try_into().unwrap());
    let x = f32::from_le_bytes(frd[at + 4..at + 8].try_into().unwrap());
    assert!(node == 111 && (x - 0.003).abs() < 1e-8, "{node} {x}");
}
