//! How loads that contact cannot balance carry a body away: what a person needs to see why, and to mend it.

use serde::{Deserialize, Serialize};

use super::among::Among;
use super::equilibrium::{Slide, in_words_among, moving_among, name, velocity, with};
use super::rigid::RigidMotions;
use super::{ContactProblem, Friction};
use crate::Error;
use crate::fem::Motion;
use crate::mesh::v3::{V3, add, dot, norm, scale, sub};

/// What is to be said of a problem without equilibrium.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Escape {
    /// Which body moves, and how: `body "post": translation along z`.
    pub motion: String,
    /// What its contact points do in this motion, and the forces: sentences without full stops.
    pub facts: Vec<String>,
    /// What can be done about it.
    pub remedy: String,
}

impl Escape {
    /// All in one sentence, without its remedy.
    pub fn sentence(&self) -> String {
        let facts: String = self.facts.iter().map(|fact| format!("; {fact}")).collect();
        format!("the loads carry away {}{facts}", self.motion)
    }
}

/// What contact does in the motion.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    LiftOff,
    Slide,
    Tip,
}

/// A point opens if it moves apart by more than this part of the largest jump in the motion.
const OPENS: f64 = 1e-6;

/// Normals that differ by less are those of one plane.
const FLAT: f64 = 1e-6;

/// The motion `slide`, on which no contact forces take up the work of the loads, in words.
pub fn escape(problem: &ContactProblem, motions: &RigidMotions, slide: &Slide) -> Escape {
    escape_among(problem, motions, slide, &Among::ALONE)
}

/// The same where ranks share the problem; all of them say the same.
pub(crate) fn escape_among(problem: &ContactProblem, motions: &RigidMotions, slide: &Slide, among: &Among) -> Escape {
    let bodies = moving_among(motions, &slide.alpha, among.max);
    let Some(&first) = bodies.first() else {
        let motion = in_words_among(problem, motions, &slide.alpha, among.max);
        return Escape { motion, facts: Vec::new(), remedy: String::new() };
    };
    let points = touching(problem, motions, first, among);
    let mut counts = [opening(problem, motions, slide, &points, among) as f64, points.len() as f64];
    (among.sum)(&mut counts);
    let [opening, all] = counts.map(|count| count as usize);
    let kind = match opening {
        opening if opening == all => Kind::LiftOff,
        0 => Kind::Slide,
        _ => Kind::Tip,
    };
    let force = load(problem, motions, first, among);
    let mut facts = vec![did(kind, opening, all)];
    facts.extend(force.map(|force| format!("the loads on it add up to the force {}", components(force))));
    let (t, omega, origin, centre, radius) = velocity(problem, motions, first, &slide.alpha);
    if kind != Kind::LiftOff && bodies.len() == 1 {
        facts.extend(force.and_then(|force| resisted(problem, motions, first, &points, force, among)));
    }
    let middle = Motion::of_middle(t, omega, origin, centre, radius).filter(|_| kind == Kind::LiftOff);
    let motion = match middle {
        // As it leaves it may turn as well, which says nothing about why.
        Some(motion) if !matches!(Motion::of(t, omega, origin, centre, radius), Motion::Translation { .. }) => {
            let names: Vec<String> = bodies.iter().map(|&number| name(problem, motions, number)).collect();
            format!("{}: {motion}, while it turns{}", names[0], with(&names))
        }
        _ => in_words_among(problem, motions, &slide.alpha, among.max),
    };
    Escape { motion, facts, remedy: remedy(kind).into() }
}

fn did(kind: Kind, opening: usize, all: usize) -> String {
    match kind {
        Kind::LiftOff if all == 0 => "it has no contact point".into(),
        Kind::LiftOff => format!("it lifts off: all of its {all} contact points open"),
        Kind::Slide => format!("it slides: none of its {all} contact points opens"),
        Kind::Tip => format!(
            "it tips over: {opening} of its {all} contact points open, and pressure on the others cannot hold it"
        ),
    }
}

fn remedy(kind: Kind) -> &'static str {
    match kind {
        Kind::LiftOff => "hold it by a support, a spring or a bonded contact, or press it down",
        Kind::Slide => "hold it along this motion by a support or a spring, press it harder, or give more friction",
        Kind::Tip => "let the loads act nearer to the contact, or hold it by a support or a spring",
    }
}

/// The contact points here that a body has a part in, as far as they take part themselves.
fn touching(problem: &ContactProblem, motions: &RigidMotions, body: usize, among: &Among) -> Vec<usize> {
    let own = &motions.bodies[body].unknowns;
    let meets = |&j: &usize| problem.contact.B.row(j).0.iter().any(|i| own.binary_search(i).is_ok());
    // Points of couplings and equations are of no surface.
    let is_in = |&j: &usize| {
        problem.labels.unity_sum.get(j) != Some(&0.0) && problem.contact.out.binary_search(&(j as u32)).is_err()
    };
    (0..problem.points()).filter(|&j| (among.point)(j)).filter(is_in).filter(meets).collect()
}

/// How many of these points move apart.
fn opening(problem: &ContactProblem, motions: &RigidMotions, slide: &Slide, points: &[usize], among: &Among) -> usize {
    let mut u = vec![0.0; problem.unknowns()];
    motions.add(&slide.alpha, &mut u);
    let (jump, m) = (problem.contact.B.times(&u), problem.points());
    let own = jump.iter().enumerate().filter(|(i, _)| (among.point)(i % m));
    let least = OPENS * among.largest(own.map(|(_, jump)| jump.abs()));
    points.iter().filter(|&&j| problem.contact.friction[j] != Friction::Bonded && jump[j] < -least).count()
}

/// The resultant of the loads on a body that nothing holds; `None` for others, on which supports act as well.
fn load(problem: &ContactProblem, motions: &RigidMotions, body: usize, among: &Among) -> Option<V3> {
    let kernel = problem.elastic.near_kernel.as_ref().filter(|_| motions.bodies[body].motions.len() == 6)?;
    let along = |c: usize| -> f64 {
        let own = motions.bodies[body].unknowns.iter().map(|&i| i as usize).filter(|&i| (among.unknown)(i));
        own.map(|i| problem.elastic.f[i] * kernel[i][c]).sum()
    };
    let mut sums = [along(0), along(1), along(2)];
    (among.sum)(&mut sums);
    Some(sums)
}

/// How the push along a plane compares with friction. `None` where contact is no plane, or its friction not that of Coulomb:
/// then no single figure tells.
fn resisted(
    problem: &ContactProblem,
    motions: &RigidMotions,
    body: usize,
    points: &[usize],
    force: V3,
    among: &Among,
) -> Option<String> {
    let kernel = problem.elastic.near_kernel.as_ref()?;
    let own = &motions.bodies[body].unknowns;
    let normal = |j: usize| -> V3 {
        let here = problem.contact.B.entries_of(j).filter(|(i, _)| own.binary_search(i).is_ok());
        let sum =
            here.fold([0.0; 3], |sum, (i, entry)| add(sum, scale(entry, [0, 1, 2].map(|c| kernel[i as usize][c]))));
        scale(1.0 / norm(sum), sum)
    };
    let normals: Vec<V3> = points.iter().map(|&j| normal(j)).collect();
    let mut mean = normals.iter().fold([0.0; 3], |sum, normal| add(sum, *normal));
    (among.sum)(&mut mean);
    let plane = scale(1.0 / norm(mean), mean);
    // What is no number is turned.
    let turned = |normal: &V3| if norm(sub(*normal, plane)) < FLAT { 0.0 } else { 1.0 };
    let (mut others, mut largest) = (normals.iter().map(turned).fold(0.0, f64::max), 0.0f64);
    for &j in points {
        match problem.contact.friction[j] {
            Friction::None => {}
            Friction::Coulomb { coefficient } | Friction::Limited { coefficient, .. } => {
                largest = largest.max(coefficient);
            }
            _ => others = 1.0,
        }
    }
    let mut most = [others, largest];
    (among.max)(&mut most);
    let [others, largest] = most;
    let press = dot(force, plane);
    // What is no number presses nowhere.
    if others > 0.0 || press.is_nan() || press <= 0.0 {
        return None;
    }
    let push = norm(sub(force, scale(press, plane)));
    let [push, press, most] = [push, press, largest * press].map(Error::number);
    Some(format!(
        "they push along the contact with {push} and press on it with {press}: friction holds at most {largest} x {press} = {most}"
    ))
}

/// A vector to read; what rounding has left of a component is zero.
fn components(v: V3) -> String {
    let [x, y, z] = v.map(|c| Error::number(if c.abs() < 1e-9 * norm(v) { 0.0 } else { c }));
    format!("({x}, {y}, {z})")
}
