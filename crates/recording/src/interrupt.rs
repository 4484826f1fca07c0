//! A request to end the work of a thread, from whoever called it in the same process.
//!
//! A command of its own ends by signals. Work inside another program hears of Ctrl-C by a flag that
//! its caller sets; every reader of a recording looks at it, and what else takes long may.

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static FLAG: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// Does some work in this thread, which the flag interrupts.
pub fn interruptible<T>(flag: &Arc<AtomicBool>, work: impl FnOnce() -> T) -> T {
    let before = FLAG.replace(Some(Arc::clone(flag)));
    let done = work();
    FLAG.set(before);
    done
}

/// The flag of the work in this thread, if somebody may interrupt it.
pub fn flag() -> Option<Arc<AtomicBool>> {
    FLAG.with_borrow(Clone::clone)
}

/// Tells whether the work in this thread is to end.
pub fn is_interrupted() -> bool {
    FLAG.with_borrow(|flag| flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readers_end_when_the_work_around_them_is_interrupted() {
        let flag = Arc::new(AtomicBool::new(false));
        let folder = tempfile::tempdir().unwrap();
        let csv = folder.path().join("a.csv");
        std::fs::write(&csv, "time_s,y\n0,1\n1,2\n").unwrap();
        interruptible(&flag, || {
            assert_eq!(crate::Recording::read(&csv).unwrap().len(), 2);
            flag.store(true, Ordering::Relaxed);
            let ended = crate::Recording::read(&csv).unwrap_err().to_string();
            assert!(ended.ends_with("reading it was interrupted"), "{ended}");
        });
        assert!(!is_interrupted());
        assert_eq!(crate::Recording::read(&csv).unwrap().len(), 2);
    }
}
