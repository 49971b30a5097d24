//! What the interactive view shows, and how it stands in the file: numbers in 16 bits, in base64.

use serde_json::{Value, json};

use super::text::base64;

/// A body and its contact surfaces, with fields over their vertices for each moment.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct View {
    /// Where the vertices are before any load, length; those of contact surfaces come last.
    pub points: Vec<[f64; 3]>,
    /// Where the vertices of contact surfaces begin.
    pub first_contact_point: usize,
    /// Vertices of each face; a triangle repeats its last.
    pub faces: Vec<[u32; 4]>,
    /// Where the faces of contact surfaces begin.
    pub first_contact_face: usize,
    pub fields: Vec<Field>,
    pub frames: Vec<Frame>,
    /// What the view leaves out, one sentence each.
    pub notes: Vec<String>,
}

/// A scalar over the vertices.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Field {
    pub label: &'static str,
    pub unit: String,
    /// Whether it is the state of contact: 0 open, 1 stick, 2 slip, -1 held.
    pub status: bool,
}

/// One moment: a load step, or the only one.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Frame {
    /// What the reader calls it.
    pub name: String,
    /// Of each vertex, length.
    pub displacement: Vec<[f64; 3]>,
    /// For each field a number a vertex, NaN where there is none.
    pub values: Vec<Vec<f64>>,
}

/// The largest code of a number; [`NONE`] says that there is none.
const STEPS: f64 = 65534.0;
const NONE: u16 = 65535;
/// The largest code of a component of a displacement.
const SIGNED_STEPS: f64 = 32767.0;

/// The view as JSON: what `viewer.js` decodes.
///
/// Coordinates and fields run in 65534 steps from the lowest to the highest, displacements in 32767 steps up to the
/// largest component.
pub(super) fn encoded(view: &View) -> Value {
    let axis = |c: usize| Range::of(view.points.iter().map(|x| x[c]));
    let axes = [axis(0), axis(1), axis(2)];
    let position = view.points.iter().flat_map(|x| [0, 1, 2].map(|c| axes[c].code(x[c])));
    let small = view.points.len() <= usize::from(u16::MAX);
    let corners = view.faces.iter().flatten();
    let faces = if small {
        base64(corners.flat_map(|&v| (v as u16).to_le_bytes()))
    } else {
        base64(corners.flat_map(|&v| v.to_le_bytes()))
    };
    json!({
        "low": axes.map(|r| r.low),
        "high": axes.map(|r| r.high),
        "position": base64(position.flat_map(u16::to_le_bytes)),
        "points": view.points.len(),
        "firstContactPoint": view.first_contact_point,
        "faces": faces,
        "indexBytes": if small { 2 } else { 4 },
        "firstContactFace": view.first_contact_face,
        "fields": view.fields.iter().map(|f| json!({
            "label": f.label,
            "unit": f.unit,
            "status": f.status,
        })).collect::<Vec<_>>(),
        "frames": view.frames.iter().map(frame).collect::<Vec<_>>(),
    })
}

fn frame(frame: &Frame) -> Value {
    let largest =
        frame.displacement.iter().flatten().fold(0.0f64, |a, u| if u.is_finite() { a.max(u.abs()) } else { a });
    let unit = if largest > 0.0 { largest } else { 1.0 };
    let code = |u: &f64| if u.is_finite() { (u / unit * SIGNED_STEPS).round() as i16 } else { 0 };
    let displacement = frame.displacement.iter().flatten().map(code);
    let fields = frame.values.iter().map(|values| {
        let range = Range::of(values.iter().copied());
        json!({
            "low": range.low,
            "high": range.high,
            "data": base64(values.iter().flat_map(|&v| range.code(v).to_le_bytes())),
        })
    });
    json!({
        "name": frame.name,
        "largest": unit,
        "displacement": base64(displacement.flat_map(i16::to_le_bytes)),
        "values": fields.collect::<Vec<_>>(),
    })
}

/// The finite numbers of an array.
#[derive(Clone, Copy)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = values.filter(|v| v.is_finite()).fold(start, |(l, h), v| (l.min(v), h.max(v)));
        if low <= high { Range { low, high } } else { Range { low: 0.0, high: 0.0 } }
    }

    fn code(self, value: f64) -> u16 {
        if !value.is_finite() {
            return NONE;
        }
        // Halves, so that the difference of the ends cannot overflow.
        let size = self.high / 2.0 - self.low / 2.0;
        if size > 0.0 { ((value / 2.0 - self.low / 2.0) / size * STEPS).round() as u16 } else { 0 }
    }
}
