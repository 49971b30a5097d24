//! What the files tell of the second surface of a pair.

use std::path::Path;

use crate::folder::Folder;
use stiction::io::problem::read_problem;
use stiction::io::vtu_read::{Over, Polygons, read_polygons};

/// `contact.vtu` of one pair, one side: places, force, pressure and shear of its points.
struct Side {
    points: Vec<[f64; 3]>,
    lambda: Vec<[f64; 3]>,
    pressure: Vec<f64>,
    shear: Vec<[f64; 3]>,
    status: Vec<f64>,
}

fn side(file: &Path, pair: usize, side: usize) -> Side {
    let names = ["pair", "side", "lambda", "pressure", "shear_traction", "status"].map(|name| (Over::Points, name));
    let (Polygons { points, faces }, fields) = read_polygons(file, &names).unwrap();
    let [pairs, sides, lambda, pressure, shear, status] = [0, 1, 2, 3, 4, 5].map(|i| fields.arrays[i].clone().unwrap());
    let own = |&i: &usize| pairs[i] == pair as f64 && sides[i] == side as f64;
    let of = |i: usize| own(&i);
    assert!(
        faces.iter().all(|face| face.iter().all(|&v| of(v as usize) == of(face[0] as usize))),
        "a face of one side"
    );
    let chosen: Vec<usize> = (0..points.len()).filter(own).collect();
    let vectors = |v: &[f64]| chosen.iter().map(|&i| [v[3 * i], v[3 * i + 1], v[3 * i + 2]]).collect::<Vec<_>>();
    let scalars = |v: &[f64]| chosen.iter().map(|&i| v[i]).collect::<Vec<_>>();
    Side {
        points: chosen.iter().map(|&i| points[i]).collect(),
        lambda: vectors(&lambda),
        pressure: scalars(&pressure),
        shear: vectors(&shear),
        status: scalars(&status),
    }
}

/// Resultant and moment about the origin.
fn resultant(s: &Side) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for (x, f) in s.points.iter().zip(&s.lambda) {
        for c in 0..3 {
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            sum[c] += f[c];
            sum[3 + c] += x[a] * f[b] - x[b] * f[a];
        }
    }
    sum
}

/// Of each contact point of a pair the area that counts in sums, and what it carries of the force.
fn areas(folder: &Path, pair: usize) -> Vec<(f64, f64)> {
    let labels = read_problem(&folder.join("problem.npz")).unwrap().0.labels;
    let of = |j: usize| (labels.unity_sum[j] * labels.area[j], labels.unity_sum[j]);
    labels.pairs[pair].points.clone().map(of).collect()
}

/// The pressures at the contact points, and their forces over their areas, both in the order of the points.
fn at_points(slave: &Side, areas: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
    let points = (0..slave.points.len()).filter(|&i| slave.status[i] >= 0.0);
    let pressure: Vec<f64> = points.clone().map(|i| slave.pressure[i]).collect();
    let quotient: Vec<f64> = points.zip(areas).map(|(i, area)| slave.lambda[i][2].abs() / area.0).collect();
    assert_eq!((pressure.len(), quotient.len()), (areas.len(), areas.len()));
    (pressure, quotient)
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, v| a.max(v.abs()))
}

/// The column of the patch test: on the slope of tanθ = 0.3 the pressure is cos²θ and the shear sinθ cosθ, on either
/// side and at every node, whichever surface has the contact points; the upper part pushes the lower one down.
#[test]
fn a_constant_pressure_is_constant_on_the_master() {
    let folder = Folder::new("both-sides", "");
    let case = concat!(env!("CARGO_MANIFEST_DIR"), "/../../cases/patch/patch.toml");
    let cos2: f64 = 1.0 / 1.09;
    for slave in ["on", "against"] {
        let role = format!("contact.0.slave={slave}");
        folder.run(&["solve", case, "-o", "out", "--set", &role]).ends(0, &[]);
        let [low, high] = [0, 1].map(|number| side(&folder.path.join("out/contact.vtu"), 0, number));
        assert!(low.points.len() > 4 && high.points.len() > 4 && low.points.len() != high.points.len());
        let extent = |c: usize| high.points.iter().fold(0.0, |a: f64, x| a.max(x[c]));
        for s in [&low, &high] {
            let push = resultant(s);
            let expected = [0.0, 0.0, -extent(0) * extent(1)];
            assert!((0..3).all(|c| (push[c] - expected[c]).abs() < 1e-9), "{slave} {push:?} {expected:?}");
        }
        let down = [-cos2.sqrt(), 0.0, -0.3 * cos2.sqrt()];
        let expected = down.map(|d| 0.3 * cos2 * d);
        for (pressure, shear) in high.pressure.iter().zip(&high.shear) {
            assert!((pressure - cos2).abs() < 1e-8, "{slave} {pressure}");
            assert!((0..3).all(|c| (shear[c] - expected[c]).abs() < 1e-8), "{slave} {shear:?} {expected:?}");
        }
        assert!(high.status.iter().all(|&status| status == -1.0));
        assert!(folder.exists("out/master-pressure.png") && folder.exists("out/master-shear.png"));
    }
}

/// The gasket covers a part of the vessel and of the lid only, with other meshes.
#[test]
fn both_sides_of_a_pair_have_one_resultant_and_what_nothing_reaches_has_no_pressure() {
    let folder = Folder::new("both-sides-gasket", "");
    folder.run(&["new", "g", "--from", "gasket"]).ends(0, &[]);
    folder.run(&["solve", "g/case.toml", "-o", "out"]).ends(0, &[]);
    let normal = folder.summary("out")["pairs"][0]["normal_force"].as_f64().unwrap();
    for (pair, name) in ["lower_face", "upper_face"].into_iter().enumerate() {
        let [slave, master] = [0, 1].map(|number| side(&folder.path.join("out/contact-0003.vtu"), pair, number));
        let (a, b) = (resultant(&slave), resultant(&master));
        assert!((a[2].abs() - normal).abs() < 1e-6 * normal, "{a:?}");
        // Moments over the outer radius of the gasket, 65.
        let apart: Vec<f64> = (0..6).map(|c| (a[c] - b[c]) / if c < 3 { 1.0 } else { 65.0 }).collect();
        assert!(largest(&apart) < 1e-10 * normal, "{name}: {a:?} {b:?}");
        let areas = areas(&folder.path.join("out"), pair);
        let (pressure, quotient) = at_points(&slave, &areas);
        let sum: f64 = pressure.iter().zip(&areas).map(|(p, area)| p * area.0).sum();
        assert!((sum / normal - 1.0).abs() < 1e-3, "{name}: the pressures amount to {sum}, the force is {normal}");
        let within = quotient.iter().fold((0.0, 0.0), |(a, b), p| (f64::min(a, *p), f64::max(b, *p)));
        assert!(pressure.iter().all(|p| (within.0..=within.1).contains(p)), "{name} {within:?}");
        let told = master.pressure.iter().filter(|p| !p.is_nan());
        assert!(told.clone().count() > 20 && told.clone().all(|p| (within.0..=within.1).contains(p)), "{within:?}");
        for ((x, pressure), lambda) in master.points.iter().zip(&master.pressure).zip(&master.lambda) {
            // Faces of vessel and lid are at most 7 wide along the radius.
            let radius = x[0].hypot(x[1]);
            if !(48.0..=72.0).contains(&radius) {
                assert!(pressure.is_nan() && *lambda == [0.0; 3], "{radius} {pressure}");
            } else if radius > 56.0 && radius < 64.0 {
                assert!(*pressure > 0.0, "{radius} {pressure}");
            }
        }
        assert!(folder.exists(&format!("out/master-pressure-{name}.png")));
    }
}

/// A block of 1 x 1 under uniform pressure on a wider plate that is held everywhere: the plate's nodes see that pressure,
/// those of quadratic faces and those whose faces the block covers in part as well.
#[test]
fn a_constant_pressure_on_a_part_of_a_master_is_constant_at_all_nodes_it_reaches() {
    for (plate, cells) in [("hex20", 3), ("tet10", 3), ("hex8", 5), ("tet4", 4)] {
        let text = format!(
            r#"
[mesh.parts.plate]
block = {{ size = [1.7, 1.6, 0.3], cells = [{cells}, {cells}, 1], element = "{plate}" }}
move = [-0.4, -0.3, -0.3]
[mesh.parts.block]
block = {{ size = [1, 1, 0.5], cells = [4, 3, 2], element = "hex8" }}
[materials.steel]
young = 2e11
poisson = 0
[[fix]]
on = "plate.z-min"
[[fix]]
on = "plate.z-max"
[[fix]]
on = "block.x-min"
components = "x"
[[fix]]
on = "block.y-min"
components = "y"
[[load]]
on = "block.z-max"
pressure = 3e6
[[contact]]
on = "block.z-min"
against = "plate.z-max"
friction = "none"
slave = "on"
"#
        );
        let folder = Folder::new(&format!("both-sides-{plate}"), &text);
        folder.run(&["solve", "case.toml", "-o", "out"]).ends(0, &[]);
        let master = side(&folder.path.join("out/contact.vtu"), 0, 1);
        let reached = |x: &[f64; 3]| (0..2).all(|c| x[c] > -1e-9 && x[c] < 1.0 + 1e-9);
        let mut seen = 0;
        for (x, pressure) in master.points.iter().zip(&master.pressure) {
            assert!(pressure.is_nan() || (pressure / 3e6 - 1.0).abs() < 1e-9, "{plate} {x:?} {pressure}");
            assert!(!(reached(x) && pressure.is_nan()), "{plate} {x:?}");
            seen += usize::from(!pressure.is_nan() && !reached(x));
        }
        assert!(seen > 3, "{plate}: {seen} nodes beside the block");
    }
}

/// A stiff plate presses an elastic bed that behaves like columns, nearly: the pressure is `E d / h`. The faces of
/// the plate hang over the edges of the bed by all but a sliver, and its nodes are more than the bed can tell apart. Force
/// over area of a point then says anything; pressures are uniform.
#[test]
fn pressures_beside_an_edge_that_the_slave_hangs_over_are_uniform() {
    for (plate, bed, cells) in [("tet4", "hex8", 3), ("hex8", "tet4", 3), ("tet10", "hex20", 4), ("hex20", "tet10", 3)]
    {
        let mut worst: f64 = 0.0;
        for covered in [0.5, 0.1, 0.01, 0.001] {
            let (size, start) = (6.0 / (4.0 + 2.0 * covered), (covered - 1.0) / (4.0 + 2.0 * covered));
            let text = format!(
                r#"
[mesh.parts.bed]
block = {{ size = [1, 1, 0.25], cells = [{cells}, {cells}, 2], element = "{bed}" }}
[mesh.parts.plate]
block = {{ size = [{size}, {size}, 0.4], cells = [6, 6, 2], element = "{plate}" }}
move = [{start}, {start}, 0.25]
[materials.soft]
on = "bed"
young = 200
poisson = 0
[materials.stiff]
on = "plate"
young = 2e5
poisson = 0.3
[[fix]]
on = "bed.z-min"
[[fix]]
on = "plate.z-max"
value = [0, 0, -1e-3]
[[contact]]
on = "plate.z-min"
against = "bed.z-max"
friction = "none"
slave = "on"
"#
            );
            let folder = Folder::new(&format!("sliver-{plate}-{covered}"), &text);
            folder.run(&["solve", "case.toml", "-o", "out"]).ends(0, &[]);
            let out = folder.path.join("out");
            let [slave, master] = [0, 1].map(|number| side(&out.join("contact.vtu"), 0, number));
            let (pressure, quotient) = at_points(&slave, &areas(&out, 0));
            let exact = 200.0 * 1e-3 / 0.25;
            for told in pressure.iter().chain(&master.pressure) {
                // The plate gives way by a part in a thousand.
                assert!((told / exact - 1.0).abs() < 0.01, "{plate} {bed} {covered}: {told} for {exact}");
            }
            assert_eq!(
                folder.summary("out")["contact"]["max_pressure"],
                *pressure.iter().max_by(|a, b| a.total_cmp(b)).unwrap()
            );
            // What the file shows of the other surface is told as well: the points have means of it.
            let most = master.pressure.iter().fold(0.0, |most: f64, p| most.max(*p));
            assert_eq!(folder.summary("out")["contact"]["max_other_pressure"], most);
            worst = quotient.iter().fold(worst, |worst, q| worst.max((q / exact - 1.0).abs()));
        }
        // Ten times what pressures may differ by.
        assert!(worst > 0.1, "{plate}: forces over areas are nearly uniform as well, {worst}: nothing is tested");
    }
}

/// Of two quarters of rings, 2 quadratic faces each, a circle is integrated over 8 chords, which are `8 sin(pi/8) / pi` of it.
#[test]
fn areas_of_curved_pairs_say_what_they_leave_out() {
    let text = r#"
[mesh.parts.hub]
ring = { radii = [2, 3], height = 1, degrees = 90, cells = [1, 2, 1], element = "hex20" }
[mesh.parts.shaft]
ring = { radii = [1, 2], height = 1, degrees = 90, cells = [1, 2, 1], element = "hex20" }
[materials.m]
young = 1
poisson = 0.3
[[fix]]
on = "hub.outer"
[[fix]]
on = "shaft.inner"
[[contact]]
on = "hub.inner"
against = "shaft.outer"
friction = "none"
gap = -1e-3
"#;
    let folder = Folder::new("curved-pair", text);
    let run = folder.run(&["solve", "case.toml"]);
    run.ends(0, &[]);
    let told = run.out.lines().find(|line| line.contains("within reach")).unwrap();
    let area: f64 = told.split_whitespace().nth(1).unwrap().parse().unwrap();
    let chords = 8.0 * (std::f64::consts::PI / 8.0).sin() / std::f64::consts::PI;
    assert!((area / (chords * std::f64::consts::PI) - 1.0).abs() < 1e-4, "{told}");
    assert!(told.contains("(of flat pieces, 2.5 % less than the curved faces)"), "{told}");
    let flat = folder.run(&[
        "solve",
        "case.toml",
        "--set",
        "mesh.parts.hub.ring.element=hex8",
        "--set",
        "mesh.parts.shaft.ring.element=hex8",
    ]);
    assert!(!flat.out.contains("flat pieces") && flat.out.contains("within reach"), "{flat:#?}");
}
