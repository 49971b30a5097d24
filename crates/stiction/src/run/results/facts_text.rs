//! The posed problem in plain words.

use std::fmt;

use super::pair_text;
use super::rows::{Row, Rows, print};
use crate::contact::{Cohesion, CoulombLaw, Counterpart, InterfaceStiffness, Obstacle, Side, SurfaceFriction};
use crate::io::text::{number, triple};
use crate::run::pose::{ContactFacts, CyclicFacts, Facts, LoadFacts};

/// Width of the labels.
const LABELS: usize = 10;

impl fmt::Display for Facts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        print(f, &problem_rows(self), LABELS)
    }
}

/// The case as the program understood it.
pub(crate) fn problem_rows(facts: &Facts) -> Vec<Row> {
    let mut rows = Rows::default();
    if let Some(units) = &facts.units {
        rows.add("units", units.clone());
    }
    let mesh = &facts.mesh;
    let cells = mesh.cells.iter().map(|c| format!("{} {}", c.count, c.kind.name())).collect::<Vec<_>>().join(", ");
    let bodies = if mesh.bodies == 1 { String::new() } else { format!(", {} bodies", mesh.bodies) };
    rows.add("mesh", format!("{} nodes, {cells} cells, volume {}{bodies}", mesh.nodes, number(mesh.volume)));
    for m in &facts.materials {
        let law = match &m.orthotropic {
            None => format!("young {}, poisson {}", number(m.young), m.poisson),
            Some([young, poisson, shear]) => {
                let [young, poisson, shear] = [young, poisson, shear].map(|values| triple(*values));
                format!("orthotropic, young {young}, poisson {poisson}, shear {shear}")
            }
        };
        let density = if m.density > 0.0 { format!(", density {}", number(m.density)) } else { String::new() };
        let volume = number(m.volume);
        rows.add("material", format!("{}: {law}{density}, {} cells, volume {volume}", m.name, m.cells));
    }
    for fix in &facts.fixes {
        let at = fix.at.map_or(String::new(), |x| format!(" (node at {})", triple(x)));
        rows.add("fix", format!("{}{at}: {} of {} nodes", fix.on, fix.components, fix.nodes));
    }
    for s in &facts.springs {
        let [area, normal, tangential] = [s.area, s.normal, s.tangential].map(number);
        let value = format!("{}: normal {normal}, tangential {tangential} per area, on area {area}", s.on);
        rows.add("spring", value);
    }
    facts.loads.iter().for_each(|load| rows.add("load", describe(load)));
    for b in &facts.bolts {
        let (axis, value) = (triple(b.axis), number(b.value));
        rows.add("bolt", format!("{}: {} {value} along {axis}, cut through {} nodes", b.name, b.by, b.nodes));
    }
    for CyclicFacts { cuts: [on, against], nodes, sectors } in &facts.cyclic {
        let what = format!("{nodes} nodes of {on} follow those of {against}; all results are of one sector");
        rows.add("cyclic", format!("one of {sectors} sectors: {what}"));
    }
    for c in &facts.couplings {
        let how = if c.distributing { "in the mean" } else { "as one rigid body" };
        rows.add("coupling", format!("{}: {} nodes move {how} with the point {}", c.on, c.nodes, triple(c.point)));
    }
    if facts.loads.len() > 1 {
        rows.add("loads", format!("resultant of all {}", triple(facts.resultant())));
    }
    if let Some((increments, end)) = facts.steps {
        let end = number(end);
        rows.add("steps", format!("{increments} increments from t = 0 to {end}, the time of the loads above"));
    }
    facts.contacts.iter().for_each(|contact| contact_rows(&mut rows, contact));
    if let Some([count, held]) = facts.equations {
        rows.add("equations", format!("{count} between {held} displacements"));
    }
    rows.add("unknowns", format!("{} displacements, {} contact points", facts.unknowns, facts.points));
    facts.warnings.iter().for_each(|warning| rows.add("warning", warning.clone()));
    facts.notes.iter().for_each(|note| rows.add("note", note.clone()));
    rows.0
}

fn describe(load: &LoadFacts) -> String {
    let LoadFacts { on, kind, .. } = load;
    let extent = number(load.extent);
    if let Some([low, high]) = load.range {
        return format!("{on}: temperature from {} to {} in volume {extent}", number(low), number(high));
    }
    if *kind == "force at nodes" {
        return format!("{on}: {kind}, {extent} of them, resultant {}", triple(load.resultant));
    }
    let measure = if ["gravity", "rotation"].contains(kind) { "volume" } else { "area" };
    format!("{on}: {kind} on {measure} {extent}, resultant {}", triple(load.resultant))
}

fn contact_rows(rows: &mut Rows, contact: &ContactFacts) {
    let s = &contact.surface;
    let against = match &contact.against {
        Counterpart::Obstacle(it) => obstacle(it),
        Counterpart::Surface(_) => format!("the surface {}", contact.names[1]),
    };
    rows.add("contact", format!("{}: {} points, area {}, against {against}", s.name, s.points, number(s.area)));
    rows.more(format!("friction {}", friction(&contact.friction)));
    if let Some(InterfaceStiffness { normal, tangential }) = contact.stiffness {
        let [normal, tangential] = [normal, tangential].map(number);
        rows.more(format!("yields by the stiffness {normal} along the normal and {tangential} along the surface"));
    }
    if let Some(pair) = &s.pair {
        pair_text::lines(contact, pair).into_iter().for_each(|line| rows.more(line));
        return;
    }
    let gap = match (s.gap_min, s.gap_max) {
        (low, high) if low == high => format!("gap {}", number(low)),
        (low, high) => format!("gap from {} to {}", number(low), number(high)),
    };
    rows.more(match s.overlapping {
        0 => format!("{gap}, no overlap"),
        count => format!("{gap}; {count} points (area {}) start inside the obstacle", number(s.overlapping_area)),
    });
}

fn obstacle(obstacle: &Obstacle) -> String {
    let sided = |side: Side| match side {
        Side::Outside => "outside",
        Side::Inside => "inside",
    };
    match obstacle.clone() {
        Obstacle::Plane { point, normal } => {
            format!("a plane through {} with normal {}", triple(point), triple(normal))
        }
        Obstacle::Sphere { center, radius, side } => {
            format!("a sphere of radius {} at {}, body {}", number(radius), triple(center), sided(side))
        }
        Obstacle::Cylinder { point, axis, radius, side } => {
            let (radius, point, axis) = (number(radius), triple(point), triple(axis));
            format!("a cylinder of radius {radius} through {point} along {axis}, body {}", sided(side))
        }
        Obstacle::Surface(surface) => {
            let form = match surface.border_edges {
                0 => format!("closed around the volume {}", number(surface.volume.abs())),
                edges => format!("open with {edges} edges on its border"),
            };
            let (name, count, sharp) = (&surface.name, surface.triangles().len(), surface.sharp_edges);
            format!("the surface {name}: {count} triangles, {form}, {sharp} sharp edges, body {}", sided(surface.side))
        }
    }
}

fn friction(friction: &SurfaceFriction) -> String {
    match friction {
        SurfaceFriction::None => "none".into(),
        SurfaceFriction::Bonded => "none: bonded, no slip and no opening".into(),
        SurfaceFriction::Coulomb(coefficient) => format!("of Coulomb, coefficient {coefficient}"),
        SurfaceFriction::GivenStress(stress) => format!("given: slips at the shear stress {}", number(*stress)),
        SurfaceFriction::GivenForce(force) => format!("given: slips at the force {} of a point", number(*force)),
        SurfaceFriction::Law(CoulombLaw { coefficient, across, limit, cohesion }) => {
            let mut text = format!("of Coulomb, coefficient {coefficient:?}");
            if let Some(across) = across {
                text += &format!(" along {} and {:?} across", triple(across.direction), across.coefficient);
            }
            if let Some(Cohesion { shear, tension, brittle }) = cohesion.as_deref() {
                let lost = if *brittle { "lost where it slips or opens" } else { "never lost" };
                text += &format!(", cohesion {shear:?} and tensile strength {tension:?}, {lost}");
            }
            match limit {
                Some(stress) => text + &format!(", up to the shear stress {}", number(*stress)),
                None => text,
            }
        }
    }
}
