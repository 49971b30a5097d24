//! One mistake at a time: the place and the remedy.

use super::{BRICK, edited, parse, set};
use crate::friction::{Coupling, Given, Method, MethodSettings, Penalty, Splitting, Sweeps};

/// The error for `text`: its place without the file name, and the whole message.
fn error(text: &str) -> (String, String) {
    let error = match parse(text, "case.toml", &[]) {
        Err(error) => error,
        Ok(_) => panic!("accepted:\n{text}"),
    };
    assert!(!error.remedy.is_empty() && !error.excerpt.is_empty(), "{error}");
    (error.place.trim_start_matches("case.toml:").to_string(), error.to_string())
}

/// The brick with `from` replaced by `to` fails at `place` with a message that contains all `parts`.
fn fails(from: &str, to: &str, place: &str, parts: &[&str]) {
    let (found, message) = error(&edited(from, to));
    assert_eq!(found, place, "{message}");
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in:\n{message}");
    }
}

#[test]
fn unknown_keys_are_answered_with_the_nearest_valid_one() {
    fails("tolerance =", "tolerence =", "18:1", &["did you mean `tolerance`?", "max_iterations", "^^^^^^^^^"]);
    fails("young =", "yuong =", "6:1", &["[materials.steel] has no key", "`young`", "poisson"]);
    fails("size = [3", "sise = [3", "4:11", &["`block` has no key", "did you mean `size`?"]);
    fails("normal =", "motion =", "15:42", &["`plane` has no key", "into `against`"]);
    fails("[solver]", "[solvre]", "17:2", &["the case file has no key", "`solver`"]);
    fails("[[contact]]", "[[kontakt]]", "13:3", &["contact"]);
    fails("normal =", "norm =", "15:42", &["`plane` has no key", "`normal`"]);
    fails("friction = { coulomb", "friction = { columb", "16:14", &["did you mean `coulomb`?"]);
}

#[test]
fn wrong_types_name_what_is_there_what_is_wanted_and_an_example() {
    fails(
        "21.19e10",
        "\"steel\"",
        "6:9",
        &["the text \"steel\"", "a number greater than 0", "a list of 3 entries", "young = 210e9"],
    );
    fails("[24, 8, 8]", "[24, 8]", "4:37", &["a list of 2 entries", "a list of 3 entries", "cells = [24, 8, 8]"]);
    fails("[24, 8, 8]", "[24, 8.5, 8]", "4:42", &["`cells[1]` is the number 8.5", "a whole number"]);
    fails("[24, 8, 8]", "[24, 0, 8]", "4:42", &["the number 0", "from 1"]);
    fails("[3, 1, 1]", "[3, -1, 1]", "4:22", &["`size[1]` is -1.0", "greater than 0"]);
    fails("on = \"x-min\"", "on = 3", "9:6", &["the number 3", "a table { box, point }"]);
    fails("on = \"x-min\"", "on = []", "9:6", &["a list of 0 entries", "at least 1"]);
    fails("on = \"x-min\"", "on = [\"a\", 4]", "9:12", &["`on[1]` is the number 4"]);
    fails("on = \"x-min\"", "on = \" \"", "9:6", &["empty text"]);
    fails("title = \"Brick on a rigid foundation\"", "title = true", "1:9", &["true", "a text in double quotes"]);
    fails("[[fix]]", "[fix]", "8:1", &["a table", "a list of tables", "[[fix]]"]);
    fails("[materials.steel]", "[[materials]]", "5:1", &["a table of tables", "[materials.steel]"]);
    let (place, message) = error("fix = [1]\n");
    assert!(place == "1:8" && message.contains("a list of tables") && message.contains("[[fix]]"), "{message}");
    fails("0.277", "1979-05-27", "7:11", &["a date"]);
    fails("poisson", "expansion", "5:1", &["has no `poisson`"]);
    fails("\"tet4\"", "\"tet\"", "4:59", &["did you mean \"tet4\"?", "linear tetrahedra", "hex8"]);
    fails("young = 21.19e10", "young = 99999999999999999999", "6:9", &["too large"]);
}

#[test]
fn rings_that_cannot_be_are_refused_where_they_stand() {
    let ring =
        |keys: &str| format!("ring = {{ radii = [2, 4], height = 1, degrees = 90, cells = [2, 9, 1]{keys} }}\n#");
    let fails = |text: String, place: &str, parts: &[&str]| fails("block = {", &text, place, parts);
    fails(ring("").replace("[2, 4]", "[4, 2]"), "4:18", &["inner radius 4 is not smaller", "inner radius first"]);
    fails(ring("").replace("[2, 4]", "[0, 2]"), "4:19", &["`radii[0]` is 0", "greater than 0"]);
    fails(ring("").replace("90", "360"), "4:48", &["`degrees` is 360", "270"]);
    fails(ring(", element = \"hex8\", split = \"six\""), "4:97", &["hex8, which is cut in one way only"]);
    fails("scale = 2\n".to_string() + &ring(""), "4:9", &["the mesh is a ring"]);
    fails("file = \"a.msh\"\n".to_string() + &ring(""), "5:1", &["both `file` and `ring`"]);
}

#[test]
fn numbers_out_of_range_are_refused_with_reasons() {
    fails("0.277", "0.5", "7:11", &["incompressible", "0.49", "b-bar"]);
    fails("0.277", "0.7", "7:11", &["greater than -1 and less than 0.5"]);
    fails("0.277", "-1", "7:11", &["greater than -1"]);
    fails("0.35", "-0.35", "16:24", &["`coulomb` is -0.35", "of at least 0", "direction of friction"]);
    fails("21.19e10", "nan", "6:9", &["NaN", "finite"]);
    fails("21.19e10", "1e999", "6:9", &["inf", "finite"]);
    fails("[0, 0, 1]", "[0, 0, -inf]", "15:58", &["-inf", "finite"]);
    fails("traction = [0,", "traction = [nan,", "12:13", &["NaN"]);
    fails("1e-8", "0.5", "18:13", &["at least 1e-14 and at most 0.1"]);
    fails("[0, 0, 1]", "[0, 0, 0]", "15:51", &["`normal` is zero", "[0, 0, 1]"]);
    fails("[24, 8, 8]", "[9999, 9999, 9999]", "4:37", &["fewer cells"]);
}

#[test]
fn faults_in_expressions_are_marked_inside_the_quotes() {
    fails("\"-2/3*1e6*(3 - x)\"", "\"-2/3*1e6*(3 - r)\"", "12:34", &["\"r\"", "x, y, z, t", "^"]);
    fails("\"-2/3*1e6*(3 - x)\"", "\"2x\"", "12:21", &["2*x"]);
    fails("\"-2/3*1e6*(3 - x)\"", "\"\"", "12:20", &["empty"]);
    fails("\"-2/3*1e6*(3 - x)\"", "\"\\u0032x\"", "12:19", &["2*x"]);
    fails("traction = [0, 0, \"-2/3*1e6*(3 - x)\"]", "force = [0, 0, \"x\"]", "12:17", &["only t may"]);
}

#[test]
fn keys_that_are_missing_or_exclude_one_another_are_named() {
    fails("poisson = 0.277\n", "", "5:1", &["[materials.steel] has no `poisson`", "add poisson = 0.3"]);
    fails("friction = { coulomb = 0.35 }\n", "", "13:1", &["no `friction`", "none", "bonded", "coulomb", "tresca"]);
    fails("on = \"z-max\"\n", "", "11:12", &["where it acts", "add on"]);
    fails("traction = [0, 0, \"-2/3*1e6*(3 - x)\"]\n", "", "10:1", &["none of traction, pressure", "exactly one"]);
    fails("[materials.steel]", "[materials.steel]\n[materials.tin]", "5:1", &["[materials.steel] has no `young`"]);
    fails("[materials.steel]", "[materials]", "6:1", &["`materials.young`", "a table is wanted", "[materials.steel]"]);
    fails("[mesh]", "[mesh]\nfile = \"a.msh\"", "5:1", &["both `file` and `block`", "keep one"]);
    fails("coulomb = 0.35", "coulomb = 0.35, tresca = 1", "16:30", &["both"]);
    fails("coulomb = 0.35", "", "16:12", &["none of coulomb, tresca"]);
    fails("coulomb = 0.35", "coulomb = 0.3, nodal = true", "16:37", &["`nodal` is for tresca"]);
    fails("[mesh]", "[mesh]\nscale = 2", "4:9", &["`scale` is for a mesh file"]);
    fails("\"tet4\"", "\"hex8\", split = \"five\"", "4:75", &["`split` is for tet4"]);
    fails("\"tet4\"", "\"hex8\", parity = 0", "4:76", &["`parity` is for tet4"]);
    fails("\"tet4\"", "\"hex20\", parity = 0", "4:77", &["`parity` is for tet4 and tet10", "hex20"]);
    fails("\"tet4\"", "\"tet4\", split = \"six\", parity = 0", "4:91", &["`parity` is for split"]);
    fails("on = \"x-min\"", "on = { box = [[0, 0, 0], [1, 1, 1]], point = [0, 0, 0] }", "9:38", &["both"]);
    let two = "density = 1\n[materials.tin]\nyoung = 1\npoisson = 0\n[[fix]]";
    fails("[[fix]]", two, "5:1", &["does not say where it is", "2 materials"]);
    let (place, message) = error("title = \"a\"\n[mesh]\nfile = \"a\"\n");
    assert!(place == "1:1" && message.contains("no [materials]") && message.contains("[materials.steel]"), "{message}");
}

#[test]
fn what_this_version_cannot_do_is_said_plainly() {
    let absent = "not available in this version";
    fails("\"tet4\"", "\"hex27\"", "4:59", &[absent, "hex20"]);
    fails("traction =", "temperature = 80\ntraction =", "13:1", &["both `temperature` and `traction`"]);
    let plane = "{ plane = { point = [0, 0, 0], normal = [0, 0, 1] } }";
    fails(
        plane,
        "7",
        "15:11",
        &["the number 7", "a table { plane, sphere, cylinder, surface, scale,", "at least 1 entries"],
    );
}

#[test]
fn steps_and_motions_are_held_to_the_time_axis() {
    let with =
        |steps: &str, place: &str, parts: &[&str]| fails("[solver]", &format!("{steps}\n[solver]"), place, parts);
    with("[[step]]", "17:1", &["this [[step]] has no `until`", "add until = 1"]);
    with("[[step]]\nuntil = 0", "18:9", &["`until` is", "greater than 0"]);
    with("[[step]]\nuntil = 1\n[[step]]\nuntil = 1", "20:9", &["begins at t = 1", "no duration"]);
    with(
        "[[step]]\nname = \"a\"\nuntil = 1\n[[step]]\nname = \"a\"\nuntil = 2",
        "21:8",
        &["two steps are called \"a\""],
    );
    with("[[step]]\nuntil = 1\nincrements = 0", "19:14", &["from 1 to 100000"]);
    with("[[step]]\nuntil = 1\nincrement = 2", "19:1", &["did you mean `increments`?"]);
    let plane = "plane = { point = [0, 0, 0], normal = [0, 0, 1] }";
    fails(plane, &format!("{plane}, motion = [0, 0, \"x\"]"), "15:81", &["only t may"]);
    fails(plane, &format!("{plane}, motion = 1"), "15:73", &["`motion` is the number 1", "motion = [0, 0"]);
    fails(plane, &format!("{plane}, moton = [0, 0, 1]"), "15:64", &["did you mean `motion`?"]);
}

#[test]
fn mistakes_about_pairs_and_parts_are_shown() {
    let plane = "{ plane = { point = [0, 0, 0], normal = [0, 0, 1] } }";
    fails(plane, "\" \"", "15:11", &["empty text"]);
    fails(plane, &format!("{plane}\ngap = 0.1"), "16:7", &["`gap` is for contact between two surfaces"]);
    fails(plane, &format!("{plane}\nsearch = 1"), "16:10", &["`search` is for", "name a group in `against`"]);
    fails(plane, "\"a\"\nslave = \"a\"", "16:9", &["\"on\" (the surface of `on`)"]);
    fails(plane, "\"a\"\nsearch = 0", "16:10", &["greater than 0"]);
    fails(plane, "\"a\"\ngap = \"open\"", "16:7", &["as-meshed", "closed"]);
    fails("block = {", "parts.a = 3\n#", "4:7", &["`parts.a`", "[mesh.parts.ring]"]);
    fails("block = {", "parts.a.move = [0, 0, 1]\n#", "4:7", &["none of block, ring, file"]);
    fails("block = {", "scale = 2\nparts.a.block = {", "4:9", &["the mesh has parts"]);
    fails("block = {", "scale = 2\nfile = \"a.msh\"\nparts.a.block = {", "6:1", &["both `file` and `parts`"]);
    fails("block = {", "turn = { axis = [0, 0, 0], degrees = 1 }\nblock = {", "4:17", &["`axis` is zero"]);
    fails("block = {", "turn = { axis = [0, 0, 1] }\nblock = {", "4:8", &["no `degrees`"]);
}

#[test]
fn mistakes_of_meaning_are_caught() {
    fails("[[fix]]", "[[fix]]\ncomponents = \"xw\"", "9:14", &["'w'", "some of x, y, z"]);
    fails("[[fix]]", "[[fix]]\ncomponents = \"xx\"", "9:14", &["x twice"]);
    fails("[[fix]]", "[[fix]]\nvalue = [1, 2]", "9:9", &["has 2 of the 3 components", "x, y, z"]);
    fails("[[fix]]", "[[fix]]\nvalue = 1", "9:9", &["has 1 of the 3 components"]);
    fails("on = \"z-min\"", "on = { point = [0, 0, 0] }", "14:6", &["a point has neither"]);
    fails("on = \"x-min\"", "on = { box = [[0, 0, 0], [1, -1, 1]] }", "9:14", &["empty", "lowest corner"]);
    fails("[solver]", "[[load]]\ngravity = [0, 0, -9.81]\n[solver]", "17:1", &["no material has a density"]);
    let again = "[[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\nfriction = \"none\"\n[solver]";
    fails("[solver]", again, "18:6", &["two contacts are called \"z-min\"", "name ="]);
    fails("{ coulomb = 0.35 }", "\"nome\"", "16:12", &["did you mean \"none\"?", "bonded", "or a table"]);
}

#[test]
fn bad_toml_is_shown_at_its_place() {
    fails("[solver]", "[solver", "17:8", &["not TOML", "key = value"]);
    fails("young = 21.19e10", "young 21.19e10", "6:7", &["not TOML"]);
    fails("poisson = 0.277", "young = 1", "7:1", &["duplicate key", "[[contact]]"]);
    fails("\"m, N, Pa\"", "\"m, N, Pa", "2:18", &["not TOML"]);
}

#[test]
fn wrong_overrides_are_shown_as_they_were_given() {
    let cases = [
        ("solver.tolerence", "1e-6", "did you mean `tolerance`?"),
        ("solver.tolerance", "small", "the text \"small\""),
        ("contact.1.friction", "none", "the last is 0"),
        ("contact.friction", "none", "counted from 0"),
        ("materials.steel.young.x", "1", "cannot be set inside the number"),
        ("", "1", "no path of keys"),
        ("a..b", "1", "no path of keys"),
        ("a = 1 #", "1", "no path of keys"),
        ("materials.tin.young", "1", "[materials.tin] has no `poisson`"),
        ("contact.0.friction.tresca", "5", "both `coulomb` and `tresca`"),
        ("load.0.traction.2", "1+", "ends where a value should follow"),
        ("solver.tolerance", "nan", "finite"),
    ];
    for (key, value, part) in cases {
        let error = parse(BRICK, "case.toml", &set(&[(key, value)])).err().unwrap();
        assert_eq!(error.place, format!("--set {key}={value}"), "{error}");
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn settings_of_methods_are_held_against_the_method_and_the_friction() {
    let solver = |text: &str| format!("[solver]\n{text}\n");
    let given = |text: &str| BRICK.replace("{ coulomb = 0.35 }", "{ tresca = 1e5 }").replace("[solver]\n", text);
    let coulomb = "alg1\" is for given friction, but the friction of contact \"z-min\" is coulomb";
    fails("[solver]", &solver("method = \"alg1\""), "18:10", &[coulomb, "\"msa1\"", "tresca"]);
    fails("[solver]", &solver("method = \"cfs3\""), "18:10", &["did you mean \"cfs1\"?", "\"newton\""]);
    fails("[solver]", &solver("squares = 4"), "18:11", &["`squares` is not used by the method \"newton\""]);
    fails("[solver]", &solver("method = \"cfs2\"\nsquares = 0"), "19:11", &["whole number from 1"]);
    fails("[solver]", &solver("method = \"cfs2\"\nrho = 0"), "19:7", &["greater than 0"]);
    fails("[solver]", &solver("method = \"cfs2\"\nrho-factor = 1"), "19:1", &["did you mean `rho_factor`?"]);
    fails("[solver]", &solver("method = \"cfs2\"\nvariant = 1"), "19:11", &["`variant` is not used", "rho_factor"]);
    fails("[solver]", &solver("method = \"cfs2\"\ninner_tolerance = -1"), "19:19", &["of at least 1e-14"]);
    fails("[solver]", &solver("method = \"cfs2\"\nrho = 1\nrho_factor = 1"), "20:14", &["twice"]);
    fails("[solver]", &solver("method = \"msa2\"\ninner = \"discs\""), "19:9", &["\"discs\" has none", "msa1"]);
    fails(
        "[solver]",
        &solver("method = \"msa1\"\ninner = \"smalbe\"\nsplitting = \"no\""),
        "20:13",
        &["`splitting` is not used by the method \"msa1\" with \"smalbe\" inside"],
    );
    let read = |text: &str| parse(&given(&solver(text)), "a", &[]).unwrap_or_else(|e| panic!("{e}")).solver;
    let alg1 =
        read("method = \"alg1\"\nsquares = 4\nrho = 1e-9\nvariant = 1\nsplitting = \"partial\"\ncoupling = \"chain\"");
    assert_eq!(alg1.method.method, Method::Given(Given::alg1(Sweeps::UntilConverged, Splitting::Partial)));
    assert_eq!((alg1.method.squares, alg1.method.penalty), (4, Penalty::Absolute(1e-9)));
    assert_eq!((alg1.method.coupling, alg1.max_iterations), (Coupling::Chain, 10_000));
    assert_eq!(read("method = \"discs\"").method.method, Method::Given(Given::Discs));
    assert_eq!(read("method = \"cfs1\"\nmax_iterations = 7").method.max_iterations, 7);
    assert_eq!(read("method = \"msa2\"").method.method, Method::cfs2());
    assert_eq!(read("method = \"msa1\"\ninner = \"discs\"").method.method, Method::FixedPoint(Given::Discs));
    assert_eq!(read("").method, MethodSettings::new(Method::Newton));
}

#[test]
fn mistakes_about_orthotropic_and_thermal_materials_are_shown() {
    let wood = |keys: &str, place: &str, parts: &[&str]| fails("young = 21.19e10\npoisson = 0.277", keys, place, parts);
    wood("young = [3, 2, 1]\npoisson = 0.3", "7:11", &["needs three values of `poisson`", "poisson = [0.4"]);
    wood("young = [3, 2, 1]\npoisson = [0, 0, 0]", "5:1", &["needs three values of `shear`", "shear = ["]);
    let shear = "\nshear = [1, 1, 1]";
    let with = |poisson: &str| format!("young = [4, 1, 1]\npoisson = {poisson}{shear}");
    wood(&with("[2, 0, 0]"), "7:11", &["|nu12| = 2 is not below sqrt(E1/E2) = 2.000000", "nu12/E1 = nu21/E2"]);
    wood(&with("[0, 0, -1.5]"), "7:11", &["|nu23| = 1.5", "sqrt(E2/E3) = 1.000000"]);
    wood(&with("[1.2, 1.2, 0.8]"), "7:11", &["1 - nu12 nu21", "is not above zero"]);
    wood(&format!("{}\nformulation = \"b-bar\"", with("[0, 0, 0]")), "9:15", &["isotropic", "take `formulation` out"]);
    wood(&format!("{}\naxes = [[1, 0, 0], [2, 0, 0]]", with("[0, 0, 0]")), "9:8", &["do not span a plane", "parallel"]);
    wood(&format!("{}\naxes = [[1, 0, 0]]", with("[0, 0, 0]")), "9:8", &["a list of 2 entries"]);
    fails(
        "poisson = 0.277",
        "poisson = 0.277\naxes = [[1, 0, 0], [0, 1, 0]]",
        "8:8",
        &["single numbers", "take `axes` out"],
    );
    fails("poisson = 0.277", "poisson = 0.277\nexpansion = \"a\"", "8:13", &["the text \"a\"", "expansion = 12e-6"]);
}

#[test]
fn mistakes_about_loads_and_supports_are_shown() {
    let load =
        |keys: &str, place: &str, parts: &[&str]| fails("traction = [0, 0, \"-2/3*1e6*(3 - x)\"]", keys, place, parts);
    load("moment = [0, 0, \"x\"]", "12:18", &["only t may"]);
    load("moment = 3", "12:10", &["the number 3", "a list of 3 entries", "moment = [0, 0, 50]"]);
    load("pressure = 3\nmoment = [0, 0, 1]", "13:1", &["both `pressure` and `moment`"]);
    load("pressure = 3\nabout = [0, 0, 1]", "13:9", &["`about` is for a force or a moment"]);
    load("about = [0, 0, 1]", "10:1", &["none of traction, pressure, force, moment"]);
    load("hydrostatic = { weight = 0, level = 1 }", "12:26", &["greater than 0"]);
    load("hydrostatic = { weight = 1 }", "12:15", &["`hydrostatic` has no `level`"]);
    load("hydrostatic = { weight = 1, level = \"z\" }", "12:38", &["only t may"]);
    load("hydrostatic = { weight = 1, level = 1, up = [0, 0, 0] }", "12:45", &["`up` is zero"]);
    load("rotation = { axis = [0, 0, 0], speed = 1 }", "12:21", &["`axis` is zero"]);
    load("rotation = { axis = [0, 0, 1], speed = 1 }", "10:1", &["rotation acts on nothing", "density"]);
    load("temperature = { aray = \"T\" }", "12:17", &["did you mean `array`?"]);
    load("temperature = { array = \"T\", ramp = \"x\" }", "12:38", &["only t may"]);
    fails("[[contact]]", "[[spring]]\non = \"z-min\"\n[[contact]]", "13:1", &["no stiffness", "normal = 5e7"]);
    fails("[[contact]]", "[[spring]]\nnormal = 1\n[[contact]]", "13:1", &["no `on`"]);
    fails("[[contact]]", "[[spring]]\non = \"a\"\nnormal = -1\n[[contact]]", "15:10", &["of at least 0"]);
    let fix = |keys: &str, place: &str, parts: &[&str]| fails("on = \"x-min\"", keys, place, parts);
    fix("on = \"x-min\"\ncondition = \"mirror\"", "10:13", &["symmetry"]);
    fix("on = \"x-min\"\ncondition = \"symmetry\"\nvalue = 1", "11:9", &["beside condition", "take `value` out"]);
    fix("on = { point = [0, 0, 0] }\ncondition = \"symmetry\"", "9:6", &["a point has neither"]);
}

#[test]
fn mistakes_about_bolts_are_shown() {
    let bolt = |keys: &str, place: &str, parts: &[&str]| {
        fails("[[contact]]", &format!("[[bolt]]\non = \"a\"\n{keys}[[contact]]"), place, parts)
    };
    bolt("", "13:1", &["none of force, shortening", "exactly one"]);
    bolt("force = 1\nshortening = 2\n", "16:1", &["both `force` and `shortening`"]);
    bolt("force = \"x\"\n", "15:10", &["only t may"]);
    bolt("axis = [0, 0, 0]\nforce = 1\n", "15:8", &["`axis` is zero"]);
    bolt("force = 1\nlock = \"b\"\n", "16:8", &["no step called \"b\"", "add [[step]]"]);
    bolt("force = 1\n[[bolt]]\non = \"a\"\nforce = 1\n", "16:1", &["two bolts called \"a\"", "`name`"]);
}

#[test]
fn laws_of_friction_that_say_too_much_or_too_little_are_refused() {
    let law = |law: &str, place: &str, parts: &[&str]| fails("coulomb = 0.35", law, place, parts);
    law("coulomb = [0.1, 0.3]", "16:24", &["no direction", "direction = [1, 0, 0]"]);
    law("coulomb = 0.1, direction = [1, 0, 0]", "16:41", &["one is given", "[along, across]"]);
    law("coulomb = [0.1, -0.3], direction = [1, 0, 0]", "16:24", &["is -0.3", "at least zero"]);
    law("coulomb = [0.1, 0.3, 0.4], direction = [1, 0, 0]", "16:24", &["a list of 3 entries", "2 entries"]);
    law("coulomb = [0.1, 0.3], direction = [0, 0, 0]", "16:48", &["has no direction"]);
    law("coulomb = \"0.1 + s\"", "16:31", &["s", "x, y, z, t"]);
    law("coulomb = [\"0.1*t\", 0.3], direction = [1, 0, 0]", "16:24", &["changes with the time t", "one coefficient"]);
    law("coulomb = { aray = \"mu\" }", "16:26", &["`coulomb` has no key", "did you mean `array`?"]);
    law("coulomb = { array = \"\" }", "16:34", &["empty text"]);
    law("coulomb = { array = \"mu\" }, direction = [1, 0, 0]", "16:54", &["one is given"]);
    law("coulomb = [0.1, { array = 3 }], direction = [1, 0, 0]", "16:40", &["the number 3", "array = \"mu\""]);
    law("coulomb = 0.1, limit = 0", "16:37", &["greater than 0", "limit = 5e7"]);
    law("tresca = 0.1, limit = 3", "16:36", &["`limit` is for coulomb"]);
    law("tresca = 0.1, direction = [1, 0, 0]", "16:40", &["`direction` is for coulomb"]);
}

#[test]
fn keys_of_a_surface_belong_to_a_surface() {
    let plane = "plane = { point = [0, 0, 0], normal = [0, 0, 1] }";
    fails(plane, &format!("{plane}, scale = 2"), "15:72", &["`scale` is for an obstacle from a file", "surface ="]);
    fails(plane, &format!("{plane}, surface = \"a.stl\""), "15:64", &["both `plane` and `surface`"]);
    let round = "cylinder = { point = [0, 0, 0], axis = [0, 0, 1], radius = 2 }";
    fails(plane, &format!("{round}, side = \"inside\""), "15:84", &["inside the braces of `cylinder`", "side ="]);
    fails(plane, "surface = \"a.stl\", feature_angle = 200", "15:48", &["at most 180"]);
    fails(plane, "surface = \"a.stl\", side = \"within\"", "15:39", &["inside", "outside"]);
}
