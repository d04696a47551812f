//! What is known of a few particles between the stages of a sweep, component by component.

use crate::lanes::{Batch, LANES, Mask, Quad, Real};

/// Particles of a chunk. Few enough for their numbers to stay in the cache of a core, enough for the stages to overlap.
pub(super) const CHUNK: usize = 64;

/// A number a particle. Eight may be written wherever a particle is, so there is room for some that are not there.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Column(pub(super) [f64; CHUNK + LANES]);

/// Memory of a sweep; of use to nobody after it.
#[repr(C, align(64))]
pub(super) struct Chunk<const W: usize> {
    /// Local coordinate in its cell, by axis; of use only where the functions are those of inner cells.
    pub(super) xi: [Column; 3],
    /// Velocity of the grid, later of the particle.
    pub(super) velocity: [Column; 3],
    /// Acceleration of the grid; the first is a mark (see `Stepper::mark_held_nodes`).
    pub(super) acceleration: [Column; 4],
    /// Derivative of the velocity of the grid, by component and axis.
    pub(super) gradient: [[Column; 3]; 3],
    /// Affine matrix, by component and axis.
    pub(super) affine: [[Column; 3]; 3],
    /// -V0 tau, times the kick where forces are merged with momenta; at least that half of which the first number is not above the second.
    pub(super) force: [[Column; 3]; 3],
    pub(super) packets: [Packets<W>; CHUNK / LANES],
    /// The nodes of the cell that is taken from and of the next, in turns.
    pub(super) cells: [Cell<W>; 2],
    /// Index of the first node of each particle in the tile of its bin.
    pub(super) node: [u32; CHUNK + LANES],
    /// Particles of each eight whose functions are not those of inner cells.
    pub(super) outside: [Mask; CHUNK / LANES],
}

impl<const W: usize> Chunk<W> {
    /// Whether the functions at particle `at` are those of inner cells.
    #[inline(always)]
    pub(super) fn is_inner(&self, at: usize) -> bool {
        self.outside[at % CHUNK / LANES] >> (at % LANES) & 1 == 0
    }

    /// The end of the run of particles from `start` on, below `end`, that are in one cell.
    #[inline(always)]
    pub(super) fn end_of_run(&self, start: usize, end: usize) -> usize {
        let (node, mut next) = (self.node[start % CHUNK], start + 1);
        while next < end.min(CHUNK) && self.node[next] == node {
            next += 1;
        }
        next
    }
}

/// The nodes of a cell, slot by slot as the middle one and the differences of the others from it: weights sum to 1 and slopes to 0, so
/// the middle one needs neither. All particles of the cell share them.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Cell<const W: usize> {
    /// By node of slots 0 and 1: two of the others along slot 2 each, in their order; at the end the middle one twice.
    pub(super) rows: [[[Batch; 4]; W]; W],
}

/// What eight particles add to the grid.
///
/// A particle adds to node (i, j, k) the field f = N_i N_j N_k b + e0_i N_j N_k + N_i e1_j N_k + N_i N_j e2_k with b of mass and momentum, and
/// e of what grows with the distance (the affine matrix) or goes by a slope (the stress). As the sum of all N is 1 and that of all
/// slopes and arms 0, the sum of f along an axis is that of the N of the other axes: in inner cells it takes the place of the middle node.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Packets<const W: usize> {
    pub(super) base: [Quad; LANES],
    /// e by slot and node; along slots 0 and 1 that of the middle node is not kept.
    pub(super) more: [[[Quad; LANES]; W]; 3],
    /// N by slot and node.
    pub(super) value: [[Batch; W]; 3],
}

/// Memory for the chunks of one thread.
#[derive(Debug, Default)]
pub(crate) struct ChunkMemory(Vec<Aligned>);

#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Aligned([f64; LANES]);

impl ChunkMemory {
    /// A chunk of any content.
    pub(super) fn chunk<const W: usize>(&mut self) -> &mut Chunk<W> {
        let lines = size_of::<Chunk<W>>() / size_of::<Aligned>();
        if self.0.len() < lines {
            self.0.resize(lines, Aligned([0.0; LANES]));
        }
        // SAFETY: the memory is as large and as aligned as a chunk, and a chunk is made of numbers, for which any bits will do.
        unsafe { &mut *self.0.as_mut_ptr().cast::<Chunk<W>>() }
    }
}

/// Eight numbers from a particle of the chunk on.
#[inline(always)]
pub(super) fn load<V: Real>(column: &Column, at: usize) -> V {
    // SAFETY: there is room for eight numbers from any particle on.
    V::load(unsafe { &*column.0.as_ptr().add(at % CHUNK).cast::<Batch>() })
}

/// Writes eight numbers from a particle of the chunk on.
#[inline(always)]
pub(super) fn store<V: Real>(column: &mut Column, at: usize, value: V) {
    // SAFETY: there is room for eight numbers from any particle on.
    value.store(unsafe { &mut *column.0.as_mut_ptr().add(at % CHUNK).cast::<Batch>() });
}
