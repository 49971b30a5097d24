//! `[[contact]]`: surfaces, obstacles and friction.

use std::path::Path;

use super::data::{AgainstSpec, ContactSpec, Region, StepSpec, SurfaceFile};
use super::during::During;
use super::read_body::{field, fields};
use super::read_bolt::{during, step_called};
use super::read_mesh::placing;
use super::read_region::{extended_region, groups};
use super::tree::Node;
use super::view::View;
use crate::Error;
use crate::contact::{
    Across, Coefficient, Cohesion, CoulombLaw, InitialGap, InterfaceStiffness, Obstacle, Role, Side, SurfaceFriction,
};
use crate::fem::Field;
use crate::io::expression::{VARIABLES, compile};

/// All contacts; their names differ. Relative paths start at `folder`.
pub(super) fn contacts(case: &View, folder: &Path, steps: &[StepSpec]) -> Result<Vec<ContactSpec>, Error> {
    let mut contacts: Vec<ContactSpec> = Vec::new();
    for (i, (_, table)) in case.tables("contact").iter().enumerate() {
        let contact = contact(table, i, folder, steps)?;
        if contacts.iter().any(|other| other.name == contact.name) {
            let key = if table.given("name").is_some() { "name" } else { "on" };
            let what = format!("two contacts are called {:?}", contact.name);
            return Err(table.error(key, what, "give this one another name, as in name = \"sole\""));
        }
        contacts.push(contact);
    }
    Ok(contacts)
}

fn contact(table: &View, i: usize, folder: &Path, steps: &[StepSpec]) -> Result<ContactSpec, Error> {
    let on = extended_region(table, "contact")?.unwrap_or(Region::Groups(Vec::new()));
    let name = match (&on, table.given("name")) {
        (_, Some(_)) => table.text("name"),
        (Region::Groups(groups), None) => groups.iter().map(|g| g.0.as_str()).collect::<Vec<_>>().join("+"),
        _ => format!("contact {}", i + 1),
    };
    let (against, motion, friction) = (against(table, folder)?, motion(table)?, friction(table)?);
    let friction_spot = table.given("friction").map_or(table.spot(), |node| table.source.spot(&node.at));
    let wear = table.given("wear").map(|_| table.number("wear"));
    let (stiffness, initial_stress) = (stiffness(table), initial_stress(table)?);
    let (during, spot) = (during(table, steps)?, table.spot());
    let names = table.given("without").map_or(&[][..], Node::items).iter().filter_map(Node::text);
    let without = names.map(|name| step_called(table, "without", name, steps)).collect::<Result<Vec<_>, _>>()?;
    let (first, last) = (during.from.unwrap_or(0), during.until.unwrap_or(steps.len().saturating_sub(1)));
    if !without.is_empty() && (first..=last).all(|step| without.contains(&step)) {
        let what = "this contact is out in all steps";
        return Err(table.error("without", what, "leave a step out of `without`, or take the contact out"));
    }
    let bonded_until = bonded_until(table, &friction, during, steps)?;
    Ok(ContactSpec {
        name,
        on,
        against,
        motion,
        friction,
        friction_spot,
        stiffness,
        initial_stress,
        during,
        without,
        bonded_until,
        wear,
        spot,
    })
}

/// The step through which the surfaces are bonded, if they come apart later.
fn bonded_until(
    table: &View,
    friction: &SurfaceFriction,
    during: During,
    steps: &[StepSpec],
) -> Result<Option<usize>, Error> {
    if table.given("bonded_until").is_none() {
        return Ok(None);
    }
    let refuse = |what: &str, remedy: &str| Err(table.error("bonded_until", what, remedy));
    let step = step_called(table, "bonded_until", &table.text("bonded_until"), steps)?;
    let last = during.until.unwrap_or(steps.len().saturating_sub(1));
    if *friction == SurfaceFriction::Bonded {
        return refuse("`friction` bonds the surfaces in all steps", "give the friction that holds afterwards");
    }
    if step >= last {
        return refuse("the surfaces are bonded in all steps", "give friction = \"bonded\" instead");
    }
    if during.from.is_some_and(|from| from > 0) {
        return refuse("this contact begins with a later step than the first", "take `from` or `bonded_until` out");
    }
    table.refuse(&["stiffness"], "lets the interface yield, which bonded surfaces do not", "")?;
    Ok(Some(step))
}

fn stiffness(table: &View) -> Option<InterfaceStiffness> {
    let of = table.table("stiffness")?;
    let normal = of.number("normal");
    let tangential = of.given("tangential").map_or(normal, |_| of.number("tangential"));
    Some(InterfaceStiffness { normal, tangential })
}

/// Components as the case lists them: xx, yy, zz, yz, xz, xy.
fn initial_stress(table: &View) -> Result<Option<[Field; 6]>, Error> {
    let Some(node) = table.given("initial_stress") else { return Ok(None) };
    let mut stress = [const { Field::Constant(0.0) }; 6];
    for (component, item) in stress.iter_mut().zip(node.items()) {
        *component = field(table, item, &VARIABLES[..3])?;
    }
    Ok(Some(stress))
}

fn against(table: &View, folder: &Path) -> Result<AgainstSpec, Error> {
    let names = match table.given("against") {
        Some(node) if node.entries().is_empty() => groups(table.source, node),
        _ => Vec::new(),
    };
    if names.is_empty() {
        let why = "is for contact between two surfaces, but `against` is a rigid obstacle";
        table.refuse(&["gap", "slave", "search"], why, ", or name a group in `against`")?;
        return match surface_file(table, folder)? {
            Some(file) => Ok(AgainstSpec::File(file)),
            None => Ok(AgainstSpec::Obstacle(obstacle(table)?)),
        };
    }
    let given = |key: &str| table.given("gap").and_then(|node| node.get(key));
    let within = given("closed_within").and_then(Node::number);
    let closed_at = given("closed_at").map(|node| Region::Groups(groups(table.source, node)));
    let gap = match table.given("gap").and_then(|node| node.number()) {
        Some(gap) => InitialGap::Uniform(gap),
        None if within.is_some() => InitialGap::ClosedWithin(within.unwrap_or_default()),
        None if table.text("gap") == "closed" => InitialGap::Closed,
        None => InitialGap::AsMeshed,
    };
    let slave = table.given("slave").map(|_| if table.text("slave") == "on" { Role::On } else { Role::Against });
    let search = table.given("search").map(|_| table.number("search"));
    Ok(AgainstSpec::Surface { region: Region::Groups(names), gap, closed_at, slave, search, widened: None })
}

/// Keys of `against` that belong to `surface`.
const OF_SURFACE: [&str; 5] = ["scale", "turn", "move", "side", "feature_angle"];

fn surface_file(table: &View, folder: &Path) -> Result<Option<SurfaceFile>, Error> {
    let Some(against) = table.table("against") else { return Ok(None) };
    let round = ["sphere", "cylinder"].into_iter().find(|name| against.given(name).is_some());
    if let (Some(round), true) = (round, against.given("side").is_some()) {
        let remedy = format!("move it there, as in {round} = {{ radius = 20, .., side = \"inside\" }}");
        return Err(against.error("side", format!("`side` belongs inside the braces of `{round}`"), remedy));
    }
    if against.given("surface").is_none() {
        let why = "is for an obstacle from a file, but `against` has no `surface`";
        return against.refuse(&OF_SURFACE, why, ", or give surface = \"die.stl\"").map(|()| None);
    }
    Ok(Some(SurfaceFile {
        path: folder.join(against.text("surface")),
        scale: against.number("scale"),
        placing: placing(&against)?,
        side: side(&against),
        feature_angle: against.number("feature_angle"),
    }))
}

fn obstacle(table: &View) -> Result<Obstacle, Error> {
    let against = table.table("against");
    let inside = |name| against.as_ref().and_then(|view| view.table(name));
    if let Some(plane) = inside("plane") {
        Ok(Obstacle::Plane { point: plane.vector("point"), normal: direction(&plane, "normal")? })
    } else if let Some(sphere) = inside("sphere") {
        let (center, radius) = (sphere.vector("center"), sphere.number("radius"));
        Ok(Obstacle::Sphere { center, radius, side: side(&sphere) })
    } else if let Some(cylinder) = inside("cylinder") {
        Ok(Obstacle::Cylinder {
            point: cylinder.vector("point"),
            axis: direction(&cylinder, "axis")?,
            radius: cylinder.number("radius"),
            side: side(&cylinder),
        })
    } else {
        Err(table.error("against", "`against` names no obstacle", "give a plane, a sphere, a cylinder or a surface"))
    }
}

/// How the obstacle moves, if it does.
fn motion(table: &View) -> Result<Option<[Field; 3]>, Error> {
    let Some(against) = table.table("against") else { return Ok(None) };
    against.given("motion").map(|node| fields(&against, node, &["t"])).transpose()
}

fn side(table: &View) -> Side {
    if table.text("side") == "inside" { Side::Inside } else { Side::Outside }
}

/// The vector under `key`, scaled to length one.
pub(super) fn direction(table: &View, key: &str) -> Result<[f64; 3], Error> {
    let v = table.vector(key);
    // Dividing by the largest entry first keeps the squares from overflowing or vanishing.
    let largest = v.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    if largest == 0.0 {
        let what = format!("`{key}` is zero and has no direction");
        return Err(table.error(key, what, format!("write for instance {key} = [0, 0, 1]")));
    }
    let v = v.map(|x| x / largest);
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    Ok(v.map(|x| x / length))
}

fn friction(table: &View) -> Result<SurfaceFriction, Error> {
    let Some(law) = table.table("friction") else {
        return Ok(SurfaceFriction::None);
    };
    if let Some(name) = law.node.text() {
        return Ok(if name == "bonded" { SurfaceFriction::Bonded } else { SurfaceFriction::None });
    }
    if let Some(node) = law.given("coulomb") {
        return coulomb(&law, node);
    }
    let why = "is for coulomb, but the friction is tresca";
    law.refuse(
        &["direction", "limit", "cohesion", "tension", "cohesion_lost"],
        why,
        ", or give friction = { coulomb = ... }",
    )?;
    let bound = law.number("tresca");
    Ok(if law.flag("nodal") { SurfaceFriction::GivenForce(bound) } else { SurfaceFriction::GivenStress(bound) })
}

fn coulomb(law: &View, node: &Node) -> Result<SurfaceFriction, Error> {
    law.refuse(&["nodal"], "is for tresca, but the friction is coulomb, whose coefficient has no unit", "")?;
    let limit = law.given("limit").map(|_| law.number("limit"));
    let coefficient = |node| coefficient(law, node);
    let (along, across) = match (node.items(), law.given("direction")) {
        ([], None) => (coefficient(node)?, None),
        ([], Some(_)) => {
            let what = "`direction` is for two coefficients, but one is given";
            return Err(law.error("direction", what, "write coulomb = [along, across], or take `direction` out"));
        }
        (_, None) => {
            let what = "two coefficients of friction, and no direction along which the first holds";
            return Err(law.error("coulomb", what, "add direction = [1, 0, 0], or give one coefficient"));
        }
        ([first, second, ..], Some(_)) => {
            let direction = direction(law, "direction")?;
            let both = [coefficient(first)?, coefficient(second)?];
            if both.iter().any(|it| matches!(it, Coefficient::OfTime { .. })) {
                let what = "friction that differs by direction changes with the time t";
                return Err(law.error("coulomb", what, "give one coefficient, or two that do not change"));
            }
            let [along, across] = both;
            (along, Some(Across { coefficient: across, direction }))
        }
        ([only], Some(_)) => (coefficient(only)?, None),
    };
    let of_time = matches!(along, Coefficient::OfTime { .. });
    let cohesion = cohesion(law, &[("t", of_time), ("direction", across.is_some()), ("limit", limit.is_some())])?;
    Ok(match (along, across, limit, cohesion) {
        (Coefficient::Field(Field::Constant(c)), None, None, None) => SurfaceFriction::Coulomb(c),
        (coefficient, across, limit, cohesion) => {
            SurfaceFriction::Law(CoulombLaw { coefficient, across, limit, cohesion })
        }
    })
}

/// The strength beside friction, if any; `others` are keys that do not go with it, and whether they are there.
fn cohesion(law: &View, others: &[(&str, bool)]) -> Result<Option<Box<Cohesion>>, Error> {
    let Some(node) = law.given("cohesion") else {
        let why = "belongs to `cohesion`, which is missing";
        law.refuse(&["tension", "cohesion_lost"], why, ", or add cohesion = ...")?;
        return Ok(None);
    };
    if let Some((key, _)) = others.iter().find(|(_, given)| *given) {
        let what = match *key {
            "t" => "a coefficient that changes with the time t, and `cohesion`, in one law of friction".to_string(),
            _ => format!("`{key}` and `cohesion` in one law of friction"),
        };
        return Err(law.error("cohesion", what, "keep one of the two"));
    }
    let strength = |key: &str, node: &Node| match coefficient(law, node)? {
        Coefficient::OfTime { .. } => {
            let what = format!("`{key}` depends on the time t");
            Err(law.error(key, what, "give a number, an expression in x, y, z, or an array"))
        }
        found => Ok(found),
    };
    let tension = law.given("tension").map(|node| strength("tension", node)).transpose()?;
    Ok(Some(Box::new(Cohesion {
        shear: strength("cohesion", node)?,
        tension: tension.unwrap_or(Coefficient::Field(Field::Constant(0.0))),
        brittle: law.text("cohesion_lost") == "on slip",
    })))
}

fn coefficient(law: &View, node: &Node) -> Result<Coefficient, Error> {
    if let Some(name) = node.get("array").and_then(Node::text) {
        return Ok(Coefficient::Array { name: name.into(), values: Vec::new() });
    }
    match field(law, node, &VARIABLES)? {
        Field::Constant(c) if c < 0.0 => {
            let what = format!("a coefficient or a strength is {c}");
            let remedy =
                "the direction of friction follows from the slip, coefficients and strengths are at least zero";
            Err(law.error("coulomb", what, remedy))
        }
        field @ Field::Constant(_) => Ok(Coefficient::Field(field)),
        of_place if node.text().is_some_and(|text| compile(text, &VARIABLES[..3]).is_ok()) => {
            Ok(Coefficient::Field(of_place))
        }
        field => Ok(Coefficient::OfTime { field, values: Vec::new() }),
    }
}
