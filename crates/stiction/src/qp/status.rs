/// How a minimisation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QpStatus {
    /// The measure of optimality is at most the tolerance, with a gradient that is not only a recurrence.
    Solved,
    /// The caller's `stop` said so.
    Interrupted,
    /// The products with the operator are used up.
    Limit,
    /// Rounding in the gradient hides what is left; the tolerance is below it.
    Stalled,
    /// A direction of zero or negative curvature: the operator is not positive definite.
    Indefinite,
    /// A product, the start or the right-hand side is not finite.
    NotFinite,
    /// No point satisfies the bounds: a lower one above its upper one, or one that is not a number.
    Empty,
}
