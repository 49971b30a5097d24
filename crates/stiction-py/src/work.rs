//! Long work beside the interpreter: on threads of its own, without the GIL, and ended by signals.
//!
//! The thread that calls waits, hears what the work reports and asks the interpreter for signals; the work itself never
//! touches Python. It waits for the answer to each thing it reports, so that a callback stops it where it says so. Work that does not hear a stop soon is left alone: it owns what it needs and ends without a listener.

use std::any::Any;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::panic::PanicException;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use stiction::Error;
use stiction::linalg::Stop;

use crate::errors::raised;

/// How often signals are asked for.
const PERIOD: Duration = Duration::from_millis(20);
/// How long work that was asked to stop is waited for: what it has is worth keeping, and nobody should wait longer.
const GRACE: Duration = Duration::from_millis(60);

/// Threads that sleep until the next call. Each call has a pool to itself: work of another caller that one of its threads
/// takes up could not be left.
static IDLE: Mutex<Vec<Pool>> = Mutex::new(Vec::new());

struct Pool {
    /// After a fork the threads are those of the parent.
    process: u32,
    threads: usize,
    pool: Arc<ThreadPool>,
}

impl Pool {
    fn take(threads: usize) -> Result<Pool, Error> {
        let process = std::process::id();
        // Never waited for: at a fork another thread may have held it.
        if let Ok(mut idle) = IDLE.try_lock() {
            let (own, foreign) =
                std::mem::take(&mut *idle).into_iter().partition(|pool: &Pool| pool.process == process);
            *idle = own;
            // Ending them would wait for locks that nobody gives back.
            std::mem::forget::<Vec<Pool>>(foreign);
            if let Some(place) = idle.iter().position(|pool| pool.threads == threads) {
                return Ok(idle.swap_remove(place));
            }
        }
        let pool = ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("stiction-{i}")).build();
        let pool = pool.map_err(|error| {
            let what = format!("{threads} threads cannot be had ({error})");
            Error::new("threads", what, "ask for fewer, or raise the limits of the process")
        })?;
        Ok(Pool { process, threads, pool: Arc::new(pool) })
    }

    fn give_back(self) {
        if let Ok(mut idle) = IDLE.try_lock() {
            idle.push(self);
        }
    }
}

/// What comes from the work.
enum Message<N, T> {
    /// It waits for an answer.
    Note(N),
    Done(Result<T, Box<dyn Any + Send>>),
}

/// How work tells what it does, and hears whether to go on.
pub(crate) struct Teller<N, T> {
    send: Sender<Message<N, T>>,
    answers: Receiver<bool>,
}

impl<N, T> Teller<N, T> {
    /// Whether to go on; not if nobody is left to hear.
    pub(crate) fn tell(&self, note: N) -> ControlFlow<()> {
        match self.send.send(Message::Note(note)).is_ok() && self.answers.recv().unwrap_or(false) {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    }
}

/// Does `work` on `threads` threads (zero: one a core), calls `hear` with each of its notes, and ends with the exception of a
/// signal or of `hear`. `hear` answers whether to go on.
pub(crate) fn run<N: Send + 'static, T: Send + 'static>(
    py: Python<'_>,
    threads: usize,
    work: impl FnOnce(Stop, &Teller<N, T>) -> T + Send + 'static,
    mut hear: impl FnMut(N) -> PyResult<bool>,
) -> PyResult<T> {
    let (send, mut receive) = channel();
    let (answer, answers) = channel();
    let asked = Arc::new(AtomicBool::new(false));
    let stop = Stop::when({
        let asked = asked.clone();
        move || asked.load(Ordering::Relaxed)
    });
    let pool = py.detach(|| Pool::take(threads)).map_err(|error| raised(py, error))?;
    let own = pool.pool.clone();
    own.spawn(move || {
        let teller = Teller { send, answers };
        let done = catch_unwind(AssertUnwindSafe(|| work(stop, &teller)));
        pool.give_back();
        let _ = teller.send.send(Message::Done(done));
    });
    drop(own);
    let error = loop {
        let message;
        (receive, message) = next(py, receive, PERIOD);
        let heard = match message {
            Ok(Message::Done(done)) => return ended(done),
            Ok(Message::Note(note)) => hear(note).map(|goes_on| {
                if !goes_on {
                    asked.store(true, Ordering::Relaxed);
                }
                // Work that ended meanwhile by itself needs no answer.
                let _ = answer.send(goes_on);
            }),
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the work ended without a result"));
            }
        };
        if let Err(error) = heard.and_then(|()| py.check_signals()) {
            break error;
        }
    };
    asked.store(true, Ordering::Relaxed);
    drop(answer);
    let until = Instant::now() + GRACE;
    while let Some(left) = until.checked_duration_since(Instant::now()) {
        let message;
        (receive, message) = next(py, receive, left);
        if matches!(message, Ok(Message::Done(_)) | Err(RecvTimeoutError::Disconnected)) {
            break;
        }
    }
    Err(error)
}

/// The same for short work on borrowed data, which is waited for after a stop: it is to ask often.
pub(crate) fn borrowed<T: Send>(py: Python<'_>, work: impl FnOnce(&Stop) -> T + Send) -> PyResult<T> {
    let pool = py.detach(|| Pool::take(0)).map_err(|error| raised(py, error))?;
    let asked = Arc::new(AtomicBool::new(false));
    let stop = Stop::when({
        let asked = asked.clone();
        move || asked.load(Ordering::Relaxed)
    });
    let mut error = None;
    let done = py.detach(|| {
        let (send, receive) = channel();
        pool.pool.in_place_scope(|scope| {
            scope.spawn(move |_| {
                let _ = send.send(catch_unwind(AssertUnwindSafe(|| work(&stop))));
            });
            loop {
                match receive.recv_timeout(PERIOD) {
                    Err(RecvTimeoutError::Timeout) if error.is_none() => {
                        error = Python::attach(|py| py.check_signals()).err();
                        asked.store(error.is_some(), Ordering::Relaxed);
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Ok(done) => break Some(done),
                    Err(RecvTimeoutError::Disconnected) => break None,
                }
            }
        })
    });
    pool.give_back();
    match (error, done) {
        (Some(error), _) => Err(error),
        (None, Some(done)) => ended(done),
        (None, None) => Err(PyRuntimeError::new_err("the work ended without a result")),
    }
}

type Next<N, T> = (Receiver<Message<N, T>>, Result<Message<N, T>, RecvTimeoutError>);

fn next<N: Send, T: Send>(py: Python<'_>, receive: Receiver<Message<N, T>>, patience: Duration) -> Next<N, T> {
    py.detach(move || {
        let message = receive.recv_timeout(patience);
        (receive, message)
    })
}

fn ended<T>(done: Result<T, Box<dyn Any + Send>>) -> PyResult<T> {
    done.map_err(|cause| {
        let text = cause.downcast_ref::<String>().cloned();
        let text = text.or_else(|| cause.downcast_ref::<&str>().map(|text| text.to_string()));
        PanicException::new_err(text.unwrap_or_else(|| "internal error".into()))
    })
}
