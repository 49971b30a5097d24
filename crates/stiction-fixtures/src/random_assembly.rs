//! Assemblies drawn at random: two or three bodies of unlike elements and materials on one another, with gaps and overlaps,
//! springs, any law of friction, held by supports or by contact alone, in one load or in load steps. For the benchmark
//! that counts which are solved and for the campaign that judges the answers by other code.

use crate::random_case::Draw;

/// Every element; what occurs twice is drawn twice as often.
pub const ELEMENTS: [&str; 6] = ["tet4", "hex8", "tet10", "hex20", "tet4", "hex8"];

/// A block: where it begins and ends, before it is turned about z.
struct Place {
    low: [f64; 3],
    high: [f64; 3],
}

impl Place {
    fn middle(&self, axis: usize) -> f64 {
        0.5 * (self.low[axis] + self.high[axis])
    }

    fn size(&self, axis: usize) -> f64 {
        self.high[axis] - self.low[axis]
    }
}

/// What all parts of an assembly share.
struct Scales {
    /// How far bodies are moved, length.
    travel: f64,
    /// Pressure of the loads, stress.
    pressure: f64,
    young: f64,
    stepped: bool,
}

impl Scales {
    /// A load that rises in the first unit of time.
    fn rises(&self, value: f64) -> String {
        if self.stepped { format!("\"{value:e}*min(t, 1)\"") } else { format!("{value:e}") }
    }

    /// A load that comes in the second unit of time, or comes and goes.
    fn follows(&self, value: f64, returns: bool) -> String {
        match (self.stepped, returns) {
            (false, _) => format!("{value:e}"),
            (true, false) => format!("\"{value:e}*max(0, t - 1)\""),
            (true, true) => format!("\"{value:e}*sin(pi*max(0, t - 1))\""),
        }
    }
}

/// A law, and the share of the pressure that it can hold.
fn law(d: &mut Draw, pressure: f64) -> (String, f64) {
    let coefficient = match d.unit() {
        x if x < 0.4 => d.between(0.0, 0.6),
        x if x < 0.8 => d.between(0.0, 1.5),
        _ => d.between(0.0, 3.0),
    };
    match d.unit() {
        x if x < 0.1 => ("\"none\"".into(), 0.0),
        x if x < 0.2 => ("\"bonded\"".into(), 1.0),
        x if x < 0.3 => {
            let bound = d.unit();
            (format!("{{ tresca = {:e} }}", bound * pressure), bound)
        }
        x if x < 0.7 => (format!("{{ coulomb = {coefficient} }}"), coefficient),
        x if x < 0.85 => {
            let limit = d.between(0.1, 2.0);
            (format!("{{ coulomb = {coefficient}, limit = {:e} }}", limit * pressure), f64::min(coefficient, limit))
        }
        _ => {
            let across = coefficient * d.one(&[0.2, 0.5, 2.0]);
            let law = format!("{{ coulomb = [{coefficient}, {across}], direction = [1, {:.3}, 0] }}", d.unit());
            (law, f64::min(coefficient, across))
        }
    }
}

fn body(d: &mut Draw, case: &mut String, name: &str, place: &Place, scales: &Scales, elements: &[&str]) {
    let element = d.one(elements);
    let cells = d.cells(if element == "tet10" || element == "hex20" { 3 } else { 4 });
    let size = [0, 1, 2].map(|axis| place.size(axis));
    let grading = if d.unit() < 0.2 { [0; 3].map(|_| d.one(&[0.5, 1.0, 3.0])) } else { [1.0; 3] };
    *case += &format!(
        "[mesh.parts.{name}]\nblock = {{ size = {size:?}, cells = {cells:?}, element = \"{element}\", origin = {:?}, \
         grading = {grading:?} }}\n",
        place.low
    );
    if name != "a" && d.unit() < 0.25 {
        let (x, y, degrees) = (place.middle(0), place.middle(1), d.between(-45.0, 45.0));
        *case += &format!("turn = {{ axis = [0, 0, 1], degrees = {degrees:.2}, point = [{x}, {y}, 0] }}\n");
    }
    let young = scales.young * if d.unit() < 0.5 { 1.0 } else { 10f64.powf(d.between(-2.0, 2.0)) };
    let weight = scales.pressure / place.size(2) * d.one(&[0.01, 1.0]);
    *case += &format!("[materials.{name}]\non = \"{name}\"\nyoung = {young}\npoisson = {}\n", d.one(&[0.0, 0.3, 0.4]));
    *case += &format!("density = {weight:e}\n");
}

/// The contact of two surfaces, and the share of the pressure that friction holds.
fn contact(d: &mut Draw, case: &mut String, on: &str, against: &str, scales: &Scales) -> f64 {
    let (law, holds) = law(d, scales.pressure);
    *case += &format!("[[contact]]\non = \"{on}\"\nagainst = {against}\nfriction = {law}\n");
    if against.starts_with('"') && d.unit() < 0.2 {
        let gap = format!("{:e}", d.between(-1.0, 1.0) * scales.travel);
        *case += &format!("gap = {}\n", d.one(&["\"closed\"", &gap]));
    }
    holds
}

/// What keeps a body where it is, besides contact.
#[derive(Clone, Copy, PartialEq)]
enum Held {
    Not,
    BySprings,
    ByFixing,
}

/// Draws the supports of the body `name`.
fn supports(d: &mut Draw, case: &mut String, name: &str, scales: &Scales, size: f64) -> Held {
    let stiffness = scales.young / size * 10f64.powf(d.between(-3.0, 1.0));
    match d.unit() {
        x if x < 0.45 => return Held::Not,
        x if x < 0.75 => {
            let (face, components) = d.one(&[("x-min", "xyz"), ("y-min", "xy")]);
            *case += &format!("[[fix]]\non = \"{name}.{face}\"\ncomponents = \"{components}\"\n");
            return Held::ByFixing;
        }
        _ => {
            // Springs along one direction alone would leave another to friction, which the loads of a held body exceed.
            let across = stiffness * d.between(0.1, 1.0);
            *case += &format!("[[spring]]\non = \"{name}.x-min\"\nnormal = {stiffness:e}\ntangential = {across:e}\n");
        }
    }
    Held::BySprings
}

/// The case of a seed: lengths in mm, two or three bodies of these `elements`.
pub fn text(seed: u64, elements: &[&str]) -> String {
    let d = &mut Draw::seeded(seed);
    let size = [0; 3].map(|_| d.one(&[8.0, 20.0, 50.0]));
    let young = 10f64.powf(d.between(1.0, 6.0));
    let least = size.into_iter().fold(f64::INFINITY, f64::min);
    let scales = Scales {
        travel: least * 10f64.powf(d.between(-5.0, -2.3)),
        pressure: young * 10f64.powf(d.between(-5.0, -3.5)),
        young,
        stepped: d.unit() < 0.3,
    };
    let case = &mut String::new();
    let mut holds = f64::INFINITY;

    // The lowest body on a foundation, on a rigid obstacle or held.
    let below = Place { low: [0.0; 3], high: size };
    body(d, case, "a", &below, &scales, elements);
    match d.unit() {
        x if x < 0.45 => *case += "[[fix]]\non = \"a.z-min\"\n",
        x if x < 0.6 => *case += "[[fix]]\non = \"a.x-min\"\n",
        x if x < 0.75 => {
            let stiffness = young / size[2] * 10f64.powf(d.between(-2.0, 1.0));
            let tangential = stiffness * d.between(0.1, 1.0);
            *case += &format!("[[spring]]\non = \"a.z-min\"\nnormal = {stiffness:e}\ntangential = {tangential:e}\n");
        }
        x if x < 0.9 => {
            let plane = "{ plane = { point = [0, 0, 0], normal = [0, 0, 1] } }";
            holds = holds.min(contact(d, case, "a.z-min", plane, &scales));
        }
        _ => {
            let radius = d.between(3.0, 30.0) * size[0].max(size[1]);
            let (x, y) = (below.middle(0), below.middle(1));
            let sphere = format!("{{ sphere = {{ center = [{x}, {y}, {}], radius = {radius} }} }}", -radius);
            holds = holds.min(contact(d, case, "a.z-min", &sphere, &scales));
            *case += "[[fix]]\non = \"a.y-max\"\ncomponents = \"xy\"\n";
        }
    }

    // One or two bodies on it, one on another or side by side.
    let three = d.unit() < 0.4;
    let beside = three && d.unit() < 0.5;
    let mut under = ("a", below);
    for (name, share) in [("b", [0.0, 0.48]), ("c", [0.52, 1.0])].into_iter().take(1 + usize::from(three)) {
        let apart = match d.unit() {
            x if x < 0.5 => 0.0,
            x if x < 0.75 => scales.travel * d.unit(),
            _ => -scales.travel * d.unit(),
        };
        let share = if beside { share } else { [d.between(-0.1, 0.2), d.between(0.8, 1.1)] };
        let (low, high) = (under.1.low, under.1.high);
        let (y, z, height) = ([d.between(-0.1, 0.2), d.between(0.8, 1.1)], high[2] + apart, d.one(&[0.3, 1.0, 1.5]));
        let at = |axis: usize, share: f64| low[axis] + share * (high[axis] - low[axis]);
        let place = Place {
            low: [at(0, share[0]), at(1, y[0]), z],
            high: [at(0, share[1]), at(1, y[1]), z + height * size[0].min(size[1])],
        };
        body(d, case, name, &place, &scales, elements);
        let against = format!("\"{}.z-max\"", under.0);
        holds = holds.min(contact(d, case, &format!("{name}.z-min"), &against, &scales));
        let held = supports(d, case, name, &scales, place.size(0));
        let top = beside || !three || name == "c";
        if top {
            load(d, case, name, &place, &scales, held, holds);
        }
        if !beside {
            under = (name, place);
        }
    }
    if d.unit() < 0.5 {
        *case += "[[load]]\ngravity = [0, 0, -1]\n";
    }
    if scales.stepped {
        let increments = d.one(&[1, 2]);
        *case += &format!("[[step]]\nuntil = 1\nincrements = {increments}\n[[step]]\nuntil = 2\n");
        *case += &format!("increments = {}\n", d.one(&[1, 2, 4]));
    }
    std::mem::take(case)
}

/// What presses and shears a body on top.
fn load(d: &mut Draw, case: &mut String, name: &str, place: &Place, scales: &Scales, held: Held, holds: f64) {
    let returns = d.unit() < 0.3;
    if d.unit() < 0.35 && held != Held::ByFixing {
        let along = scales.follows(d.between(-1.0, 1.0) * scales.travel, returns);
        let [across, down] =
            [d.between(-0.5, 0.5), -d.between(0.1, 1.5)].map(|share| scales.rises(share * scales.travel));
        *case += &format!("[[fix]]\non = \"{name}.z-max\"\nvalue = [{along}, {across}, {down}]\n");
        return;
    }
    *case += &format!("[[load]]\non = \"{name}.z-max\"\npressure = {}\n", scales.rises(scales.pressure));
    // A body that nothing holds neither slides nor tips.
    let share = f64::min(0.5 * holds.min(1.5), 0.25 * place.size(0) / place.size(2));
    let free = held == Held::Not;
    let along = scales.pressure * d.between(-1.0, 1.0) * if free { share } else { 1.0 };
    let traction = [along, if free { 0.0 } else { 0.3 * along }].map(|value| scales.follows(value, returns));
    *case += &format!("[[load]]\non = \"{name}.z-max\"\ntraction = [{}, {}, 0]\n", traction[0], traction[1]);
}
