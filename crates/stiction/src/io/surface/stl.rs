//! STL.

use super::{DAMAGED, finished, on_line, point, shown, words};
use crate::Error;
use crate::contact::RawSurface;

/// Bytes before the triangles of a binary file (a heading and their number), and of each triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

pub(super) fn parse(bytes: &[u8], scale: f64) -> Result<RawSurface, Error> {
    let count = bytes.get(80..HEAD).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes).map(|n| n as usize);
    // Binary files may begin with the word "solid" as well: their length is what tells them.
    if let Some(count) = count.filter(|&count| Some(bytes.len()) == promised(count)) {
        return binary(&bytes[HEAD..], count, scale);
    }
    let begin = bytes.trim_ascii_start();
    if begin.len() >= 5 && begin[..5].eq_ignore_ascii_case(b"solid") && !bytes.contains(&0) {
        return text(bytes, scale);
    }
    let what = match count {
        Some(count) => {
            format!(
                "a binary file of {count} triangles has {HEAD} + {TRIANGLE} x {count} bytes, this one has {}",
                bytes.len()
            )
        }
        None => "this is neither a text that begins with \"solid\" nor a binary STL".to_string(),
    };
    Err(Error::new("", what, DAMAGED))
}

fn promised(count: usize) -> Option<usize> {
    count.checked_mul(TRIANGLE)?.checked_add(HEAD)
}

fn binary(bytes: &[u8], count: usize, scale: f64) -> Result<RawSurface, Error> {
    let mut surface = RawSurface::new("number");
    surface.labels.reserve_exact(count);
    surface.triangles.reserve_exact(count);
    for (number, triangle) in bytes.chunks_exact(TRIANGLE).enumerate() {
        let mut corners = [0; 3];
        for (k, corner) in corners.iter_mut().enumerate() {
            let mut x = [0.0; 3];
            for (c, x) in x.iter_mut().enumerate() {
                let at = 12 * (k + 1) + 4 * c;
                let value = f32::from_le_bytes([triangle[at], triangle[at + 1], triangle[at + 2], triangle[at + 3]]);
                *x = scale * f64::from(value);
                if !x.is_finite() {
                    let place = format!("triangle {}", number + 1);
                    return Err(Error::new(place, format!("the coordinate {value} is not finite"), DAMAGED));
                }
            }
            *corner = surface.point(x);
        }
        surface.triangle(corners, number + 1);
    }
    Ok(surface.finish())
}

/// `solid name`, then `facet normal ...`, `outer loop`, three times `vertex x y z`, `endloop`, `endfacet`, and
/// `endsolid name`; several solids make up one surface.
fn text(bytes: &[u8], scale: f64) -> Result<RawSurface, Error> {
    let mut surface = RawSurface::new("on line");
    let mut corners: Vec<u32> = Vec::new();
    let (mut facet, mut inside) = (0, false);
    for (number, line) in (1..).zip(bytes.split(|&b| b == b'\n')) {
        let mut words = words(line);
        let Some(word) = words.next() else { continue };
        match word.to_ascii_lowercase().as_slice() {
            b"solid" | b"endsolid" | b"outer" | b"endloop" => {}
            b"facet" if inside => {
                return Err(on_line(number, format!("a facet begins before the one on line {facet} ends"), DAMAGED));
            }
            b"facet" => (facet, inside) = (number, true),
            b"vertex" if !inside || corners.len() == 3 => {
                let what = if inside { "a fourth vertex of one facet" } else { "a vertex outside of a facet" };
                return Err(on_line(number, what, DAMAGED));
            }
            b"vertex" => {
                let x = point(&mut words, number, scale)?;
                corners.push(surface.point(x));
            }
            b"endfacet" => {
                let [a, b, c] = corners[..] else {
                    let what = format!("the facet has {} vertices where three are needed", corners.len());
                    return Err(on_line(facet.max(1), what, DAMAGED));
                };
                surface.triangle([a, b, c], facet);
                corners.clear();
                inside = false;
            }
            _ => return Err(on_line(number, format!("{} is no word of an STL file", shown(word)), DAMAGED)),
        }
    }
    if inside {
        return Err(on_line(facet, "the file ends within this facet", DAMAGED));
    }
    finished(surface, "facet")
}
