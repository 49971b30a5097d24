//! The threads that share the work.

use stiction::Error;

/// Starts so many, or one a core. Started by their first use, those that cannot be had would be a panic.
pub fn start(count: Option<u16>) -> Result<(), Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count.unwrap_or(0).into()).build_global();
    pool.map_err(|error| {
        let threads = count.map_or("the threads of this machine".into(), |count| format!("{count} threads"));
        Error::new("--threads", format!("{threads} cannot be had ({error})"), "ask for fewer, or raise `ulimit -v`")
    })
}
