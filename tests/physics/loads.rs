//! Loads, bolts and planes of symmetry against closed forms.

use stiction::run::{Outcome, Prepared, bolt_states, check, prepare};
use stiction_fixtures::case_run::{CORNER, at, block, displacement, is, refused, solved, stress};

const STEEL: &str = "[materials.steel]\nyoung = 200e3\npoisson = 0.3\ndensity = 8e-9\nexpansion = 12e-6\n";
/// Springs all over the feet, so that a body needs no other support.
const SPRINGS: &str = "[[spring]]\non = \"z-min\"\nnormal = 1000\ntangential = 1000\n";

/// Loads at the nodes: their sum and their moment about `point`.
fn resultants(prepared: &Prepared, point: [f64; 3]) -> [[f64; 3]; 2] {
    let load = &prepared.problem.labels.supports.as_ref().unwrap().free_load;
    let (mut sum, mut moment) = ([0.0; 3], [0.0; 3]);
    for (x, f) in prepared.mesh.nodes.iter().zip(load.as_chunks::<3>().0) {
        let r = [0, 1, 2].map(|c| x[c] - point[c]);
        let m = [r[1] * f[2] - r[2] * f[1], r[2] * f[0] - r[0] * f[2], r[0] * f[1] - r[1] * f[0]];
        (0..3).for_each(|c| (sum[c], moment[c]) = (sum[c] + f[c], moment[c] + m[c]));
    }
    [sum, moment]
}

fn prepared(text: &str) -> Prepared {
    prepare(&stiction::io::case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"))).unwrap()
}

/// A file with a grid of hexahedra whose nodes are moved by `map`, and the faces at `i = cut` as the group "cut".
fn grid(name: &str, cells: [usize; 3], cut: usize, map: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let node = |i: usize, j: usize, k: usize| (k * (cells[1] + 1) + j) * (cells[0] + 1) + i + 1;
    let (mut nodes, mut elements) = (String::new(), Vec::new());
    for k in 0..=cells[2] {
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                let [x, y, z] =
                    map([i as f64 / cells[0] as f64, j as f64 / cells[1] as f64, k as f64 / cells[2] as f64]);
                nodes += &format!("{} {x:?} {y:?} {z:?}\n", node(i, j, k));
            }
        }
    }
    let quad = |tag: usize, n: [usize; 4]| format!("3 2 {tag} {tag} {} {} {} {}", n[0], n[1], n[2], n[3]);
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                let n = |a: usize, b: usize, c: usize| node(i + a, j + b, k + c);
                let corners =
                    [n(0, 0, 0), n(1, 0, 0), n(1, 1, 0), n(0, 1, 0), n(0, 0, 1), n(1, 0, 1), n(1, 1, 1), n(0, 1, 1)];
                elements.push(format!("5 2 9 9 {}", corners.map(|c| c.to_string()).join(" ")));
                let x = |a| quad([1, 2][a], [n(a, 0, 0), n(a, 1, 0), n(a, 1, 1), n(a, 0, 1)]);
                let y = |a| quad([3, 4][a], [n(0, a, 0), n(1, a, 0), n(1, a, 1), n(0, a, 1)]);
                let z = |a| quad([5, 6][a], [n(0, 0, a), n(1, 0, a), n(1, 1, a), n(0, 1, a)]);
                for (at, count, face) in
                    [(i, cells[0], &x as &dyn Fn(usize) -> String), (j, cells[1], &y), (k, cells[2], &z)]
                {
                    elements.extend((at == 0).then(|| face(0)));
                    elements.extend((at + 1 == count).then(|| face(1)));
                }
                elements.extend((i == cut).then(|| quad(7, [n(0, 0, 0), n(0, 1, 0), n(0, 1, 1), n(0, 0, 1)])));
            }
        }
    }
    let count = (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1);
    let lines: String = elements.iter().enumerate().map(|(number, e)| format!("{} {e}\n", number + 1)).collect();
    let names = ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max", "cut"];
    let names: String = names.iter().zip(1..).map(|(name, tag)| format!("2 {tag} \"{name}\"\n")).collect();
    let text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n8\n{names}3 9 \"body\"\n$EndPhysicalNames\n$Nodes\n{count}\n{nodes}$EndNodes\n\
         $Elements\n{}\n{lines}$EndElements\n",
        elements.len()
    );
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    format!("[mesh]\nfile = {:?}\n", path.display().to_string())
}

/// Thin annular disc, plane stress (Timoshenko & Goodier, Theory of Elasticity, art. 32):
/// sigma_t(a) = (3 + nu)/4 rho w² (b² + (1 - nu)/(3 + nu) a²), and u(a) = a sigma_t(a)/E, for it carries no load there.
#[test]
fn a_rotating_disc_grows_as_in_the_closed_form() {
    let (a, b, nu, young, rho, speed) = (1.0, 3.0, 0.3, 200e3, 8e-9, 2000.0);
    let error = |n: usize| {
        let mesh = grid(&format!("disc-{n}.msh"), [n, n, 1], usize::MAX, |[r, p, z]| {
            let (radius, angle) = (a + (b - a) * r, p * std::f64::consts::FRAC_PI_2);
            [radius * angle.cos(), radius * angle.sin(), 0.02 * z]
        });
        let text = mesh
            + STEEL
            + "[[fix]]\non = \"y-min\"\ncondition = \"symmetry\"\n[[fix]]\non = \"y-max\"\ncondition = \"symmetry\"\n\
               [[fix]]\non = \"z-min\"\ncondition = \"symmetry\"\n\
               [[load]]\nrotation = { axis = [0, 0, 3], point = [0, 0, 7], speed = \"2000*t\" }\n";
        let stress = (3.0 + nu) / 4.0 * rho * speed * speed * (b * b + (1.0 - nu) / (3.0 + nu) * a * a);
        (at(&solved(&text), [a, 0.0, 0.0])[0] / (a * stress / young) - 1.0).abs()
    };
    let (coarse, fine) = (error(8), error(16));
    assert!(fine < 4e-3 && coarse / fine > 3.0, "{coarse:.2e} {fine:.2e}");
}

/// Archimedes, with the line of action: through the centre of the displaced liquid, whichever way the block lies.
#[test]
fn a_liquid_lifts_a_body_by_the_weight_of_what_it_displaces() {
    for element in ["element = \"hex8\"", "element = \"tet4\""] {
        let mesh = block([4.0, 2.0, 3.0], [3, 2, 3], element) + "turn = { axis = [1, 2, 5], degrees = 50 }\n";
        let sides = "on = [\"x-min\", \"x-max\", \"y-min\", \"y-max\", \"z-min\", \"z-max\"]\n";
        let load = format!("[[load]]\n{sides}hydrostatic = {{ weight = 2, level = 10, up = [0, 3, 4] }}\n");
        let p = prepared(&(mesh + STEEL + SPRINGS + &load));
        let centre = stiction::mesh::Turn {
            point: [0.0; 3],
            axis: [1.0, 2.0, 5.0].map(|c: f64| c / 30f64.sqrt()),
            degrees: 50.0,
        };
        let [force, moment] = resultants(&p, centre.apply([2.0, 1.0, 1.5]));
        (0..3).for_each(|c| is(force[c], 2.0 * 24.0 * [0.0, 0.6, 0.8][c], 48.0));
        moment.iter().for_each(|&m| is(m, 0.0, 48.0));
        // Half under, up to a row of faces.
        let load = format!("[[load]]\n{sides}hydrostatic = {{ weight = 2, level = \"2*t\" }}\n");
        let [force, _] =
            resultants(&prepared(&(block([4.0, 2.0, 3.0], [3, 2, 3], element) + STEEL + SPRINGS + &load)), [0.0; 3]);
        (0..3).for_each(|c| is(force[c], [0.0, 0.0, 32.0][c], 32.0));
    }
}

/// A corner of the block dips into the liquid: a tetrahedron with edges D/up_c from the corner at the depth D, whatever the
/// cells. Archimedes again, to rounding; and on one side of it, a triangle: weight D area/3, at a quarter of its edges.
#[test]
fn a_level_across_the_faces_presses_on_what_is_below_it() {
    let (up, depth, weight) = ([2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0], 0.8, 2.0);
    let edges = up.map(|c: f64| depth / c);
    for element in ["hex8", "tet4", "hex20", "tet10"] {
        let mesh = block([4.0, 2.0, 3.0], [3, 2, 5], &format!("element = \"{element}\"")) + STEEL + SPRINGS;
        let pressed = |on: &str, level: &str| {
            let liquid = format!("hydrostatic = {{ weight = {weight}, level = {level}, up = [2, 3, 6] }}\n");
            prepared(&(mesh.clone() + "[[load]]\n" + &format!("on = {on}\n") + &liquid))
        };
        let all = pressed("[\"x-min\", \"x-max\", \"y-min\", \"y-max\", \"z-min\", \"z-max\"]", "\"0.8*t\"");
        let lift = weight * edges.iter().product::<f64>() / 6.0;
        let [force, moment] = resultants(&all, edges.map(|edge| edge / 4.0));
        (0..3).for_each(|c| is(force[c], lift * up[c], lift));
        moment.iter().for_each(|&m| is(m, 0.0, lift));
        let wanted = weight * depth / 3.0 * edges[1] * edges[2] / 2.0;
        let [force, moment] = resultants(&pressed("\"x-min\"", "0.8"), [0.0, edges[1] / 4.0, edges[2] / 4.0]);
        (0..3).for_each(|c| is(force[c], [wanted, 0.0, 0.0][c], wanted));
        moment.iter().for_each(|&m| is(m, 0.0, wanted));
        let [force, _] = resultants(&pressed("\"x-max\"", "0.8"), [0.0; 3]);
        (0..3).for_each(|c| is(force[c], 0.0, wanted));
    }
}

/// A quarter of a tank of radius R filled from outside to the height R sin a, within a cell: with `g` the weight,
/// F_x = -g H R² sin² a / 2 and F_y = -g H R² (sin a (1 - cos a) - a/2 + sin 2a / 4), by integration over the arc.
#[test]
fn a_level_across_curved_faces_presses_as_on_the_arc() {
    let (radius, height, weight, a) = (5.0f64, 4.0, 3.0, 50f64.to_radians());
    let wanted = [0.5 * a.sin().powi(2), a.sin() * (1.0 - a.cos()) - 0.5 * a + 0.25 * (2.0 * a).sin()];
    let size = -weight * height * radius * radius;
    let errors = [3, 6].map(|around| {
        let text = format!(
            "[mesh]\nring = {{ radii = [4, 5], height = {height}, degrees = 90, cells = [1, {around}, 1], element = \"hex20\" }}\n\
             {STEEL}[[fix]]\non = \"start\"\n[[load]]\non = \"outer\"\n\
             hydrostatic = {{ weight = {weight}, level = {:?}, up = [0, 1, 0] }}\n",
            radius * a.sin()
        );
        let p = prepared(&text);
        let mut sum = [0.0; 3];
        let supports = p.problem.labels.supports.as_ref().unwrap();
        for (force, dofs) in [(&supports.free_load, &p.model.dofs.free), (&supports.load, &p.model.dofs.prescribed)] {
            force.iter().zip(dofs).for_each(|(f, dof)| sum[*dof as usize % 3] += f);
        }
        (0..2).map(|c| (sum[c] / size - wanted[c]).abs()).fold(0.0, f64::max)
    });
    println!("{errors:?}");
    assert!(errors[0] < 2e-3 && errors[1] < errors[0] / 8.0, "{errors:?}");
}

/// Pure bending by a moment that grows with the square of time: M = 10 t², the beam stores M² L / (2 E I) in every step
/// and its axis sinks by M x² / (2 E I), of second degree and therefore exact on quadratic cells.
#[test]
fn a_moment_that_grows_in_time_bends_a_beam_step_by_step() {
    let (young, inertia, length) = (200e3, 2.0 * 27.0 / 12.0, 4.0);
    for element in ["hex20", "tet10"] {
        let text = block([length, 2.0, 3.0], [2, 1, 1], &format!("element = \"{element}\""))
            + &STEEL.replace("0.3", "0")
            + "[[fix]]\non = \"x-min\"\ncomponents = \"x\"\n[[fix]]\non = { point = [0, 0, 0] }\ncomponents = \"yz\"\n\
               [[fix]]\non = { point = [0, 2, 0] }\ncomponents = \"z\"\n\
               [[load]]\non = \"x-max\"\nmoment = [0, \"10*t^2\", 0]\n[[step]]\nuntil = 2\nincrements = 4\n";
        let run = solved(&text);
        for (step, t) in run.0.steps.iter().zip([0.5f64, 1.0, 1.5, 2.0]) {
            let stored = (10.0 * t * t).powi(2) * length / (2.0 * young * inertia);
            is(step.balance.elastic, stored, stored);
        }
        let sunk = 40.0 * length * length / (2.0 * young * inertia);
        is(at(&run, [length, 0.0, 0.0])[2], -sunk, sunk);
    }
}

/// On faces that are not even flat, force and moment come out to rounding; on a symmetric section the tractions are those
/// of Navier's bending, M z/I.
#[test]
fn a_total_force_and_moment_have_their_resultants() {
    for element in ["element = \"hex8\"", "element = \"tet4\""] {
        let mesh = block([4.0, 2.0, 3.0], [3, 2, 3], element)
            + "turn = { axis = [1, 2, 5], degrees = 50 }\n"
            + STEEL
            + SPRINGS;
        let load =
            "[[load]]\non = [\"x-max\", \"z-max\"]\nforce = [3, -1, 2]\nmoment = [5, \"7*t\", -4]\nabout = [1, 1, 9]\n";
        let [force, moment] = resultants(&prepared(&(mesh.clone() + load)), [1.0, 1.0, 9.0]);
        (0..3).for_each(|c| is(force[c], [3.0, -1.0, 2.0][c], 3.0));
        (0..3).for_each(|c| is(moment[c], [5.0, 7.0, -4.0][c], 7.0));
        // Acting through a point, without any moment about it.
        let [force, moment] = resultants(
            &prepared(&(mesh + "[[load]]\non = \"x-max\"\nforce = [3, -1, 2]\nabout = [9, 0, 0]\n")),
            [9.0, 0.0, 0.0],
        );
        (0..3).for_each(|c| is(force[c], [3.0, -1.0, 2.0][c], 3.0));
        moment.iter().for_each(|&m| is(m, 0.0, 30.0));

        let mesh = block([4.0, 2.0, 3.0], [3, 2, 3], element) + STEEL + SPRINGS;
        let nodal = |load: &str| {
            let p = prepared(&(mesh.clone() + "[[load]]\non = \"x-max\"\n" + load));
            p.problem.labels.supports.unwrap().free_load
        };
        let inertia = 2.0 * 27.0 / 12.0;
        let bent = nodal(&format!("traction = [\"10*(z - 1.5)/{inertia}\", 0, 0]\n"));
        for (a, b) in nodal("moment = [0, 10, 0]\n").into_iter().zip(bent) {
            is(a, b, 1.0);
        }
    }
}

#[test]
fn a_plane_of_symmetry_is_told_by_its_faces() {
    let text = |fixes: &str| {
        block([4.0, 2.0, 3.0], [3, 2, 2], "element = \"tet4\"")
            + STEEL
            + fixes
            + "[[load]]\non = \"z-max\"\ntraction = [1, 2, -3]\n[[fix]]\non = \"x-max\"\n"
    };
    let by_name = solved(&text("[[fix]]\non = \"x-min\"\ncondition = \"symmetry\"\n"));
    let by_component = solved(&text("[[fix]]\non = \"x-min\"\ncomponents = \"x\"\n"));
    assert_eq!(displacement(&by_name), displacement(&by_component));
    let message = refused(&text("[[fix]]\non = [\"x-min\", \"y-min\"]\ncondition = \"symmetry\"\n"));
    assert!(message.contains("x-min, y-min is not flat") && message.contains("[[fix]]"), "{message}");
}

fn bolt(run: &(Outcome, Prepared)) -> [f64; 2] {
    let all = bolt_states(&run.1, &run.0);
    [all[0].force, all[0].shortening]
}

const WALLS: &str = "[[fix]]\non = \"x-max\"\ncomponents = \"x\"\nvalue = \"pull*max(0, t - 1)\"\n";

/// A bar of length 4 and section 4 between two walls, the far one of which moves by `pull` from t = 1 to 2.
fn bar(mesh: &str, pull: f64, bolt: &str, rest: &str) -> String {
    mesh.to_string() + STEEL + CORNER + &WALLS.replace("pull", &pull.to_string()) + "[[bolt]]\n" + bolt + rest
}

/// N = E A s/L wherever the bar is cut, faces of its cells or not; heated, N = E A (s/L - alpha dT).
#[test]
fn a_bar_between_walls_is_tightened_by_its_shortening() {
    let stiffness = 200e3 * 4.0 / 4.0;
    let meshes = [
        block([4.0, 2.0, 2.0], [4, 2, 2], "element = \"hex8\""),
        block([4.0, 2.0, 2.0], [3, 2, 2], "element = \"tet4\""),
        block([4.0, 2.0, 2.0], [3, 2, 2], "split = \"six\""),
        block([4.0, 2.0, 2.0], [3, 1, 1], "element = \"hex20\""),
        block([4.0, 2.0, 2.0], [3, 1, 1], "element = \"tet10\""),
    ];
    for mesh in &meshes {
        let by_plane = "on = \"body\"\naxis = [-2, 0, 0]\npoint = [2.1, 0, 0]\nshortening = 1e-3\n";
        let run = solved(&bar(mesh, 0.0, by_plane, ""));
        is(bolt(&run)[0], stiffness * 1e-3, stiffness * 1e-3);
        stress(&run).iter().for_each(|s| (0..6).for_each(|c| is(s[c], [50.0, 0.0, 0.0, 0.0, 0.0, 0.0][c], 50.0)));
        let run = solved(&bar(mesh, 0.0, by_plane, "[[load]]\ntemperature = 10\n"));
        let heated = stiffness * (1e-3 - 4.0 * 12e-6 * 10.0);
        is(bolt(&run)[0], heated, heated);
        stress(&run).iter().for_each(|s| is(s[0], heated / 4.0, 50.0));
        // By force the same state is found from the other side.
        let run = solved(&bar(mesh, 0.0, &by_plane.replace("shortening = 1e-3", "force = 200"), ""));
        assert!((bolt(&run)[1] / 1e-3 - 1.0).abs() < 1e-6 && (bolt(&run)[0] / 200.0 - 1.0).abs() < 1e-6);
    }
    // Faces between cells, the sides distinguished by their own normal.
    let meshes = [grid("bolt.msh", [4, 2, 2], 3, |[x, y, z]| [4.0 * x, 2.0 * y, 2.0 * z]), cut_hex20("bolt20.msh")];
    for (mesh, element) in meshes
        .iter()
        .flat_map(|mesh| ["on = \"cut\"\n", "on = \"cut\"\naxis = [-1, 0, 0]\n"].map(|element| (mesh, element)))
    {
        let run = solved(&bar(mesh, 0.0, &format!("{element}shortening = 1e-3\n"), ""));
        is(bolt(&run)[0], stiffness * 1e-3, stiffness * 1e-3);
        stress(&run).iter().for_each(|s| is(s[0], 50.0, 50.0));
    }
}

/// A bar of hex20 with its faces at x = 3 as the group "cut", as Gmsh writes it.
fn cut_hex20(name: &str) -> String {
    use stiction::mesh::{Block, BlockElement};
    const EDGES: [usize; 12] = [8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14];
    let (origin, grading, element) = ([0.0; 3], [1.0; 3], BlockElement::Hex20);
    let mesh =
        stiction::mesh::block(&Block { size: [4.0, 2.0, 2.0], cells: [4, 2, 2], origin, grading, element }).unwrap();
    let mut elements: Vec<String> = Vec::new();
    let list = |nodes: &[u32]| nodes.iter().map(|n| (n + 1).to_string()).collect::<Vec<_>>().join(" ");
    for (tag, side) in ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max"].iter().enumerate() {
        for &face in &mesh.group(side).unwrap().faces {
            elements.push(format!("16 2 {0} {0} {1}", tag + 1, list(mesh.faces[face as usize].nodes())));
        }
    }
    for (_, cell) in mesh.cell_iter() {
        let order: Vec<u32> = (0..8).chain(EDGES).map(|k| cell[k]).collect();
        elements.push(format!("17 2 9 9 {}", list(&order)));
        // The side x-max of a cell: corners 1, 2, 6, 5 and the middles between them.
        let face = [1, 2, 6, 5, 9, 18, 13, 17].map(|k| cell[k]);
        if face[..4].iter().all(|&n| (mesh.nodes[n as usize][0] - 3.0).abs() < 1e-9) {
            elements.push(format!("16 2 7 7 {}", list(&face)));
        }
    }
    let nodes: String =
        (1..).zip(&mesh.nodes).map(|(n, x)| format!("{n} {:?} {:?} {:?}\n", x[0], x[1], x[2])).collect();
    let names = ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max", "cut"];
    let names: String = names.iter().zip(1..).map(|(name, tag)| format!("2 {tag} \"{name}\"\n")).collect();
    let lines: String = elements.iter().zip(1..).map(|(e, number)| format!("{number} {e}\n")).collect();
    let (count, of) = (mesh.nodes.len(), elements.len());
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(
        &path,
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n8\n{names}3 9 \"body\"\n$EndPhysicalNames\n\
             $Nodes\n{count}\n{nodes}$EndNodes\n$Elements\n{of}\n{lines}$EndElements\n"
        ),
    )
    .unwrap();
    format!("[mesh]\nfile = {:?}\n", path.display().to_string())
}

/// Heated by T = 10 + 5 x along it alone, without contraction: N = E A (s/L - 12e-6 ∫T dx/L) = 200 - 192, wherever
/// the cut and whatever the slope within its cells.
#[test]
fn a_bolt_in_a_slope_of_temperature_is_unloaded_by_its_mean() {
    let along = "[materials.bar]\nyoung = [200e3, 200e3, 200e3]\npoisson = [0, 0, 0]\nshear = [100e3, 100e3, 100e3]\n\
                 axes = [[1, 0, 0], [0, 1, 0]]\nexpansion = [12e-6, 0, 0]\n";
    for element in ["hex20", "tet10", "hex8"] {
        let mesh = block([4.0, 2.0, 2.0], [3, 2, 2], &format!("element = \"{element}\""));
        for place in [1.1, 2.1, 2.9] {
            let text = bar(
                &mesh,
                0.0,
                &format!("on = \"body\"\naxis = [1, 0, 0]\npoint = [{place}, 0, 0]\nshortening = 1e-3\n"),
                "[[load]]\ntemperature = \"10 + 5*x\"\n",
            );
            let run = solved(&text.replace(STEEL, along));
            is(bolt(&run)[0], 200.0 - 192.0, 200.0);
            stress(&run).iter().for_each(|s| is(s[0], 2.0, 50.0));
        }
    }
}

/// Tightened to 200 and then pulled by 1e-3: locked it carries 200 + E A d/L, by force still 200. Work is elastic energy
/// to rounding, on both solver paths, and the files of the run say so as well.
#[test]
fn a_locked_bolt_takes_up_load_and_one_held_by_force_does_not() {
    let mesh = block([4.0, 2.0, 2.0], [4, 2, 2], "element = \"hex8\"");
    let steps = "[[step]]\nname = \"tighten\"\nuntil = 1\n[[step]]\nname = \"pull\"\nuntil = 2\nincrements = 2\n";
    for (lock, path, wanted) in
        [("lock = \"tighten\"\n", "auto", 400.0), ("", "auto", 200.0), ("lock = \"tighten\"\n", "multigrid", 400.0)]
    {
        let by = format!("on = \"body\"\naxis = [1, 0, 0]\nforce = \"200*min(t, 1)\"\n{lock}");
        let run = solved(&bar(&mesh, 1e-3, &by, &format!("{steps}[solver]\npath = \"{path}\"\n")));
        assert!((bolt(&run)[0] / wanted - 1.0).abs() < 1e-6, "{:?}", bolt(&run));
        let tightened = &run.0.steps[0].answer.bolts[0];
        assert!((tightened.force / 200.0 - 1.0).abs() < 1e-6, "{tightened:?}");
        let last = run.0.steps.last().unwrap().balance;
        // 1/2 N²L/(E A); the work of the wrench and of the wall.
        let elastic = 0.5 * wanted * wanted / 200e3;
        assert!((last.elastic / elastic - 1.0).abs() < 1e-5, "{last:?}");
        assert!(last.drift.abs() < 1e-6 * elastic, "{last:?}");
    }
}

/// Two halves of one block, each with a force of its own: what the walls carry is their sum.
#[test]
fn several_bolts_find_their_forces_together() {
    let half = |name: &str, low: f64, force: f64| {
        let high = low + 2.0;
        format!(
            "[[bolt]]\nname = \"{name}\"\non = {{ box = [[{low}, 0, 0], [{high}, 2, 6]] }}\naxis = [0, 0, 1]\npoint = [0, 0, 3]\nforce = {force}\n"
        )
    };
    let text = block([4.0, 2.0, 6.0], [4, 2, 6], "element = \"hex8\"")
        + STEEL
        + "[[fix]]\non = [\"z-min\", \"z-max\"]\n"
        + &half("a", 0.0, 300.0)
        + &half("b", 2.0, 500.0);
    let run = solved(&text);
    let forces: Vec<f64> = bolt_states(&run.1, &run.0).iter().map(|b| b.force).collect();
    assert!((forces[0] / 300.0 - 1.0).abs() < 1e-6 && (forces[1] / 500.0 - 1.0).abs() < 1e-6, "{forces:?}");
    // Over the lowest row of cells, whose faces across the load have the area one.
    let stress = stress(&run);
    let lowest = |nodes: &[u32]| run.1.mesh.nodes[nodes[0] as usize][2] < 0.5;
    let rows = stress.iter().zip(run.1.mesh.cell_iter()).filter(|(_, (_, nodes))| lowest(nodes));
    let through: f64 = rows.map(|(s, _)| s[2]).sum();
    assert!((through / 800.0 - 1.0).abs() < 1e-6, "{through}");
}

#[test]
fn bolts_that_cannot_be_cut_are_refused() {
    let mesh = block([4.0, 2.0, 2.0], [4, 2, 2], "element = \"hex8\"");
    let says = |bolt: &str, part: &str| {
        let message = refused(&bar(&mesh, 0.0, bolt, ""));
        assert!(message.contains(part), "{part:?} is not in:\n{message}");
    };
    says("on = \"body\"\nshortening = 1\n", "has no axis");
    says(
        "on = \"body\"\naxis = [1, 0, 0]\npoint = [7, 0, 0]\nshortening = 1\n",
        "leaves no cells of bolt \"body\", which reaches from 0 to 4, on both sides",
    );
    // Inside the bolt, and beyond the centres of its last cells.
    says(
        "on = \"body\"\naxis = [1, 0, 0]\npoint = [3.6, 0, 0]\nshortening = 1\n",
        "give a `point` at 0.5 or more, and below 3.5, along the axis",
    );
    // Tetrahedra of the last layer lie on both sides of this plane: the cut reaches the wall.
    let message = refused(&bar(
        &block([4.0, 2.0, 2.0], [3, 2, 2], "element = \"tet4\""),
        0.0,
        "on = \"body\"\naxis = [1, 0, 0]\npoint = [3.2, 0, 0]\nshortening = 1\n",
        "",
    ));
    assert!(message.contains("which is held along it") && message.contains("another `point`"), "{message}");
    says("on = \"boby\"\naxis = [1, 0, 0]\nshortening = 1\n", "did you mean \"body\"?");
    says("on = \"body\"\naxis = [1, 0, 0]\nshortening = \"1/(1 - t)\"\n", "is inf at time t = 1");
    says(
        "on = \"body\"\naxis = [1, 0, 0]\nshortening = 1\n[[bolt]]\nname = \"b\"\non = \"body\"\naxis = [1, 0, 0]\nshortening = 1\n",
        "a cell of bolt \"body\"",
    );
}

/// Everything at once in load steps, through the files: heat, a bolt, springs, contact with friction.
#[test]
fn a_folder_with_heat_bolts_and_springs_passes_its_check() {
    let text = block([4.0, 2.0, 2.0], [4, 2, 2], "element = \"hex8\"")
        + STEEL
        + SPRINGS.replace("z-min", "x-min").as_str()
        + "[[load]]\ntemperature = \"30*t\"\n[[load]]\non = \"z-max\"\nforce = [0, 0, \"-50*t\"]\nmoment = [\"5*t\", 0, 0]\n\
           [[bolt]]\non = \"body\"\naxis = [1, 0, 0]\nforce = \"20*min(t, 1)\"\nlock = \"a\"\n\
           [[fix]]\non = \"x-max\"\ncondition = \"symmetry\"\n[[contact]]\non = \"z-min\"\n\
           against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\nfriction = { coulomb = 0.3 }\n\
           [[step]]\nname = \"a\"\nuntil = 1\n[[step]]\nuntil = 2\nincrements = 2\n";
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("heat-and-bolts");
    let _ = std::fs::remove_dir_all(&folder);
    let case = stiction::io::case::parse(&text, "case.toml", &[]).unwrap();
    let mut prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let (mut files, _) = stiction::run::begin_steps(&prepared, &folder, false).unwrap();
    let settings = stiction::run::Settings::of(&case.solver);
    let mut keep =
        |prepared: &Prepared, step: &stiction::run::Step| stiction::run::keep_step(&mut files, prepared, step);
    let mut outcome = stiction::run::solve_steps(&mut prepared, &settings, None, &mut keep, &mut |_| {
        std::ops::ControlFlow::Continue(())
    })
    .unwrap();
    stiction::run::write(&prepared, &mut outcome, &stiction::run::Origin::default(), &folder).unwrap();
    let checked = check(&folder).unwrap_or_else(|e| panic!("{e}"));
    assert!(checked.passed() && checked.steps.len() == 3, "{checked:?}");
    let bolts = |step: usize| outcome.steps[step].answer.bolts[0].clone();
    assert!((bolts(0).force / 20.0 - 1.0).abs() < 1e-6);
    assert_eq!(bolts(0).shortening, bolts(2).shortening);
    // A run that goes on from the files of the first two steps would start where they end.
    let (_, restart) = stiction::run::begin_steps(&prepared, &folder, true).unwrap();
    let last = restart.unwrap().last;
    assert_eq!(last.shortening, [bolts(2).shortening]);
}
