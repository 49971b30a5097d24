//! The files of a job: results at the nodes, tables, and two accounts of the iteration.

use std::path::{Path, PathBuf};

use stiction::Error;
use stiction::friction::PointState;
use stiction::io::deck::{Deck, DeckLayer, Requests};
use stiction::io::frd::{Form, FrdTime, scientific};
use stiction::run::{self, Outcome, Prepared, StepRecord};

use super::tables;
use crate::frd::{Frd, refused};

/// Files under way.
pub(super) struct Files {
    job: PathBuf,
    layer: Option<DeckLayer>,
    requests: Requests,
    frd: Frd,
    dat: String,
    sta: String,
    cvg: String,
}

/// The file of a job with this ending. The name of a job may have dots.
pub(super) fn beside(job: &Path, ending: &str) -> PathBuf {
    let mut name = job.as_os_str().to_os_string();
    name.push(".");
    name.push(ending);
    name.into()
}

const STA: &str =
    "SUMMARY OF JOB INFORMATION\n  STEP      INC     ATT  ITRS     TOT TIME     STEP TIME      INC TIME\n";
const CVG: &str = "SUMMARY OF C0NVERGENCE INFORMATION\n  STEP   INC  ATT   ITER     CONT.   RESID.        CORR.      RESID.      CORR.\n\
                   \x20                             EL.    FORCE         DISP       FLUX        TEMP.\n\
                   \x20                             (#)     (%)           (%)        (%)         (%)\n";

impl Files {
    /// Begins the files of a job.
    pub(super) fn begin(job: &Path, deck: &Deck) -> Result<Files, Error> {
        let title = job.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
        let form = if deck.requests.binary { Form::Binary } else { Form::Ascii };
        let keys = deck.requests.file.clone();
        let files = Files {
            job: job.to_path_buf(),
            layer: deck.layer.clone(),
            requests: deck.requests.clone(),
            frd: Frd::begin(beside(job, "frd"), title, deck.labels.clone(), keys, form)?,
            dat: String::new(),
            sta: STA.into(),
            cvg: CVG.into(),
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
        let (body, surfaces) = (run::body_fields(prepared, outcome), run::surface_fields(prepared, outcome));
        self.frd.add_fields(prepared, outcome, step, &body, &surfaces)?;
        let of = tables::Answer {
            labels: self.frd.labels(),
            layer: self.layer.as_ref(),
            body: &body,
            surfaces: &surfaces,
            time: self.frd.at.time,
            step: self.frd.at.step,
        };
        self.dat += &tables::text(&self.requests, &of);
        self.account(outcome, step);
        self.texts()
    }

    /// A line for the increment, and one for each of its iterations.
    fn account(&mut self, outcome: &Outcome, step: Option<&StepRecord>) {
        let FrdTime { time, step: number, increment, .. } = self.frd.at;
        let (attempts, dt) = step.map_or((1, 1.0), |record| (record.attempts, record.dt));
        let history = &outcome.solution.history;
        let times: String = [time, time - self.frd.begin, dt].map(|t| format!("  {}", fortran(t, 6))).concat();
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
    pub(super) fn end(self) -> Result<(), Error> {
        self.frd.end()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_look_as_ccx_writes_them() {
        let shown = [1.0, 0.05, 2.5e-7, 99.999_999_9, 0.0].map(|time| fortran(time, 6));
        assert_eq!(shown, ["0.100000E+01", "0.500000E-01", "0.250000E-06", "0.100000E+03", "0.000000E+00"]);
    }
}
