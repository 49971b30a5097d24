//! The file of the two fields that prove a bound of the discretisation error.

use std::path::Path;

use super::npz::{self, Array, Arrays, count, f64s, u32s, usizes};
use super::problem::damaged;
use crate::Error;
use crate::certificate::{BoundClaim, BoundFields, BoundSide, BoundUnknown, FlatObstacle, Touch};

/// Number of its format.
const FORMAT: usize = 2;
/// Numbers of a [`Touch`] in their order: pressure, shear, law, opening, slip, reference.
const TOUCH: usize = 3 + 9 + 6 + 6 + 18 + 18;

/// Writes fields and what they are said to prove.
///
/// # Errors
/// If the file cannot be written.
pub fn write_bound(path: &Path, fields: &BoundFields, claim: &BoundClaim) -> Result<(), Error> {
    let sides = &fields.sides;
    let corners: Vec<u32> = sides.iter().flat_map(|side| side.corners).collect();
    let load: Vec<f64> = sides.iter().flat_map(|side| side.load).flatten().collect();
    let ends = sides.iter().scan(0, |end, side| {
        *end += side.held.len();
        Some(*end)
    });
    let held_ends: Vec<usize> = ends.collect();
    let held: Vec<f64> = sides.iter().flat_map(|side| &side.held).flatten().copied().collect();
    let touches: Vec<(usize, &Touch)> =
        sides.iter().enumerate().flat_map(|(i, side)| side.touches.iter().map(move |touch| (i, touch))).collect();
    let touch_of: Vec<usize> = touches.iter().flat_map(|(side, touch)| [*side, touch.obstacle as usize]).collect();
    let touch: Vec<f64> = touches.iter().flat_map(|(_, touch)| flat(touch)).collect();
    let obstacles: Vec<f64> =
        fields.obstacles.iter().flat_map(|at| [at.normal[0], at.normal[1], at.normal[2], at.offset]).collect();
    let unknown_of: Vec<u32> = fields.unknowns.iter().map(|unknown| unknown.node).collect();
    let directions: Vec<f64> = fields.unknowns.iter().flat_map(|unknown| unknown.direction).collect();
    let [low, high] = claim.energy;
    npz::write(
        path,
        &[
            ("format", Array::count(FORMAT)),
            ("claim", Array::f64(&[claim.error, claim.mean_error, claim.mean_norm, low, high])),
            ("nodes", Array::f64(fields.nodes.as_flattened())),
            ("corners", Array::u32(fields.corners.as_flattened())),
            ("middles", Array::u32(fields.middles.as_flattened())),
            ("stiffness", Array::f64(fields.stiffness.as_flattened().as_flattened())),
            ("material", Array::u32(&fields.material)),
            ("initial", Array::f64(fields.initial.as_flattened())),
            ("body_force", Array::f64(fields.body_force.as_flattened())),
            ("unknown_of", Array::u32(&unknown_of)),
            ("directions", Array::f64(&directions)),
            ("found", Array::f64(&fields.found)),
            ("displacement", Array::f64(&fields.displacement)),
            ("stress", Array::f64(fields.stress.as_flattened().as_flattened().as_flattened())),
            ("obstacles", Array::f64(&obstacles)),
            ("sides", Array::u32(&corners)),
            ("load", Array::f64(&load)),
            ("held_ends", Array::usize(&held_ends)),
            ("held", Array::f64(&held)),
            ("touch_of", Array::usize(&touch_of)),
            ("touch", Array::f64(&touch)),
        ],
    )
}

/// Reads them again.
///
/// # Errors
/// If the file cannot be read, is damaged, or of another format.
pub fn read_bound(path: &Path) -> Result<(BoundFields, BoundClaim), Error> {
    let remedy = "solve the case again";
    let placed = |error: Error| Error::new(path.display().to_string(), error.what, remedy);
    npz::read(path).and_then(|arrays| read(&arrays)).map_err(placed)
}

fn read(arrays: &Arrays) -> Result<(BoundFields, BoundClaim), Error> {
    if count(arrays, "format")? != FORMAT {
        return Err(damaged("the file has another format than this version reads"));
    }
    let claim = f64s(arrays, "claim", Some(5))?;
    let claim = BoundClaim { error: claim[0], mean_error: claim[1], mean_norm: claim[2], energy: [claim[3], claim[4]] };
    let vectors = |name: &str| parts::<3, f64>(name, f64s(arrays, name, None)?);
    let mut sides = Vec::new();
    let corners = parts::<3, u32>("sides", u32s(arrays, "sides", None)?)?;
    let (load, held) = (vectors("load")?, vectors("held")?);
    let ends = usizes(arrays, "held_ends", Some(corners.len()))?;
    let load = parts::<3, [f64; 3]>("load", &load)?;
    if load.len() != corners.len() {
        return Err(damaged("there is not one load for each boundary face"));
    }
    let mut begin = 0;
    for ((corners, load), end) in corners.into_iter().zip(load).zip(ends) {
        let held =
            held.get(begin..end).ok_or_else(|| damaged("the directions that are held are not those of the faces"))?;
        sides.push(BoundSide { corners, held: held.to_vec(), load, touches: Vec::new() });
        begin = end;
    }
    let touch = parts::<TOUCH, f64>("touch", f64s(arrays, "touch", None)?)?;
    let of = parts::<2, usize>("touch_of", &usizes(arrays, "touch_of", Some(2 * touch.len()))?)?;
    for ([side, obstacle], values) in of.into_iter().zip(&touch) {
        let obstacle = u32::try_from(obstacle).map_err(|_| damaged("there are not so many obstacles"))?;
        let side = sides.get_mut(side).ok_or_else(|| damaged("a face that does not exist touches an obstacle"))?;
        side.touches.push(touch_from(obstacle, values));
    }
    let unknown_of = u32s(arrays, "unknown_of", None)?;
    let directions = parts::<3, f64>("directions", f64s(arrays, "directions", Some(3 * unknown_of.len()))?)?;
    let unknowns = unknown_of.iter().zip(directions).map(|(&node, direction)| BoundUnknown { node, direction });
    let obstacles = parts::<4, f64>("obstacles", f64s(arrays, "obstacles", None)?)?;
    let obstacle = |[x, y, z, offset]: [f64; 4]| FlatObstacle { normal: [x, y, z], offset };
    let stiffness = parts::<6, f64>("stiffness", f64s(arrays, "stiffness", None)?)?;
    let stress = parts::<6, f64>("stress", f64s(arrays, "stress", None)?)?;
    let fields = BoundFields {
        nodes: vectors("nodes")?,
        corners: parts("corners", u32s(arrays, "corners", None)?)?,
        middles: parts("middles", u32s(arrays, "middles", None)?)?,
        stiffness: parts("stiffness", &stiffness)?,
        material: u32s(arrays, "material", None)?.to_vec(),
        initial: parts("initial", f64s(arrays, "initial", None)?)?,
        body_force: vectors("body_force")?,
        unknowns: unknowns.collect(),
        found: f64s(arrays, "found", None)?.to_vec(),
        displacement: f64s(arrays, "displacement", None)?.to_vec(),
        stress: parts("stress", &parts::<4, [f64; 6]>("stress", &stress)?)?,
        obstacles: obstacles.into_iter().map(obstacle).collect(),
        sides,
    };
    Ok((fields, claim))
}

/// A list in parts of `N`.
fn parts<const N: usize, T: Copy>(name: &str, list: &[T]) -> Result<Vec<[T; N]>, Error> {
    match list.as_chunks::<N>() {
        (parts, []) => Ok(parts.to_vec()),
        _ => Err(damaged(format!("array \"{name}\" has {} entries, which are not parts of {N}", list.len()))),
    }
}

fn flat(touch: &Touch) -> Vec<f64> {
    let parts: [&[f64]; 6] = [
        &touch.pressure,
        touch.shear.as_flattened(),
        touch.law.as_flattened(),
        &touch.opening,
        touch.slip.as_flattened(),
        touch.reference.as_flattened(),
    ];
    parts.concat()
}

fn touch_from(obstacle: u32, values: &[f64; TOUCH]) -> Touch {
    let vector = |at: usize| std::array::from_fn(|c| values[at + c]);
    Touch {
        obstacle,
        pressure: vector(0),
        shear: std::array::from_fn(|a| vector(3 + 3 * a)),
        law: std::array::from_fn(|a| [values[12 + 2 * a], values[13 + 2 * a]]),
        opening: std::array::from_fn(|k| values[18 + k]),
        slip: std::array::from_fn(|k| vector(24 + 3 * k)),
        reference: std::array::from_fn(|k| vector(42 + 3 * k)),
    }
}
