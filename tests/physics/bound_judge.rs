//! The judge of a proof, `certificate/bound`: fields of another problem, wrong proofs and flipped bits are refused.

use stiction::certificate::{BOUND_TOLERANCE, BoundClaim, BoundFields, BoundSide, Touch, judge_bound, judge_tie};
use stiction::run::{Outcome, Prepared, error_bound};

use super::error_bound::{bounded, brick, judged, solved};

/// A change of the fields.
type Lie = fn(&mut BoundFields);

/// The first side that slips, and a corner of it that does.
fn slipping(fields: &mut BoundFields) -> (&mut Touch, usize) {
    let touches = fields.sides.iter_mut().flat_map(|side| &mut side.touches);
    let slips = |touch: &Touch, a: usize| touch.slip[a].iter().any(|slip| slip.abs() > 1e-8);
    let at = |touch: &Touch| (0..3).find(|&a| touch.pressure[a] > 1e5 && slips(touch, a));
    touches.filter_map(|touch| at(touch).map(|a| (touch, a))).next().unwrap()
}

/// Names of the measures of the tie to problem and answer that are not met.
fn untied(fields: &BoundFields, (prepared, outcome): &(Prepared, Outcome)) -> Vec<&'static str> {
    let measures = judge_tie(fields, &prepared.problem, &outcome.solution.u).unwrap();
    assert_eq!(measures.len(), 6, "{measures:#?}");
    measures.iter().filter(|measure| !measure.is_met()).map(|measure| measure.name).collect()
}

#[test]
fn fields_of_another_problem_or_answer_are_refused() {
    let (limited, tied) = ("{ coulomb = 0.35, limit = 2e5 }", "\"none\"");
    let bonded = "[[contact]]\non = \"y-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 1, 0] } }\nfriction = \"bonded\"\n";
    for (element, friction, more) in [
        ("tet4", "\"none\"", ""),
        ("tet10", "{ tresca = 1e5 }", ""),
        ("tet4", limited, ""),
        ("tet10", limited, "[[load]]\ngravity = [0, 0, -9.81]\n[[load]]\ntemperature = 30\n"),
        ("tet10", tied, bonded),
    ] {
        let text = brick([6, 2, 2], element, friction)
            .replace("poisson = 0.277", "poisson = 0.277\ndensity = 7.8e3\nexpansion = 1.2e-5");
        let solved = solved(&(text + more));
        let bound = error_bound(&solved.0, &solved.1).unwrap();
        assert_eq!(untied(&bound.fields, &solved), [""; 0], "{element} {friction} {more}");
    }
    let solved = solved(&brick([6, 2, 2], "tet10", "{ coulomb = 0.35 }"));
    let bound = error_bound(&solved.0, &solved.1).unwrap();
    let (displacements, forces) = ("displacements of solution.npz", "forces of problem.npz");
    let (supports, obstacles) = ("supports of problem.npz", "obstacles of problem.npz");
    let reference = "slip reference of problem.npz";
    let lies: [(&[&str], Lie); 13] = [
        (&[displacements], |fields| fields.found.iter_mut().for_each(|u| *u *= 1.0 + 1e-5)),
        (&[displacements, forces], |fields| fields.unknowns[5].direction = [0.0, 0.0, -1.0]),
        (&[displacements, forces], |fields| fields.unknowns.swap(3, 30)),
        (&[forces], |fields| fields.stiffness[0].iter_mut().flatten().for_each(|c| *c *= 1.0 + 1e-6)),
        (&[forces], |fields| fields.nodes[fields.corners[9][0] as usize][0] += 1e-6),
        (&[forces], |fields| fields.initial = vec![[1e-10, 0.0, 0.0, 0.0, 0.0, 0.0]; fields.corners.len()]),
        (&[forces], |fields| fields.sides.iter_mut().for_each(|side| side.load[0][2] *= 1.0 + 1e-5)),
        (&[supports], |fields| {
            let free = |side: &&mut BoundSide| side.held.is_empty();
            fields.sides.iter_mut().find(free).unwrap().held.push([0.0, 1.0, 0.0]);
        }),
        (&[obstacles], |fields| fields.obstacles[0].offset += 1e-11),
        (&[obstacles], |fields| fields.obstacles[0].normal = [1e-8, 0.0, -1.0]),
        (&["friction of problem.npz"], |fields| {
            let touches = fields.sides.iter_mut().flat_map(|side| &mut side.touches);
            touches.for_each(|touch| touch.law[0][0] *= 1.0 + 1e-6);
        }),
        (&[reference], |fields| {
            let touches = fields.sides.iter_mut().flat_map(|side| &mut side.touches);
            touches.flat_map(|touch| &mut touch.reference).for_each(|reference| reference[0] += 1e-11);
        }),
        (&[reference], |fields| slipping(fields).0.reference[1][1] += 1e-11),
    ];
    for (number, (names, lie)) in lies.into_iter().enumerate() {
        let mut fields = bound.fields.clone();
        lie(&mut fields);
        assert_eq!(untied(&fields, &solved), names, "lie {number}");
    }
    let mut fewer = bound.fields.clone();
    fewer.unknowns.pop();
    assert!(judge_tie(&fewer, &solved.0.problem, &solved.1.solution.u).is_err());
}

/// Next to a support rows of the contact points have parts that are held, and where nothing acts forces are rounding.
#[test]
fn a_body_that_does_not_reach_its_obstacle_has_a_bound() {
    let text = r#"
[mesh]
block = { size = [10, 10, 5], cells = [2, 2, 1], element = "tet10" }
[materials.m]
young = 1e4
poisson = 0.3
[[fix]]
on = "x-min"
[[load]]
on = "y-max"
traction = [1, -3, 0]
[[contact]]
on = "z-min"
against = { plane = { point = [0, 0, -1], normal = [0, 0, 1] } }
friction = "none"
"#;
    let solved = solved(text);
    let bound = error_bound(&solved.0, &solved.1).unwrap_or_else(|why| panic!("{why}"));
    judged(&bound);
    assert_eq!(untied(&bound.fields, &solved), [""; 0]);
    // The exact energy is in the intervals of both meshes, the finer of which has less.
    assert!(solved.1.solution.lambda.iter().all(|&force| force == 0.0));
    let finer = bounded(&text.replace("[2, 2, 1]", "[8, 8, 4]")).unwrap();
    let [least, most] = finer.energy;
    assert!(
        bound.energy[0] <= most && least <= most && most <= bound.energy[1],
        "{:?} {:?}",
        bound.energy,
        finer.energy
    );
}

#[test]
fn a_wrong_proof_is_refused_for_its_reason() {
    let bound = bounded(&brick([6, 2, 2], "tet10", "{ coulomb = 0.35 }")).unwrap();
    judged(&bound);
    let lies: [(&str, Lie); 12] = [
        ("straight edges", |fields| fields.nodes[fields.middles[3][2] as usize][1] += 1e-6),
        ("balance of the cells", |fields| fields.body_force = vec![[0.0, 0.0, 1.0]; fields.corners.len()]),
        ("continuity inside the cells", |fields| fields.stress[7][1][2][0] += 1e2),
        ("continuity across faces", |fields| {
            // A uniform stress in one cell is in balance there.
            fields.stress[7].iter_mut().flatten().for_each(|stress| stress[2] += 1e2);
        }),
        ("tractions given on the boundary", |fields| {
            let loaded = |side: &&mut BoundSide| side.load[0][2] != 0.0;
            fields.sides.iter_mut().find(loaded).unwrap().load[0][2] *= 1.0 + 1e-5;
        }),
        ("pressure without tension", |fields| slipping(fields).0.pressure = [-1e3; 3]),
        ("shears within the limit of friction", |fields| {
            let (touch, a) = slipping(fields);
            let shear = touch.shear[a].iter().map(|q| q * q).sum::<f64>().sqrt();
            touch.law[a][0] = shear / touch.pressure[a] * (1.0 - 1e-5);
        }),
        ("shears along the surface", |fields| slipping(fields).0.shear[0][2] += 1e3),
        ("prescribed displacements", |fields| {
            let held = fields.sides.iter().find(|side| side.held.len() == 3).unwrap().corners[0];
            fields.displacement[3 * held as usize] += 1e-12;
        }),
        ("openings", |fields| slipping(fields).0.opening[0] -= 1e-11),
        ("slips", |fields| {
            let (touch, a) = slipping(fields);
            touch.slip[a] = touch.slip[a].map(|slip| slip * (1.0 - 1e-6));
        }),
        ("nodes out of the obstacle", |fields| {
            let (touch, a) = slipping(fields);
            touch.opening[a] = -1e-11;
            fields.obstacles[0].offset -= 1e-11;
        }),
    ];
    for (name, lie) in lies {
        let mut fields = bound.fields.clone();
        lie(&mut fields);
        let judged = judge_bound(&fields, &bound.claim()).unwrap();
        let measure = judged.measures.iter().find(|measure| measure.name == name).unwrap();
        assert!(
            measure.value > BOUND_TOLERANCE && !measure.place.is_empty() && !judged.passed(),
            "{name}: {measure:?}"
        );
    }
    let claim = bound.claim();
    let off = |x: f64| x * (1.0 - 1e-6);
    let [low, high] = claim.energy;
    let wrong = [
        ("bound of the error", BoundClaim { error: off(claim.error), ..claim }),
        ("bound of the error of the mean stress", BoundClaim { mean_error: off(claim.mean_error), ..claim }),
        ("norm of the mean stress", BoundClaim { mean_norm: off(claim.mean_norm), ..claim }),
        ("interval of the energy", BoundClaim { energy: [off(low), high], ..claim }),
        ("interval of the energy", BoundClaim { energy: [low, off(high)], ..claim }),
        ("bound of the error", BoundClaim { error: f64::NAN, ..claim }),
    ];
    for (name, claim) in wrong {
        let judged = judge_bound(&bound.fields, &claim).unwrap();
        let refused: Vec<&str> =
            judged.measures.iter().filter(|m| m.value.is_nan() || m.value > BOUND_TOLERANCE).map(|m| m.name).collect();
        assert_eq!(refused, [name]);
    }
}

/// Every number that the proof uses, by the name of its array.
fn numbers(fields: &mut BoundFields) -> Vec<(&'static str, Vec<&mut f64>)> {
    let in_contact = fields.sides.iter_mut().flat_map(|side| &mut side.touches);
    let (mut pressure, mut shear, mut opening, mut slip) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for touch in in_contact {
        let is_pressed = touch.pressure != [0.0; 3];
        pressure.extend(&mut touch.pressure);
        shear.extend(touch.shear.iter_mut().flatten());
        opening.extend(&mut touch.opening);
        // Where nothing can be sheared nothing is asked of slips.
        if is_pressed {
            slip.extend(touch.slip.iter_mut().flatten());
        }
    }
    vec![
        ("nodes", fields.nodes.iter_mut().flatten().collect()),
        ("stiffness", fields.stiffness.iter_mut().flatten().flatten().collect()),
        ("displacement", fields.displacement.iter_mut().collect()),
        ("stress", fields.stress.iter_mut().flatten().flatten().flatten().collect()),
        ("pressure", pressure),
        ("shear", shear),
        ("opening", opening),
        ("slip", slip),
    ]
}

#[test]
fn a_flipped_bit_is_found() {
    for friction in ["\"none\"", "{ coulomb = 0.35 }"] {
        let bound = bounded(&brick([6, 2, 2], "tet10", friction)).unwrap();
        judged(&bound);
        let count = numbers(&mut bound.fields.clone()).len();
        let mut flipped = 0;
        for array in 0..count {
            let length = numbers(&mut bound.fields.clone())[array].1.len();
            for place in (0..length).step_by((length / 16).max(1)) {
                // Sign, exponent, and the first thousandths of the mantissa.
                for bit in [42, 46, 51, 52, 55, 62, 63] {
                    let mut fields = bound.fields.clone();
                    let mut all = numbers(&mut fields);
                    let (name, ref mut values) = all[array];
                    let largest = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
                    let old = *values[place];
                    let new = f64::from_bits(old.to_bits() ^ 1 << bit);
                    *values[place] = new;
                    // Bits of numbers that are no more than rounding mean nothing.
                    if (new - old).abs() <= 1e-4 * largest.max(1e-200) {
                        continue;
                    }
                    // Without friction there is no slip to be looked at.
                    if friction == "\"none\"" && name == "slip" {
                        continue;
                    }
                    flipped += 1;
                    let found = judge_bound(&fields, &bound.claim()).is_ok_and(|judged| judged.passed());
                    assert!(!found, "{friction}: number {place} of {name}, bit {bit}: {old:e} is {new:e}");
                }
            }
        }
        assert!(flipped > 300, "{flipped}");
    }
}

#[test]
fn fields_that_do_not_fit_are_an_error() {
    let bound = bounded(&brick([3, 1, 1], "tet4", "\"none\"")).unwrap();
    let damages: [(&str, Lie); 8] = [
        ("`stress` has", |fields| fields.stress.truncate(3)),
        ("node 1000", |fields| fields.corners[0][3] = 999),
        ("a material that does not exist", |fields| fields.material[0] = 9),
        ("`displacement` holds what is no number", |fields| fields.displacement[4] = f64::NAN),
        ("positive definite", |fields| fields.stiffness[0][5][5] = -1.0),
        ("boundary faces", |fields| drop(fields.sides.pop())),
        ("an obstacle that does not exist", |fields| fields.obstacles.clear()),
        ("no volume", |fields| fields.corners[0][1] = fields.corners[0][0]),
    ];
    for (what, damage) in damages {
        let mut fields = bound.fields.clone();
        damage(&mut fields);
        let error = judge_bound(&fields, &bound.claim()).unwrap_err();
        assert!(error.what.contains(what), "{what}: {error}");
    }
}
