//! Input that cannot be used: exit code 2, what is wrong and where and what to do, and nothing written.

use crate::folder::{CASE, Folder, Run, two_cubes};

/// Solves the case with `old` replaced by `new` and asserts the words of the message.
#[track_caller]
fn refused(name: &str, old: &str, new: &str, words: &[&str]) {
    assert!(CASE.contains(old), "{old}");
    let folder = Folder::new(name, &CASE.replacen(old, new, 1));
    let run = folder.run(&["solve", "case.toml"]);
    run.ends(2, words);
    run.ends(2, &["error: ", "remedy: "]);
    assert_eq!(folder.names(), ["case.toml"], "nothing is written");
}

#[test]
fn an_unknown_key_is_shown_with_the_key_that_was_meant() {
    refused("key", "young =", "yuong =", &["case.toml:9:1", "yuong = 21.19e10", "^^^^^", "did you mean `young`?"]);
}

#[test]
fn a_value_of_the_wrong_type_is_shown_with_an_example() {
    refused("type", "poisson = 0.277", "poisson = \"soft\"", &["case.toml:10:11", "\"soft\"", "poisson = 0.3"]);
}

#[test]
fn a_missing_group_is_shown_with_the_nearest_name_and_all_that_would_do() {
    refused("group", "on = \"z-min\"", "on = \"z_min\"", &["case.toml:24:6", "did you mean \"z-min\"?", "x-max"]);
    refused("fixed", "on = \"x-min\"", "on = \"wall\"", &["no group \"wall\"", "groups with nodes: x-min"]);
}

#[test]
fn a_group_of_the_wrong_kind_is_shown_with_what_it_has() {
    refused("kind", "on = \"z-min\"", "on = \"body\"", &["no boundary faces: it has 81 cells", "groups with boundary"]);
}

#[test]
fn values_outside_their_range_are_refused() {
    refused("incompressible", "poisson = 0.277", "poisson = 0.5", &["incompressible", "b-bar"]);
    refused("friction", "coulomb = 0.35", "coulomb = -0.35", &["case.toml:26:24", "-0.35"]);
    refused("nan", "young = 21.19e10", "young = nan", &["case.toml:9:9", "finite"]);
    refused("infinite", "traction = [0, 0, 1e6]", "traction = [0, 0, inf]", &["finite"]);
}

#[test]
fn expressions_that_cannot_be_read_or_evaluated_are_shown() {
    refused("expression", "(3 - x)\"", "(3 - x\"", &["case.toml:17:", "2/3*1e6*(3 - x"]);
    refused("unknown", "(3 - x)\"", "(3 - r)\"", &["case.toml:17:", "r"]);
    refused(
        "pole",
        "traction = [0, 0, 1e6]",
        "traction = [0, 0, \"1/(3 - x)\"]",
        &["case.toml:19:1", "1/(3 - x)", "inf"],
    );
}

#[test]
fn a_body_that_could_move_is_refused_with_its_motions() {
    // The floor is smooth, or there is none.
    let rough = "on = \"x-min\"\n\n[[load]]\non = \"z-max\"\ntraction = [0, 0, \"-2/3*1e6*(3 - x)\"]\n\n[[load]]\non = \
                 \"x-max\"\ntraction = [0, 0, 1e6]\n\n[[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, \
                 0], normal = [0, 0, 1] } }\nfriction = { coulomb = 0.35 }\n";
    let smooth = rough.replace("{ coulomb = 0.35 }", "\"none\"").replacen("\n", "\ncomponents = \"xz\"\n", 1);
    let body = "of the body: translation along y";
    refused("sliding", rough, &smooth, &["case.toml:12:1", body, "not determined", "or friction"]);
    let pushed = smooth.replace("[0, 0, 1e6]", "[0, 1e3, 1e6]");
    refused("pushed", rough, &pushed, &["case.toml:12:1", body, "the loads push it there"]);
    let alone = &smooth[..smooth.find("[[contact]]").unwrap()];
    refused("sliding", rough, alone, &["case.toml:12:1", "the body is not held", "translation along y"]);
    let bare = format!("[[fix]]\n{rough}");
    refused("floating", &bare, "", &["case.toml:5:1", "not held at all", "[[contact]]"]);
    let held = "on = [\"x-min\", \"x-max\", \"y-min\", \"y-max\", \"z-min\", \"z-max\", \"body\"]";
    refused("held", "on = \"x-min\"", held, &["case.toml:12:1", "nothing to solve"]);
}

#[test]
fn contradictory_fixes_are_shown() {
    let twice = "[[fix]]\non = \"y-min\"\ncomponents = \"y\"\nvalue = 1e-3\n\n[[load]]";
    refused("twice", "[[load]]", twice, &["case.toml:15:1", "prescribed twice"]);
}

#[test]
fn boxes_without_anything_inside_are_refused() {
    let far = "on = { box = [[7, 7, 7], [8, 8, 8]] }";
    refused("box", "on = \"z-min\"", far, &["no boundary face lies inside", "[3.0, 1.0, 1.0]"]);
}

#[test]
fn a_cell_needs_exactly_one_material() {
    let other = "on = \"body\"\n[materials.brass]\nyoung = 1e11\npoisson = 0.3\non = \"body\"";
    refused(
        "materials",
        "poisson = 0.277",
        &format!("poisson = 0.277\n{other}"),
        &["81 cells", "\"steel\" and \"brass\""],
    );
}

/// A case on a mesh file with this text.
fn on_mesh(name: &str, mesh: &str, contact: &str) -> (Folder, Run) {
    let case = "[mesh]\nfile = \"part.msh\"\n[materials.m]\nyoung = 1\npoisson = 0.3\n[[fix]]\non = \"top\"\n[[contact]]\non = \
                \"CONTACT\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\nfriction = \"none\"\n";
    let folder = Folder::new(name, &case.replace("CONTACT", contact));
    folder.write("part.msh", mesh);
    let run = folder.run(&["solve", "case.toml"]);
    (folder, run)
}

#[test]
fn what_an_option_brings_about_later_is_shown_at_the_option() {
    let (folder, run) = on_mesh("option", &two_cubes(), "bottom");
    run.ends(0, &[]);
    let run = |more: &[&str]| folder.run(&[&["solve", "case.toml"], more].concat());
    let file = run(&["--set", "mesh.file=nix.msh"]);
    file.ends(
        2,
        &["error: --set mesh.file=nix.msh (case.toml:1:1), nix.msh: the mesh file cannot be read", "1 | [mesh]"],
    );
    run(&["--accuracy", "10"]).ends(2, &["error: --accuracy 10: ", "remedy: did you mean 10%? write that, or 0.1"]);
    run(&["--accuracy", "90"]).ends(2, &["error: --accuracy 90: ", "remedy: 0.02 is 2 %"]);
    let mu = run(&["--mu", "0.3"]);
    mu.ends(
        2,
        &[
            "unexpected argument '--mu'",
            "tip: values of the case are changed with --set KEY=VALUE: --set contact.0.friction",
        ],
    );
    assert!(!mu.err.contains("as a value"), "{mu:#?}");
    run(&["--progres", "none"]).ends(2, &["a similar argument exists: '--progress'"]);
}

/// A block and a lid on it.
const LID: &str = r#"
[mesh.parts.lid]
block = { size = [1, 1, 1], cells = [2, 2, 2], element = "hex8" }
move = [0, 0, 1]
[mesh.parts.box]
block = { size = [1, 1, 1], cells = [2, 2, 2], element = "hex8" }
[materials.m]
young = 1
poisson = 0.3
[[fix]]
on = "box.z-min"
[[contact]]
name = "seat"
on = "lid.z-min"
against = "box.z-max"
friction = { coulomb = 0.3 }
"#;

#[test]
fn a_body_that_nothing_holds_is_called_by_its_name() {
    let folder = Folder::new("lid", LID);
    let bare = LID[..LID.find("[[contact]]").unwrap()].to_string()
        + "[[contact]]\non = \"box.x-max\"\nagainst = { plane = { point = [1, 0, 0], normal = [-1, 0, 0] } }\nfriction = \"none\"\n";
    folder.write("bare.toml", &bare);
    let bare = folder.run(&["solve", "bare.toml"]);
    bare.ends(2, &["body \"lid\"", "bare.toml:10:1"]);
    let own = folder.run(&["solve", "case.toml", "--set", "contact.0.against=lid.z-max"]);
    own.ends(
        2,
        &[
            "error: --set contact.0.against=lid.z-max (case.toml:12:1): ",
            "contact \"seat\" names two surfaces of one body, \"lid\": is one of another body meant?",
        ],
    );
}

#[test]
fn contact_inside_the_body_is_refused() {
    let (folder, run) = on_mesh("interior", &two_cubes(), "middle");
    run.ends(2, &["case.toml:9:6", "1 faces of group \"middle\" lie between two cells"]);
    assert_eq!(folder.names(), ["case.toml", "part.msh"]);
    on_mesh("boundary", &two_cubes(), "bottom").1.ends(0, &[]);
}

#[test]
fn damaged_meshes_are_refused() {
    let mesh = two_cubes();
    on_mesh("truncated", &mesh[..mesh.len() / 2], "bottom").1.ends(2, &["part.msh", "line", "remedy: "]);
    on_mesh("nothing", "", "bottom").1.ends(2, &["part.msh", "remedy: "]);
    on_mesh("foreign", "solid part\nfacet normal 0 0 1\n", "bottom").1.ends(2, &["part.msh", "remedy: "]);
    let huge = mesh.replace("$Nodes\n12", "$Nodes\n4000000000");
    on_mesh("huge", &huge, "bottom").1.ends(2, &["part.msh", "remedy: "]);
    let folder = Folder::new("absent", &CASE.replace("block = {", "file = \"none.msh\" #"));
    folder.run(&["solve", "case.toml"]).ends(2, &["case.toml:5:1", "none.msh", "cannot be read"]);
    let folder = Folder::new("format", &CASE.replace("block = {", "file = \"part.stl\" #"));
    folder.run(&["solve", "case.toml"]).ends(2, &[".stl cannot be read in this version", "Gmsh"]);
}

#[test]
fn a_folder_that_cannot_be_written_to_is_refused_before_anything_is_solved() {
    let folder = Folder::new("folder", CASE);
    folder.write("taken", "");
    let run = folder.run(&["solve", "case.toml", "-o", "taken/results"]);
    run.ends(2, &["taken/results", "-o DIR"]);
    assert!(!run.err.contains("factorising") && run.out.is_empty());
}

#[test]
fn too_little_memory_is_refused() {
    let folder = Folder::new("memory", CASE);
    folder.run(&["solve", "case.toml", "--set", "solver.memory=1e-6"]).ends(2, &["case.toml:5:1", "MB", "remedy: "]);
    // Enough for the mesh and its matrix, too little for the factor with its dense block.
    let sizes = ["--set", "mesh.block.cells=[24,8,8]", "--set", "solver.memory=0.0125"];
    let large = [&sizes[..], &["--set", "solver.path=dense"]].concat();
    folder
        .run(&[&["solve", "case.toml"][..], &large[..]].concat())
        .ends(2, &["case.toml:5:1", "Cholesky factor", "coarsen the mesh"]);
    assert_eq!(folder.names(), ["case.toml"]);
}

#[test]
fn options_that_cannot_be_used_are_refused() {
    let folder = Folder::new("options", CASE);
    folder.run(&["solve"]).ends(2, &["CASE"]);
    folder.run(&["solve", "case.toml", "--set", "tolerance"]).ends(2, &["KEY=VALUE"]);
    folder
        .run(&["solve", "case.toml", "--set", "solver.tolerence=1"])
        .ends(2, &["--set solver.tolerence=1", "tolerance"]);
    folder.run(&["solve", "case.toml", "--threads", "0"]).ends(2, &["threads"]);
    folder.run(&["solve", "none.toml"]).ends(2, &["none.toml", "stiction new"]);
    assert_eq!(folder.names(), ["case.toml"]);
}
