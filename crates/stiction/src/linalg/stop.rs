use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;
use std::{fmt, panic, thread};

use crate::Error;

/// Called at every event of a kind; whether to go on.
pub type Watch<'a, Event> = dyn FnMut(&Event) -> ControlFlow<()> + 'a;

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

/// How often it is asked while other work goes on.
const PERIOD: Duration = Duration::from_millis(20);

/// What comes of work that cannot be left: a stop leaves it to a thread of its own, which runs on to its end with what the
/// work holds.
///
/// # Errors
/// If it was stopped, or there is no thread to be had.
pub(super) fn unless_stopped<T: Send + 'static>(
    stop: &Stop,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Error> {
    if stop.0.is_none() {
        return Ok(work());
    }
    let (send, receive) = channel();
    // Nobody may be left to hear of the result.
    let run = move || drop(send.send(work()));
    let thread = thread::Builder::new().name("stoppable".into()).spawn(run).map_err(|error| {
        Error::new("", format!("the system gives no thread ({error})"), "end other programs, or raise their limit")
    })?;
    loop {
        match receive.recv_timeout(PERIOD) {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Timeout) => stop.check()?,
            Err(RecvTimeoutError::Disconnected) => {
                if let Err(cause) = thread.join() {
                    panic::resume_unwind(cause);
                }
                unreachable!("it sends before it ends");
            }
        }
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

#[cfg(test)]
impl Stop {
    /// Stops when it has been asked more than so many times.
    pub fn after(questions: usize) -> Self {
        let asked = std::sync::atomic::AtomicUsize::new(0);
        Stop::when(move || asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) >= questions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_does_not_end_is_left() {
        let (hold, held) = channel::<()>();
        let work = move || {
            let _ = held.recv();
            3
        };
        assert!(unless_stopped(&Stop::after(2), work).unwrap_err().interrupted);
        drop(hold);
        assert_eq!(unless_stopped(&Stop::when(|| false), || 3), Ok(3));
        assert_eq!(unless_stopped(&Stop::never(), || 3), Ok(3));
    }
}
