//! The tables of J. Haslinger, R. Kucera, Z. Dostal, J. Comput. Appl. Math. 164-165 (2004) 387-408 with the fitted choices
//! of the study, mostly on partition 1. The bands were stated from two independent prototypes before these runs were made.

use std::ops::ControlFlow;
use std::sync::LazyLock;

use super::compare::{Quantity, Verdict};
use super::published::published;
use super::study::Study;
use super::{Request, study};

static QUICK: LazyLock<Study> = LazyLock::new(|| {
    let request = Request { tables: vec![1, 3, 4, 6, 8, 9, 10, 12], figures: Vec::new(), quick: true };
    study(&request, &mut |_| ControlFlow::Continue(())).unwrap()
});

/// Published and own numbers of a quantity of a table, run by run.
fn pairs(table: usize, quantity: Quantity) -> Vec<(String, f64, f64)> {
    let report = QUICK.tables.iter().find(|t| t.number == table).unwrap();
    let found = report.comparisons.iter().filter(|c| c.quantity == quantity);
    found.filter_map(|c| Some((c.run.clone(), c.published?, c.ours?))).collect()
}

#[test]
fn iterations_of_alg1_and_their_changes_with_the_number_of_squares_are_those_published() {
    let iterations = [pairs(1, Quantity::Iterations), pairs(3, Quantity::Iterations)].concat();
    assert_eq!(iterations.len(), 9);
    for (run, paper, ours) in iterations {
        assert!((ours - paper).abs() <= 0.1 * paper, "{run}: {ours}, published {paper}");
    }
    let changes = pairs(3, Quantity::Change);
    assert_eq!(changes.iter().map(|c| c.1).collect::<Vec<_>>(), [0.066, 0.022]);
    for (run, paper, ours) in changes {
        assert!((ours - paper).abs() <= 0.1 * paper, "{run}: {ours}, published {paper}");
    }
}

#[test]
fn coulomb_changes_with_the_number_of_squares_are_those_published() {
    // Table 9 depends neither on the loads nor on the start: no fit stands behind it.
    let changes = pairs(9, Quantity::Change);
    assert_eq!(changes.iter().map(|c| c.1).collect::<Vec<_>>(), [0.0244, 0.0077]);
    for (run, paper, ours) in changes {
        assert!((ours - paper).abs() <= 0.15 * paper, "{run}: {ours}, published {paper}");
    }
}

#[test]
fn iterations_of_alg2_and_cfs2_are_those_published() {
    let given = pairs(4, Quantity::Iterations);
    assert_eq!(given.len(), 9, "log rho = -10 .. -2");
    for (run, paper, ours) in given {
        assert!((ours - paper).abs() <= f64::max(1.0, 0.1 * paper), "{run}: {ours}, published {paper}");
    }
    let coulomb = pairs(10, Quantity::Iterations);
    assert_eq!(coulomb.len(), 8, "log rho = -10 .. -3");
    for (run, paper, ours) in coulomb {
        let band = if paper > 20.0 { 0.1 * paper } else { 1.0 };
        assert!((ours - paper).abs() <= band, "{run}: {ours}, published {paper}");
    }
}

#[test]
fn steps_of_conjugate_gradients_are_near_those_published() {
    let steps = pairs(4, Quantity::CgSteps)
        .into_iter()
        .filter(|(run, _, _)| ["-9", "-8", "-7"].iter().any(|rho| run.ends_with(rho)));
    let steps: Vec<_> = steps.collect();
    assert_eq!(steps.len(), 3);
    for (run, paper, ours) in steps {
        assert!((ours - paper).abs() <= 0.3 * paper, "{run}: {ours}, published {paper}");
    }
    // Rounding decides where between 368 and 470 this one lies (26 runs), on both sides of its band.
    let (_, _, ours) = pairs(4, Quantity::CgSteps).into_iter().find(|(run, _, _)| run.ends_with("-6")).unwrap();
    assert!((350.0..=490.0).contains(&ours), "{ours}");
}

#[test]
fn nothing_lies_outside_its_band_but_what_is_documented() {
    let all: Vec<_> = QUICK.tables.iter().flat_map(|t| t.comparisons.iter().map(|c| (t.number, c))).collect();
    let of = |wanted: fn(Verdict) -> bool| all.iter().filter(|(_, c)| wanted(c.verdict)).collect::<Vec<_>>();
    assert!(of(|v| v == Verdict::Outside).is_empty(), "{:#?}", of(|v| v == Verdict::Outside));
    assert!(of(|v| v == Verdict::Within).len() >= 50, "{}", of(|v| v == Verdict::Within).len());
    let mut known: Vec<_> = of(|v| matches!(v, Verdict::Known(_))).iter().map(|(n, c)| (*n, c.run.as_str())).collect();
    // Near the end of its band and sensitive to rounding; see `known.rs`.
    known.retain(|&it| it != (4, "log rho = -6"));
    assert_eq!(known, [(6, "log rho = -8, N = 6"), (12, "partition 1, N = 6")]);
}

#[test]
fn what_is_judged_is_what_was_printed() {
    for report in &QUICK.tables {
        let table = published(report.number).unwrap();
        let printed: Vec<f64> = table.rows.iter().flatten().filter_map(|cell| cell.parse().ok()).collect();
        for c in &report.comparisons {
            assert!(c.published.is_none_or(|p| printed.contains(&p)), "table {}: {c:?}", report.number);
        }
    }
}
