use std::fmt;
use std::sync::Arc;

use crate::Error;

/// A way to stop long work from outside: what it asks of, every few milliseconds where that can be had and from whichever
/// thread it runs on. Clones ask the same.
///
/// ```
/// use std::time::{Duration, Instant};
/// use stiction::linalg::Stop;
///
/// let end = Instant::now() + Duration::from_secs(60);
/// let stop = Stop::when(move || Instant::now() >= end);
/// assert!(!stop.asked());
/// ```
#[derive(Clone, Default)]
pub struct Stop(Option<Arc<dyn Fn() -> bool + Send + Sync>>);

impl Stop {
    /// Work that runs to its end.
    pub fn never() -> Self {
        Stop(None)
    }

    /// Stops as soon as `asked` says so; once it has it should go on saying so. It should be quick, and must not panic.
    pub fn when(asked: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Stop(Some(Arc::new(asked)))
    }

    /// Whether to stop.
    pub fn asked(&self) -> bool {
        self.0.as_ref().is_some_and(|asked| asked())
    }

    /// # Errors
    /// [`Error::interrupted`] if it was asked to stop.
    pub fn check(&self) -> Result<(), Error> {
        if self.asked() { Err(Error::interrupted()) } else { Ok(()) }
    }
}

impl fmt::Debug for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Stop(when)" } else { "Stop(never)" })
    }
}

/// Equal are those that ask the same.
impl PartialEq for Stop {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (None, None) => true,
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}
