//! Contact surfaces and obstacles; poses the [`ContactProblem`].
