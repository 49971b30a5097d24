//! What a rank takes part in of quantities that are found from sums over all ranks.

/// Of a problem that ranks share what this one counts, with sums and maxima over all of them.
pub(crate) struct Among<'a> {
    pub point: &'a dyn Fn(usize) -> bool,
    pub unknown: &'a dyn Fn(usize) -> bool,
    pub sum: &'a dyn Fn(&mut [f64]),
    pub max: &'a dyn Fn(&mut [f64]),
}

impl Among<'_> {
    /// All of it.
    pub(crate) const ALONE: Among<'static> = Among { point: &|_| true, unknown: &|_| true, sum: &|_| {}, max: &|_| {} };

    /// The largest of numbers, none of which is negative.
    pub(crate) fn largest(&self, here: impl Iterator<Item = f64>) -> f64 {
        let mut most = [here.fold(0.0, f64::max)];
        (self.max)(&mut most);
        most[0]
    }
}
