//! Reading a case: what is understood, and that every mistake is shown at its line with a remedy.

mod mistakes;
mod robustness;

use super::*;
use crate::contact::{Across, Coefficient, CoulombLaw, InitialGap, Obstacle, Role, Side, SurfaceFriction};
use crate::fem::{Field, Formulation, Material};
use crate::mesh::{Block, BlockElement, Ring, Turn};

/// The case file of the design, with a title that is easy to move.
const BRICK: &str = r#"title = "Brick on a rigid foundation"
units = "m, N, Pa"
[mesh]
block = { size = [3, 1, 1], cells = [24, 8, 8], element = "tet4" }
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
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = { coulomb = 0.35 }
[solver]
tolerance = 1e-8
"#;

fn read_text(text: &str) -> Case {
    parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// The brick with `from` replaced by `to`.
fn edited(from: &str, to: &str) -> String {
    assert!(BRICK.contains(from), "{from}");
    BRICK.replacen(from, to, 1)
}

fn set(pairs: &[(&str, &str)]) -> Vec<(String, String)> {
    pairs.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect()
}

#[test]
fn steps_and_the_motion_of_an_obstacle_are_read() {
    let with = edited("} }\nfriction", "}, motion = [\"2*t\", 0, -1] }\nfriction");
    let case = read_text(&(with + "[[step]]\nuntil = 0.5\n[[step]]\nname = \"slide\"\nuntil = 2\nincrements = 3\n"));
    let steps: Vec<_> = case.steps.iter().map(|s| (s.name.as_str(), s.until, s.increments)).collect();
    assert_eq!(steps, [("step 1", 0.5, 1), ("slide", 2.0, 3)]);
    let motion = case.contacts[0].motion.as_ref().unwrap();
    assert_eq!([0, 1, 2].map(|c| motion[c].at([f64::NAN; 3], 4.0)), [8.0, 0.0, -1.0]);
    assert!(read_text(BRICK).steps.is_empty() && read_text(BRICK).contacts[0].motion.is_none());
}

#[test]
fn laws_of_friction_and_surfaces_are_read() {
    let friction = |law: &str| read_text(&edited("coulomb = 0.35", law)).contacts[0].friction.clone();
    let constant = |c| Coefficient::Field(Field::Constant(c));
    let law = CoulombLaw { coefficient: constant(0.3), across: None, limit: Some(5e7), cohesion: None };
    assert_eq!(friction("coulomb = 0.3, limit = 5e7"), SurfaceFriction::Law(law));
    let across = Some(Across { coefficient: constant(0.3), direction: [0.6, 0.8, 0.0] });
    let law = CoulombLaw { coefficient: constant(0.1), across, limit: None, cohesion: None };
    assert_eq!(friction("coulomb = [0.1, 0.3], direction = [3, 4, 0]"), SurfaceFriction::Law(law));
    let SurfaceFriction::Law(law) = friction("coulomb = \"0.2 + 0.1*x - y*z\"") else { panic!() };
    let Coefficient::Field(field) = law.coefficient else { panic!() };
    assert!((field.at([1.0, 2.0, 0.05], f64::NAN) - 0.2).abs() < 1e-15);
    let SurfaceFriction::Law(law) = friction("coulomb = [0.1, { array = \"mu\" }], direction = [3, 4, 0]") else {
        panic!()
    };
    let array = Coefficient::Array { name: "mu".into(), values: Vec::new() };
    assert_eq!((law.coefficient, law.across.unwrap().coefficient), (constant(0.1), array));
    assert_eq!(friction("coulomb = \"2*0.1\""), SurfaceFriction::Coulomb(0.2));
    let plane = "plane = { point = [0, 0, 0], normal = [0, 0, 1] }";
    let surface =
        "surface = \"parts/die.stl\", scale = 1e-3, turn = { axis = [0, 0, 2], degrees = 90 }, side = \"inside\"";
    let AgainstSpec::File(file) = read_text(&edited(plane, surface)).contacts[0].against.clone() else { panic!() };
    assert!(file.path.ends_with("parts/die.stl") && file.scale == 1e-3 && file.side == Side::Inside);
    assert_eq!((file.feature_angle, file.placing.by), (30.0, [0.0; 3]));
    assert_eq!(file.placing.turn, Some(Turn { point: [0.0; 3], axis: [0.0, 0.0, 1.0], degrees: 90.0 }));
}

#[test]
fn the_brick_is_read_as_it_is_meant() {
    let case = read_text(BRICK);
    assert_eq!(case.title, "Brick on a rigid foundation");
    assert_eq!(case.units.as_deref(), Some("m, N, Pa"));
    let block = Block {
        size: [3.0, 1.0, 1.0],
        cells: [24, 8, 8],
        origin: [0.0; 3],
        grading: [1.0; 3],
        element: BlockElement::Tet4Five { parity: 0 },
    };
    assert_eq!(case.mesh.source, MeshSource::Block(block));
    assert_eq!(case.mesh.spot.place, "case.toml:3:1");
    let [steel] = case.materials.as_slice() else { panic!() };
    let Material { name, young, poisson, density, .. } = &steel.material;
    assert_eq!((name.as_str(), *young, *poisson, *density), ("steel", 21.19e10, 0.277, 0.0));
    assert_eq!((steel.material.formulation, &steel.on), (Formulation::Auto, &None));
    let [fix] = case.fixes.as_slice() else { panic!() };
    assert!(fix.value.iter().all(|v| matches!(v, Some(Field::Constant(0.0)))));
    let Region::Groups(groups) = &fix.on else { panic!() };
    assert_eq!((groups[0].0.as_str(), groups[0].1.place.as_str()), ("x-min", "case.toml:9:6"));
    let LoadKind::Traction(traction) = &case.loads[0].kind else { panic!() };
    // At x = 0 the load of the paper is two megapascals, and it vanishes at x = 3.
    assert!((traction[2].at([0.0; 3], 0.0) + 2e6).abs() < 1e-9 * 2e6);
    assert_eq!(traction[2].at([3.0, 0.5, 1.0], 0.0), 0.0);
    assert!(matches!(traction[0], Field::Constant(0.0)));
    let [contact] = case.contacts.as_slice() else { panic!() };
    assert_eq!(contact.name, "z-min");
    let plane = Obstacle::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    assert_eq!(contact.against, AgainstSpec::Obstacle(plane));
    assert_eq!(contact.friction, SurfaceFriction::Coulomb(0.35));
    assert_eq!(contact.spot.place, "case.toml:13:1");
    assert_eq!(case.solver, SolverSpec { spot: case.solver.spot.clone(), ..SolverSpec::default() });
}

#[test]
fn a_spot_makes_an_error_that_shows_its_line() {
    let case = read_text(BRICK);
    let Region::Groups(groups) = &case.contacts[0].on else { panic!() };
    let error = groups[0].1.error("there is no group \"z-min\"", "did you mean \"zmin\"?");
    let shown =
        "case.toml:14:6: there is no group \"z-min\"; did you mean \"zmin\"?\n14 | on = \"z-min\"\n   |      ^^^^^^^";
    assert_eq!(error.to_string(), shown);
}

#[test]
fn every_template_is_a_valid_case() {
    for template in templates() {
        let case = parse(template.text, template.name, &[]).unwrap_or_else(|e| panic!("{e}"));
        assert!(!case.contacts.is_empty() && !template.description.is_empty());
    }
}

#[test]
fn a_case_without_any_optional_key_takes_every_default() {
    let text = "[mesh]\nfile = \"parts/a.msh\"\n[materials.m]\nyoung = 1\npoisson = 0\n";
    let case = parse(text, "some/where/beam.toml", &[]).unwrap();
    assert_eq!(case.title, "beam");
    assert_eq!(case.mesh.source, MeshSource::File { path: "parts/a.msh".into(), scale: 1.0, include: Vec::new() });
    assert_eq!(case.solver, SolverSpec::default());
    assert!(case.fixes.is_empty() && case.loads.is_empty() && case.contacts.is_empty());
    let solver = parse(&format!("{text}[solver]\n"), "a", &[]).unwrap().solver;
    assert_eq!(solver, SolverSpec { spot: solver.spot.clone(), ..SolverSpec::default() });
    assert!(solver.spot.place.starts_with("a:") && case.solver.spot.place.is_empty(), "{}", solver.spot.place);
}

#[test]
fn a_byte_order_mark_and_windows_line_ends_change_nothing() {
    let text = format!("\u{feff}{}", BRICK.replace('\n', "\r\n"));
    let case = read_text(&text);
    assert_eq!(case.contacts[0].spot.place, "case.toml:13:1");
}

#[test]
fn blocks_are_cut_as_asked() {
    let element = |keys: &str| {
        let text = edited("element = \"tet4\"", keys);
        match read_text(&text).mesh.source {
            MeshSource::Block(block) => block.element,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(element("element = \"hex8\""), BlockElement::Hex8);
    assert_eq!(element("split = \"six\""), BlockElement::Tet4Six);
    assert_eq!(element("parity = 1"), BlockElement::Tet4Five { parity: 1 });
    assert_eq!(element("element = \"hex20\""), BlockElement::Hex20);
    assert_eq!(element("element = \"tet10\", parity = 1"), BlockElement::Tet10Five { parity: 1 });
    assert_eq!(element("element = \"tet10\", split = \"six\""), BlockElement::Tet10Six);
}

#[test]
fn rings_are_read_with_their_defaults() {
    let text = edited("block = {", "ring = { radii = [2, 4], height = 1, degrees = 90, cells = [2, 9, 1] }\n#");
    let (element, grading) = (BlockElement::Tet4Five { parity: 0 }, [1.0; 3]);
    let ring = Ring { radii: [2.0, 4.0], height: 1.0, degrees: 90.0, cells: [2, 9, 1], grading, element };
    assert_eq!(read_text(&text).mesh.source, MeshSource::Ring(ring));
}

#[test]
fn components_and_values_keep_the_order_of_the_user() {
    let value =
        |lines: &str| read_text(&edited("on = \"x-min\"", &format!("on = \"x-min\"\n{lines}"))).fixes[0].value.clone();
    let [x, y, z] = value("components = \"zx\"\nvalue = [3, \"x + t\"]");
    assert!(matches!((y, z), (None, Some(Field::Constant(3.0)))));
    assert_eq!(x.unwrap().at([5.0, 0.0, 0.0], 2.0), 7.0);
    let [x, y, z] = value("components = \"y\"\nvalue = \"2*y\"");
    assert!(x.is_none() && z.is_none() && y.unwrap().at([0.0, 4.0, 0.0], 0.0) == 8.0);
}

#[test]
fn regions_obstacles_and_laws_of_friction_are_read() {
    let contact = |lines: &str| {
        let head = BRICK.split("[[contact]]").next().unwrap();
        read_text(&format!("{head}[[contact]]\n{lines}")).contacts[0].clone()
    };
    let c =
        contact("on = [\"a\", \"b\"]\nagainst.plane = { point = [0, 0, 1], normal = [0, 3, 4] }\nfriction = \"none\"");
    assert_eq!((c.name.as_str(), &c.friction), ("a+b", &SurfaceFriction::None));
    let obstacle = |c: &ContactSpec| match c.against.clone() {
        AgainstSpec::Obstacle(obstacle) => obstacle,
        _ => panic!(),
    };
    assert_eq!(obstacle(&c), Obstacle::Plane { point: [0.0, 0.0, 1.0], normal: [0.0, 0.6, 0.8] });
    let c = contact(
        "name = \"n\"\non.box = [[0, 0, 0], [1, 2, 0]]\nagainst.sphere = { center = [0, 0, 1], radius = 2, side = \"inside\" }\nfriction = \"bonded\"",
    );
    assert_eq!((c.name.as_str(), &c.friction), ("n", &SurfaceFriction::Bonded));
    assert_eq!(c.on, Region::Box { min: [0.0; 3], max: [1.0, 2.0, 0.0] });
    assert_eq!(obstacle(&c), Obstacle::Sphere { center: [0.0, 0.0, 1.0], radius: 2.0, side: Side::Inside });
    let c = contact(
        "on = \"a\"\nagainst.cylinder = { point = [0, 0, 1], axis = [0, -1e300, 0], radius = 2 }\nfriction = { tresca = 5 }",
    );
    let (point, axis) = ([0.0, 0.0, 1.0], [0.0, -1.0, 0.0]);
    assert_eq!(obstacle(&c), Obstacle::Cylinder { point, axis, radius: 2.0, side: Side::Outside });
    assert_eq!(c.friction, SurfaceFriction::GivenStress(5.0));
    let c = contact(
        "on.box = [[0, 0, 0], [1, 1, 1]]\nagainst.plane = { point = [0, 0, 0], normal = [1, 0, 0] }\nfriction = { tresca = 5, nodal = true }",
    );
    assert_eq!((c.name.as_str(), &c.friction), ("contact 1", &SurfaceFriction::GivenForce(5.0)));
}

#[test]
fn pairs_of_surfaces_are_read() {
    let pair = |lines: &str| {
        let text = edited("against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }", lines);
        match read_text(&text).contacts[0].against.clone() {
            AgainstSpec::Surface { region: Region::Groups(groups), gap, slave, search, .. } => {
                (groups.iter().map(|g| g.0.clone()).collect::<Vec<_>>().join(" "), gap, slave, search)
            }
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(pair("against = \"a\""), ("a".into(), InitialGap::AsMeshed, None, None));
    let all = pair("against = [\"a\", \"b\"]\ngap = -2e-3\nslave = \"against\"\nsearch = 4");
    assert_eq!(all, ("a b".into(), InitialGap::Uniform(-2e-3), Some(Role::Against), Some(4.0)));
    assert_eq!(pair("against = \"a\"\ngap = \"closed\"\nslave = \"on\"").1, InitialGap::Closed);
}

#[test]
fn parts_of_a_mesh_are_read_with_their_places() {
    let text = edited(
        "block = {",
        "move = [1, 2, 3]\nparts.low.file = \"low.msh\"\nparts.low.scale = 1e-3\nparts.top.turn = { axis = [0, 0, 2], degrees = 30 }\nparts.top.block = {",
    );
    let mesh = read_text(&text).mesh;
    let MeshSource::Parts(parts) = &mesh.source else { panic!() };
    assert_eq!((mesh.placing, parts[0].0.as_str()), (Placing { turn: None, by: [1.0, 2.0, 3.0] }, "low"));
    assert_eq!(parts[0].1.source, MeshSource::File { path: "low.msh".into(), scale: 1e-3, include: Vec::new() });
    let turn = Turn { point: [0.0; 3], axis: [0.0, 0.0, 1.0], degrees: 30.0 };
    assert_eq!((parts[1].0.as_str(), parts[1].1.placing), ("top", Placing { turn: Some(turn), by: [0.0; 3] }));
    assert!(matches!(parts[1].1.source, MeshSource::Block(_)));
}

#[test]
fn overrides_replace_add_and_quote_as_needed() {
    let pairs = set(&[
        ("mesh.block.cells", "[12, 4, 4]"),
        ("contact.0.friction.coulomb", "0.2"),
        ("solver.max_iterations", " 7 "),
        ("fix.0.on", "y-min"),
        ("mesh.block.size.0", "5"),
        ("materials.\"steel\".density", "1"),
        ("solver.tolerance", "1e-6"),
        ("solver.tolerance", "1e-5"),
    ]);
    let case = parse(BRICK, "case.toml", &pairs).unwrap_or_else(|e| panic!("{e}"));
    let MeshSource::Block(block) = &case.mesh.source else { panic!() };
    assert_eq!((block.cells, block.size), ([12, 4, 4], [5.0, 1.0, 1.0]));
    assert_eq!(case.contacts[0].friction, SurfaceFriction::Coulomb(0.2));
    assert_eq!((case.solver.max_iterations, case.solver.tolerance), (7, 1e-5));
    assert_eq!(case.materials[0].material.density, 1.0);
    let Region::Groups(groups) = &case.fixes[0].on else { panic!() };
    assert_eq!((groups[0].0.as_str(), groups[0].1.place.as_str()), ("y-min", "--set fix.0.on=y-min"));
}

#[test]
fn a_mesh_file_is_looked_for_beside_the_case_file() {
    let folder = std::env::temp_dir().join(format!("stiction-case-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("case.toml");
    std::fs::write(
        &path,
        edited("block = { size = [3, 1, 1], cells = [24, 8, 8], element = \"tet4\" }", "file = \"a.msh\""),
    )
    .unwrap();
    let case = read(&path, &[]).unwrap();
    assert_eq!(case.mesh.source, MeshSource::File { path: folder.join("a.msh"), scale: 1.0, include: Vec::new() });
    std::fs::write(&path, b"title = \"a\"\nunits = \"\xff\"\n").unwrap();
    let error = read(&path, &[]).unwrap_err();
    assert!(error.place.ends_with("case.toml:2:10") && error.what.contains("UTF-8"), "{error}");
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(read(&path, &[]).unwrap_err().what.contains("cannot be read"));
}

#[test]
fn the_schema_knows_every_key_of_the_templates() {
    fn walk(value: &toml::Value, schema: &serde_json::Value, path: &str) {
        // Alternatives: any one of them may know the key.
        let options: Vec<_> = match schema["anyOf"].as_array() {
            Some(options) => options.iter().collect(),
            None => vec![schema],
        };
        match value {
            toml::Value::Table(table) => {
                for (key, value) in table {
                    let path = format!("{path}.{key}");
                    let known = options.iter().find_map(|s| {
                        s["properties"]
                            .get(key)
                            .or(s["additionalProperties"].as_object().map(|_| &s["additionalProperties"]))
                    });
                    walk(value, known.unwrap_or_else(|| panic!("{path} is not in the schema")), &path);
                }
            }
            toml::Value::Array(items) => {
                let schema = options.iter().find(|s| s["type"] == "array").unwrap_or_else(|| panic!("{path}"));
                items.iter().for_each(|item| walk(item, &schema["items"], path));
            }
            _ => assert!(options.iter().any(|s| !s["type"].is_null()), "{path}"),
        }
    }
    let schema = schema();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(schema["required"], serde_json::json!(["mesh", "materials"]));
    assert_eq!(schema["properties"]["solver"]["properties"]["tolerance"]["default"], 1e-8);
    assert_eq!(schema["properties"]["step"]["items"]["required"], serde_json::json!(["until"]));
    for template in templates() {
        let value: toml::Table = template.text.parse().unwrap();
        walk(&toml::Value::Table(value), &schema, template.name);
    }
}
