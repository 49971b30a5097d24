//! Linear equations between displacements.

use stiction::certificate::certify;
use stiction::run::totals;
use stiction_fixtures::case_run::{at, block, displacement, is, refused, solved};

/// Two columns of stiffness E A/L = 1000 each, a unit cube and one beside it, both held at their feet; 10 pull at the first.
fn columns(equations: &str, path: &str) -> String {
    let part = |name: &str, x: f64| {
        let mesh = block([1.0, 1.0, 1.0], [1, 1, 1], "element = \"hex8\"");
        mesh.replacen("[mesh]", &format!("[mesh.parts.{name}]"), 1) + &format!("move = [{x}, 0, 0]\n")
    };
    part("a", 0.0)
        + &part("b", 2.0)
        + "[materials.soft]\nyoung = 1000\npoisson = 0\n[[fix]]\non = [\"a.z-min\", \"b.z-min\"]\n\
           [[load]]\non = \"a.z-max\"\ntraction = [0, 0, 10]\n"
        + equations
        + &format!("[solver]\npath = \"{path}\"\n")
}

/// The sum over the four nodes of each top, times a factor, adds up to a value.
fn tops([a, b]: [f64; 2], value: &str) -> String {
    format!(
        "[[equation]]\nterms = [{{ on = \"a.z-max\", along = \"z\", factor = {a} }}, {{ on = \"b.z-max\", along = \"z\", factor = {b} }}]\n\
         value = {value}\n"
    )
}

/// With k u_a = F - a p, k u_b = -b p and a u_a + b u_b = c: p = (a F - c k)/(a² + b²).
#[test]
fn coupled_columns_share_a_load_as_levers_do() {
    for ([a, b], value) in [([1.0, -1.0], 0.0), ([2.0, 1.0], 0.0), ([-0.5, 3.0], 0.01)] {
        let force = (a * 10.0 - value * 1000.0) / (a * a + b * b);
        for path in ["dense", "solves", "auto"] {
            let run = solved(&columns(&tops([a, b], &format!("{}", 4.0 * value)), path));
            is(at(&run, [0.0, 0.0, 1.0])[2], (10.0 - a * force) / 1000.0, 0.01);
            is(at(&run, [3.0, 1.0, 1.0])[2], -b * force / 1000.0, 0.01);
        }
    }
}

#[test]
fn an_answer_that_misses_an_equation_is_refused() {
    let run = solved(&columns(&tops([1.0, -1.0], "0"), "auto"));
    let (problem, solution) = (&run.1.problem, &run.0.solution);
    assert!(certify(problem, &solution.u, &solution.lambda, 1e-8).passed);
    // The equilibrium of other tops.
    let other = solved(&columns(&tops([1.0, -1.0 - 1e-6], "0"), "auto")).0.solution;
    assert!(!certify(problem, &other.u, &other.lambda, 1e-8).passed);
    let mut lambda = solution.lambda.clone();
    lambda.iter_mut().for_each(|force| *force *= 1.0 + 1e-6);
    assert!(!certify(problem, &solution.u, &lambda, 1e-8).passed);
}

/// A block pressed by a force on a top that is kept level, and drawn along the floor: both paths agree, the top is level, and
/// floor and friction carry what the load says. The equations are a chain: each node with the one before it.
#[test]
fn a_level_top_on_a_floor_is_found_by_both_paths() {
    let nodes: Vec<[usize; 2]> = (0..25).map(|n| [n % 5, n / 5]).collect();
    let on =
        |[i, j]: [usize; 2]| format!("on = {{ point = [{}, {}, 1] }}, along = \"z\"", 0.5 * i as f64, 0.25 * j as f64);
    let equation = |pair: &[[usize; 2]]| {
        format!("[[equation]]\nterms = [{{ {} }}, {{ {}, factor = -1 }}]\n", on(pair[0]), on(pair[1]))
    };
    let level: String = nodes.windows(2).map(equation).collect();
    let text = |path: &str| {
        block([2.0, 1.0, 1.0], [4, 4, 4], "element = \"hex8\"")
            + "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[fix]]\non = { point = [0, 0, 1] }\ncomponents = \"xy\"\n\
               [[fix]]\non = { point = [2, 0, 1] }\ncomponents = \"y\"\n\
               [[load]]\non = \"z-max\"\ntraction = [0, 0, \"-100*x\"]\n[[load]]\non = \"x-max\"\ntraction = [60, 0, 0]\n\
               [[contact]]\non = \"z-min\"\nfriction = { coulomb = 0.2 }\n\
               against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n"
            + &level
            + &format!("[solver]\npath = \"{path}\"\n")
    };
    let [direct, multigrid] = ["dense", "multigrid"].map(|path| solved(&text(path)));
    for run in [&direct, &multigrid] {
        let top = at(run, [0.0, 0.0, 1.0])[2];
        nodes.iter().for_each(|&[i, j]| is(at(run, [0.5 * i as f64, 0.25 * j as f64, 1.0])[2], top, 1e2 * top));
        let all = totals(&run.1, &run.0);
        is(all.normal_force, 200.0, 1e2 * 200.0);
        assert_eq!(all.points, 25);
    }
    for (a, b) in displacement(&direct).iter().zip(displacement(&multigrid)) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-9), "{a:?} {b:?}");
    }
}

/// Values follow the time, and slanted directions at a node are held at once.
#[test]
fn values_follow_the_time_along_slanted_directions() {
    let at_corner = |along: &str, value: &str| {
        format!(
            "[[equation]]\nterms = [{{ on = {{ point = [1, 1, 1] }}, along = {along}, factor = 2 }}]\nvalue = \"{value}\"\n"
        )
    };
    let text = block([1.0, 1.0, 1.0], [2, 2, 2], "element = \"hex8\"")
        + "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[fix]]\non = \"z-min\"\n"
        + &at_corner("[3, 4, 0]", "2e-3*t")
        + &at_corner("[1, 0, 0]", "-1e-3*t")
        + &at_corner("[0, 1, 2]", "4e-3")
        + "[[step]]\nuntil = 1\n[[step]]\nuntil = 3\n";
    let run = solved(&text);
    let u = at(&run, [1.0, 1.0, 1.0]);
    let (x, t) = (-0.5e-3 * 3.0, 3.0);
    is(u[0], x, 1e-3);
    is(0.6 * u[0] + 0.8 * u[1], 1e-3 * t, 1e-3);
    is((u[1] + 2.0 * u[2]) / 5f64.sqrt(), 2e-3, 1e-3);
}

#[test]
fn equations_that_repeat_or_hold_nothing_are_refused() {
    let twice = tops([1.0, -1.0], "0") + &tops([-2.0, 2.0], "0.01");
    assert!(refused(&columns(&twice, "auto")).contains("equations above it hold all of it"));
    // The third is the difference of the first two.
    let corner = |x: f64| format!("{{ on = {{ point = [{x}, 0, 1] }}, along = \"x\" }}");
    let pair = |a: f64, b: f64| {
        format!(
            "[[equation]]\nterms = [{}, {}]\n",
            corner(a),
            corner(b).replace(" }}", ", factor = -1 }}").replace("\"x\" }", "\"x\", factor = -1 }")
        )
    };
    let circle = pair(0.0, 1.0) + &pair(1.0, 2.0) + &pair(0.0, 2.0);
    assert!(refused(&columns(&circle, "auto")).contains("equations above it hold all of it"));
    let held = "[[equation]]\nterms = [{ on = \"a.z-min\", along = \"x\" }]\n";
    assert!(refused(&columns(held, "auto")).contains("supports"));
    let parse = |equation: &str| {
        stiction::io::case::parse(&columns(equation, "auto"), "case.toml", &[]).map(|_| ()).unwrap_err().to_string()
    };
    assert!(parse("[[equation]]\nterms = []\n").contains("no terms"));
    assert!(parse("[[equation]]\nterms = [{ on = \"a.z-max\", along = \"w\" }]\n").contains("along"));
    assert!(parse("[[equation]]\nterms = [{ on = \"a.z-max\", along = \"x\", factor = 0 }]\n").contains("factor zero"));
    let refined = tops([1.0, -1.0], "0") + "[accuracy]\nenergy = 0.1\n";
    assert!(parse(&refined).contains("acts by forces at nodes"));
}
