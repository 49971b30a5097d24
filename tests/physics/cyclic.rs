//! Cyclic symmetry: one sector against the whole it stands for.

use stiction::run::{Outcome, Prepared, coupling_states, surface_fields, totals};
use stiction_fixtures::case_run::{at, is, refused, solved};

/// A square plate on a floor, pressed and twisted at its rim, held at the middle of its top: nothing in it is symmetric about
/// a plane. The whole, or the quarter between the planes x = 0 and y = 0.
fn plate(whole: bool, element: &str, path: &str) -> String {
    let (size, cells, origin) = if whole { ("[2, 2, 0.5]", "[8, 8, 2]", -1) } else { ("[1, 1, 0.5]", "[4, 4, 2]", 0) };
    let rim = if whole { "[\"x-min\", \"x-max\", \"y-min\", \"y-max\"]" } else { "[\"x-max\", \"y-max\"]" };
    format!(
        "[mesh]\nblock = {{ size = {size}, cells = {cells}, origin = [{origin}, {origin}, 0], element = \"{element}\" }}\n\
         [materials.steel]\nyoung = 1000\npoisson = 0.3\n\
         [[fix]]\non = {{ box = [[-0.25, -0.25, 0.5], [0.25, 0.25, 0.5]] }}\n\
         [[load]]\non = \"z-max\"\npressure = \"10*(x^2 + y^2)\"\n\
         [[load]]\non = {rim}\ntraction = [\"-y\", \"x\", 0]\n\
         [[contact]]\non = \"z-min\"\nfriction = {{ coulomb = 0.3 }}\n\
         against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         [solver]\ntolerance = 1e-11\npath = \"{path}\"\n"
    )
}

const CUTS: &str = "[[cyclic]]\non = \"x-min\"\nagainst = \"y-min\"\nsectors = 4\naxis = [0, 0, 3]\n";

fn turned([x, y, z]: [f64; 3], quarters: usize) -> [f64; 3] {
    (0..quarters).fold([x, y, z], |[x, y, z], _| [-y, x, z])
}

/// The answer of each place of the whole is that of the sector, turned.
fn same(whole: &(Outcome, Prepared), sector: &(Outcome, Prepared), tolerance: f64) {
    let largest = sector.0.solution.u.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    for &x in &sector.1.mesh.nodes {
        let u = at(sector, x);
        for quarters in 0..4 {
            let (wanted, found) = (turned(u, quarters), at(whole, turned(x, quarters)));
            for c in 0..3 {
                assert!((wanted[c] - found[c]).abs() <= tolerance * largest, "{x:?}: {found:?} for {wanted:?}");
            }
        }
    }
    let [whole, sector] = [whole, sector].map(|run| totals(&run.1, &run.0));
    is(4.0 * sector.normal_force, whole.normal_force, 1e9 * tolerance * whole.normal_force);
    assert!(sector.slip > 0 && sector.stick > 0, "{sector:?}");
}

#[test]
fn a_sector_moves_as_its_part_of_the_whole() {
    for element in ["hex8", "hex20"] {
        let whole = solved(&plate(true, element, "auto"));
        for path in ["dense", "solves", "auto"] {
            same(&whole, &solved(&(plate(false, element, path) + CUTS)), 1e-8);
        }
    }
}

/// The other way round the cut that follows is behind the one it follows.
#[test]
fn either_cut_may_follow_the_other() {
    let whole = solved(&plate(true, "hex8", "auto"));
    let other = CUTS.replace("x-min", "middle").replace("y-min", "x-min").replace("middle", "y-min");
    same(&whole, &solved(&(plate(false, "hex8", "auto") + &other)), 1e-8);
}

/// A plate on a plate, pressed and twisted: contact points and what they touch lie on the cuts, and each body has nodes in the
/// same places there. The other plate may have other cells: points at both cuts, measured from other nodes on both sides, are one.
#[test]
fn contact_between_bodies_may_meet_the_cuts() {
    let two = |whole: bool, [low, high]: [usize; 2], element: &str| {
        let part = |name: &str, cells: usize, z: f64| {
            let (size, cells, low) = if whole { (2, 2 * cells, -1) } else { (1, cells, 0) };
            format!(
                "[mesh.parts.{name}]\nblock = {{ size = [{size}, {size}, 0.5], cells = [{cells}, {cells}, 1], \
                 origin = [{low}, {low}, {z}], element = \"{element}\" }}\n"
            )
        };
        part("low", low, 0.0)
            + &part("high", high, 0.5)
            + "[materials.steel]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"low.z-min\"\n\
               [[load]]\non = \"high.z-max\"\ntraction = [\"-2.7*y\", \"2.7*x\", \"-10*(x^2 + y^2)\"]\n\
               [[contact]]\nname = \"seat\"\non = \"high.z-min\"\nagainst = \"low.z-max\"\nfriction = { coulomb = 0.4 }\n\
               [solver]\ntolerance = 1e-11\n"
    };
    let cuts = CUTS.replace("\"x-min\"", "[\"low.x-min\", \"high.x-min\"]");
    let cuts = cuts.replace("\"y-min\"", "[\"low.y-min\", \"high.y-min\"]");
    // Quadratic faces that do not match are projected on one another to some 1e-7: the whole turned by a quarter is itself to 2e-7.
    for (cells, element, tolerance) in [([4, 4], "hex8", 1e-8), ([4, 3], "hex8", 1e-8), ([3, 2], "hex20", 1e-6)] {
        let (whole, sector) = (solved(&two(true, cells, element)), solved(&(two(false, cells, element) + &cuts)));
        same(&whole, &sector, tolerance);
        // Near the axis a point may reach one node on both sides of a cut: parts whose signs differ are one there, and two in the whole.
        pressures_are_the_same(&whole, &sector, if cells == [4, 4] { 1e-6 } else { 2e-2 });
    }
}

/// On both surfaces of each pair, at the cuts as between them.
fn pressures_are_the_same(whole: &(Outcome, Prepared), sector: &(Outcome, Prepared), tolerance: f64) {
    let fields = |run: &(Outcome, Prepared)| surface_fields(&run.1, &run.0);
    for (all, part) in fields(whole).iter().zip(fields(sector)) {
        let largest = all.pressure.iter().filter(|p| !p.is_nan()).fold(0.0, |a: f64, p| a.max(*p));
        let mut compared = 0;
        for (x, pressure) in part.points.iter().zip(&part.pressure).filter(|(_, pressure)| !pressure.is_nan()) {
            let near = |y: &[f64; 3]| (0..3).all(|c| (x[c] - y[c]).abs() < 1e-9);
            let other = all.pressure[all.points.iter().position(near).unwrap()];
            assert!((pressure - other).abs() <= tolerance * largest, "{x:?}: {pressure} for {other}");
            compared += 1;
        }
        assert!(compared > 8 && largest > 0.0, "{compared} {largest}");
    }
}

/// A quarter of a ring pressed into another by `gap`, the outer one turned by so many degrees.
fn rings(degrees: f64, friction: &str) -> String {
    let ring = |name: &str, radii: &str, more: &str| {
        format!(
            "[mesh.parts.{name}]\nring = {{ radii = {radii}, height = 8, degrees = 90, cells = [3, 6, 2], element = \"hex8\" }}\n{more}"
        )
    };
    let held = |on: &str| {
        format!("[[fix]]\non = \"{on}\"\naxes = {{ point = [0, 0, 0], axis = [0, 0, 1] }}\ncomponents = \"tz\"\n")
    };
    let cut = |name: &str| {
        format!("[[cyclic]]\non = \"{name}.end\"\nagainst = \"{name}.start\"\nsectors = 4\naxis = [0, 0, 1]\n")
    };
    ring("shaft", "[5, 10]", "")
        + &ring("hub", "[10, 20]", &format!("turn = {{ axis = [0, 0, 1], degrees = {degrees} }}\n"))
        + "[materials.s]\nyoung = 2e5\npoisson = 0.3\n"
        + &held("shaft.inner")
        + &held("hub.outer")
        + &format!(
            "[[contact]]\nname = \"fit\"\non = \"shaft.outer\"\nagainst = \"hub.inner\"\nfriction = {friction}\ngap = -0.01\n"
        )
        + &cut("shaft")
        + &cut("hub")
        + "[solver]\ntolerance = 1e-11\n"
}

/// Every station of two coaxial rings is like the others, those at the cuts too: normals there are those of the faces on both sides.
#[test]
fn smooth_rings_in_each_other_have_no_torque_and_the_same_force_at_every_station() {
    let run = solved(&rings(0.0, "\"none\""));
    let lambda = &run.0.solution.lambda;
    let m = run.1.problem.points();
    let nodes = &run.1.facts.contacts[0].surface.nodes;
    let middle: Vec<f64> = (0..nodes.len())
        .filter(|&j| (run.1.mesh.nodes[nodes[j] as usize][2] - 4.0).abs() < 1e-9)
        .map(|j| lambda[j])
        .collect();
    assert!(middle.len() == 6 && lambda[m..2 * m].len() == m);
    middle.iter().for_each(|&force| is(force, middle[0], middle[0]));
    let axis = |j: usize| {
        let (columns, values) = run.1.problem.contact.B.row(j);
        let own = columns.iter().zip(values).map(|(&k, &v)| (run.1.model.dofs.free[k as usize], v));
        own.filter(|(dof, _)| dof / 3 == nodes[j]).fold([0.0; 3], |mut sum, (dof, v)| {
            let d = run.1.model.dofs.direction(dof);
            (0..3).for_each(|c| sum[c] += v * d[c]);
            sum
        })
    };
    for (j, &node) in nodes.iter().enumerate() {
        let ([x, y, _], [nx, ny, _]) = (run.1.mesh.nodes[node as usize], axis(j));
        is(x * ny - y * nx, 0.0, 10.0);
    }
}

/// A ring shrunk on a shaft, which turns until it lifts off: from there nothing holds it along and about the axis, and it stays where it
/// was. It grows as the ring alone does, which is held there.
#[test]
fn a_ring_that_lifts_off_its_shaft_does_not_turn() {
    let ring = |element: &str| {
        format!(
            "[mesh.parts.ring]\nring = {{ radii = [20, 28], height = 10, degrees = 60, cells = [1, 2, 1], element = \"{element}\" }}\n\
             [materials.steel]\nyoung = 210e3\npoisson = 0.3\ndensity = 7.8e-9\n\
             [[load]]\non = \"ring\"\nrotation = {{ axis = [0, 0, 1], point = [0, 0, 0], speed = \"6000*max(0, t - 1)\" }}\n\
             [[step]]\nuntil = 1\n[[step]]\nuntil = 2\nincrements = 2\n[[step]]\nuntil = 3\n"
        )
    };
    let cut = |parts: [&str; 1]| {
        parts.map(|part| {
            format!("[[cyclic]]\non = \"{part}.end\"\nagainst = \"{part}.start\"\nsectors = 6\naxis = [0, 0, 1]\n")
        })
    };
    for element in ["hex8", "hex20"] {
        let shaft = format!(
            "[mesh.parts.shaft]\nring = {{ radii = [10, 20], height = 10, degrees = 60, cells = [2, 2, 1], element = \"{element}\" }}\n\
             [[fix]]\non = \"shaft.inner\"\n\
             [[contact]]\non = \"ring.inner\"\nagainst = \"shaft.outer\"\ngap = -0.01\nfriction = {{ coulomb = 0.2 }}\n"
        );
        let run = solved(&(ring(element) + &shaft + &cut(["ring"]).concat() + &cut(["shaft"]).concat()));
        let axes = "axes = { point = [0, 0, 0], axis = [0, 0, 1] }";
        let held = format!(
            "[[fix]]\non = \"ring.outer\"\n{axes}\ncomponents = \"t\"\n\
             [[fix]]\non = {{ box = [[24.2, 13.9, -0.1], [24.3, 14.1, 0.1]] }}\ncomponents = \"z\"\n"
        );
        let alone = solved(&(ring(element) + &held + &cut(["ring"]).concat()));
        let totals = totals(&run.1, &run.0);
        assert!(totals.normal_force == 0.0, "{totals:?}");
        let radial = |run: &(Outcome, Prepared), [x, y, z]: [f64; 3]| {
            let u = at(run, [x, y, z]);
            let r = x.hypot(y);
            [(u[0] * x + u[1] * y) / r, (u[1] * x - u[0] * y) / r]
        };
        // The nodes on the bore lie where those of the shaft do.
        for &x in alone.1.mesh.nodes.iter().filter(|x| x[0].hypot(x[1]) > 21.0) {
            let ([growth, _], [found, turned]) = (radial(&alone, x), radial(&run, x));
            assert!(
                (found - growth).abs() <= 1e-6 * growth && turned.abs() <= 1e-6 * growth,
                "{x:?}: {found} {turned} for {growth}"
            );
        }
    }
}

/// Points would look in vain for what is in the next sector.
#[test]
fn contact_that_goes_on_in_the_next_sector_is_refused() {
    let error = refused(&rings(15.0, "\"none\""));
    assert!(error.contains("in the next sector") && error.contains("cut both bodies by the same planes"), "{error}");
}

#[test]
fn cuts_that_do_not_match_are_refused() {
    let with = |old: &str, new: &str| refused(&(plate(false, "hex8", "auto") + &CUTS.replace(old, new)));
    assert!(with("sectors = 4", "sectors = 5").contains("away from the nearest node of y-min turned by 360/5 degrees"));
    assert!(with("axis = [0, 0, 3]", "axis = [0, 1, 3]").contains("away from the nearest node"));
    assert!(with("against = \"y-min\"", "against = \"z-max\"").contains("the cuts do not match: x-min has"));
    assert!(with("against = \"y-min\"", "against = \"x-min\"").contains("away from the nearest node"));
}

/// A sector of 60 degrees of a ring without lateral contraction on a floor, whose face moves with a point on the axis.
fn pressed(coupling: &str) -> String {
    format!(
        "[mesh]\nring = {{ radii = [20, 40], height = 10, degrees = 60, cells = [3, 8, 2], element = \"hex8\" }}\n\
         [materials.m]\nyoung = 1e5\npoisson = 0\n\
         [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ coulomb = 0.3 }}\n[[coupling]]\non = \"z-max\"\npoint = [0, 0, 10]\n{coupling}\
         [[cyclic]]\non = \"end\"\nagainst = \"start\"\nsectors = 6\naxis = [0, 0, 1]\n[solver]\ntolerance = 1e-11\n"
    )
}

/// A point on the axis is in all sectors and moves with none of them in a way of its own: a sector that could tip would press with a few of
/// its points, not with the stress `E u / h` everywhere.
#[test]
fn a_reference_point_on_the_axis_moves_along_and_about_it_alone() {
    let run = solved(&pressed("motion = { x = 0, y = 0, z = -1e-2 }\nrotation = { x = 0, y = 0, z = 0 }\n"));
    // Eight segments of 7.5 degrees.
    let area = 8.0 * 0.5 * (40.0_f64.powi(2) - 20.0_f64.powi(2)) * 7.5_f64.to_radians().sin();
    let force = 1e5 * 1e-2 / 10.0 * area;
    is(totals(&run.1, &run.0).normal_force, force, force);
    is(coupling_states(&run.1, &run.0)[0].force[2], -force, force);
    let pushed = "motion = { z = -1e-2 }\n";
    for coupling in [pushed, "kind = \"distributing\"\nmotion = { z = -1e-2 }\n", "force = [0, 0, -1]\n"] {
        let error = refused(&pressed(coupling));
        assert!(error.contains("on the axis of cyclic symmetry"), "{error}");
    }
    // Beside the axis each sector has a point of its own.
    assert!(
        solved(&pressed(pushed).replace("point = [0, 0, 10]", "point = [26, 15, 10]")).0.solution.certificate.passed
    );
}
