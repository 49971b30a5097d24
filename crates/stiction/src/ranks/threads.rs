use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;

use super::Ranks;

/// A rank that is a thread. Each pair of ranks has a channel in each direction.
#[derive(Debug)]
struct Thread {
    rank: usize,
    to: Vec<Mutex<Sender<Vec<u8>>>>,
    from: Vec<Mutex<Receiver<Vec<u8>>>>,
}

impl Ranks for Thread {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn exchange(&self, out: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>> {
        for (rank, message) in out {
            let to = self.to[rank].lock().expect("one thread uses a rank");
            to.send(message).expect("the other rank has ended before its time");
        }
        let receive = |&rank: &usize| {
            let from = self.from[rank].lock().expect("one thread uses a rank");
            from.recv().expect("the other rank has ended before its time")
        };
        from.iter().map(receive).collect()
    }
}

/// Runs `work` as so many ranks in threads of this process; what each returns, in their order.
///
/// # Panics
/// If one of them does: the channels of a rank that is gone end the others.
pub fn threads<T: Send>(size: usize, work: impl Fn(Arc<dyn Ranks>) -> T + Sync) -> Vec<T> {
    let mut to: Vec<Vec<_>> = (0..size).map(|_| Vec::new()).collect();
    let mut from: Vec<Vec<_>> = (0..size).map(|_| Vec::new()).collect();
    for sender in &mut to {
        for receiver in &mut from {
            let (send, receive) = channel();
            sender.push(Mutex::new(send));
            receiver.push(Mutex::new(receive));
        }
    }
    let ranks = to.into_iter().zip(from).enumerate().map(|(rank, (to, from))| Thread { rank, to, from });
    let work = &work;
    thread::scope(|scope| {
        let started: Vec<_> = ranks.map(|rank| scope.spawn(move || work(Arc::new(rank)))).collect();
        started.into_iter().map(|thread| thread.join().expect("a rank panicked")).collect()
    })
}
