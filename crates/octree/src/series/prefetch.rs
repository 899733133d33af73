//! Reading a file ahead of its use.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// Bytes that are read at once: large enough for disks, small beside any volume.
const CHUNK: usize = 1 << 20;

/// A thread that reads a step from the disk so that nobody waits for it later; see [`Series::prefetch`](crate::Series::prefetch).
///
/// Dropping it stops the thread, and waits for that: for one read of 1 MiB at most.
#[derive(Debug)]
#[must_use = "dropping it stops it"]
pub struct Prefetch {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<u64>>,
}

impl Prefetch {
    /// Runs `read`, which is told when to stop and gives the number of bytes it has read.
    pub(super) fn spawn(read: impl FnOnce(&AtomicBool) -> u64 + Send + 'static) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::Builder::new().name("prefetch".to_owned());
        // Without a thread nothing is read ahead: it is a matter of speed alone.
        Self { stop, thread: thread.spawn(move || read(&stopped)).ok() }
    }

    /// Waits for the end, and tells how many bytes were read.
    pub fn wait(mut self) -> u64 {
        self.join()
    }

    fn join(&mut self) -> u64 {
        self.thread.take().and_then(|thread| thread.join().ok()).unwrap_or(0)
    }
}

impl Drop for Prefetch {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.join();
    }
}

/// Reads the file from `first` on, then what is before that, `budget` bytes at most; tells how many it has read.
pub(super) fn read(path: &Path, first: u64, budget: u64, stop: &AtomicBool) -> u64 {
    let mut left = budget;
    // A file that cannot be read will say so when it is opened to be used.
    let _ = File::open(path).and_then(|mut file| {
        let length = file.metadata()?.len();
        let first = first.min(length);
        read_range(&mut file, first, length - first, &mut left, stop)?;
        read_range(&mut file, 0, first, &mut left, stop)
    });
    budget - left
}

fn read_range(file: &mut File, begin: u64, length: u64, left: &mut u64, stop: &AtomicBool) -> io::Result<()> {
    file.seek(SeekFrom::Start(begin))?;
    let mut buffer = vec![0; CHUNK];
    let mut rest = length.min(*left);
    while rest > 0 && !stop.load(Ordering::Relaxed) {
        let most = rest.min(CHUNK as u64) as usize;
        match file.read(&mut buffer[..most])? as u64 {
            0 => break,
            n => (rest, *left) = (rest - n, *left - n),
        }
    }
    Ok(())
}
