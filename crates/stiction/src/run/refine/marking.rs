//! Which cells are refined.

/// Part of the squared error whose cells are marked (Dörfler, SIAM J. Numer. Anal. 33 (1996) 1106). A larger part gives fewer
/// meshes, the last of which is the farther beyond the goal.
const PART: f64 = 0.5;
/// What two bisections leave of the squared error of a cell, for the prediction of the last mesh: 0.16 where the solution is
/// smooth (quadratic cells, 1.59 times smaller), more at edges. On the brick 0.19 to 0.22, closure included.
const LEFT: f64 = 0.25;
/// The last mesh aims at this part of the goal.
const AIM: f64 = 0.97;

/// The cells with the largest indicators (squared, all of them >= 0), in ascending order: those that hold half of the sum, or
/// fewer where refining them is expected to bring the sum below `goal`.
pub(super) fn marked(indicators: &[f64], goal: Option<f64>) -> Vec<u32> {
    let mut order: Vec<u32> = (0..indicators.len() as u32).collect();
    let value = |cell: u32| indicators[cell as usize];
    // Equal indicators in the order of the cells: the marks do not depend on how the sort is divided.
    order.sort_unstable_by(|&a, &b| value(b).total_cmp(&value(a)).then(a.cmp(&b)));
    let sum: f64 = indicators.iter().sum();
    let enough = goal.map_or(f64::INFINITY, |goal| (sum - AIM * AIM * goal) / (1.0 - LEFT)).max(0.0).min(PART * sum);
    let mut held = 0.0;
    let count = order.iter().take_while(|&&cell| {
        let more = held < enough;
        held += value(cell);
        more
    });
    let count = count.count().max(1).min(order.len());
    order.truncate(count);
    order.sort_unstable();
    order
}

/// Marks `more` cells too; `marked` stays in ascending order.
pub(super) fn mark_also(marked: &mut Vec<u32>, more: Vec<u32>) {
    marked.extend(more);
    marked.sort_unstable();
    marked.dedup();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_are_marked_until_half_of_the_sum_is_held() {
        let indicators = [1.0, 9.0, 4.0, 4.0, 0.0, 2.0]; // sum 20
        assert_eq!(marked(&indicators, None), [1, 2]);
        assert_eq!(marked(&[1.0; 8], None), [0, 1, 2, 3]);
    }

    #[test]
    fn near_the_goal_fewer_are_marked_and_one_at_least() {
        let indicators = vec![1.0; 1000];
        let few = marked(&indicators, Some(1000.0)).len();
        assert!((1..500).contains(&few), "{few}");
        // What is left after refinement is what was aimed at.
        let left = 1000.0 - few as f64 * (1.0 - LEFT);
        assert!((left - AIM * AIM * 1000.0).abs() <= 1.0, "{left}");
        assert_eq!(marked(&indicators, Some(2000.0)), [0]);
        assert_eq!(marked(&indicators, Some(0.0)).len(), 500);
    }
}
