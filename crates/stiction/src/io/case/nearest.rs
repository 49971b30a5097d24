//! The name a user probably meant.

use strsim::osa_distance;

/// The candidate closest to `name`, if it is close enough to be a slip of the fingers.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase();
    let length = wanted.chars().count();
    // Nobody misspells a name this long, and the distance takes time proportional to the product of the lengths.
    if length > 100 {
        return None;
    }
    // Insertions, deletions, substitutions and swaps of neighbours count one each.
    let distances = candidates.into_iter().map(|c| (osa_distance(&wanted, &c.to_lowercase()), c));
    distances.filter(|(d, _)| *d <= 1 + length / 4).min_by_key(|(d, _)| *d).map(|(_, c)| c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swap_counts_one() {
        assert_eq!(nearest("yuong", ["yang", "young"]), Some("young"));
        assert_eq!(nearest("abc", ["acb"]), Some("acb"));
        assert_eq!(nearest("abc", ["cba"]), None);
        assert_eq!(nearest("kitten", ["sitting"]), None);
    }

    #[test]
    fn only_close_names_are_suggested() {
        let keys = ["young", "poisson", "density"];
        assert_eq!(nearest("Poison", keys), Some("poisson"));
        assert_eq!(nearest("stiffness", keys), None);
        assert_eq!(nearest("", ["ab", "c"]), Some("c"));
    }
}
