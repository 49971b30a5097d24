//! Orthotropic elasticity, thermal strain and elastic foundations against closed forms.

use stiction::run::{Outcome, Prepared};
use stiction_fixtures::case_run::{CORNER, at, block, displacement, is, refused, solved, stress};

const WOOD: &str = "[materials.wood]\nyoung = [11000, 900, 500]\npoisson = [0.4, 0.45, 0.3]\nshear = [700, 600, 60]\n";
const STEEL: &str = "[materials.steel]\nyoung = 200e3\npoisson = 0.3\nexpansion = 12e-6\nreference_temperature = 20\n";

/// Three points that hold the rigid motions of a block of length 4 and width 2 and nothing else.
const POINTS: &str = "[[fix]]\non = { point = [0, 0, 0] }\n[[fix]]\non = { point = [4, 0, 0] }\ncomponents = \"yz\"\n\
                      [[fix]]\non = { point = [0, 2, 0] }\ncomponents = \"z\"\n";

/// Along each of its axes a bar stretches by s/E_a and contracts by nu_ab s/E_a = nu_ba s/E_b across.
#[test]
fn an_orthotropic_bar_stretches_and_contracts_by_its_own_constants() {
    let (e, nu) = (
        [11000.0, 900.0, 500.0],
        [[0.0, 0.4, 0.45], [0.4 * 900.0 / 11000.0, 0.0, 0.3], [0.45 * 500.0 / 11000.0, 0.3 * 500.0 / 900.0, 0.0]],
    );
    for element in ["element = \"hex8\"", "element = \"tet4\""] {
        for axis in 0..3 {
            let face = ["x-max", "y-max", "z-max"][axis];
            let text = block([4.0, 2.0, 3.0], [2, 2, 2], element)
                + WOOD
                + CORNER
                + &format!("[[load]]\non = \"{face}\"\npressure = -3\n");
            let run = solved(&text);
            let u = at(&run, [4.0, 2.0, 3.0]);
            for c in 0..3 {
                let strain = if c == axis { 3.0 / e[axis] } else { -nu[axis][c] * 3.0 / e[axis] };
                is(u[c] / [4.0, 2.0, 3.0][c], strain, 3.0 / e[axis]);
            }
            let wanted: [f64; 6] = std::array::from_fn(|c| if c == axis { 3.0 } else { 0.0 });
            stress(&run).iter().for_each(|s| (0..6).for_each(|c| is(s[c], wanted[c], 3.0)));
        }
    }
}

/// Tension at 30 degrees to the first axis: 1/E_x = c^4/E1 + s^4/E2 + c²s² (1/G12 - 2 nu12/E1), and the bar shears by
/// (2/E1 + 2 nu12/E1 - 1/G12) c³s - (2/E2 + 2 nu12/E1 - 1/G12) c s³ (Lekhnitskii).
#[test]
fn tension_across_the_grain_shears_a_bar() {
    let (sine, cosine) = 30f64.to_radians().sin_cos();
    let (e1, e2, nu, g) = (11000.0, 900.0, 0.4, 700.0);
    for element in ["element = \"hex8\"", "split = \"six\""] {
        let text = block([4.0, 2.0, 2.0], [3, 2, 2], element)
            + WOOD
            + &format!("axes = [[{cosine}, {sine}, 0], [{}, {cosine}, 0]]\n", -sine)
            + POINTS
            + "[[load]]\non = [\"x-max\", \"x-min\"]\npressure = -3\n";
        let run = solved(&text);
        let modulus = cosine.powi(4) / e1 + sine.powi(4) / e2 + (cosine * sine).powi(2) * (1.0 / g - 2.0 * nu / e1);
        let shear = (2.0 / e1 + 2.0 * nu / e1 - 1.0 / g) * cosine.powi(3) * sine
            - (2.0 / e2 + 2.0 * nu / e1 - 1.0 / g) * cosine * sine.powi(3);
        is(at(&run, [4.0, 0.0, 0.0])[0], 4.0 * 3.0 * modulus, 0.1);
        is(at(&run, [0.0, 2.0, 0.0])[0], 2.0 * 3.0 * shear, 0.1);
    }
}

/// Nature does not know our axes: a turned block of a turned material is the turned solution, contact included.
#[test]
fn a_turned_block_of_a_turned_material_behaves_the_same() {
    let turn = stiction::mesh::Turn { point: [0.0; 3], axis: [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0], degrees: 40.0 };
    let case = |turned: bool| {
        let image = |v: [f64; 3]| if turned { turn.apply(v) } else { v };
        let mesh = block([4.0, 2.0, 2.0], [4, 2, 2], "element = \"hex8\"");
        let line = if turned { "turn = { axis = [2, 3, 6], degrees = 40 }\n" } else { "" };
        let [a, b, n, f] = [[1.0, 2.0, 0.5], [0.0, 1.0, 3.0], [0.0, 0.0, 1.0], [3.0, 1.0, -8.0]].map(image);
        mesh + line
            + WOOD
            + &format!(
                "axes = [{a:?}, {b:?}]\nexpansion = [1e-6, 3e-5, 9e-5]\n[[fix]]\non = \"x-min\"\n\
            [[load]]\non = \"z-max\"\ntraction = {f:?}\n[[load]]\ntemperature = 20\n[[contact]]\non = \"z-min\"\n\
            against = {{ plane = {{ point = [0, 0, 0], normal = {n:?} }} }}\nfriction = {{ coulomb = 0.3 }}\n[solver]\ntolerance = 1e-11\n"
            )
    };
    let (straight, turned) = (solved(&case(false)), solved(&case(true)));
    let size = displacement(&straight).as_flattened().iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    for (u, v) in displacement(&straight).into_iter().zip(displacement(&turned)) {
        (0..3).for_each(|c| is(turn.apply(u)[c], v[c], size));
    }
    assert!(straight.0.solution.lambda.iter().any(|&l| l > 0.1));
}

/// Between two walls sigma = -E alpha dT along the bar; free it grows by alpha dT and carries nothing. B-bar as well.
#[test]
fn a_heated_bar_is_stressed_where_it_is_clamped_and_nowhere_else() {
    for element in ["hex8", "tet4", "hex20", "tet10"].map(|element| format!("element = \"{element}\"")) {
        for poisson in ["0.3", "0.48"] {
            let body = block([4.0, 2.0, 2.0], [3, 2, 2], &element) + &STEEL.replace("0.3", poisson);
            let clamped = solved(
                &(body.clone() + CORNER + "[[fix]]\non = \"x-max\"\ncomponents = \"x\"\n[[load]]\ntemperature = 120\n"),
            );
            for s in stress(&clamped) {
                is(s[0], -200e3 * 12e-6 * 100.0, 240.0);
                (1..6).for_each(|c| is(s[c], 0.0, 240.0));
            }
            let free = solved(&(body + POINTS + "[[load]]\ntemperature = 120\n"));
            stress(&free).iter().flatten().for_each(|&s| is(s, 0.0, 240.0));
            let u = at(&free, [4.0, 2.0, 2.0]);
            (0..3).for_each(|c| is(u[c], 12e-6 * 100.0 * [4.0, 2.0, 2.0][c], 5e-3));
        }
    }
}

/// In a linear temperature field T = 100 + 30 x - 10 y + 5 z a free body is not stressed and moves by
/// `u = a (T_0 x + (g . x) x - |x|² g / 2)`, g the slope: of second degree, so that quadratic cells have it to rounding,
/// by an expression and by temperatures at the nodes. Linear cells, which cannot bend so, near it by the square of their
/// size at best.
#[test]
fn a_free_body_in_a_linear_temperature_field_bends_without_stress() {
    use stiction::io::vtu::{Array, Grid, write};
    use stiction::mesh::BlockElement;
    let slope = [30.0, -10.0, 5.0];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let wanted =
        |x: [f64; 3]| [0, 1, 2].map(|c| 12e-6 * (100.0 * x[c] + dot(slope, x) * x[c] - 0.5 * dot(x, x) * slope[c]));
    // The rigid motions are held at three points by the values of the closed form.
    let held: String = [([0.0, 0.0, 0.0], "xyz"), ([4.0, 0.0, 0.0], "yz"), ([0.0, 2.0, 0.0], "z")]
        .into_iter()
        .map(|(x, components)| {
            let u = wanted(x);
            let values: Vec<f64> = components.bytes().map(|c| u[(c - b'x') as usize]).collect();
            format!("[[fix]]\non = {{ point = {x:?} }}\ncomponents = \"{components}\"\nvalue = {values:?}\n")
        })
        .collect();
    let heat = |value: &str| format!("{held}[[load]]\ntemperature = {value}\n");
    let error = |run: &(Outcome, Prepared)| {
        let off = run.1.mesh.nodes.iter().zip(displacement(run)).map(|(&x, u)| {
            let w = wanted(x);
            (0..3).map(|c| (u[c] - w[c]).powi(2)).sum::<f64>().sqrt()
        });
        off.fold(0.0, f64::max) / 6e-3
    };
    let expression = "\"120 + 30*x - 10*y + 5*z\"";
    for element in [BlockElement::Hex20, BlockElement::Tet10Six, BlockElement::Tet10Five { parity: 0 }] {
        let [size, origin, grading] = [[4.0, 2.0, 2.0], [0.0; 3], [1.0; 3]];
        let described = stiction::mesh::Block { size, cells: [2, 2, 1], origin, grading, element };
        let mesh = stiction::mesh::block(&described).unwrap();
        let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("bent-{element:?}.vtu"));
        let mut values: Vec<f64> = mesh.nodes.iter().map(|&x| 120.0 + dot(slope, x)).collect();
        let written = |values: &[f64]| {
            write(&path, &Grid::from_mesh(&mesh), &[Array::scalar("T", values)], &[]).unwrap();
            format!("[mesh]\nfile = {:?}\n{STEEL}", path.display().to_string())
        };
        for value in [expression, "{ array = \"T\" }"] {
            let run = solved(&(written(&values) + &heat(value)));
            assert!(error(&run) < 1e-10, "{element:?} {value}: {}", error(&run));
            stress(&run).iter().flatten().for_each(|&s| is(s, 0.0, 240.0));
        }
        // Programs for linear fields leave the middles of edges out: that is no temperature.
        let middle = mesh.cell(0).1[10 - 1] as usize;
        values[middle] = f64::NAN;
        let message = refused(&(written(&values) + &heat("{ array = \"T\" }")));
        assert!(message.contains("at every node of the heated cells, the middles of their edges"), "{message}");
    }
    let linear = |n: usize| {
        error(&solved(&(block([4.0, 2.0, 2.0], [2 * n, n, n], "element = \"hex8\"") + STEEL + &heat(expression))))
    };
    let (coarse, fine) = (linear(2), linear(4));
    assert!(coarse > 1e-3 && coarse / fine > 2.5, "{coarse} {fine}");
}

/// The turned axes expand by their own coefficients: e = sum a_k e_k e_k'.
#[test]
fn an_orthotropic_body_expands_along_its_own_axes_without_stress() {
    let (sine, cosine) = 30f64.to_radians().sin_cos();
    let text = block([4.0, 2.0, 2.0], [2, 2, 2], "element = \"hex8\"")
        + WOOD
        + &format!("axes = [[{cosine}, {sine}, 0], [{}, {cosine}, 0]]\nexpansion = [1e-5, 5e-5, 9e-5]\n", -sine)
        + POINTS
        + "[[load]]\ntemperature = \"50*t\"\n";
    let run = solved(&text);
    stress(&run).iter().flatten().for_each(|&s| is(s, 0.0, 1.0));
    let along = 50.0 * (1e-5 * cosine * cosine + 5e-5 * sine * sine);
    let shear = 50.0 * 2.0 * (1e-5 - 5e-5) * sine * cosine;
    is(at(&run, [4.0, 0.0, 0.0])[0], 4.0 * along, 1e-2);
    is(at(&run, [0.0, 2.0, 0.0])[0], 2.0 * shear, 1e-2);
    is(at(&run, [0.0, 0.0, 2.0])[2], 2.0 * 50.0 * 9e-5, 1e-2);
}

/// A gap of 2e-3 before a bar of length 4 closes at dT = g/(alpha L) = 41.67; afterwards the wall carries
/// E A (alpha dT - g/L). On the way the work of the temperature is the elastic energy.
#[test]
fn a_heated_bar_closes_its_gap_and_then_presses() {
    let text = |temperature: &str, steps: &str| {
        block([4.0, 2.0, 2.0], [4, 2, 2], "element = \"hex8\"")
            + STEEL
            + CORNER
            + &format!(
                "[[load]]\ntemperature = \"{temperature}\"\n[[contact]]\non = \"x-max\"\n\
                against = {{ plane = {{ point = [4.002, 0, 0], normal = [-1, 0, 0] }} }}\nfriction = \"none\"\n{steps}"
            )
    };
    let force = |run: &(Outcome, Prepared)| stiction::run::totals(&run.1, &run.0).normal_force;
    is(force(&solved(&text("20 + 41.6*t", ""))), 0.0, 1.0);
    let pressed = 200e3 * 4.0 * (12e-6 * 100.0 - 2e-3 / 4.0);
    is(force(&solved(&text("20 + 100*t", ""))), pressed, pressed);
    let run = solved(&text("20 + 100*t", "[[step]]\nuntil = 1\nincrements = 3\n"));
    is(force(&run), pressed, pressed);
    let last = run.0.steps.last().unwrap();
    let wanted = 0.5 * pressed * pressed / 4.0 / 200e3 * 4.0;
    is(last.balance.elastic, wanted, wanted);
    // The force of the step in which the gap closes is taken as its mean: the drift of closing, first order in time.
    assert!(last.balance.drift.abs() < 0.2 * wanted, "{last:?}");
    // Held from the start there is nothing to close, and the balance is exact.
    let held = text("20 + 100*t", "[[step]]\nuntil = 1\nincrements = 3\n")
        .replace("4.002", "4")
        .replace("\"none\"", "\"bonded\"");
    let run = solved(&held);
    let last = run.0.steps.last().unwrap().balance;
    assert!(last.drift.abs() < 1e-9 * last.elastic, "{last:?}");
}

#[test]
fn temperatures_are_refused_where_they_mean_nothing() {
    let body = block([4.0, 2.0, 2.0], [2, 2, 2], "element = \"hex8\"");
    let load = "[[fix]]\non = \"x-min\"\n[[load]]\ntemperature = 50\n";
    let text = body.clone() + WOOD + load;
    let message = refused(&text);
    assert!(message.contains("material \"wood\", which has no expansion") && message.contains("[[load]]"), "{message}");
    let message = refused(&(body.clone() + STEEL + load + "[[load]]\ntemperature = 60\n"));
    assert!(message.contains("8 cells have a temperature already"), "{message}");
    let message = refused(&(body.clone() + STEEL + &load.replace("50", "\"sqrt(1 - x)\"")));
    assert!(message.contains("\"sqrt(1 - x)\" is NaN at (") && message.contains("finite"), "{message}");
    let message = refused(&(body + STEEL + &load.replace("50", "{ array = \"T\" }")));
    assert!(message.contains("no array \"T\"") && message.contains(".vtu"), "{message}");
}

/// A block on springs alone: the springs give by p/k, the block by p h/E on top of it, and a shear on the foot by s/k_t.
#[test]
fn a_block_on_springs_sinks_and_slides_by_the_load_over_their_stiffness() {
    for element in ["element = \"hex8\"", "element = \"tet4\""] {
        let text = block([4.0, 2.0, 3.0], [2, 2, 3], element)
            + "[materials.m]\nyoung = 1000\npoisson = 0\n[[spring]]\non = \"z-min\"\nnormal = 5\ntangential = 2\n\
               [[load]]\non = \"z-max\"\npressure = 7\n[[load]]\non = \"z-min\"\ntraction = [1, -3, 0]\n";
        let run = solved(&text);
        let top = at(&run, [4.0, 2.0, 3.0]);
        for (value, wanted) in top.into_iter().zip([0.5, -1.5, -7.0 / 5.0 - 7.0 * 3.0 / 1000.0]) {
            is(value, wanted, 1.0);
        }
        let body = &run.0.solution.certificate.bodies[0];
        for (value, wanted) in body.support.into_iter().zip([-8.0, 24.0, 56.0]) {
            is(value, wanted, 56.0);
        }
        assert!(body.balance.force < 1e-12 && body.balance.moment < 1e-12);
    }
}

/// Springs beside contact: a frictionless foot, held against sliding by the springs at its side only.
#[test]
fn springs_hold_what_contact_does_not() {
    let text = |spring: &str| {
        block([4.0, 2.0, 3.0], [4, 2, 3], "element = \"hex8\"")
            + "[materials.m]\nyoung = 1000\npoisson = 0.3\n[[load]]\non = \"z-max\"\ntraction = [0.2, 0, -7]\n[[contact]]\non = \"z-min\"\n\
               against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\nfriction = \"none\"\n"
            + spring
    };
    let message = refused(&text(""));
    assert!(message.contains("no spring and no contact resists"), "{message}");
    let run = solved(&text("[[spring]]\non = \"x-min\"\nnormal = 0.5\ntangential = 0.1\n"));
    let body = &run.0.solution.certificate.bodies[0];
    is(body.support[0], -0.2 * 8.0, 1.6);
    assert!(body.balance.force < 1e-9 && body.balance.moment < 1e-9);
    // Nothing is turned and nothing is lost: what the springs along z carry, the floor does not.
    is(body.support[2] + body.contact[2], 56.0, 56.0);
    let message = refused(&text("[[spring]]\non = \"x-min\"\nnormal = 0.5\n"));
    assert!(message.contains("translation along y"), "{message}");
}

/// What heat does to a body that nothing but the floor holds: it grows, and its weight stays what the floor carries.
#[test]
fn a_heated_block_that_only_lies_there_expands_and_keeps_its_weight() {
    let text = |gravity: &str, friction: &str| {
        block([4.0, 2.0, 2.0], [4, 2, 2], "element = \"hex8\"")
            + &STEEL.replace("young", "density = 8e-9\nyoung")
            + "[[load]]\ntemperature = 120\n"
            + gravity
            + &format!(
                "[[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\nfriction = {friction}\n"
            )
    };
    let run = solved(&text("[[load]]\ngravity = [0, 0, -9810]\n", "{ coulomb = 0.2 }"));
    let weight = 8e-9 * 9810.0 * 16.0;
    let force = stiction::run::totals(&run.1, &run.0).normal_force;
    assert!((force / weight - 1.0).abs() < 1e-7, "{force} {weight}");
    let (low, high) = (at(&run, [0.0, 0.0, 2.0]), at(&run, [4.0, 2.0, 2.0]));
    for (c, length) in [4.0, 2.0].into_iter().enumerate() {
        assert!(((high[c] - low[c]) / (12e-6 * 100.0 * length) - 1.0).abs() < 1e-3);
    }
}

/// Temperatures at the points of a mesh file are those of the expression they were made with, and half of the way to them
/// is half of it.
#[test]
fn temperatures_at_points_act_like_their_expression() {
    use stiction::io::vtu::{Array, Grid, write};
    use stiction::mesh::BlockElement::{Hex8, Hex20, Tet4Six, Tet10Six};
    for element in [Hex8, Tet4Six, Hex20, Tet10Six] {
        let [size, origin, grading] = [[4.0, 2.0, 2.0], [0.0; 3], [1.0; 3]];
        let described = stiction::mesh::Block { size, cells: [4, 2, 2], origin, grading, element };
        let mesh = stiction::mesh::block(&described).unwrap();
        let values: Vec<f64> = mesh.nodes.iter().map(|x| 20.0 + 30.0 * x[0] - 10.0 * x[1]).collect();
        let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("heated-{element:?}.vtu"));
        // Linear cells take their mean, which is the value at their centre.
        let centre = |nodes: &[u32]| nodes.iter().map(|&n| values[n as usize]).sum::<f64>() / nodes.len() as f64;
        let of_cells: Vec<f64> = mesh.cell_iter().map(|(_, nodes)| centre(nodes)).collect();
        let cells = [Array::scalar("centre", &of_cells)];
        write(&path, &Grid::from_mesh(&mesh), &[Array::scalar("T", &values)], &cells).unwrap();
        let text = |temperature: &str| {
            format!(
                "[mesh]\nfile = {:?}\n{STEEL}[[fix]]\non = {{ box = [[0, 0, 0], [0, 2, 2]] }}\n[[load]]\ntemperature = {temperature}\n",
                path.display().to_string()
            )
        };
        let mut pairs = vec![
            ("{ array = \"T\" }", "\"20 + 30*x - 10*y\""),
            ("{ array = \"T\", ramp = \"t/2\" }", "\"20 + 15*x - 5*y\""),
        ];
        if matches!(element, Hex8 | Tet4Six) {
            pairs.push(("{ array = \"centre\" }", "\"20 + 30*x - 10*y\""));
        }
        for (array, expression) in pairs {
            let (a, b) = (solved(&text(array)), solved(&text(expression)));
            for (u, v) in displacement(&a).into_iter().zip(displacement(&b)) {
                (0..3).for_each(|c| is(u[c], v[c], 1e-3));
            }
            assert!(at(&a, [4.0, 0.0, 0.0])[0] > 1e-3);
        }
        let message = refused(&text("{ array = \"t\" }"));
        assert!(message.contains("did you mean \"T\"?") || message.contains("its point arrays are \"T\""), "{message}");
    }
}
