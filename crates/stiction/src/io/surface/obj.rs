//! Wavefront OBJ: `v x y z` and `f a b c ...`; all else is passed over.

use super::{DAMAGED, finished, on_line, point, shown, words};
use crate::Error;
use crate::contact::RawSurface;
use crate::io::number::integer;

pub(super) fn parse(bytes: &[u8], scale: f64) -> Result<RawSurface, Error> {
    let mut surface = RawSurface::new("on line");
    // The point of each vertex of the file, those of equal coordinates being one.
    let mut vertices: Vec<u32> = Vec::new();
    let mut corners: Vec<u32> = Vec::new();
    for (number, line) in (1..).zip(bytes.split(|&b| b == b'\n')) {
        let mut words = words(line);
        match words.next() {
            Some(b"v") => {
                let x = point(&mut words, number, scale)?;
                vertices.push(surface.point(x));
            }
            Some(b"f") => {
                corners.clear();
                for word in words {
                    corners.push(vertices[vertex(word, vertices.len(), number)?]);
                }
                polygon(&mut surface, &corners, number)?;
            }
            Some(word @ (b"cstype" | b"curv" | b"surf" | b"bzp" | b"bsp" | b"res")) => {
                let what = format!("{} begins a curved surface, and only triangles and polygons are read", shown(word));
                return Err(on_line(number, what, "export it as a mesh of triangles"));
            }
            Some(word) if !word[0].is_ascii_alphabetic() && word[0] != b'#' => {
                return Err(on_line(number, format!("{} is no word of an OBJ file", shown(word)), DAMAGED));
            }
            _ => {}
        }
    }
    finished(surface, "face")
}

/// The place of a vertex named as `7`, `7/1`, `7//3` or, counted back from the last one, `-1`.
fn vertex(word: &[u8], count: usize, line: usize) -> Result<usize, Error> {
    if word == b"\\" {
        return Err(on_line(line, "the face goes on on the next line", "write each face on one line"));
    }
    let label = word.split(|&b| b == b'/').next().unwrap_or(word);
    let Some(number) = integer(label) else {
        return Err(on_line(line, format!("{} is no number of a vertex", shown(word)), DAMAGED));
    };
    let place = if number < 0 { count as i64 + number } else { number - 1 };
    usize::try_from(place).ok().filter(|&place| place < count).ok_or_else(|| {
        on_line(line, format!("there is no vertex {number} among the {count} before this line"), DAMAGED)
    })
}

/// Cuts a polygon into triangles around its first corner.
fn polygon(surface: &mut RawSurface, corners: &[u32], line: usize) -> Result<(), Error> {
    if corners.len() < 3 {
        let what = format!("a face of {} corners", corners.len());
        return Err(on_line(line, what, "take out faces with fewer than three corners"));
    }
    if corners.len() > 3 {
        let mut sorted = corners.to_vec();
        sorted.sort_unstable();
        if sorted.windows(2).any(|pair| pair[0] == pair[1]) {
            let what = "a polygon has two corners at the same place";
            return Err(on_line(line, what, "cut it into polygons without it, or into triangles"));
        }
    }
    for pair in corners[1..].windows(2) {
        surface.triangle([corners[0], pair[0], pair[1]], line);
    }
    Ok(())
}
