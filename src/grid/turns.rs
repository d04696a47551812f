//! Which bins may be worked on side by side.

use super::{Block, colour};
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Looks for a bin before a thread lets others run.
const LOOKS: usize = 64;

/// The bins in the order in which they are added to the grid: colour after colour, so that neighbours always are in the same order, and of a
/// colour the largest first.
#[derive(Debug, Clone, Default)]
pub(crate) struct Turns {
    /// Numbers of the bins.
    order: Vec<u32>,
    /// For each bin those before it in the order that touch common nodes.
    before: Vec<Vec<u32>>,
}

impl Turns {
    /// Of bins in these blocks, with so many particles each.
    pub(crate) fn new(blocks: &[Block], particles: impl Fn(usize) -> u32) -> Self {
        let mut order: Vec<u32> = (0..blocks.len() as u32).collect();
        order.sort_by_key(|&bin| (colour(blocks[bin as usize].1), std::cmp::Reverse(particles(bin as usize))));
        let table: HashMap<Block, u32> = (0..).zip(blocks).map(|(bin, block)| (*block, bin)).collect();
        let before = blocks.iter().map(|&(field, block)| {
            // bins touch the nodes of their own block and of the next an axis
            let near = (0..27).map(|k| [k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1]).map(|way| [0, 1, 2].map(|s| block[s] + way[s]));
            let earlier = near.filter(|&other| colour(other) < colour(block));
            earlier.filter_map(|other| table.get(&(field, other)).copied()).collect()
        });
        Self { before: before.collect(), order }
    }

    /// Rounds that so many threads need, if all bins take as long.
    pub(crate) fn rounds(&self, threads: usize) -> usize {
        let (mut done, mut rounds) = (vec![false; self.order.len()], 0);
        let mut left = self.order.clone();
        while !left.is_empty() {
            let ready = |bin: &u32| self.before[*bin as usize].iter().all(|&other| done[other as usize]);
            let some: Vec<u32> = left.iter().copied().filter(ready).take(threads).collect();
            some.iter().for_each(|&bin| done[bin as usize] = true);
            left.retain(|&bin| !done[bin as usize]);
            rounds += 1;
        }
        rounds
    }

    /// Numbers of the bins, in their order.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Starts to share the bins between threads.
    pub(crate) fn share(&self) -> Shared<'_> {
        let flags = || std::iter::repeat_with(AtomicBool::default).take(self.order.len()).collect();
        Shared { turns: self, first: AtomicUsize::new(0), taken: flags(), done: flags() }
    }
}

/// Bins of which each thread takes the next.
pub(crate) struct Shared<'a> {
    turns: &'a Turns,
    /// Turns before this one are taken.
    first: AtomicUsize,
    taken: Vec<AtomicBool>,
    done: Vec<AtomicBool>,
}

impl Shared<'_> {
    /// Works on bins, one after the other, until all are taken: on the first of which all are done that come before it and touch common
    /// nodes. There always is one, or somebody works on such a one.
    pub(crate) fn work(&self, mut on: impl FnMut(u32)) {
        let mut looks = 0;
        loop {
            match self.take() {
                Next::Take(bin) => {
                    let _done = Done(&self.done[bin as usize]);
                    on(bin);
                    looks = 0;
                }
                Next::Wait => {
                    looks += 1;
                    if looks % LOOKS == 0 { std::thread::yield_now() } else { std::hint::spin_loop() }
                }
                Next::End => return,
            }
        }
    }

    fn take(&self) -> Next {
        let Turns { order, before } = self.turns;
        let (first, mut all_taken, mut waits) = (self.first.load(Ordering::Relaxed), true, false);
        for (turn, &bin) in order.iter().enumerate().skip(first) {
            let taken = &self.taken[bin as usize];
            if taken.load(Ordering::Relaxed) {
                if all_taken {
                    self.first.fetch_max(turn + 1, Ordering::Relaxed);
                }
                continue;
            }
            all_taken = false;
            if before[bin as usize].iter().any(|&other| !self.done[other as usize].load(Ordering::Acquire)) {
                waits = true;
            } else if !taken.swap(true, Ordering::Relaxed) {
                return Next::Take(bin);
            }
        }
        if waits { Next::Wait } else { Next::End }
    }
}

enum Next {
    Take(u32),
    /// Others are at work on what all that are left wait for.
    Wait,
    End,
}

/// Says that a bin is done, also where work on it ends in a panic: the others would wait for ever.
struct Done<'a>(&'a AtomicBool);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn neighbours_never_meet_and_keep_their_order() {
        // 5 x 4 x 3 blocks of many sizes
        let blocks: Vec<Block> = (0..60).map(|b| (0, [b / 12, b / 3 % 4, b % 3])).collect();
        let turns = Turns::new(&blocks, |bin| (37 * bin as u32) % 23);
        let near = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|bin| blocks[bin as usize].1);
            (0..3).all(|s| (a[s] - b[s]).abs() <= 1)
        };
        for _ in 0..50 {
            let (shared, busy, ended) = (turns.share(), Mutex::new(Vec::<u32>::new()), Mutex::new(Vec::new()));
            std::thread::scope(|scope| {
                for _ in 0..4 {
                    scope.spawn(|| {
                        shared.work(|bin| {
                            let mut all = busy.lock().expect("no panic");
                            assert!(all.iter().all(|&other| !near(bin, other)));
                            all.push(bin);
                            drop(all);
                            std::thread::yield_now();
                            busy.lock().expect("no panic").retain(|&other| other != bin);
                            ended.lock().expect("no panic").push(bin);
                        });
                    });
                }
            });
            let ended = ended.into_inner().expect("no panic");
            assert_eq!(ended.len(), blocks.len());
            let place = |list: &[u32], bin: u32| list.iter().position(|&b| b == bin).expect("all are there");
            for a in 0..60 {
                for b in (0..60).filter(|&b| near(a, b)) {
                    let first = |list: &[u32]| place(list, a).cmp(&place(list, b));
                    assert_eq!(first(&ended), first(turns.order()));
                }
            }
        }
    }

    #[test]
    fn a_panic_reaches_the_caller() {
        let blocks: Vec<Block> = (0..9).map(|b| (0, [0, b / 3, b % 3])).collect();
        let turns = Turns::new(&blocks, |_| 1);
        let shared = turns.share();
        let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            std::thread::scope(|scope| {
                for _ in 0..2 {
                    scope.spawn(|| shared.work(|bin| assert_ne!(bin, turns.order()[2])));
                }
            });
        }));
        assert!(caught.is_err());
    }
}
