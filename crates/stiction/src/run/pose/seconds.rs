//! Where the time goes.

use std::time::Instant;

use crate::io::machine;

/// Time that something took, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Span {
    /// On the clock.
    pub wall: f64,
    /// Of all threads; on a machine with other work to do this is what can be compared.
    pub cpu: f64,
}

impl std::ops::Add for Span {
    type Output = Span;

    fn add(self, other: Span) -> Span {
        Span { wall: self.wall + other.wall, cpu: self.cpu + other.cpu }
    }
}

/// Time by phase.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seconds {
    /// Reading and checking the mesh.
    pub mesh: Span,
    /// Assembly.
    pub assembly: Span,
    /// Posing of contact.
    pub contact: Span,
    /// The multigrid hierarchy.
    pub setup: Span,
    /// Ordering of the unknowns.
    pub ordering: Span,
    /// Factorisation.
    pub factorisation: Span,
    /// The iteration.
    pub iteration: Span,
    /// Estimates of contraction and uniqueness.
    pub coulomb: Span,
    /// Writing of results.
    pub output: Span,
}

impl Seconds {
    fn spans(&mut self) -> [(&'static str, &mut Span); 9] {
        [
            ("mesh", &mut self.mesh),
            ("assembly", &mut self.assembly),
            ("contact", &mut self.contact),
            ("setup", &mut self.setup),
            ("ordering", &mut self.ordering),
            ("factorisation", &mut self.factorisation),
            ("iteration", &mut self.iteration),
            ("coulomb", &mut self.coulomb),
            ("output", &mut self.output),
        ]
    }

    /// All phases with their names.
    pub fn phases(mut self) -> [(&'static str, Span); 9] {
        self.spans().map(|(name, span)| (name, *span))
    }

    /// Of the times of all phases in their order.
    pub(crate) fn of(spans: impl Iterator<Item = Span>) -> Self {
        let mut seconds = Seconds::default();
        seconds.spans().into_iter().zip(spans).for_each(|((_, to), span)| *to = span);
        seconds
    }

    /// Adds what a step has taken.
    pub(crate) fn add(&mut self, other: &Seconds) {
        self.spans().into_iter().zip(other.phases()).for_each(|((_, sum), (_, span))| *sum = *sum + span);
    }

    /// The sum of all phases.
    pub fn total(&self) -> Span {
        self.phases().iter().fold(Span::default(), |sum, (_, span)| sum + *span)
    }
}

/// The time since the last call, or since the watch was made.
pub(crate) fn stopwatch() -> impl FnMut() -> Span {
    let (mut clock, mut cpu) = (Instant::now(), machine::cpu_seconds());
    move || {
        let wall = std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
        let now = machine::cpu_seconds();
        Span { wall, cpu: now - std::mem::replace(&mut cpu, now) }
    }
}
