//! The tables of `JOB.dat`: what `*NODE PRINT` and `*CONTACT PRINT` ask for.

use std::collections::HashMap;

use stiction::io::deck::{DeckLabels, DeckLayer, Print, Printed, Requests};
use stiction::io::frd::scientific;
use stiction::run::{BodyFields, Side, SurfaceFields};

use super::files::fortran;

/// An answer with the numbers of its deck.
pub(super) struct Answer<'a> {
    pub labels: &'a DeckLabels,
    pub layer: Option<&'a DeckLayer>,
    pub body: &'a BodyFields,
    pub surfaces: &'a [SurfaceFields],
    pub time: f64,
    pub step: usize,
}

/// Which tables are not given, in words.
pub(super) fn unanswered(requests: &Requests) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    for print in &requests.prints {
        for key in &print.keys {
            let what = match (print.of, key.as_str()) {
                (Printed::Nodes, "U" | "RF") | (Printed::Contact, "CF") => continue,
                (Printed::Cells, "S" | "E") => {
                    format!("{key} at integration points (*EL PRINT) is not written; *EL FILE gives it at the nodes")
                }
                (Printed::Contact, key) => {
                    format!(
                        "{key} at integration points (*CONTACT PRINT) is not written; *CONTACT FILE gives it at the nodes"
                    )
                }
                (_, key) => format!("{key} of the PRINT cards is not computed and left out"),
            };
            if !out.contains(&what) {
                out.push(what);
            }
        }
    }
    out
}

/// All tables of an answer.
pub(super) fn text(requests: &Requests, of: &Answer) -> String {
    let mut out = String::new();
    for print in requests.prints.iter().filter(|print| print.steps.contains(&of.step)) {
        for key in &print.keys {
            match (print.of, key.as_str()) {
                (Printed::Nodes, "U") => {
                    nodes(&mut out, print, of, ["displacements (vx,vy,vz)", ""], &of.body.displacement)
                }
                (Printed::Nodes, "RF") => {
                    let whole = of.layer.map(|layer| layer.whole(&of.body.reaction));
                    let forces = whole.as_deref().unwrap_or(&of.body.reaction);
                    nodes(&mut out, print, of, ["forces (fx,fy,fz)", "total force (fx,fy,fz)"], forces);
                }
                (Printed::Contact, "CF") => contact(&mut out, requests, print, of),
                _ => {}
            }
        }
    }
    out
}

fn number(value: f64) -> String {
    scientific(value, 14, 6)
}

fn head(out: &mut String, what: &str, set: &str, time: f64) {
    *out += &format!("\n {what} for set {} and time  {}\n\n", set.to_uppercase(), fortran(time, 7));
}

fn nodes(out: &mut String, print: &Print, of: &Answer, [each, total]: [&str; 2], values: &[[f64; 3]]) {
    let [single, sum] = print.values;
    if single {
        head(out, each, &print.set, of.time);
        for &node in &print.places {
            let value: String = values[node as usize].map(number).concat();
            *out += &format!("{:10}{value}\n", of.labels.nodes[node as usize]);
        }
    }
    if sum && !total.is_empty() {
        head(out, total, &print.set, of.time);
        let places = print.places.iter().map(|&node| values[node as usize]);
        let total = places.fold([0.0; 3], |sum, value| [0, 1, 2].map(|c| sum[c] + value[c]));
        *out += &format!("   {}\n", total.map(number).concat());
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Resultants of pairs: force on the slave with its moment, centre and normal of its area in contact, normal force and shear.
fn contact(out: &mut String, requests: &Requests, print: &Print, of: &Answer) {
    // Of a layer all that acts is brought into the plane of the deck, which is its middle: nothing acts across it.
    let copies = of.layer.iter().flat_map(|layer| &layer.copies);
    let angles: HashMap<i32, f64> = copies.map(|&(_, copy, angle)| (copy as i32, angle)).collect();
    let in_plane = |node: i32, v: [f64; 3]| {
        if of.layer.is_none() {
            return v;
        }
        let (sin, cos) = angles.get(&node).copied().unwrap_or(0.0).sin_cos();
        [v[0] * cos + v[2] * sin, v[1], 0.0]
    };
    let slaves = of.surfaces.iter().filter(|s| s.side == Side::Slave);
    for s in slaves.filter(|s| print.set.is_empty() || s.name.eq_ignore_ascii_case(&print.set)) {
        let master =
            requests.pairs.iter().find(|pair| pair[0].eq_ignore_ascii_case(&s.name)).map_or("", |pair| &pair[1]);
        let (mut force, mut moment, mut centre, mut normal, mut area) = ([0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], 0.0);
        // Normal force: tension is positive.
        let (mut pull, mut shear) = (0.0, [0.0; 3]);
        for at in (0..s.nodes.len()).filter(|&at| s.status[at] > 0) {
            let node = s.nodes[at];
            let x = std::array::from_fn(|c| s.points[at][c] + of.body.displacement[node as usize][c]);
            let factor = of.layer.map_or(1.0, |layer| layer.factor);
            let (x, on_slave) = (in_plane(node, x), in_plane(node, s.lambda[at].map(|f| -factor * f)));
            let own = in_plane(node, s.normal[at]);
            let turn = cross(x, on_slave);
            let along = (0..3).map(|c| on_slave[c] * own[c]).sum::<f64>();
            for c in 0..3 {
                force[c] += on_slave[c];
                moment[c] += turn[c];
                centre[c] += s.area[at] * x[c];
                normal[c] += s.area[at] * own[c];
                shear[c] += on_slave[c] - along * own[c];
            }
            pull += along;
            area += s.area[at];
        }
        let size = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        let part = |v: [f64; 3], by: f64| if by > 0.0 { v.map(|x| x / by) } else { v };
        let (centre, normal) = (part(centre, area), part(normal, size));
        let about = cross(centre, force);
        let about_centre = [0, 1, 2].map(|c| moment[c] - about[c]);
        let shear = shear.iter().map(|f| f * f).sum::<f64>().sqrt();
        let names = [s.name.to_uppercase(), master.to_uppercase()];
        *out += &format!(
            "\n statistics for slave set {}, master set {} and time  {}\n",
            names[0],
            names[1],
            fortran(of.time, 7)
        );
        let row = |values: &[f64]| format!("\n  {}\n", values.iter().map(|v| number(*v)).collect::<String>());
        *out += "\n   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)\n";
        *out += &row(&[force, moment].concat());
        *out += "\n    center of gravity and mean normal\n";
        *out += &row(&[centre, normal].concat());
        *out += "\n    moment about the center of gravity(mx,my,mz)\n";
        *out += &row(&about_centre);
        *out += "\n    area,  normal force (+ = tension) and shear force (size)\n";
        *out += &row(&[area, pull, shear]);
    }
}
