//! The files of a job: results at the nodes, tables, and two accounts of the iteration.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use stiction::Error;
use stiction::friction::PointState;
use stiction::io::deck::{Deck, DeckLabels, DeckLayer, Requests};
use stiction::io::frd::{self, Form, FrdMesh, FrdTime, Quantity, scientific};
use stiction::run::{self, BodyFields, Outcome, Prepared, Side, StepRecord, SurfaceFields};

use super::tables;

/// Files under way.
pub(super) struct Files {
    job: PathBuf,
    labels: DeckLabels,
    layer: Option<DeckLayer>,
    requests: Requests,
    title: String,
    frd: BufWriter<File>,
    dat: String,
    sta: String,
    cvg: String,
    /// Blocks of results so far.
    blocks: usize,
    at: FrdTime,
    /// Name and end of the step before.
    before: (String, f64),
    /// Beginning of the present step.
    begin: f64,
}

/// The file of a job with this ending. The name of a job may have dots.
pub(super) fn beside(job: &Path, ending: &str) -> PathBuf {
    let mut name = job.as_os_str().to_os_string();
    name.push(".");
    name.push(ending);
    name.into()
}

fn refused(path: &Path, error: &std::io::Error) -> Error {
    Error::new(path.display().to_string(), format!("it cannot be written ({error})"), "make room, or run it elsewhere")
}

const STA: &str =
    "SUMMARY OF JOB INFORMATION\n  STEP      INC     ATT  ITRS     TOT TIME     STEP TIME      INC TIME\n";
const CVG: &str = "SUMMARY OF C0NVERGENCE INFORMATION\n  STEP   INC  ATT   ITER     CONT.   RESID.        CORR.      RESID.      CORR.\n\
                   \x20                             EL.    FORCE         DISP       FLUX        TEMP.\n\
                   \x20                             (#)     (%)           (%)        (%)         (%)\n";

impl Files {
    /// Begins the files of a job.
    pub(super) fn begin(job: &Path, deck: &Deck) -> Result<Files, Error> {
        let path = beside(job, "frd");
        let frd = File::create(&path).map_err(|error| refused(&path, &error))?;
        let files = Files {
            job: job.to_path_buf(),
            labels: deck.labels.clone(),
            layer: deck.layer.clone(),
            requests: deck.requests.clone(),
            title: job.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned()),
            frd: BufWriter::new(frd),
            dat: String::new(),
            sta: STA.into(),
            cvg: CVG.into(),
            blocks: 0,
            at: FrdTime { time: 0.0, step: 0, increment: 0, count: 0 },
            before: (String::new(), 0.0),
            begin: 0.0,
        };
        files.texts()?;
        Ok(files)
    }

    fn texts(&self) -> Result<(), Error> {
        [("dat", &self.dat), ("sta", &self.sta), ("cvg", &self.cvg)].into_iter().try_for_each(|(ending, text)| {
            let path = beside(&self.job, ending);
            std::fs::write(&path, text).map_err(|error| refused(&path, &error))
        })
    }

    /// What the deck asks for and is not given, in words.
    pub(super) fn unanswered(&self) -> Vec<String> {
        let known = ["U", "RF", "S", "E", "CDIS", "CSTR", "NOE", "RFL"];
        let missing: Vec<&str> =
            self.requests.file.iter().map(String::as_str).filter(|key| !known.contains(key)).collect();
        let mut out = Vec::new();
        if !missing.is_empty() {
            out.push(format!("{} of the deck's FILE or OUTPUT cards is not computed and left out", missing.join(", ")));
        }
        out.extend(tables::unanswered(&self.requests));
        out
    }

    /// Adds an answer, that of an increment or of all at once.
    pub(super) fn add(
        &mut self,
        prepared: &Prepared,
        outcome: &Outcome,
        step: Option<&StepRecord>,
    ) -> Result<(), Error> {
        let path = beside(&self.job, "frd");
        self.advance(prepared, step);
        let (body, surfaces) = (run::body_fields(prepared, outcome), run::surface_fields(prepared, outcome));
        self.results(prepared, outcome, &body, &surfaces).map_err(|error| refused(&path, &error))?;
        let of = tables::Answer {
            labels: &self.labels,
            layer: self.layer.as_ref(),
            body: &body,
            surfaces: &surfaces,
            time: self.at.time,
            step: self.at.step,
        };
        self.dat += &tables::text(&self.requests, &of);
        self.account(outcome, step);
        self.texts()
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
        let form = if self.requests.binary { Form::Binary } else { Form::Ascii };
        let of = FrdMesh {
            mesh: &prepared.mesh,
            nodes: &self.labels.nodes,
            cells: &self.labels.cells,
            materials: &prepared.material_of_cell,
        };
        if self.blocks == 0 && self.at.count == 1 {
            let version = format!("Version {}", env!("CARGO_PKG_VERSION"));
            let lines = [("USER", ""), ("PGM", "stiction"), ("VERSION", &version), ("DBN", &self.title)];
            let lines = lines.map(|(name, text)| frd::heading(name, text)).into_iter();
            let materials = (1..).zip(&prepared.materials).map(|(i, material)| format!("MAT{i:5}{}", material.name));
            let heading: Vec<String> = lines.chain(materials).collect();
            frd::write_mesh(&mut self.frd, &of, form, &heading)?;
        }
        let asked = |keys: &[&str]| self.requests.file.iter().any(|key| keys.contains(&key.as_str()));
        let [displacement, stress, strain, force, contact] =
            [&["U"][..], &["S"], &["E"], &["RF"], &["CDIS", "CSTR"]].map(asked);
        let mut next = |quantity| {
            self.blocks += 1;
            (quantity, self.blocks)
        };
        let (out, at) = (&mut self.frd, &self.at);
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

    /// A line for the increment, and one for each of its iterations.
    fn account(&mut self, outcome: &Outcome, step: Option<&StepRecord>) {
        let FrdTime { time, step: number, increment, .. } = self.at;
        let (attempts, dt) = step.map_or((1, 1.0), |record| (record.attempts, record.dt));
        let history = &outcome.solution.history;
        let times: String = [time, time - self.begin, dt].map(|t| format!("  {}", fortran(t, 6))).concat();
        self.sta += &format!("{number:6} {increment:10} {attempts:5} {:5}{times}\n", history.len());
        let touching = outcome.solution.states.iter().filter(|state| **state != PointState::Open).count();
        for (iteration, progress) in (1..).zip(history) {
            let points = if progress.open + progress.stick + progress.slip == 0 {
                touching
            } else {
                progress.stick + progress.slip
            };
            let percent = |value: f64| scientific(100.0 * value, 10, 4);
            let (residual, none) = (percent(progress.residual), percent(0.0));
            self.cvg += &format!(
                "{number:6} {increment:5} {attempts:5} {iteration:5} {points:8}  {residual}  {none}  {none}  {none}\n"
            );
        }
    }

    /// Ends the file of results.
    pub(super) fn end(mut self) -> Result<(), Error> {
        let path = beside(&self.job, "frd");
        frd::write_end(&mut self.frd).and_then(|()| self.frd.flush()).map_err(|error| refused(&path, &error))
    }
}

/// A number as `ccx` writes times: 0.100000E+01.
pub(super) fn fortran(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return format!("{value:.digits$}E+00");
    }
    let exponent = value.abs().log10().floor() as i32 + 1;
    let (mantissa, exponent) = match value / 10f64.powi(exponent) {
        // Rounding may reach one.
        mantissa if mantissa.abs() >= 1.0 - 0.5 * 0.1f64.powi(digits as i32) => (mantissa / 10.0, exponent + 1),
        mantissa => (mantissa, exponent),
    };
    format!("{mantissa:.digits$}E{}{:02}", if exponent < 0 { '-' } else { '+' }, exponent.abs())
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
    fn times_look_as_ccx_writes_them() {
        let shown = [1.0, 0.05, 2.5e-7, 99.999_999_9, 0.0].map(|time| fortran(time, 6));
        assert_eq!(shown, ["0.100000E+01", "0.500000E-01", "0.250000E-06", "0.100000E+03", "0.000000E+00"]);
    }

    #[test]
    fn the_axes_of_a_surface_are_right_handed_with_its_normal() {
        assert_eq!(axes([0.0, 0.0, 1.0]), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(axes([1.0, 0.0, 0.0]), [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]);
        let r = 0.5f64.sqrt();
        let [first, second] = axes([r, 0.0, r]);
        assert!((first[0] - r).abs() < 1e-15 && (first[2] + r).abs() < 1e-15 && (second[1] - 1.0).abs() < 1e-15);
    }
}
