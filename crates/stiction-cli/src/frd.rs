//! Files of results as CalculiX writes them (.frd), for cgx, ccx2paraview, FreeCAD and PrePoMax.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use stiction::Error;
use stiction::io::deck::DeckLabels;
use stiction::io::frd::{self, Form, FrdMesh, FrdTime, Quantity};
use stiction::run::{self, BodyFields, Outcome, Prepared, Side, StepRecord, SurfaceFields};

/// All that a file of results may hold, by the keys of `*NODE FILE`, `*EL FILE` and `*CONTACT FILE`.
const ALL: [&str; 5] = ["U", "S", "E", "RF", "CDIS"];

/// A file under way.
pub struct Frd {
    path: PathBuf,
    title: String,
    /// Numbers of nodes and cells; empty without a deck until there is an answer: then they count from 1.
    labels: DeckLabels,
    /// What is written, by its keys.
    keys: Vec<String>,
    form: Form,
    out: BufWriter<File>,
    /// Blocks of results so far.
    blocks: usize,
    /// Of the last answer.
    pub at: FrdTime,
    /// Name and end of the step before.
    before: (String, f64),
    /// Beginning of the present step.
    pub begin: f64,
}

/// An error of the system about a file.
pub fn refused(path: &Path, error: &std::io::Error) -> Error {
    Error::new(path.display().to_string(), format!("it cannot be written ({error})"), "make room, or run it elsewhere")
}

impl Frd {
    /// Begins a file; `keys` are those of a deck.
    pub fn begin(
        path: PathBuf,
        title: String,
        labels: DeckLabels,
        keys: Vec<String>,
        form: Form,
    ) -> Result<Frd, Error> {
        let out = BufWriter::new(File::create(&path).map_err(|error| refused(&path, &error))?);
        let (at, before) = (FrdTime { time: 0.0, step: 0, increment: 0, count: 0 }, (String::new(), 0.0));
        Ok(Frd { path, title, labels, keys, form, out, blocks: 0, at, before, begin: 0.0 })
    }

    /// Begins a file of text with all that it may hold.
    pub fn whole(path: &Path, labels: DeckLabels) -> Result<Frd, Error> {
        let title = path.file_stem().map_or(String::new(), |name| name.to_string_lossy().into_owned());
        Frd::begin(path.to_path_buf(), title, labels, ALL.map(str::to_string).into(), Form::Ascii)
    }

    /// Numbers of nodes and cells.
    pub fn labels(&self) -> &DeckLabels {
        &self.labels
    }

    /// Adds an answer, that of an increment or of all at once.
    pub fn add(&mut self, prepared: &Prepared, outcome: &Outcome, step: Option<&StepRecord>) -> Result<(), Error> {
        let (body, surfaces) = (run::body_fields(prepared, outcome), run::surface_fields(prepared, outcome));
        self.add_fields(prepared, outcome, step, &body, &surfaces)
    }

    /// The same of fields that are known.
    pub fn add_fields(
        &mut self,
        prepared: &Prepared,
        outcome: &Outcome,
        step: Option<&StepRecord>,
        body: &BodyFields,
        surfaces: &[SurfaceFields],
    ) -> Result<(), Error> {
        self.advance(prepared, step);
        self.results(prepared, outcome, body, surfaces).map_err(|error| refused(&self.path, &error))
    }

    /// Which step and increment this is.
    fn advance(&mut self, prepared: &Prepared, step: Option<&StepRecord>) {
        self.at.count += 1;
        let Some(record) = step else {
            self.at = FrdTime { time: 1.0, step: 1, increment: 1, count: 1 };
            return;
        };
        let number = prepared.loading.steps.iter().position(|step| step.name == record.name).unwrap_or(0) + 1;
        if number != self.at.step {
            (self.at.increment, self.begin) = (0, self.before.1);
        }
        self.at = FrdTime { time: record.t, step: number, increment: self.at.increment + 1, ..self.at };
        self.before = (record.name.clone(), record.t);
    }

    fn results(
        &mut self,
        prepared: &Prepared,
        outcome: &Outcome,
        body: &BodyFields,
        surfaces: &[SurfaceFields],
    ) -> std::io::Result<()> {
        if self.labels.nodes.is_empty() {
            self.labels = own_labels(prepared);
        }
        let (form, labels) = (self.form, &self.labels);
        let of = FrdMesh {
            mesh: &prepared.mesh,
            nodes: &labels.nodes,
            cells: &labels.cells,
            materials: &prepared.material_of_cell,
        };
        if self.blocks == 0 && self.at.count == 1 {
            let version = format!("Version {}", env!("CARGO_PKG_VERSION"));
            let lines = [("USER", ""), ("PGM", "stiction"), ("VERSION", &version), ("DBN", &self.title)];
            let lines = lines.map(|(name, text)| frd::heading(name, text)).into_iter();
            let materials = (1..).zip(&prepared.materials).map(|(i, material)| format!("MAT{i:5}{}", material.name));
            let heading: Vec<String> = lines.chain(materials).collect();
            frd::write_mesh(&mut self.out, &of, form, &heading)?;
        }
        let asked = |keys: &[&str]| self.keys.iter().any(|key| keys.contains(&key.as_str()));
        let [displacement, stress, strain, force, contact] =
            [&["U"][..], &["S"], &["E"], &["RF"], &["CDIS", "CSTR"]].map(asked);
        let mut next = |quantity| {
            self.blocks += 1;
            (quantity, self.blocks)
        };
        let (out, at) = (&mut self.out, &self.at);
        if displacement {
            frd::write_results(out, &of, form, next(Quantity::Displacement), at, &body.displacement)?;
        }
        if stress || strain {
            let nodal = run::nodal_stress_of(prepared, &outcome.solution.u);
            if stress {
                frd::write_results(out, &of, form, next(Quantity::Stress), at, &nodal.stress)?;
            }
            if strain {
                frd::write_results(out, &of, form, next(Quantity::Strain), at, &nodal.strain)?;
            }
        }
        if force {
            frd::write_results(out, &of, form, next(Quantity::Force), at, &body.reaction)?;
        }
        if contact && !surfaces.is_empty() {
            let values = contact_values(prepared.mesh.nodes.len(), surfaces);
            frd::write_results(out, &of, form, next(Quantity::Contact), at, &values)?;
        }
        Ok(())
    }

    /// Ends the file.
    pub fn end(mut self) -> Result<(), Error> {
        frd::write_end(&mut self.out).and_then(|()| self.out.flush()).map_err(|error| refused(&self.path, &error))
    }
}

/// Nodes and cells from 1 on.
fn own_labels(prepared: &Prepared) -> DeckLabels {
    let from_one = |count: usize| (1..=count as u32).collect();
    DeckLabels { nodes: from_one(prepared.mesh.nodes.len()), cells: from_one(prepared.mesh.cell_count()) }
}

/// Opening, slip, pressure and shear at each node: those of the surfaces with the contact points, zero elsewhere. The axes are those of
/// CalculiX: the first is the x-axis brought into the surface of the master, or the z-axis where x is normal to it; the second
/// completes them with the master's normal.
fn contact_values(nodes: usize, surfaces: &[SurfaceFields]) -> Vec<[f64; 6]> {
    let mut values = vec![[0.0; 6]; nodes];
    for s in surfaces.iter().filter(|s| s.side == Side::Slave) {
        for at in (0..s.nodes.len()).filter(|&at| s.status[at] >= 0) {
            let axes = axes(s.normal[at].map(|n| -n));
            let [slip, shear] = [s.slid[at], s.shear[at]].map(|v| axes.map(|axis| dot(axis, v)));
            let pressure = s.pressure[at];
            values[s.nodes[at] as usize] = [s.gap[at], slip[0], slip[1], pressure, shear[0], shear[1]];
        }
    }
    values
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Two unit vectors along a surface with the unit normal `n`.
fn axes(n: [f64; 3]) -> [[f64; 3]; 2] {
    // Beyond this the x-axis has no direction along the surface to speak of.
    const ALONG: f64 = 0.999_99;
    let start = if n[0].abs() > ALONG { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let level: [f64; 3] = std::array::from_fn(|c| start[c] - dot(start, n) * n[c]);
    let first = level.map(|x| x / dot(level, level).sqrt());
    let second =
        [n[1] * first[2] - n[2] * first[1], n[2] * first[0] - n[0] * first[2], n[0] * first[1] - n[1] * first[0]];
    [first, second]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_of_a_surface_are_right_handed_with_its_normal() {
        assert_eq!(axes([0.0, 0.0, 1.0]), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(axes([1.0, 0.0, 0.0]), [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]);
        let r = 0.5f64.sqrt();
        let [first, second] = axes([r, 0.0, r]);
        assert!((first[0] - r).abs() < 1e-15 && (first[2] + r).abs() < 1e-15 && (second[1] - 1.0).abs() < 1e-15);
    }
}
