use crate::Error;
use crate::contact::{ContactProblem, Friction};
use crate::linalg::Csr;

/// Coulomb friction at points whose relative velocity is a linear function of their impulses, as the collection FCLib
/// exchanges it (Acary, Brémond, Koziara, Pérignon 2014). `m` points, `d` components each, point by point: the normal
/// one first, then the tangential ones. Any consistent units.
///
/// ```text
/// u = W r + q + V l,   V' r + R l + s = 0
/// 0 <= u_n  perp  r_n >= 0,   |r_t| <= mu r_n,   u_t != 0  =>  r_t = -mu r_n u_t / |u_t|
/// ```
/// `W` may be singular and not symmetric.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalProblem {
    /// `d`: 2 or 3.
    pub dimension: usize,
    /// `dm x dm`, velocity per impulse.
    pub W: Csr,
    /// Relative velocity without contact, `dm`.
    pub q: Vec<f64>,
    /// Coefficient of friction, `m`, at least zero.
    pub mu: Vec<f64>,
    /// Bilateral constraints.
    pub bilateral: Option<Bilateral>,
}

/// Constraints without a sign among those of a [`LocalProblem`]: `V' r + R l + s = 0`, `p` rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Bilateral {
    /// `dm x p`.
    pub V: Csr,
    /// `p x p`.
    pub R: Csr,
    /// `p`.
    pub s: Vec<f64>,
}

/// The same with the velocities `v` of the bodies as unknowns, `n` of them:
///
/// ```text
/// M v = H r + f + G l,   u = H' v + w,   G' v + b = 0
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct GlobalProblem {
    /// `d`: 2 or 3.
    pub dimension: usize,
    /// Mass or stiffness, `n x n`, regular.
    pub M: Csr,
    /// Directions of the impulses, `n x dm`.
    pub H: Csr,
    /// Impulses from outside, `n`.
    pub f: Vec<f64>,
    /// `dm`.
    pub w: Vec<f64>,
    /// Coefficient of friction, `m`, at least zero.
    pub mu: Vec<f64>,
    /// Bilateral constraints.
    pub equalities: Option<Equalities>,
}

/// Constraints without a sign of a [`GlobalProblem`]: `G' v + b = 0`, `p` of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Equalities {
    /// `n x p`.
    pub G: Csr,
    /// `p`.
    pub b: Vec<f64>,
}

/// A problem in either form.
#[derive(Debug, Clone, PartialEq)]
pub enum DiscreteProblem {
    /// `u = W r + q`.
    Local(LocalProblem),
    /// `M v = H r + f`, `u = Hᵀ v + w`.
    Global(GlobalProblem),
}

impl DiscreteProblem {
    /// Number of contact points.
    pub fn points(&self) -> usize {
        self.mu().len()
    }

    /// Coefficients of friction.
    pub(super) fn mu(&self) -> &[f64] {
        match self {
            DiscreteProblem::Local(p) => &p.mu,
            DiscreteProblem::Global(p) => &p.mu,
        }
    }

    /// Components of a point, 2 or 3.
    pub fn dimension(&self) -> usize {
        match self {
            DiscreteProblem::Local(p) => p.dimension,
            DiscreteProblem::Global(p) => p.dimension,
        }
    }

    /// Checks every length, index and value once; the solvers trust a problem that passed.
    ///
    /// # Errors
    /// What does not fit, and where.
    pub fn validate(&self) -> Result<(), Error> {
        match self {
            DiscreteProblem::Local(p) => p.validate(),
            DiscreteProblem::Global(p) => p.validate(),
        }
    }
}

fn fits(name: &str, found: usize, wanted: usize) -> Result<(), Error> {
    if found == wanted {
        return Ok(());
    }
    let remedy = "the lengths of mu (m), q or w (d m), f (n) and the sizes of the matrices belong together";
    Err(Error::new("", format!("{name}: {found} where {wanted} are needed"), remedy))
}

fn finite(name: &str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(i) => Err(Error::new("", format!("{name}[{i}] is {}", values[i]), "give finite numbers")),
        None => Ok(()),
    }
}

fn matrix(name: &str, matrix: &Csr, rows: usize, cols: usize) -> Result<(), Error> {
    fits(&format!("rows of {name}"), matrix.rows, rows)?;
    fits(&format!("columns of {name}"), matrix.cols, cols)?;
    matrix.validate(name)
}

fn law(dimension: usize, mu: &[f64]) -> Result<(), Error> {
    if dimension != 2 && dimension != 3 {
        let what = format!("the points have {dimension} components");
        return Err(Error::new("", what, "points have two or three: the normal one and one or two tangential ones"));
    }
    if let Some(j) = mu.iter().position(|x| !(x.is_finite() && *x >= 0.0)) {
        let what = format!("mu[{j}] is {}", mu[j]);
        return Err(Error::new("", what, "a coefficient of friction is a finite number, at least zero"));
    }
    Ok(())
}

impl LocalProblem {
    /// The trace of the diagonal block of `W` at each point, `m`.
    pub fn traces(&self) -> Vec<f64> {
        let d = self.dimension;
        let trace = |a: usize| (d * a..d * (a + 1)).map(|i| self.W.entry(i, i)).sum();
        (0..self.mu.len()).map(trace).collect()
    }

    fn validate(&self) -> Result<(), Error> {
        law(self.dimension, &self.mu)?;
        let size = self.dimension * self.mu.len();
        fits("q", self.q.len(), size)?;
        matrix("W", &self.W, size, size)?;
        finite("q", &self.q)?;
        if let Some(Bilateral { V, R, s }) = &self.bilateral {
            matrix("V", V, size, s.len())?;
            matrix("R", R, s.len(), s.len())?;
            finite("s", s)?;
        }
        Ok(())
    }
}

impl GlobalProblem {
    fn validate(&self) -> Result<(), Error> {
        law(self.dimension, &self.mu)?;
        let (size, n) = (self.dimension * self.mu.len(), self.f.len());
        fits("w", self.w.len(), size)?;
        matrix("M", &self.M, n, n)?;
        matrix("H", &self.H, n, size)?;
        finite("f", &self.f)?;
        finite("w", &self.w)?;
        if let Some(Equalities { G, b }) = &self.equalities {
            matrix("G", G, n, b.len())?;
            finite("b", b)?;
        }
        Ok(())
    }

    /// A posed contact problem in this form: `M = K`, `H = -B'`, `w` the gap of the undeformed body.
    ///
    /// # Errors
    /// If a point has given or limited friction or cohesion, friction that differs by direction, or is bonded: the form knows
    /// Coulomb's law alone.
    pub fn of(problem: &ContactProblem) -> Result<Self, Error> {
        let m = problem.points();
        let coefficient = |(j, law): (usize, &Friction)| match law {
            Friction::None => Ok(0.0),
            Friction::Coulomb { coefficient } => Ok(*coefficient),
            Friction::Given { .. } | Friction::Limited { .. } | Friction::Cohesive { .. } | Friction::Bonded => {
                let what = format!("point {j} is bonded, or its friction is given, limited or with cohesion");
                Err(Error::new("", what, "this form of a problem knows Coulomb friction alone"))
            }
        };
        if let Some(j) = (0..m).find(|&j| problem.orthotropy_ratio(j) != 1.0) {
            let what = format!("friction at point {j} differs by direction");
            return Err(Error::new("", what, "this form of a problem knows one coefficient a point"));
        }
        let mu = problem.contact.friction.iter().enumerate().map(coefficient).collect::<Result<Vec<f64>, Error>>()?;
        let stacked: Vec<u32> = (0..3 * m).map(|i| (i % 3 * m + i / 3) as u32).collect();
        let mut transposed = problem.contact.B.select_rows(&stacked);
        transposed.value.iter_mut().for_each(|v| *v = -*v);
        let offset: Vec<f64> = problem.contact.gap.iter().chain(&problem.contact.slip_reference).copied().collect();
        Ok(GlobalProblem {
            dimension: 3,
            M: problem.elastic.K.full(),
            H: transposed.transpose(),
            f: problem.elastic.f.clone(),
            w: stacked.iter().map(|&i| offset[i as usize]).collect(),
            mu,
            equalities: None,
        })
    }
}
