//! The paper's twelve tables as they were printed.

/// The source of everything published here.
pub const SOURCE: &str = "J. Haslinger, R. Kučera, Z. Dostál, An algorithm for the numerical realization of 3D contact \
                          problems with Coulomb friction, J. Comput. Appl. Math. 164-165 (2004) 387-408, \
                          doi:10.1016/j.cam.2003.06.002";

const FILES: [&str; 12] = [
    include_str!("../../data/paper/table01.csv"),
    include_str!("../../data/paper/table02.csv"),
    include_str!("../../data/paper/table03.csv"),
    include_str!("../../data/paper/table04.csv"),
    include_str!("../../data/paper/table05.csv"),
    include_str!("../../data/paper/table06.csv"),
    include_str!("../../data/paper/table07.csv"),
    include_str!("../../data/paper/table08.csv"),
    include_str!("../../data/paper/table09.csv"),
    include_str!("../../data/paper/table10.csv"),
    include_str!("../../data/paper/table11.csv"),
    include_str!("../../data/paper/table12.csv"),
];

/// A published table: names of columns, and cells as they were printed.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    pub number: usize,
    /// What the table shows, from the last comment of its file.
    pub caption: &'static str,
    pub columns: Vec<&'static str>,
    pub rows: Vec<Vec<&'static str>>,
}

impl Published {
    /// The cell of a row as text; empty if there is no such column.
    pub fn text(&self, row: usize, column: &str) -> &'static str {
        let cell = self.columns.iter().position(|&c| c == column).and_then(|c| self.rows.get(row)?.get(c));
        cell.copied().unwrap_or("")
    }

    /// The cell of a row as a number; `None` where the paper printed none.
    pub fn number(&self, row: usize, column: &str) -> Option<f64> {
        self.text(row, column).parse().ok()
    }
}

/// Table `number`, 1 to 12.
pub fn published(number: usize) -> Option<Published> {
    let text: &'static str = FILES.get(number.checked_sub(1)?)?;
    let mut comments = text.lines().filter_map(|line| line.strip_prefix("# "));
    let caption = comments.next_back().unwrap_or("");
    let mut lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    let cells = |line: &'static str| line.split(',').collect::<Vec<_>>();
    let columns = lines.next().map(cells)?;
    Some(Published { number, caption, columns, rows: lines.map(cells).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_tables_are_read_with_as_many_cells_as_columns() {
        let rows: Vec<usize> = (1..=12).map(|n| published(n).unwrap().rows.len()).collect();
        assert_eq!(rows, [6, 6, 3, 12, 12, 7, 4, 6, 3, 12, 12, 2]);
        for table in (1..=12).filter_map(published) {
            assert!(table.rows.iter().all(|row| row.len() == table.columns.len()), "{table:?}");
            let numbers = |row: usize| table.columns.iter().filter(|c| table.number(row, c).is_some()).count();
            assert!((0..table.rows.len()).all(|row| numbers(row) >= 2), "{table:?}");
        }
        assert!(published(0).is_none() && published(13).is_none());
    }

    #[test]
    fn the_numbers_are_those_in_print() {
        let at = |table: usize, row: usize, column: &str| published(table).unwrap().number(row, column);
        assert_eq!(at(1, 5, "iter"), Some(164.0));
        assert_eq!(at(3, 2, "rel_error"), Some(0.022));
        assert_eq!(at(4, 0, "prec"), Some(6.0e-3));
        assert_eq!(at(6, 4, "cg_n6"), None, "the paper stopped this run");
        assert_eq!(at(9, 1, "rel_error"), Some(0.0244));
        assert_eq!(at(12, 1, "cg_n6"), Some(816.0));
        // QPPs = N x Iter for variant 2, as the paper says below its equation (6.2).
        for table in [1, 2].map(|n| published(n).unwrap()) {
            for row in 3..6 {
                let [iter, qpps] = ["iter", "qpps"].map(|c| table.number(row, c).unwrap());
                assert_eq!((table.text(row, "variant"), qpps), ("2", 2.0 * iter));
            }
        }
        // Tables 6 and 7 repeat the columns of tables 4 and 5 for N = 2, table 12 those of tables 10 and 11 at 1e-8.
        for (whole, part, first) in [(4, 6, 0), (5, 7, 2)] {
            for row in 0..published(part).unwrap().rows.len() {
                assert_eq!(at(whole, row + first, "iter"), at(part, row, "iter_n2"));
                assert_eq!(at(whole, row + first, "cg_steps"), at(part, row, "cg_n2"));
            }
        }
        assert_eq!([at(12, 0, "cg_n2"), at(12, 1, "cg_n2")], [at(10, 2, "cg_steps"), at(11, 2, "cg_steps")]);
    }
}
