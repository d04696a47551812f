//! Threads after a fork: the threads of the parent's pool do not exist in the child, work that is given to them would wait for ever.

use pyo3::prelude::*;
use rayon::ThreadPool;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicBool, AtomicPtr, Ordering};

/// Whether this process is a fork of one that may have threads.
static FORKED: AtomicBool = AtomicBool::new(false);
/// Pool of a forked process, made when first needed and never freed.
static POOL: AtomicPtr<ThreadPool> = AtomicPtr::new(null_mut());

/// Called by Python in the child after a fork.
#[pyfunction]
#[pyo3(name = "_forked")]
pub(crate) fn forked() {
    FORKED.store(true, Ordering::SeqCst);
    POOL.store(null_mut(), Ordering::SeqCst);
}

/// Does work that may share itself among threads, where there are threads.
pub(crate) fn with_threads<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    if FORKED.load(Ordering::Relaxed)
        && let Some(pool) = pool()
    {
        return pool.install(work);
    }
    work()
}

fn pool() -> Option<&'static ThreadPool> {
    let mut pool = POOL.load(Ordering::Acquire);
    if pool.is_null() {
        let made = Box::into_raw(Box::new(rayon::ThreadPoolBuilder::new().build().ok()?));
        pool = match POOL.compare_exchange(null_mut(), made, Ordering::AcqRel, Ordering::Acquire) {
            Ok(_) => made,
            Err(other) => {
                // SAFETY: `made` comes from the box above, and nobody else has seen it.
                drop(unsafe { Box::from_raw(made) });
                other
            }
        };
    }
    // SAFETY: what is in `POOL` comes from a box that is never freed.
    unsafe { pool.as_ref() }
}
