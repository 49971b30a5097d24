//! Readers of surfaces of triangles: STL, as text and binary, and Wavefront OBJ.
//!
//! Formats: StereoLithography Interface Specification, 3D Systems, 1988; Wavefront Object file specification 3.0, of
//! which vertices and faces are read. Points of equal coordinates are one point; normals follow from the order of the
//! corners, those in the file are not read.

mod obj;
mod stl;
#[cfg(test)]
mod tests;

use std::path::Path;

use super::number::float;
use crate::Error;
use crate::contact::RawSurface;

const DAMAGED: &str = "export the surface again, as STL or OBJ";

/// The surface in the file at `path`, its coordinates multiplied by `scale` > 0; the ending of the name gives the
/// format, `.stl` or `.obj`.
///
/// # Errors
/// They name the file, the line or the number of the triangle, what is wrong there, and the remedy.
pub fn read(path: &Path, scale: f64) -> Result<RawSurface, Error> {
    let name = path.display().to_string();
    let ending = path.extension().map_or(String::new(), |e| e.to_string_lossy().to_lowercase());
    let parse = match ending.as_str() {
        "stl" => parse_stl,
        "obj" => parse_obj,
        _ => {
            let what = "the name of a surface file ends in .stl or .obj, this one does not";
            return Err(Error::new(name, what, "convert it to STL or OBJ"));
        }
    };
    let bytes = std::fs::read(path).map_err(|e| {
        let what = format!("the surface file cannot be read ({e})");
        Error::new(name.clone(), what, "check its path and permissions")
    })?;
    parse(&bytes, &name, scale)
}

/// The surface in the `bytes` of an STL file, called `source_name` in messages, its coordinates multiplied by `scale`.
///
/// Never panics, and never allocates more than a fixed multiple of the length of `bytes`.
///
/// # Errors
/// If it is no STL file or has no triangles.
pub fn parse_stl(bytes: &[u8], source_name: &str, scale: f64) -> Result<RawSurface, Error> {
    super::check_scale(scale).and_then(|()| stl::parse(bytes, scale)).map_err(|e| e.at(source_name))
}

/// The same of an OBJ file.
///
/// # Errors
/// If it is no OBJ file or has no faces.
pub fn parse_obj(bytes: &[u8], source_name: &str, scale: f64) -> Result<RawSurface, Error> {
    super::check_scale(scale).and_then(|()| obj::parse(bytes, scale)).map_err(|e| e.at(source_name))
}

/// The surface that has been read, if there is any `face` in it.
fn finished(surface: RawSurface, face: &str) -> Result<RawSurface, Error> {
    if surface.triangles.is_empty() && surface.collapsed == 0 {
        return Err(Error::new("", format!("there is no {face} in this file"), DAMAGED));
    }
    Ok(surface.finish())
}

/// An error on a line, counted from 1.
fn on_line(line: usize, what: impl Into<String>, remedy: &str) -> Error {
    Error::new(format!("line {line}"), what, remedy)
}

/// Three coordinates.
fn point<'a>(words: &mut impl Iterator<Item = &'a [u8]>, line: usize, scale: f64) -> Result<[f64; 3], Error> {
    let mut x = [0.0; 3];
    for (c, axis) in x.iter_mut().zip(["x", "y", "z"]) {
        let Some(word) = words.next() else {
            return Err(on_line(line, format!("a point without {axis}"), DAMAGED));
        };
        *c = scale * float(word).ok_or_else(|| on_line(line, format!("{} is no number", shown(word)), DAMAGED))?;
        if !c.is_finite() {
            return Err(on_line(line, format!("the coordinate {} is not finite", shown(word)), DAMAGED));
        }
    }
    Ok(x)
}

/// The words of a line.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A word as it can be shown, shortened.
fn shown(word: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(word).chars().take(30).collect();
    format!("{text:?}")
}
