//! The name a user probably meant.

/// The candidate closest to `name`, if it is close enough to be a slip of the fingers.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = lower(name);
    // Nobody misspells a name this long, and the distance takes time proportional to the product of the lengths.
    if wanted.len() > 100 {
        return None;
    }
    let allowed = 1 + wanted.len() / 4;
    let distances = candidates.into_iter().map(|c| (distance(&wanted, &lower(c)), c));
    distances.filter(|(d, _)| *d <= allowed).min_by_key(|(d, _)| *d).map(|(_, c)| c)
}

fn lower(text: &str) -> Vec<char> {
    text.chars().flat_map(char::to_lowercase).collect()
}

/// Damerau-Levenshtein distance with adjacent swaps: insertions, deletions, substitutions and swaps count one each.
fn distance(a: &[char], b: &[char]) -> usize {
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let substitution = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = substitution.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_swap_counts_one() {
        let d = |a: &str, b: &str| distance(&lower(a), &lower(b));
        assert_eq!(d("yuong", "young"), 1);
        assert_eq!(d("kitten", "sitting"), 3);
        assert_eq!(d("", "abc"), 3);
        assert_eq!(d("abc", ""), 3);
    }

    #[test]
    fn only_close_names_are_suggested() {
        let keys = ["young", "poisson", "density"];
        assert_eq!(nearest("Poison", keys), Some("poisson"));
        assert_eq!(nearest("stiffness", keys), None);
        assert_eq!(nearest("", ["ab", "c"]), Some("c"));
    }
}
