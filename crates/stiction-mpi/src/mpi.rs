//! The ranks of MPI. Only the thread that has started MPI calls it, as `MPI_THREAD_FUNNELED` asks.

use std::ffi::{c_int, c_void};
use std::panic;

use stiction::ranks::Ranks;

unsafe extern "C" {
    fn shim_init() -> c_int;
    fn shim_rank() -> c_int;
    fn shim_size() -> c_int;
    fn shim_abort(code: c_int);
    fn shim_finalize() -> c_int;
    fn shim_lengths(
        receivers: c_int,
        to: *const c_int,
        out: *const u64,
        senders: c_int,
        from: *const c_int,
        into: *mut u64,
    ) -> c_int;
    fn shim_messages(
        receivers: c_int,
        to: *const c_int,
        sizes: *const u64,
        out: *const *const c_void,
        senders: c_int,
        from: *const c_int,
        lengths: *const u64,
        into: *const *mut c_void,
    ) -> c_int;
}

/// The code that a job ends with after a panic.
pub const PANIC: u8 = 101;

/// How Open MPI passes messages on: `ob1` takes shared memory on one machine, and knows no network of its own.
const MESSAGES: &str = "OMPI_MCA_pml";

/// The ranks of `MPI_COMM_WORLD`.
#[derive(Debug)]
pub struct Mpi {
    rank: usize,
    size: usize,
}

impl Mpi {
    /// Starts MPI. From now on a panic of one rank ends all of them: without that the others would wait for ever.
    ///
    /// # Errors
    /// If MPI does not start, or has no threads beside the calling one.
    pub fn start() -> Result<Mpi, String> {
        pass_over_networks();
        // SAFETY: called once, before any other function of MPI.
        let failed = unsafe { shim_init() };
        match failed {
            0 => {}
            -1 => return Err("this MPI does not allow threads (MPI_THREAD_FUNNELED)".into()),
            code => return Err(format!("MPI does not start (code {code})")),
        }
        // SAFETY: MPI is started.
        let (rank, size) = unsafe { (shim_rank(), shim_size()) };
        let shown = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            eprintln!("rank {rank}:");
            shown(info);
            // SAFETY: MPI is started. A panic of another thread than the main one calls MPI beside it; no call follows,
            // because the job ends here.
            unsafe { shim_abort(PANIC.into()) };
        }));
        Ok(Mpi { rank: rank as usize, size: size as usize })
    }

    /// Ends MPI, which all ranks have to.
    pub fn finish(&self) {
        // SAFETY: MPI is started, and nothing is sent any more. What it returns changes nothing for a job that is done.
        let _ = unsafe { shim_finalize() };
    }
}

/// Open MPI looks for networks before it starts, 0.2 s, also where `mpirun` has started all ranks on this machine and messages go through
/// its memory. What the user has chosen stays.
fn pass_over_networks() {
    let [all, here, chosen] = ["OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_SIZE", MESSAGES].map(std::env::var_os);
    if all.is_some() && all == here && chosen.is_none() {
        // SAFETY: the program has one thread.
        unsafe { std::env::set_var(MESSAGES, "ob1") };
    }
}

fn ints(ranks: impl Iterator<Item = usize>) -> Vec<c_int> {
    ranks.map(|rank| rank as c_int).collect()
}

/// A failure of MPI ends the job: the messages of the others would never arrive.
fn must(code: c_int) {
    assert!(code == 0, "MPI failed (code {code})");
}

impl Ranks for Mpi {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn exchange(&self, out: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>> {
        let (to, senders) = (ints(out.iter().map(|(rank, _)| *rank)), ints(from.iter().copied()));
        let sizes: Vec<u64> = out.iter().map(|(_, message)| message.len() as u64).collect();
        let mut lengths = vec![0; from.len()];
        let (receivers, count) = (to.len() as c_int, senders.len() as c_int);
        // SAFETY: all lists are as long as their counts say, and live until the call returns.
        must(unsafe {
            shim_lengths(receivers, to.as_ptr(), sizes.as_ptr(), count, senders.as_ptr(), lengths.as_mut_ptr())
        });
        let mut received: Vec<Vec<u8>> = lengths.iter().map(|&length| vec![0; length as usize]).collect();
        let sent: Vec<*const c_void> = out.iter().map(|(_, message)| message.as_ptr().cast()).collect();
        let into: Vec<*mut c_void> = received.iter_mut().map(|message| message.as_mut_ptr().cast()).collect();
        // SAFETY: as above; the buffers have the lengths that were exchanged, and no two overlap.
        must(unsafe {
            shim_messages(
                receivers,
                to.as_ptr(),
                sizes.as_ptr(),
                sent.as_ptr(),
                count,
                senders.as_ptr(),
                lengths.as_ptr(),
                into.as_ptr(),
            )
        });
        received
    }
}
