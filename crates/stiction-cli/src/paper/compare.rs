//! A number of ours beside a published one.

/// How far a number may lie from the published one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Band {
    /// Reported, not judged.
    None,
    /// Relative deviation.
    Relative(f64),
    /// Counts: so many steps, or this part of the published count where it is above `from`.
    Steps { steps: f64, relative: f64, from: f64 },
    /// Between the published number over this factor and times it.
    Factor(f64),
}

impl Band {
    /// Whether `ours` lies in the band.
    pub fn holds(self, published: f64, ours: f64) -> bool {
        let off = (ours - published).abs();
        match self {
            Band::None => true,
            Band::Relative(most) => off <= most * published.abs(),
            Band::Steps { steps, relative, from } => off <= self::steps(steps, relative, from, published),
            Band::Factor(most) => ours <= most * published && published <= most * ours,
        }
    }

    /// `within 10 %`; empty without a band.
    pub fn words(self) -> String {
        match self {
            Band::None => String::new(),
            Band::Relative(most) => format!("within {:.0} %", 100.0 * most),
            Band::Steps { steps, relative, from } if relative > 0.0 && from > 0.0 => {
                format!("within {steps}, above {from} within {:.0} %", 100.0 * relative)
            }
            Band::Steps { steps, relative, .. } if relative > 0.0 => {
                format!("within {steps} or {:.0} %", 100.0 * relative)
            }
            Band::Steps { steps, .. } => format!("within {steps}"),
            Band::Factor(most) => format!("within a factor {most}"),
        }
    }
}

fn steps(steps: f64, relative: f64, from: f64, published: f64) -> f64 {
    if published > from { steps.max(relative * published) } else { steps }
}

/// What became of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Within,
    Outside,
    /// Outside its band, as the project's study says, with what is known of it.
    Known(&'static str),
    /// No band, or nothing published.
    Unjudged,
}

impl Verdict {
    /// Holds our number against the published one; `known` is what the study says of it should it lie outside. A run
    /// that was given up where the paper's ended lies outside as well.
    pub fn of(band: Band, published: Option<f64>, ours: Option<f64>, known: Option<&'static str>) -> Verdict {
        match (band, published, ours) {
            (Band::None, _, _) | (_, None, _) => Verdict::Unjudged,
            (band, Some(published), Some(ours)) if band.holds(published, ours) => Verdict::Within,
            _ => known.map_or(Verdict::Outside, Verdict::Known),
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Verdict::Within => "within",
            Verdict::Outside => "outside",
            Verdict::Known(_) => "outside, documented",
            Verdict::Unjudged => "reported",
        }
    }
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Executions of Step 2.
    Iterations,
    /// Quadratic programs of size 3m.
    QpProblems,
    /// Steps of conjugate gradients.
    CgSteps,
    /// Operations over those of the reference run, per cent.
    Efficiency,
    /// Relative error of the multipliers of (D)_N.
    Precision,
    /// Relative change from N - 2 squares to N.
    Change,
    /// `|Psi(g) - g| / |g|`.
    FixedPoint,
}

impl Quantity {
    /// The heading the paper uses.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Iterations => "Iter",
            Quantity::QpProblems => "QPPs",
            Quantity::CgSteps => "Cg step",
            Quantity::Efficiency => "Eff (%)",
            Quantity::Precision => "Prec",
            Quantity::Change => "Rel error",
            Quantity::FixedPoint => "Cont",
        }
    }

    /// A value as the tables print it.
    pub fn show(self, value: f64) -> String {
        match self {
            Quantity::Iterations | Quantity::QpProblems | Quantity::CgSteps => format!("{value:.0}"),
            Quantity::Efficiency if value >= 100.0 => format!("{value:.0}"),
            Quantity::Efficiency => format!("{value:.2}"),
            Quantity::Change => format!("{value:.4}"),
            Quantity::Precision | Quantity::FixedPoint => format!("{value:.1e}"),
        }
    }
}

/// One number of ours beside the published one.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The run as the table names it, such as `variant 1, splitting no`.
    pub run: String,
    pub quantity: Quantity,
    /// The setting of ours, such as `fitted`.
    pub setting: &'static str,
    pub published: Option<f64>,
    pub ours: Option<f64>,
    pub band: Band,
    pub verdict: Verdict,
    /// What must be said beside the number; may be empty.
    pub note: String,
}

impl Comparison {
    /// `ours / published - 1`.
    pub fn deviation(&self) -> Option<f64> {
        Some(self.ours? / self.published? - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_given_up_lies_outside_and_what_was_not_published_is_not_judged() {
        let band = Band::Relative(0.1);
        assert_eq!(Verdict::of(band, Some(100.0), Some(109.0), Some("why")), Verdict::Within);
        assert_eq!(Verdict::of(band, Some(100.0), Some(89.0), Some("why")), Verdict::Known("why"));
        assert_eq!(Verdict::of(band, Some(100.0), None, None), Verdict::Outside);
        assert_eq!(Verdict::of(band, None, Some(1.0), None), Verdict::Unjudged);
        assert_eq!(Verdict::of(Band::None, Some(1.0), Some(9.0), None), Verdict::Unjudged);
    }

    #[test]
    fn bands_hold_up_to_their_ends() {
        assert!(Band::Relative(0.1).holds(100.0, 110.0) && !Band::Relative(0.1).holds(100.0, 111.0));
        assert!(Band::Factor(2.0).holds(10.0, 5.0) && !Band::Factor(2.0).holds(10.0, 21.0));
        let counts = Band::Steps { steps: 1.0, relative: 0.1, from: 20.0 };
        assert!(counts.holds(8.0, 9.0) && !counts.holds(14.0, 16.0) && counts.holds(60.0, 66.0));
        assert!(!counts.holds(62.0, 69.0) && counts.words() == "within 1, above 20 within 10 %");
        assert!(Band::Steps { steps: 1.0, relative: 0.1, from: 0.0 }.holds(100.0, 90.0));
        assert!(!Band::Relative(0.1).holds(1.0, f64::NAN) && !Band::Factor(2.0).holds(1.0, f64::NAN));
    }
}
