//! The facts in plain words.

use std::fmt;

use super::pair_text;
use crate::contact::{CoulombLaw, Counterpart, Obstacle, Side, SurfaceFriction};
use crate::io::report::{number, triple};
use crate::run::pose::{ContactFacts, Facts};

impl fmt::Display for Facts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        if let Some(units) = &self.units {
            writeln!(f, "  units      {units}")?;
        }
        let cells = self.mesh.cells.iter().map(|c| format!("{} {}", c.count, c.kind.name())).collect::<Vec<_>>();
        let bodies = if self.mesh.bodies == 1 { String::new() } else { format!(", {} bodies", self.mesh.bodies) };
        writeln!(
            f,
            "  mesh       {} nodes, {} cells, volume {}{bodies}",
            self.mesh.nodes,
            cells.join(", "),
            number(self.mesh.volume)
        )?;
        for m in &self.materials {
            match &m.orthotropic {
                None => write!(f, "  material   {}: young {}, poisson {}", m.name, number(m.young), m.poisson)?,
                Some([young, poisson, shear]) => write!(
                    f,
                    "  material   {}: orthotropic, young {}, poisson {}, shear {}",
                    m.name,
                    triple(*young),
                    triple(*poisson),
                    triple(*shear)
                )?,
            }
            let density = if m.density > 0.0 { format!(", density {}", number(m.density)) } else { String::new() };
            writeln!(f, "{density}, {} cells, volume {}", m.cells, number(m.volume))?;
        }
        for fix in &self.fixes {
            let at = fix.at.map_or(String::new(), |x| format!(" (node at {})", triple(x)));
            writeln!(f, "  fix        {}{at}: {} of {} nodes", fix.on, fix.components, fix.nodes)?;
        }
        for s in &self.springs {
            let (area, normal, tangential) = (number(s.area), number(s.normal), number(s.tangential));
            writeln!(f, "  spring     {}: normal {normal}, tangential {tangential} an area, on area {area}", s.on)?;
        }
        for load in &self.loads {
            if let Some([low, high]) = load.range {
                let (low, high, volume) = (number(low), number(high), number(load.extent));
                writeln!(f, "  load       {}: temperature from {low} to {high} in volume {volume}", load.on)?;
                continue;
            }
            let extent = if ["gravity", "rotation"].contains(&load.kind) { "volume" } else { "area" };
            let (on, kind, size, sum) = (&load.on, load.kind, number(load.extent), triple(load.resultant));
            writeln!(f, "  load       {on}: {kind} on {extent} {size}, resultant {sum}")?;
        }
        for b in &self.bolts {
            let (axis, value) = (triple(b.axis), number(b.value));
            writeln!(f, "  bolt       {}: {} {value} along {axis}, cut through {} nodes", b.name, b.by, b.nodes)?;
        }
        if self.loads.len() > 1 {
            writeln!(f, "  loads      resultant of all {}", triple(self.resultant()))?;
        }
        if let Some((increments, end)) = self.steps {
            writeln!(
                f,
                "  steps      {increments} increments from t = 0 to {}, where the loads are as told",
                number(end)
            )?;
        }
        self.contacts.iter().try_for_each(|contact| write!(f, "{contact}"))?;
        writeln!(f, "  unknowns   {} displacements, {} contact points", self.unknowns, self.points)?;
        self.notes.iter().try_for_each(|note| writeln!(f, "  note       {note}"))
    }
}

impl fmt::Display for ContactFacts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = &self.surface;
        let against = match &self.against {
            Counterpart::Obstacle(it) => obstacle(it),
            Counterpart::Surface(_) => format!("the surface {}", self.names[1]),
        };
        writeln!(f, "  contact    {}: {} points, area {}, against {against}", s.name, s.points, number(s.area))?;
        writeln!(f, "             friction {}", friction(&self.friction))?;
        if let Some(pair) = &s.pair {
            return pair_text::lines(self, pair).iter().try_for_each(|line| writeln!(f, "             {line}"));
        }
        let gap = match (s.gap_min, s.gap_max) {
            (low, high) if low == high => format!("gap {}", number(low)),
            (low, high) => format!("gap from {} to {}", number(low), number(high)),
        };
        match s.overlapping {
            0 => writeln!(f, "             {gap}, no overlap"),
            count => {
                let area = number(s.overlapping_area);
                writeln!(f, "             {gap}; {count} points (area {area}) start inside the obstacle")
            }
        }
    }
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
            let (name, count, sharp) = (&surface.name, surface.len(), surface.sharp_edges);
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
        SurfaceFriction::Law(CoulombLaw { coefficient, across, limit }) => {
            let mut text = format!("of Coulomb, coefficient {coefficient:?}");
            if let Some(across) = across {
                text += &format!(" along {} and {:?} across", triple(across.direction), across.coefficient);
            }
            match limit {
                Some(stress) => text + &format!(", up to the shear stress {}", number(*stress)),
                None => text,
            }
        }
    }
}
